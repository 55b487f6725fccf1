#include <algorithm>
#include <limits>
#include <utility>

#include "core/forces/element_forces.h"
#include "core/forces/finite_constants.h"
#include "core/forces/graph.h"
#include "core/forces/grid_springs.h"
#include "core/forces/own_slopes.h"
#include "core/forces/spring_kernel.h"
#include "core/forces/unstressed_lengths.h"
#include "core/parallel/parallel.h"
#include "elastin/core/forces/elasticity.h"
#include "elastin/core/laws/local.h"

namespace elastin {
namespace {

double length(const Connections& connections, const Positions& positions, int c) {
  const auto& [a, b] = connections.ends[c];
  return (positions.col(b) - positions.col(a)).norm();
}

/// q = k (1 − L/l), written with l − L, which loses no digits at small strain. A connection of no length has no
/// direction: no force.
double spring_density(double length, double constant, double rest_length) {
  return length > 0 ? constant * (length - rest_length) / length : 0;
}

void add_spring_force_densities(const Connections& connections, const VectorX& constants, const double* rest_lengths,
                                const Positions& positions, VectorX& force_densities) {
  parallel_for(connections.size(), [&](int c) {
    force_densities[c] += spring_density(length(connections, positions, c), constants[c], rest_lengths[c]);
  });
}

/// ∂q/∂s = k L / (2 l³)
void add_spring_slopes(const Connections& connections, const VectorX& constants, const double* rest_lengths,
                       const Positions& positions, VectorX& slopes) {
  parallel_for(connections.size(), [&](int c) {
    const double l = length(connections, positions, c);
    if (l > 0) slopes[c] += constants[c] * rest_lengths[c] / (2 * l * l * l);
  });
}

class Springs final : public EdgeDensities, public LocalElasticity, public ElementForces {
 public:
  Springs(const Body& body, VectorX constants)
      : body_(body),
        connections_(body.connections),
        constants_(std::move(constants)),
        rest_lengths_(body),
        grid_(GridSprings::make(body, constants_, rest_lengths_.data())) {}

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<Springs>(*this); }
  std::unique_ptr<Elasticity> on_subdomain(const Subdomain& own) const override {
    if (body_.unstressed) return nullptr;
    return std::make_unique<Springs>(*own.body, own.computed(constants_));
  }
  void set_rest(double part) override {
    rest_lengths_.set(part);
    grid_ = GridSprings::make(body_, constants_, rest_lengths_.data());
  }
  double energy(const Positions& positions) const override {
    return ordered_sum(connections_.size(), [&](int c) {
      const double stretch = length(connections_, positions, c) - rest_lengths_[c];
      return 0.5 * constants_[c] * stretch * stretch;
    });
  }
  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace&) const override {
    add_spring_force_densities(connections_, constants_, rest_lengths_.data(), positions, force_densities);
  }
  void add_forces(const Positions& positions, const Graph& graph, Positions& forces,
                  Workspace& workspace) const override {
    if (grid_) return grid_->add_forces(positions, forces, workspace);
    if (!graph.gathers())
      return graph.for_each_range([&](const Graph::Range& range) {
        spring_kernel().add_listed_flows({connections_.ends.data(), constants_.data(), rest_lengths_.data()},
                                         range.first, range.last, range.begin, range.end, positions.data(),
                                         forces.data());
      });
    graph.gather(forces, [&](int c, int a, int b) -> Vector3 {
      const Vector3 d = positions.col(b) - positions.col(a);
      return spring_density(d.norm(), constants_[c], rest_lengths_[c]) * d;
    });
  }
  std::unique_ptr<EdgeSlopes> slopes() const override {
    return std::make_unique<OwnSlopes>(connections_.size(), [this](const Positions& positions, VectorX& slopes) {
      add_spring_slopes(connections_, constants_, rest_lengths_.data(), positions, slopes);
    });
  }

  const LocalElasticity* local() const override { return this; }
  int elements() const override { return connections_.size(); }
  std::span<const int> molecules_of(int element) const override { return connections_.ends[element]; }
  double element_energy(const Positions& positions, int element) const override {
    const double stretch = length(connections_, positions, element) - rest_lengths_[element];
    return 0.5 * constants_[element] * stretch * stretch;
  }
  void set_element_forces(const Positions& positions, int element, Eigen::Ref<Positions> forces) const override {
    const auto& [a, b] = connections_.ends[element];
    const Vector3 d = positions.col(b) - positions.col(a);
    forces.col(0) = spring_density(d.norm(), constants_[element], rest_lengths_[element]) * d;
    forces.col(1) = -forces.col(0);
  }
  /// K = q I + (k − q) d dᵀ/l². A pressed spring would have its molecule go sideways: only k − q is left of it then.
  void add_blocks(const Positions& positions, std::span<const LocalSlot> slots, LocalBlock& block) const override {
    constexpr std::size_t most = 64;
    double d[3][most], k[most], rest[most], q[most];
    const SetSpringForceDensities set_force_densities = spring_kernel().set_force_densities;
    for (std::size_t first = 0; first < slots.size(); first += most) {
      const std::size_t count = std::min(most, slots.size() - first);
      for (std::size_t i = 0; i < count; ++i) {
        const auto [element, node] = slots[first + i];
        const auto& ends = connections_.ends[element];
        const double *own = positions.data() + 3 * static_cast<std::ptrdiff_t>(ends[node]),
                     *other = positions.data() + 3 * static_cast<std::ptrdiff_t>(ends[1 - node]);
        d[0][i] = own[0] - other[0], d[1][i] = own[1] - other[1], d[2][i] = own[2] - other[2];
        k[i] = constants_[element], rest[i] = rest_lengths_[element];
      }
      set_force_densities({d[0], most}, k, rest, static_cast<int>(count), q);
      double g[3] = {0, 0, 0}, h[6] = {0, 0, 0, 0, 0, 0}, round = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const double x = d[0][i], y = d[1][i], z = d[2][i], square = x * x + y * y + z * z;
        const double along = square > 0 ? (k[i] - q[i]) / square : 0;
        g[0] += q[i] * x, g[1] += q[i] * y, g[2] += q[i] * z;
        round += q[i] * k[i] > 0 ? q[i] : 0;
        const double straight = q[i] * k[i] > 0 ? along : square > 0 ? k[i] / square : 0;
        h[0] += straight * x * x, h[1] += straight * x * y, h[2] += straight * x * z;
        h[3] += straight * y * y, h[4] += straight * y * z, h[5] += straight * z * z;
      }
      block.gradient += Vector3(g[0], g[1], g[2]);
      Matrix3 own;
      own << h[0] + round, h[1], h[2], h[1], h[3] + round, h[4], h[2], h[4], h[5] + round;
      block.hessian += own;
    }
  }
  double relative_change(const Positions&, std::span<const LocalSlot> slots, const Vector3& motion) const override {
    double shortest = std::numeric_limits<double>::infinity();
    for (const LocalSlot& slot : slots) shortest = std::min(shortest, rest_lengths_[slot.element]);
    return motion.norm() / shortest;
  }
  bool add_constraints(Constraints& all) const override {
    if (constants_.size() > 0 && constants_.minCoeff() < 0) return false;
    for (int c = 0; c < connections_.size(); ++c)
      if (constants_[c] > 0) all.springs.push_back({connections_.ends[c], constants_[c], rest_lengths_[c]});
    return true;
  }

 private:
  const Body& body_;
  const Connections& connections_;
  VectorX constants_;
  UnstressedLengths rest_lengths_;
  std::optional<GridSprings> grid_;
};

class UpdatedSprings final : public EdgeDensities {
 public:
  UpdatedSprings(const Body& body, ConstantsAt constants)
      : connections_(body.connections), constants_at_(std::move(constants)), rest_lengths_(body) {}

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<UpdatedSprings>(*this); }
  void set_rest(double part) override { rest_lengths_.set(part); }
  bool has_energy() const override { return false; }
  bool has_full_tangent() const override { return false; }
  double energy(const Positions&) const override { return 0; }
  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace&) const override {
    add_spring_force_densities(connections_, constants_at_(positions), rest_lengths_.data(), positions,
                               force_densities);
  }
  std::unique_ptr<EdgeSlopes> slopes() const override {
    return std::make_unique<OwnSlopes>(connections_.size(), [this](const Positions& positions, VectorX& slopes) {
      add_spring_slopes(connections_, constants_at_(positions), rest_lengths_.data(), positions, slopes);
    });
  }

 private:
  const Connections& connections_;
  ConstantsAt constants_at_;
  UnstressedLengths rest_lengths_;
};

}  // namespace

std::unique_ptr<Elasticity> make_springs(const Body& body, VectorX constants) {
  check_finite_constants(constants, "spring constant", "N/m");
  return std::make_unique<Springs>(body, std::move(constants));
}

std::unique_ptr<Elasticity> make_updated_springs(const Body& body, ConstantsAt constants) {
  return std::make_unique<UpdatedSprings>(body, std::move(constants));
}

}  // namespace elastin
