#include "elastin/core/forces/loads.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "core/parallel/parallel.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

class Gravity final : public Load {
 public:
  Gravity(const Body& body, const Vector3& acceleration) : body_(body), acceleration_(acceleration) {}
  void add_forces(const State&, Positions& forces) const override {
    parallel_for(body_.size(), [&](int molecule) { forces.col(molecule) += body_.mass[molecule] * acceleration_; });
  }
  double energy(const State& state) const override {
    return -ordered_sum(owned_molecules(body_), [&](int molecule) {
      return body_.mass[molecule] * acceleration_.dot(state.positions.col(molecule) - body_.rest.col(molecule));
    });
  }

 private:
  const Body& body_;
  Vector3 acceleration_;
};

/// F = −c V, c [N s/m] one a molecule: Stokes's drag, mass-proportional damping.
class LinearDrag final : public Load {
 public:
  explicit LinearDrag(VectorX factor) : factor_(std::move(factor)) {}
  void add_forces(const State& state, Positions& forces) const override {
    parallel_for(static_cast<int>(factor_.size()),
                 [&](int molecule) { forces.col(molecule) -= factor_[molecule] * state.velocities.col(molecule); });
  }
  bool changes() const override { return true; }
  void add_change(const State&, const Positions&, const Positions& change, Positions& forces) const override {
    parallel_for(static_cast<int>(factor_.size()),
                 [&](int molecule) { forces.col(molecule) -= factor_[molecule] * change.col(molecule); });
  }
  void visit_blocks(const State&, double velocity_weight, const BlockVisitor& visit) const override {
    for (int molecule = 0; molecule < factor_.size(); ++molecule)
      visit(molecule, molecule, velocity_weight * factor_[molecule] * Matrix3::Identity());
  }
  bool acts_at_rest() const override { return false; }

 private:
  VectorX factor_;
};

class QuadraticDrag final : public Load {
 public:
  QuadraticDrag(const Body& body, double density, double drag_coefficient)
      : factor_(0.5 * density * drag_coefficient * std::numbers::pi * body.radius.array().square()) {}
  void add_forces(const State& state, Positions& forces) const override {
    parallel_for(static_cast<int>(factor_.size()), [&](int molecule) {
      const auto velocity = state.velocities.col(molecule);
      forces.col(molecule) -= factor_[molecule] * velocity.norm() * velocity;
    });
  }
  bool changes() const override { return true; }
  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override {
    for (int molecule = 0; molecule < factor_.size(); ++molecule) {
      const Vector3 velocity = state.velocities.col(molecule);
      const double speed = velocity.norm();
      if (speed > 0)
        visit(molecule, molecule,
              velocity_weight * factor_[molecule] *
                  (speed * Matrix3::Identity() + velocity * velocity.transpose() / speed));
    }
  }
  void add_change(const State& state, const Positions&, const Positions& change, Positions& forces) const override {
    for (int molecule = 0; molecule < factor_.size(); ++molecule) {
      const Vector3 velocity = state.velocities.col(molecule), delta = change.col(molecule);
      const double speed = velocity.norm();
      if (speed > 0)
        forces.col(molecule) -= factor_[molecule] * (speed * delta + velocity * (velocity.dot(delta) / speed));
    }
  }
  bool acts_at_rest() const override { return false; }

 private:
  VectorX factor_;
};

class Varying final : public ScaledLoad {
 public:
  Varying(std::unique_ptr<Load> load, TimeFunction function)
      : ScaledLoad(std::move(load)), function_(std::move(function)) {}
  bool steady() const override { return function_.constant() && load_->steady(); }

 private:
  double factor(double time) const override { return function_.value(time); }
  TimeFunction function_;
};

}  // namespace

void ScaledLoad::add_forces(const State& state, Positions& forces) const {
  whole_.setZero(3, forces.cols());
  load_->add_forces(state, whole_);
  forces += factor(state.time) * whole_;
}
void ScaledLoad::add_change(const State& state, const Positions& motion, const Positions& sped,
                            Positions& forces) const {
  whole_.setZero(3, forces.cols());
  load_->add_change(state, motion, sped, whole_);
  forces += factor(state.time) * whole_;
}
void ScaledLoad::visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const {
  const double scale = factor(state.time);
  const auto scaled = [&](int a, int b, const Matrix3& block) { visit(a, b, scale * block); };
  load_->visit_blocks(state, velocity_weight, std::ref(scaled));
}
std::vector<WideTerm> ScaledLoad::wide_terms(const State& state) const {
  std::vector<WideTerm> terms = load_->wide_terms(state);
  for (WideTerm& term : terms) term.factor *= factor(state.time);
  return terms;
}
void ScaledLoad::add_resistance(const State& state, Positions& forces) const {
  whole_.setZero(3, forces.cols());
  load_->add_resistance(state, whole_);
  forces += factor(state.time) * whole_;
}
double ScaledLoad::square_frequency(const State& state, double ahead) const {
  const double most = std::max(std::abs(factor(state.time)), std::abs(factor(state.time + ahead)));
  return most * load_->square_frequency(state, ahead);
}

std::unique_ptr<Load> make_varying(std::unique_ptr<Load> load, TimeFunction function) {
  return std::make_unique<Varying>(std::move(load), std::move(function));
}

PointLoads::PointLoads(const Body& body, std::vector<int> molecules, Positions forces)
    : body_(body), molecules_(std::move(molecules)), forces_(std::move(forces)) {}

void PointLoads::add_forces(const State&, Positions& forces) const {
  for (std::size_t i = 0; i < molecules_.size(); ++i)
    forces.col(molecules_[i]) += factor_ * forces_.col(static_cast<Eigen::Index>(i));
}

double PointLoads::energy(const State& state) const {
  double work = 0;
  for (std::size_t i = 0; i < molecules_.size(); ++i)
    if (molecules_[i] < owned_molecules(body_))
      work += forces_.col(static_cast<Eigen::Index>(i))
                  .dot(state.positions.col(molecules_[i]) - body_.rest.col(molecules_[i]));
  return -factor_ * work;
}

std::unique_ptr<Load> make_gravity(const Body& body, const Vector3& acceleration) {
  return std::make_unique<Gravity>(body, acceleration);
}
std::unique_ptr<Load> make_stokes_drag(const Body& body, double viscosity) {
  return std::make_unique<LinearDrag>(6 * std::numbers::pi * viscosity * body.radius);
}
std::unique_ptr<Load> make_mass_damping(const Body& body, double rate) {
  return std::make_unique<LinearDrag>(rate * body.mass);
}
std::unique_ptr<Load> make_quadratic_drag(const Body& body, double density, double drag_coefficient) {
  return std::make_unique<QuadraticDrag>(body, density, drag_coefficient);
}

}  // namespace elastin
