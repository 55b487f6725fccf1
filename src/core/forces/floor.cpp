#include <algorithm>
#include <limits>

#include "core/forces/floor.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

/// How deep each sphere is pressed in, and what that does.
class HalfSpace {
 public:
  HalfSpace(const Body& body, const Floor& floor) : body_(body), floor_(floor) { floor_.normal.normalize(); }
  double depth(const State& state, int molecule) const {
    return body_.radius[molecule] - floor_.normal.dot(state.positions.col(molecule) - floor_.point);
  }
  /// Depth over which the resistance sets in.
  double onset(int molecule) const { return 0.1 * body_.radius[molecule]; }
  /// The least mass of what touches within the next `ahead` [s]; infinite of nothing.
  double least_mass(const State& state, double ahead) const {
    double least = std::numeric_limits<double>::infinity();
    for (int molecule = 0; molecule < body_.size(); ++molecule)
      if (depth(state, molecule) + 1.5 * ahead * state.velocities.col(molecule).norm() > 0)
        least = std::min(least, body_.mass[molecule]);
    return least;
  }

 protected:
  const Body& body_;
  Floor floor_;
};

class FloorPenalty final : public Load, private HalfSpace {
 public:
  FloorPenalty(const Body& body, const Floor& floor) : HalfSpace(body, floor) {}
  const Floor& floor() const { return floor_; }

  void add_forces(const State& state, Positions& forces) const override {
    for (int molecule = 0; molecule < body_.size(); ++molecule) {
      const double d = depth(state, molecule), e = onset(molecule);
      if (d > 0) forces.col(molecule) += floor_.stiffness * (d < e ? d * d / (2 * e) : d - e / 2) * floor_.normal;
    }
  }
  double energy(const State& state) const override {
    double sum = 0;
    for (int molecule = 0; molecule < owned_molecules(body_); ++molecule) {
      const double d = depth(state, molecule), e = onset(molecule);
      if (d > 0) sum += floor_.stiffness * (d < e ? d * d * d / (6 * e) : e * e / 6 + (d - e) * d / 2);
    }
    return sum;
  }
  bool changes() const override { return true; }
  void add_change(const State& state, const Positions& change, const Positions&, Positions& forces) const override {
    for (int molecule = 0; molecule < body_.size(); ++molecule)
      forces.col(molecule) -= slope(state, molecule) * floor_.normal.dot(change.col(molecule)) * floor_.normal;
  }
  void visit_blocks(const State& state, double, const BlockVisitor& visit) const override {
    for (int molecule = 0; molecule < body_.size(); ++molecule)
      if (const double k = slope(state, molecule); k > 0)
        visit(molecule, molecule, k * floor_.normal * floor_.normal.transpose());
  }
  double square_frequency(const State& state, double ahead) const override {
    return floor_.stiffness / least_mass(state, ahead);
  }

 private:
  double slope(const State& state, int molecule) const {
    return floor_.stiffness * std::clamp(depth(state, molecule) / onset(molecule), 0., 1.);
  }
};

/// F = −c w (v·n) n, w growing from 0 to 1 with the depth as the stiffness does. That w changes with the position is
/// left out of the tangent: it is small where steps are.
class FloorDamping final : public Load, private HalfSpace {
 public:
  FloorDamping(const Body& body, const Floor& floor) : HalfSpace(body, floor) {}

  void add_forces(const State& state, Positions& forces) const override {
    add_change(state, state.positions, state.velocities, forces);
  }
  bool changes() const override { return true; }
  void add_change(const State& state, const Positions&, const Positions& change, Positions& forces) const override {
    for (int molecule = 0; molecule < body_.size(); ++molecule)
      forces.col(molecule) -= factor(state, molecule) * floor_.normal.dot(change.col(molecule)) * floor_.normal;
  }
  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override {
    for (int molecule = 0; molecule < body_.size(); ++molecule)
      if (const double c = factor(state, molecule); c > 0)
        visit(molecule, molecule, velocity_weight * c * floor_.normal * floor_.normal.transpose());
  }
  bool acts_at_rest() const override { return false; }
  double square_frequency(const State& state, double ahead) const override {
    const double rate = floor_.damping / least_mass(state, ahead);
    return rate * rate;
  }

 private:
  double factor(const State& state, int molecule) const {
    return floor_.damping * std::clamp(depth(state, molecule) / onset(molecule), 0., 1.);
  }
};

}  // namespace

double default_floor_stiffness(const Body& body, const Material& material) {
  const int owned = owned_molecules(body);
  return material.youngs_modulus * 2 * sum_over(body, body.radius.head(owned).sum()) /
         static_cast<double>(molecules_of_whole(body));
}

std::unique_ptr<Load> make_floor(const Body& body, const Floor& floor) {
  return std::make_unique<FloorPenalty>(body, floor);
}
const Floor* floor_of(const Load& load) {
  const auto* penalty = dynamic_cast<const FloorPenalty*>(&load);
  return penalty ? &penalty->floor() : nullptr;
}
std::unique_ptr<Load> make_floor_damping(const Body& body, const Floor& floor) {
  return std::make_unique<FloorDamping>(body, floor);
}

}  // namespace elastin
