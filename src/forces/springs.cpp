#include <utility>

#include "base/parallel.h"
#include "elastin/forces/elasticity.h"
#include "forces/graph.h"
#include "forces/grid_springs.h"

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

void add_spring_densities(const Connections& connections, const VectorX& constants, const Positions& positions,
                          VectorX& densities) {
  parallel_for(connections.size(), [&](int c) {
    densities[c] += spring_density(length(connections, positions, c), constants[c], connections.rest_length[c]);
  });
}

/// ∂q/∂s = k L / (2 l³)
VectorX spring_slopes(const Connections& connections, const VectorX& constants, const Positions& positions) {
  VectorX slopes(connections.size());
  parallel_for(connections.size(), [&](int c) {
    const double l = length(connections, positions, c);
    slopes[c] = l > 0 ? constants[c] * connections.rest_length[c] / (2 * l * l * l) : 0;
  });
  return slopes;
}

class Springs final : public Elasticity {
 public:
  Springs(const Body& body, VectorX constants)
      : connections_(body.connections), constants_(std::move(constants)), grid_(GridSprings::make(body, constants_)) {}

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<Springs>(*this); }
  double energy(const Positions& positions) const override {
    return ordered_sum(connections_.size(), [&](int c) {
      const double stretch = length(connections_, positions, c) - connections_.rest_length[c];
      return 0.5 * constants_[c] * stretch * stretch;
    });
  }
  void add_force_densities(const Positions& positions, VectorX& densities, Scratch&) const override {
    add_spring_densities(connections_, constants_, positions, densities);
  }
  void add_forces(const Positions& positions, const Graph& graph, Positions& forces, Scratch& scratch) const override {
    if (grid_) return grid_->add_forces(positions, forces, scratch);
    graph.add_flows(forces, [&](int c, int a, int b) -> Vector3 {
      const Vector3 d = positions.col(b) - positions.col(a);
      return spring_density(d.norm(), constants_[c], connections_.rest_length[c]) * d;
    });
  }
  void linearise(const Positions& positions) override { slopes_ = spring_slopes(connections_, constants_, positions); }
  void add_own_slopes(VectorX& slopes) const override { slopes += slopes_; }

 private:
  const Connections& connections_;
  VectorX constants_, slopes_;
  std::optional<GridSprings> grid_;
};

class UpdatedSprings final : public Elasticity {
 public:
  UpdatedSprings(const Body& body, ConstantsAt constants)
      : connections_(body.connections), constants_at_(std::move(constants)) {}

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<UpdatedSprings>(*this); }
  bool has_energy() const override { return false; }
  bool has_full_tangent() const override { return false; }
  double energy(const Positions&) const override { return 0; }
  void add_force_densities(const Positions& positions, VectorX& densities, Scratch&) const override {
    add_spring_densities(connections_, constants_at_(positions), positions, densities);
  }
  void linearise(const Positions& positions) override {
    slopes_ = spring_slopes(connections_, constants_at_(positions), positions);
  }
  void add_own_slopes(VectorX& slopes) const override { slopes += slopes_; }

 private:
  const Connections& connections_;
  ConstantsAt constants_at_;
  VectorX slopes_;
};

}  // namespace

std::unique_ptr<Elasticity> make_springs(const Body& body, VectorX constants) {
  return std::make_unique<Springs>(body, std::move(constants));
}

std::unique_ptr<Elasticity> make_updated_springs(const Body& body, ConstantsAt constants) {
  return std::make_unique<UpdatedSprings>(body, std::move(constants));
}

}  // namespace elastin
