#include "elastin/core/forces/ties.h"

#include <algorithm>
#include <array>

#include "core/parallel/parallel.h"

namespace elastin {
namespace {

class Ties final : public Load {
 public:
  explicit Ties(const Body& body) : body_(body) {}

  void add_forces(const State& state, Positions& forces) const override { add_pulls(state.positions, forces); }
  double energy(const State& state) const override {
    return ordered_sum(static_cast<int>(body_.ties.size()), [&](int t) {
      const Tie& tie = body_.ties[t];
      return tie.stiffness / 2 * gap(tie, state.positions).squaredNorm();
    });
  }
  bool changes() const override { return true; }
  void add_change(const State&, const Positions& change_of_positions, const Positions&,
                  Positions& change_of_forces) const override {
    add_pulls(change_of_positions, change_of_forces);
  }
  void visit_blocks(const State&, double, const BlockVisitor& visit) const override {
    for (const Tie& tie : body_.ties) {
      const std::array<int, 4> molecules{tie.molecule, tie.corners[0], tie.corners[1], tie.corners[2]};
      const std::array<double, 4> weights{1, -tie.weights[0], -tie.weights[1], -tie.weights[2]};
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
          visit(molecules[i], molecules[j], tie.stiffness * weights[i] * weights[j] * Matrix3::Identity());
    }
  }

 private:
  static Vector3 gap(const Tie& tie, const Positions& positions) {
    Vector3 gap = positions.col(tie.molecule);
    for (std::size_t j = 0; j < 3; ++j) gap -= tie.weights[j] * positions.col(tie.corners[j]);
    return gap;
  }
  void add_pulls(const Positions& positions, Positions& forces) const {
    for (const Tie& tie : body_.ties) {
      const Vector3 pull = tie.stiffness * gap(tie, positions);
      forces.col(tie.molecule) -= pull;
      for (std::size_t j = 0; j < 3; ++j) forces.col(tie.corners[j]) += tie.weights[j] * pull;
    }
  }

  const Body& body_;
};

}  // namespace

std::unique_ptr<Load> make_ties(const Body& body) { return std::make_unique<Ties>(body); }

}  // namespace elastin
