#include "core/forces/volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#if __has_include(<memory_resource>)
#include <memory_resource>
#endif
#include <optional>
#include <utility>

#include "core/base/cross_matrix.h"
#include "core/forces/volume_groups.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/cells.h"
#include "elastin/core/shapes/cell_shape.h"

namespace elastin {
namespace {

using AreaVectors = Eigen::Matrix<double, 3, 4>;

/// n_a = ∂V/∂x_a [m²] of the signed volume: a third of the area vector of the face across corner a, inward.
AreaVectors volume_gradient(const Positions& positions, const std::array<int, 4>& cell) {
  const Vector3 origin = positions.col(cell[0]);
  const Vector3 a = positions.col(cell[1]) - origin, b = positions.col(cell[2]) - origin,
                c = positions.col(cell[3]) - origin;
  AreaVectors n;
  n.col(1) = b.cross(c) / 6;
  n.col(2) = c.cross(a) / 6;
  n.col(3) = a.cross(b) / 6;
  n.col(0) = -(n.col(1) + n.col(2) + n.col(3));
  return n;
}

/// A tetrahedron as its squared lengths s see it. With G_ab = n_a·n_b / V², the dot products of the gradients of the
/// barycentric coordinates,
///   ∂V/∂s_ab = −½ V G_ab,  ∂²V/∂s_ab∂s_cd = ¼ V (G_ab G_cd − G_ac G_bd − G_ad G_bc).
struct Tetrahedron {
  CellVector<4> slope;  ///< ∂V/∂s [m]
  double volume;        ///< with its sign, kept off zero [m³]

  Tetrahedron() = default;
  Tetrahedron(const Positions& positions, const std::array<int, 4>& cell, double rest_volume) {
    static constexpr auto pairs = node_pairs<4>();
    const AreaVectors n = volume_gradient(positions, cell);
    volume = signed_volume(positions, cell);
    // The forces of a flat tetrahedron are finite, its force densities are not: they are those of one nearly flat.
    const double least = 1e-7 * rest_volume;
    if (std::abs(volume) < least) volume = volume < 0 ? -least : least;
    for (int c = 0; c < 6; ++c) slope[c] = -n.col(pairs[c][0]).dot(n.col(pairs[c][1])) / (2 * volume);
  }

  /// Σ_d ∂²V/∂s_c∂s_d δs_d [m].
  CellVector<4> change_of_slope(const CellVector<4>& change) const {
    static constexpr auto pairs = node_pairs<4>();
    Eigen::Matrix4d G = Eigen::Matrix4d::Zero(), D = G;
    for (int c = 0; c < 6; ++c) {
      const auto [a, b] = pairs[c];
      G(a, b) = G(b, a) = -2 * slope[c] / volume;
      D(a, b) = D(b, a) = change[c];
    }
    G.diagonal() = -G.rowwise().sum();
    const Eigen::Matrix4d turned = G * D * G;
    const double trace = -2 * slope.dot(change) / volume;  // Σ_cd G_cd δs_cd
    CellVector<4> result;
    for (int c = 0; c < 6; ++c)
      result[c] = volume / 4 * (G(pairs[c][0], pairs[c][1]) * trace - turned(pairs[c][0], pairs[c][1]));
    return result;
  }
};

bool has_sides(const Connections& connections, const Cells<4>& tetrahedra) {
  std::vector<std::array<int, 2>> known;
  known.reserve(connections.ends.size());
  for (const auto& [a, b] : connections.ends) known.push_back({std::min(a, b), std::max(a, b)});
  std::sort(known.begin(), known.end());
  const auto sides = sides_of(tetrahedra);
  return std::includes(known.begin(), known.end(), sides.begin(), sides.end());
}

/// Cubes where all their sides are connections, else tetrahedra.
std::optional<VolumeGroups> groups_of(const Body& body) {
  if (!body.cubes.empty()) {
    VolumeGroups groups = groups_of_cubes(body.cubes);
    if (has_sides(body.connections, groups.tetrahedra)) return groups;
  }
  if (body.tetrahedra.empty()) return std::nullopt;
  return groups_of_molecules(body.size(), body.tetrahedra);
}

class VolumeSlopes;

class Volume final : public EdgeDensities {
 public:
  Volume(const Body& body, VolumeGroups groups, double modulus)
      : body_(body), groups_(std::move(groups)), graph_(body.connections, groups_.tetrahedra), modulus_(modulus) {
    rest_volume_.resize(groups_.tetrahedra.size());
    group_volume_.resize(groups_.size());
    set_volumes(1);
  }

  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<Volume>(*this); }

  std::unique_ptr<Elasticity> on_subdomain(const Subdomain& own) const override {
    return body_.unstressed ? nullptr : std::unique_ptr<Elasticity>(new Volume(*this, own));
  }
  void set_rest(double part) override {
    if (body_.unstressed) set_volumes(part);
  }

  bool admissible(const Positions& positions) const override { return std::isfinite(energy(positions)); }

  double energy(const Positions& positions) const override {
    return ordered_sum(groups_.size(), [&](int group) {
      if (group_volume_[group] == 0) return 0.;  // no tetrahedron around this molecule
      double sum = 0;
      for (const int t : groups_.members[group]) sum += groups_.weight * signed_volume(positions, cell(t));
      const double ratio = sum / group_volume_[group];
      if (!(ratio > 0)) return std::numeric_limits<double>::infinity();
      return group_volume_[group] * modulus_ / 2 * (ratio - 1) * (ratio - 1);
    });
  }

  void add_force_densities(const Positions& positions, VectorX& force_densities, Workspace& workspace) const override {
    auto sums = workspace.buffer(Workspace::groups, groups_.size()),
         pressures = workspace.buffer(Workspace::cells, tetrahedra());
    set_pressures(positions, sums, pressures);
    auto slots = workspace.buffer(Workspace::slots, tetrahedra() * 6);
    parallel_for(tetrahedra(),
                 [&](int t) { slots.segment<6>(6 * t) = 2 * pressures[t] * tetrahedron(positions, t).slope; });
    graph_.gather(slots, force_densities);
  }

  bool coupled() const override { return true; }
  /// Where the groups are of other tetrahedra than the body's own, as those of cubes, these have no pressure.
  void show(const Positions& positions, VectorX& others, const StateVisitor& visit) const override {
    if (groups_.tetrahedra != body_.tetrahedra || has_blocks(body_, 3))
      return EdgeDensities::show(positions, others, visit);
    VectorX sums(groups_.size()), pressures(tetrahedra());
    set_pressures(positions, sums, pressures);
    for (int t = 0; t < tetrahedra(); ++t) {
      CellState state;
      state.stress.diagonal().setConstant(pressures[t]);
      visit(cell(t), state);
    }
  }
  std::unique_ptr<EdgeSlopes> slopes() const override;

 private:
  friend class VolumeSlopes;
  /// The groups that the subdomain computes: a molecule's by its owner, a cube's by that of its lowest corner.
  Volume(const Volume& whole, const Subdomain& own)
      : body_(*own.body),
        groups_(groups_on(whole.groups_, own, chosen_groups(whole.groups_, own))),
        graph_(own.body->connections, groups_.tetrahedra),
        modulus_(whole.modulus_) {
    const std::vector<int> chosen = chosen_groups(whole.groups_, own);
    group_volume_.resize(groups_.size());
    for (int group = 0; group < groups_.size(); ++group) group_volume_[group] = whole.group_volume_[chosen[group]];
    for (const auto& cell : groups_.tetrahedra) rest_volume_.push_back(signed_volume(own.body->rest, cell));
  }

  /// Without stress.
  void set_volumes(double part) {
    for (int t = 0; t < tetrahedra(); ++t) {
      rest_volume_[t] = signed_volume(body_.rest, cell(t));
      if (!body_.unstressed) continue;
      const Vector3 middle = body_.rest(Eigen::all, cell(t)).rowwise().mean();
      rest_volume_[t] *= body_.unstressed->at(middle, middle, part).determinant();
    }
    set_group_sums([&](int t) { return rest_volume_[t]; }, group_volume_);
  }
  int tetrahedra() const { return static_cast<int>(groups_.tetrahedra.size()); }
  const std::array<int, 4>& cell(int t) const { return groups_.tetrahedra[t]; }
  Tetrahedron tetrahedron(const Positions& positions, int t) const {
    return {positions, cell(t), std::abs(rest_volume_[t])};
  }

  /// Σ w value(T) over each group.
  template <class Value>
  void set_group_sums(Value value, Eigen::Ref<VectorX> sums) const {
    parallel_for(groups_.size(), [&](int group) {
      double sum = 0;
      for (const int t : groups_.members[group]) sum += groups_.weight * value(t);
      sums[group] = sum;
    });
  }

  /// Σ w κ ΔV_g/V_g over the groups of each tetrahedron [Pa], from the groups' changes of volume ΔV_g.
  void set_spread(Eigen::Ref<const VectorX> changes, Eigen::Ref<VectorX> pressures) const {
    parallel_for(tetrahedra(), [&](int t) {
      double sum = 0;
      for (const int group : groups_.groups_of[t]) sum += changes[group] / group_volume_[group];
      pressures[t] = groups_.weight * modulus_ * sum;
    });
  }

  /// What multiplies ∂V/∂x in the energy's gradient, of each tetrahedron [Pa]; `changes` of the groups' volumes [m³].
  void set_pressures(const Positions& positions, Eigen::Ref<VectorX> changes, Eigen::Ref<VectorX> pressures) const {
    set_group_sums([&](int t) { return signed_volume(positions, cell(t)); }, changes);
    changes -= group_volume_;
    set_spread(changes, pressures);
  }

  const Body& body_;
  VolumeGroups groups_;
  CellGraph graph_;
  double modulus_;
  std::vector<double> rest_volume_;
  VectorX group_volume_;
};

class VolumeSlopes final : public EdgeSlopes {
 public:
  explicit VolumeSlopes(const Volume& volume) : volume_(volume), groups_(volume.groups_) {}

  void linearise_at(const Positions& positions) override {
    positions_ = positions;
    changes_.resize(groups_.size());
    pressures_.resize(tetrahedra());
    volume_.set_pressures(positions, changes_, pressures_);
    now_.resize(tetrahedra());
    parallel_for(tetrahedra(), [&](int t) { now_[t] = volume_.tetrahedron(positions, t); });
  }

  void add_own_slopes(VectorX&) const override {}

  void add_change(const VectorX& change_of_squared_lengths, VectorX& change_of_force_densities,
                  Workspace& workspace) const override {
    auto changes = workspace.buffer(Workspace::changes, tetrahedra()),
         sums = workspace.buffer(Workspace::groups, groups_.size()),
         pressures = workspace.buffer(Workspace::cells, tetrahedra());
    const auto squared_lengths = [&](int t) {
      CellVector<4> change;
      for (int c = 0; c < 6; ++c) change[c] = change_of_squared_lengths[volume_.graph_.slot_connection[6 * t + c]];
      return change;
    };
    parallel_for(tetrahedra(), [&](int t) { changes[t] = now_[t].slope.dot(squared_lengths(t)); });
    volume_.set_group_sums([&](int t) { return changes[t]; }, sums);
    volume_.set_spread(sums, pressures);
    auto slots = workspace.buffer(Workspace::slots, tetrahedra() * 6);
    parallel_for(tetrahedra(), [&](int t) {
      CellVector<4> change = pressures[t] * now_[t].slope;
      if (pressures_[t] != 0) change += pressures_[t] * now_[t].change_of_slope(squared_lengths(t));
      slots.segment<6>(6 * t) = 2 * change;
    });
    volume_.graph_.gather(slots, change_of_force_densities);
  }

  void visit_blocks(const BlockVisitor& visit) const override {
    visit_group_blocks([&](int a, int b, const Matrix3& block) {
      visit(a, b, block);
      if (a != b) visit(b, a, block.transpose());
    });
    // A tetrahedron's own part: p ∂²V/∂x_a∂x_b = −p [e]×/6, e the side across, without the force densities 2p ∂V/∂s.
    static constexpr auto pairs = node_pairs<4>();
    static constexpr std::array<std::array<int, 2>, 6> across{{{2, 3}, {3, 1}, {1, 2}, {0, 3}, {2, 0}, {0, 1}}};
    for (int t = 0; t < tetrahedra(); ++t)
      for (int c = 0; c < 6; ++c) {
        const int a = cell(t)[pairs[c][0]], b = cell(t)[pairs[c][1]];
        const Matrix3 turn = cross_matrix(
            pressures_[t] / 6 * (positions_.col(cell(t)[across[c][1]]) - positions_.col(cell(t)[across[c][0]])));
        const Matrix3 density = 2 * pressures_[t] * now_[t].slope[c] * Matrix3::Identity();
        visit(a, b, density - turn);
        visit(b, a, density + turn);
        visit(a, a, -density);
        visit(b, b, -density);
      }
  }

  /// Without the parts of a tetrahedron's own, which are small where the pressure is against the modulus.
  bool visit_gradients(const GradientVisitor& visit) const override {
    GradientWorkspace workspace;
    for (int group = 0; group < groups_.size(); ++group)
      if (volume_.group_volume_[group] != 0) visit(group_gradient(group, workspace), stiffness(group));
    return true;
  }

  void visit_diagonal(const DiagonalVisitor& visit, Workspace&) const override {
    GradientWorkspace workspace;
    for (int group = 0; group < groups_.size(); ++group)
      for (const auto& [molecule, gradient] : group_gradient(group, workspace))
        visit(molecule, stiffness(group) * gradient * gradient.transpose());
    static constexpr auto pairs = node_pairs<4>();
    for (int t = 0; t < tetrahedra(); ++t)
      for (int c = 0; c < 6; ++c)
        for (const int corner : pairs[c])
          visit(cell(t)[corner], -2 * pressures_[t] * now_[t].slope[c] * Matrix3::Identity());
  }

 private:
#if __has_include(<memory_resource>)
  using Gradient = std::pmr::vector<std::pair<int, Vector3>>;
  /// Memory for one group's gradient after the other, without an allocation where groups are of usual size.
  struct GradientWorkspace {
    std::array<std::byte, 16384> bytes;
    std::pmr::monotonic_buffer_resource memory{bytes.data(), bytes.size()};
    Gradient sums{&memory};
  };
#else  // libc++ before version 16 has none
  using Gradient = std::vector<std::pair<int, Vector3>>;
  struct GradientWorkspace {
    Gradient sums;
  };
#endif

  /// ∂(Σ w V_T)/∂x of each molecule of a group [m²], ascending.
  const Gradient& group_gradient(int group, GradientWorkspace& workspace) const {
    workspace.sums.clear();
    for (const int t : groups_.members[group]) {
      const AreaVectors n = volume_gradient(positions_, cell(t));
      for (int corner = 0; corner < 4; ++corner) {
        const int molecule = cell(t)[corner];
        const auto at = std::lower_bound(workspace.sums.begin(), workspace.sums.end(), molecule,
                                         [](const auto& part, int wanted) { return part.first < wanted; });
        const Vector3 part = groups_.weight * n.col(corner);
        if (at != workspace.sums.end() && at->first == molecule)
          at->second += part;
        else
          workspace.sums.emplace(at, molecule, part);
      }
    }
    return workspace.sums;
  }

  /// visit(a, b, block) for a ≤ b of every group's κ/V_g ∂V_g/∂x_a ∂V_g/∂x_bᵀ.
  template <class Visit>
  void visit_group_blocks(Visit visit) const {
    GradientWorkspace workspace;
    for (int group = 0; group < groups_.size(); ++group) {
      const Gradient& gradient = group_gradient(group, workspace);
      for (std::size_t i = 0; i < gradient.size(); ++i)
        for (std::size_t j = i; j < gradient.size(); ++j)
          visit(gradient[i].first, gradient[j].first,
                stiffness(group) * gradient[i].second * gradient[j].second.transpose());
    }
  }
  int tetrahedra() const { return volume_.tetrahedra(); }
  const std::array<int, 4>& cell(int t) const { return volume_.cell(t); }
  /// κ over the group's volume [Pa/m³].
  double stiffness(int group) const { return volume_.modulus_ / volume_.group_volume_[group]; }

  const Volume& volume_;
  const VolumeGroups& groups_;
  // At the positions of linearise_at().
  Positions positions_;
  VectorX changes_;  // of the groups' volumes
  VectorX pressures_;
  std::vector<Tetrahedron> now_;
};

std::unique_ptr<EdgeSlopes> Volume::slopes() const { return std::make_unique<VolumeSlopes>(*this); }

}  // namespace

std::string unsuited_for_volumes(const Body& body) {
  if (body.cell_stiffness.size() || body.connection_stiffness.size())
    return "needs one stiffness for its volumes, and the body has regions";
  if (groups_of(body)) return "";
  return body.cubes.empty() ? "needs tetrahedra or cubes for its volumes: give the body cells: delaunay"
                            : "needs the lattice's axes and face diagonals for its volumes: connect them, or give the "
                              "body cells: delaunay";
}

std::unique_ptr<Elasticity> make_volume(const Body& body, double modulus) {
  auto groups = groups_of(body);
  if (!groups) throw InputError("a volume term " + unsuited_for_volumes(body));
  return std::make_unique<Volume>(body, std::move(*groups), modulus);
}

}  // namespace elastin
