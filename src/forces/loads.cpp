#include "elastin/forces/loads.h"

#include <numbers>
#include <utility>

namespace elastin {
namespace {

class Gravity final : public Load {
 public:
  Gravity(const Body& body, const Vector3& acceleration) : body_(body), acceleration_(acceleration) {}
  void add_forces(const State&, Positions& forces) const override { forces += acceleration_ * body_.mass.transpose(); }
  double energy(const State& state) const override {
    return -acceleration_.dot((state.positions - body_.rest) * body_.mass);
  }

 private:
  const Body& body_;
  Vector3 acceleration_;
};

/// Drag is a force along −V whose size is a function of |V|: linear (stokes) or quadratic.
class StokesDrag final : public Load {
 public:
  StokesDrag(const Body& body, double viscosity) : factor_(6 * std::numbers::pi * viscosity * body.radius) {}
  void add_forces(const State& state, Positions& forces) const override {
    forces -= state.velocities * factor_.asDiagonal();
  }
  void add_change(const State&, const Positions&, const Positions& change, Positions& forces) const override {
    forces -= change * factor_.asDiagonal();
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
    for (int molecule = 0; molecule < factor_.size(); ++molecule)
      forces.col(molecule) -=
          factor_[molecule] * state.velocities.col(molecule).norm() * state.velocities.col(molecule);
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

class Damping final : public Load {
 public:
  Damping(const Body& body, double coefficient) : connections_(body.connections), coefficient_(coefficient) {}

  void add_forces(const State& state, Positions& forces) const override {
    for (const auto& [a, b] : connections_.ends) {
      const Vector3 d = state.positions.col(b) - state.positions.col(a),
                    v = state.velocities.col(b) - state.velocities.col(a);
      const double square = d.squaredNorm();
      if (square == 0) continue;
      const Vector3 force = coefficient_ * d.dot(v) / square * d;
      forces.col(a) += force;
      forces.col(b) -= force;
    }
  }

  void add_change(const State& state, const Positions& dx, const Positions& dv, Positions& forces) const override {
    for (const auto& [a, b] : connections_.ends) {
      const Vector3 d = state.positions.col(b) - state.positions.col(a),
                    v = state.velocities.col(b) - state.velocities.col(a);
      const double square = d.squaredNorm();
      if (square == 0) continue;
      const Vector3 delta_d = dx.col(b) - dx.col(a), delta_v = dv.col(b) - dv.col(a);
      const double rate = d.dot(v) / square;  // relative lengthening rate; the force is b · rate · d
      const double change = (delta_d.dot(v) + d.dot(delta_v) - 2 * rate * d.dot(delta_d)) / square;
      const Vector3 force = coefficient_ * (change * d + rate * delta_d);
      forces.col(a) += force;
      forces.col(b) -= force;
    }
  }
  bool acts_at_rest() const override { return false; }

 private:
  const Connections& connections_;
  double coefficient_;
};

}  // namespace

PointLoads::PointLoads(const Body& body, std::vector<int> molecules, Positions forces)
    : body_(body), molecules_(std::move(molecules)), forces_(std::move(forces)) {}

void PointLoads::add_forces(const State&, Positions& forces) const {
  for (std::size_t i = 0; i < molecules_.size(); ++i)
    forces.col(molecules_[i]) += factor_ * forces_.col(static_cast<Eigen::Index>(i));
}

double PointLoads::energy(const State& state) const {
  double work = 0;
  for (std::size_t i = 0; i < molecules_.size(); ++i)
    work += forces_.col(static_cast<Eigen::Index>(i))
                .dot(state.positions.col(molecules_[i]) - body_.rest.col(molecules_[i]));
  return -factor_ * work;
}

std::unique_ptr<Load> make_gravity(const Body& body, const Vector3& acceleration) {
  return std::make_unique<Gravity>(body, acceleration);
}
std::unique_ptr<Load> make_stokes_drag(const Body& body, double viscosity) {
  return std::make_unique<StokesDrag>(body, viscosity);
}
std::unique_ptr<Load> make_quadratic_drag(const Body& body, double density, double drag_coefficient) {
  return std::make_unique<QuadraticDrag>(body, density, drag_coefficient);
}
std::unique_ptr<Load> make_damping(const Body& body, double coefficient) {
  return std::make_unique<Damping>(body, coefficient);
}

}  // namespace elastin
