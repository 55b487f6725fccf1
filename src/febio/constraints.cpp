#include "febio/constraints.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/base/cross_matrix.h"
#include "core/model/block_geometry.h"

namespace elastin::febio {
namespace {

/// Multipliers as history, with the count of augmentations of the increment behind them.
class Augmented : public TimedLoad {
 public:
  Augmented(std::string name, std::size_t multipliers, const Augmentation& augmentation)
      : name_(std::move(name)), multipliers_(multipliers), augmentation_(augmentation) {}

  void set_time(double) override {}
  bool changes() const override { return true; }
  std::vector<HistoryBlock> history() const override {
    if (!augmentation_.on) return {};
    return {{name_, std::vector<double>(multipliers_ + 1)}};
  }
  void commit_step(State& state) const override {
    if (HistoryBlock* block = state.find_history(name_)) block->values.back() = 0;
  }
  bool update_multipliers(State& state) const override {
    HistoryBlock* block = state.find_history(name_);
    if (!block) return false;
    double before = 0, after = 0;
    std::vector<double> next(multipliers_);
    for (std::size_t i = 0; i < multipliers_; ++i) {
      next[i] = grown(state, i, block->values[i]);
      before += block->values[i] * block->values[i];
      after += next[i] * next[i];
    }
    before = std::sqrt(before), after = std::sqrt(after);
    const double change = after > 0 ? std::abs(after - before) / after : 0;
    const double count = block->values.back();
    const bool enough =
        (change <= augmentation_.tolerance && count >= augmentation_.least) || count >= augmentation_.most;
    if (enough) return false;
    std::copy(next.begin(), next.end(), block->values.begin());
    block->values.back() = count + 1;
    return true;
  }
  void add_change(const State& state, const Positions& dx, const Positions&, Positions& change) const override {
    visit_blocks(state, 0, [&](int a, int b, const Matrix3& block) { change.col(a) -= block * dx.col(b); });
  }

 protected:
  double multiplier(const State& state, std::size_t number) const {
    const HistoryBlock* block = state.find_history(name_);
    return block ? block->values[number] : 0;
  }
  /// What a multiplier becomes where the state is in balance.
  virtual double grown(const State& state, std::size_t number, double multiplier) const = 0;

 private:
  std::string name_;
  std::size_t multipliers_;
  Augmentation augmentation_;
};

class Gaps final : public Augmented {
 public:
  Gaps(const Body& body, GapConstraint constraint, int number)
      : Augmented("febio_constraint_" + std::to_string(number), constraint.gaps.size(), constraint.augmentation),
        body_(body),
        own_(std::move(constraint)) {}

  void set_time(double time) override { shift_ = own_.shift.at(time); }

  void add_forces(const State& state, Positions& forces) const override {
    for (std::size_t i = 0; i < own_.gaps.size(); ++i) {
      const Gap& gap = own_.gaps[i];
      const double force = gap.weight * grown(state, i, multiplier(state, i));
      for (const Gap::Term& term : gap.terms) forces(term.axis, term.molecule) -= force * term.coefficient;
    }
  }
  double energy(const State& state) const override {
    double sum = 0;
    for (std::size_t i = 0; i < own_.gaps.size(); ++i) {
      const double before = multiplier(state, i), now = grown(state, i, before);
      sum += own_.gaps[i].weight * (now * now - before * before) / (2 * own_.penalty);
    }
    return sum;
  }
  void visit_blocks(const State& state, double, const BlockVisitor& visit) const override {
    for (std::size_t i = 0; i < own_.gaps.size(); ++i) {
      const Gap& gap = own_.gaps[i];
      if (own_.one_sided && grown(state, i, multiplier(state, i)) == 0) continue;
      for (const Gap::Term& a : gap.terms)
        for (const Gap::Term& b : gap.terms) {
          Matrix3 block = Matrix3::Zero();
          block(a.axis, b.axis) = gap.weight * own_.penalty * a.coefficient * b.coefficient;
          visit(a.molecule, b.molecule, block);
        }
    }
  }

 private:
  double grown(const State& state, std::size_t number, double multiplier) const override {
    const double whole = multiplier + own_.penalty * value(own_.gaps[number], state);
    return own_.one_sided ? std::max(whole, 0.) : whole;
  }
  double value(const Gap& gap, const State& state) const {
    double sum = gap.start + shift_;
    for (const Gap::Term& term : gap.terms)
      sum += term.coefficient *
             (state.positions(term.axis, term.molecule) - body_.rest(term.axis, term.molecule) + term.offset);
    return sum;
  }

  const Body& body_;
  GapConstraint own_;
  double shift_ = 0;
};

class Dilatations final : public Augmented {
 public:
  Dilatations(const Body& body, const DilatationConstraint& constraint)
      : Augmented("febio_dilatation_" + std::to_string(constraint.block),
                  static_cast<std::size_t>(block_of(body, constraint).size()), constraint.augmentation),
        block_(block_of(body, constraint)),
        modulus_(constraint.modulus) {
    for (int cell = 0; cell < block_.size(); ++cell) rest_.push_back(volume_of(cell, body.rest));
  }

  void add_forces(const State& state, Positions& forces) const override {
    for (int cell = 0; cell < block_.size(); ++cell) {
      const double force = strength(state, cell) / volume_of(cell, state.positions);
      if (force == 0) continue;
      const auto nodes = block_.cell(cell);
      const Eigen::MatrixXd gradient = gradient_of(cell, state.positions);
      for (std::size_t a = 0; a < nodes.size(); ++a)
        forces.col(nodes[a]) -= force * gradient.col(static_cast<Eigen::Index>(a));
    }
  }
  double energy(const State& state) const override {
    double sum = 0;
    for (int cell = 0; cell < block_.size(); ++cell)
      if (const double own = strength(state, cell); own != 0) sum += own * log_dilatation(state, cell);
    return sum;
  }
  void visit_blocks(const State& state, double, const BlockVisitor& visit) const override {
    for (int cell = 0; cell < block_.size(); ++cell) {
      const double volume = volume_of(cell, state.positions), force = strength(state, cell) / volume;
      if (force == 0) continue;
      const auto nodes = block_.cell(cell);
      const Eigen::MatrixXd gradient = gradient_of(cell, state.positions);
      const Eigen::MatrixXd x = positions_of(state.positions, nodes);
      const auto count = static_cast<Eigen::Index>(nodes.size());
      for (Eigen::Index a = 0; a < count; ++a)
        for (Eigen::Index b = 0; b < count; ++b) {
          Matrix3 own = -gradient.col(a) * gradient.col(b).transpose() / volume;
          for (std::size_t g = 0; g < block_.kind->slopes.size(); ++g) {
            const Eigen::MatrixXd& N = block_.kind->slopes[g];
            const Matrix3 edges = x * N.transpose();
            // ∂²det/∂x_i∂x_j = ±[x_k]×.
            for (int k = 0; k < 3; ++k) {
              const int i = (k + 1) % 3, j = (k + 2) % 3;
              own += block_.kind->weights[static_cast<Eigen::Index>(g)] * (N(j, a) * N(i, b) - N(i, a) * N(j, b)) *
                     cross_matrix(edges.col(k));
            }
          }
          visit(nodes[a], nodes[b], force * own);
        }
    }
  }

 private:
  static const CellBlock& block_of(const Body& body, const DilatationConstraint& constraint) {
    return body.blocks[constraint.block];
  }
  double grown(const State& state, std::size_t number, double multiplier) const override {
    return multiplier + modulus_ * log_dilatation(state, static_cast<int>(number));
  }
  double strength(const State& state, int cell) const {
    return multiplier(state, static_cast<std::size_t>(cell)) * rest_[cell];
  }
  double log_dilatation(const State& state, int cell) const {
    return std::log(volume_of(cell, state.positions) / rest_[cell]);
  }
  double volume_of(int cell, const Positions& positions) const {
    const Eigen::MatrixXd x = positions_of(positions, block_.cell(cell));
    double volume = 0;
    for (std::size_t g = 0; g < block_.kind->slopes.size(); ++g)
      volume += block_.kind->weights[static_cast<Eigen::Index>(g)] *
                Matrix3(x * block_.kind->slopes[g].transpose()).determinant();
    return volume;
  }
  Eigen::MatrixXd gradient_of(int cell, const Positions& positions) const {
    const Eigen::MatrixXd x = positions_of(positions, block_.cell(cell));
    Eigen::MatrixXd gradient = Eigen::MatrixXd::Zero(3, x.cols());
    for (std::size_t g = 0; g < block_.kind->slopes.size(); ++g) {
      const Matrix3 edges = x * block_.kind->slopes[g].transpose();
      Matrix3 cofactor;
      for (int k = 0; k < 3; ++k)
        cofactor.col(k) = Vector3(edges.col((k + 1) % 3)).cross(Vector3(edges.col((k + 2) % 3)));
      gradient += block_.kind->weights[static_cast<Eigen::Index>(g)] * cofactor * block_.kind->slopes[g];
    }
    return gradient;
  }

  const CellBlock& block_;
  double modulus_;
  std::vector<double> rest_;  ///< V of the cells
};

class EnclosedVolume final : public Augmented {
 public:
  EnclosedVolume(const Body& body, VolumeConstraint constraint, int number)
      : Augmented("febio_volume_" + std::to_string(number), 1, constraint.augmentation),
        first_("febio_volume_" + std::to_string(number) + "_first"),
        own_(std::move(constraint)),
        rest_(volume(body.rest)) {}

  void set_step(int step) override { active_ = own_.step < 0 || own_.step == step; }

  std::vector<HistoryBlock> history() const override {
    std::vector<HistoryBlock> all = Augmented::history();
    all.push_back({first_, {rest_}});
    return all;
  }
  void commit_step(State& state) const override {
    Augmented::commit_step(state);
    if (HistoryBlock* first = state.find_history(first_); first && !active_) first->values[0] = volume(state.positions);
  }
  bool update_multipliers(State& state) const override { return active_ && Augmented::update_multipliers(state); }

  void add_forces(const State& state, Positions& forces) const override {
    if (!active_) return;
    const double pressure = grown(state, 0, multiplier(state, 0));
    visit_face_points(own_.faces, state.positions, [&](const FacePoint& at) {
      const Vector3 force = pressure * at.weight * at.edges.col(0).cross(at.edges.col(1));
      for (Eigen::Index a = 0; a < at.values.size(); ++a) forces.col(at.nodes[a]) += at.values[a] * force;
    });
  }
  double energy(const State& state) const override {
    if (!active_) return 0;
    const double change = volume(state.positions) - first(state);
    return -(multiplier(state, 0) + own_.penalty / 2 * change) * change;
  }
  void visit_blocks(const State& state, double, const BlockVisitor& visit) const override {
    if (!active_) return;
    const double pressure = grown(state, 0, multiplier(state, 0));
    std::map<int, Vector3> gradient;
    visit_face_points(own_.faces, state.positions, [&](const FacePoint& at) {
      const Vector3 r = at.edges.col(0), s = at.edges.col(1), area = at.weight * r.cross(s);
      for (Eigen::Index a = 0; a < at.values.size(); ++a)
        gradient.try_emplace(at.nodes[a], Vector3::Zero()).first->second += at.values[a] * area;
      for (Eigen::Index b = 0; b < at.values.size(); ++b) {
        const Matrix3 block = at.slopes(1, b) * cross_matrix(r) - at.slopes(0, b) * cross_matrix(s);
        for (Eigen::Index a = 0; a < at.values.size(); ++a)
          visit(at.nodes[a], at.nodes[b], -pressure * at.weight * at.values[a] * block);
      }
    });
    for (const auto& [a, of_a] : gradient)
      for (const auto& [b, of_b] : gradient) visit(a, b, -own_.penalty * of_a * of_b.transpose());
  }

 private:
  double volume(const Positions& positions) const {
    double sum = 0;
    visit_face_points(own_.faces, positions, [&](const FacePoint& at) {
      sum += at.weight / 3 * at.position.dot(Vector3(at.edges.col(0)).cross(Vector3(at.edges.col(1))));
    });
    return sum;
  }
  double first(const State& state) const {
    const HistoryBlock* block = state.find_history(first_);
    return block ? block->values[0] : rest_;
  }
  double grown(const State& state, std::size_t, double multiplier) const override {
    return multiplier + own_.penalty * (volume(state.positions) - first(state));
  }

  std::string first_;
  VolumeConstraint own_;
  double rest_;
  bool active_ = true;
};

}  // namespace

std::unique_ptr<TimedLoad> make_volume_constraint(const Body& body, VolumeConstraint constraint, int number) {
  return std::make_unique<EnclosedVolume>(body, std::move(constraint), number);
}
std::unique_ptr<TimedLoad> make_gap_constraint(const Body& body, GapConstraint constraint, int number) {
  return std::make_unique<Gaps>(body, std::move(constraint), number);
}
std::unique_ptr<TimedLoad> make_dilatation_constraint(const Body& body, const DilatationConstraint& constraint) {
  return std::make_unique<Dilatations>(body, constraint);
}

}  // namespace elastin::febio
