#include "febio/loads.h"

#include <Eigen/SparseCore>
#include <cmath>

namespace elastin::febio {
namespace {

class DeadLoads final : public TimedLoad {
 public:
  DeadLoads(const Body& body, std::vector<DeadLoad> loads) : body_(body), loads_(std::move(loads)) { set_time(0); }

  void set_time(double time) override {
    now_ = Positions::Zero(3, body_.size());
    for (const DeadLoad& load : loads_) now_ += load.factor.at(time) * load.forces;
  }
  void remove() override { now_.setZero(); }
  void add_forces(const State&, Positions& forces) const override { forces += now_; }
  double energy(const State& state) const override { return -now_.cwiseProduct(state.positions - body_.rest).sum(); }

 private:
  const Body& body_;
  std::vector<DeadLoad> loads_;
  Positions now_;
};

class TimedSurfaceForces final : public TimedLoad {
 public:
  TimedSurfaceForces(const Body& body, SurfaceLoad load)
      : factor_(std::move(load.factor)), forces_(body, std::move(load), 0) {
    set_time(0);
  }

  void set_time(double time) override { forces_.set_factor(factor_.at(time)); }
  void remove() override { forces_.set_factor(0); }
  bool changes() const override { return forces_.changes(); }
  bool has_energy() const override { return forces_.has_energy(); }
  bool follows_surface() const override { return forces_.follows_surface(); }
  bool symmetric() const override { return forces_.symmetric(); }
  void add_forces(const State& state, Positions& forces) const override { forces_.add_forces(state, forces); }
  double energy(const State& state) const override { return forces_.energy(state); }
  void add_change(const State& state, const Positions& dx, const Positions& dv, Positions& change) const override {
    forces_.add_change(state, dx, dv, change);
  }
  void visit_blocks(const State& state, double velocity_weight, const BlockVisitor& visit) const override {
    forces_.visit_blocks(state, velocity_weight, visit);
  }

 private:
  Value factor_;
  SurfaceForces forces_;
};

class LinearSprings final : public TimedLoad {
 public:
  LinearSprings(const Body& body, std::vector<LinearSpring> springs) : springs_(std::move(springs)) {
    for (const LinearSpring& spring : springs_) rest_.push_back(span_of(spring, body.rest).norm());
    set_time(0);
  }

  void set_time(double time) override {
    constants_.clear();
    for (const LinearSpring& spring : springs_) constants_.push_back(spring.stiffness.at(time));
  }
  bool changes() const override { return true; }

  void add_forces(const State& state, Positions& forces) const override {
    for (std::size_t i = 0; i < springs_.size(); ++i) {
      const auto [a, b] = springs_[i].ends;
      const Vector3 d = span_of(springs_[i], state.positions), force = constants_[i] * (1 - ratio(i, d)) * d;
      forces.col(a) += force;
      forces.col(b) -= force;
    }
  }
  double energy(const State& state) const override {
    double sum = 0;
    for (std::size_t i = 0; i < springs_.size(); ++i)
      sum += constants_[i] / 2 * std::pow(span_of(springs_[i], state.positions).norm() - rest_[i], 2);
    return sum;
  }
  void add_change(const State& state, const Positions& dx, const Positions&, Positions& change) const override {
    visit_blocks(state, 0, [&](int a, int b, const Matrix3& block) { change.col(a) -= block * dx.col(b); });
  }
  void visit_blocks(const State& state, double, const BlockVisitor& visit) const override {
    for (std::size_t i = 0; i < springs_.size(); ++i) {
      const auto [a, b] = springs_[i].ends;
      const Vector3 d = span_of(springs_[i], state.positions), u = d.stableNormalized();
      const double part = ratio(i, d);
      const Matrix3 block = constants_[i] * ((1 - part) * Matrix3::Identity() + part * u * u.transpose());
      visit(a, a, block), visit(b, b, block), visit(a, b, -block), visit(b, a, -block);
    }
  }

 private:
  static Vector3 span_of(const LinearSpring& spring, const Positions& x) {
    return x.col(spring.ends[1]) - x.col(spring.ends[0]);
  }
  /// l₀/l; 0 where both are.
  double ratio(std::size_t i, const Vector3& d) const { return rest_[i] == 0 ? 0 : rest_[i] / d.norm(); }

  std::vector<LinearSpring> springs_;
  std::vector<double> rest_, constants_;
};

class ConsistentInertia final : public Inertia {
 public:
  ConsistentInertia(const Body& body, const std::vector<MassPair>& mass, const Positions& accelerations)
      : body_(body), accelerations_(accelerations), mass_(body.size(), body.size()) {
    std::vector<Eigen::Triplet<double>> entries;
    for (const MassPair& pair : mass) entries.emplace_back(pair.a, pair.b, pair.mass);
    mass_.setFromTriplets(entries.begin(), entries.end());
  }

  void set_time(double time) override { time_ = time; }
  void set_integration(const Integration* integration) override { integration_ = integration; }

  std::vector<HistoryBlock> history() const override {
    const auto block = [](const char* name, const Positions& values) {
      return HistoryBlock{name, {values.data(), values.data() + values.size()}};
    };
    const Positions none = Positions::Zero(3, body_.size());
    return {
        {kTime, {0}}, block(kPositions, body_.rest), block(kVelocities, none), block(kAccelerations, accelerations_)};
  }

  void commit_step(State& state) const override {
    if (!state.find_history(kTime)) return;
    const auto moving = motion(state);
    if (moving) {
      const Positions a1 = acceleration(*moving, state.positions);
      const Positions v1 = moving->velocities +
                           moving->dt * ((1 - integration_->gamma) * moving->accelerations + integration_->gamma * a1);
      block(state, kAccelerations) = a1;
      block(state, kVelocities) = v1;
    }
    block(state, kPositions) = state.positions;
    state.find_history(kTime)->values[0] = time_;
  }

  bool changes() const override { return true; }
  void add_forces(const State& state, Positions& forces) const override {
    const auto moving = motion(state);
    if (!moving) return;
    const double now = integration_->alpha_mass;
    forces -= (now * acceleration(*moving, state.positions) + (1 - now) * moving->accelerations) * mass_;
  }
  double energy(const State& state) const override {
    const auto moving = motion(state);
    if (!moving) return 0;
    const Positions off = state.positions - moving->predicted;
    const double now = integration_->alpha_mass;
    double sum = now * moving->stiffness / 2 * (off * mass_).cwiseProduct(off).sum();
    if (now != 1) sum += (1 - now) * (moving->accelerations * mass_).cwiseProduct(state.positions - body_.rest).sum();
    return sum;
  }
  void add_change(const State& state, const Positions& dx, const Positions&, Positions& change) const override {
    if (const auto moving = motion(state)) change -= integration_->alpha_mass * moving->stiffness * (dx * mass_);
  }
  void visit_blocks(const State& state, double, const BlockVisitor& visit) const override {
    const auto moving = motion(state);
    if (!moving) return;
    for (int column = 0; column < mass_.outerSize(); ++column)
      for (Eigen::SparseMatrix<double>::InnerIterator entry(mass_, column); entry; ++entry)
        visit(static_cast<int>(entry.row()), column,
              integration_->alpha_mass * moving->stiffness * entry.value() * Matrix3::Identity());
  }

 private:
  static constexpr const char *kTime = "febio_0_time", *kPositions = "febio_1_positions",
                              *kVelocities = "febio_2_velocities", *kAccelerations = "febio_3_accelerations";

  /// From the state that was committed last.
  struct Motion {
    double dt, stiffness;  ///< 1/(β Δt²)
    Positions predicted, velocities, accelerations;
  };
  static Eigen::Map<Positions> block(State& state, const char* name) {
    std::vector<double>& values = state.find_history(name)->values;
    return {values.data(), 3, static_cast<Eigen::Index>(values.size()) / 3};
  }
  std::optional<Motion> motion(const State& state) const {
    const HistoryBlock* last = state.find_history(kTime);
    const double dt = last ? time_ - last->values[0] : 0;
    if (!integration_ || !(dt > 0)) return std::nullopt;
    State& same = const_cast<State&>(state);
    const double beta = integration_->beta;
    Motion result{dt, 1 / (beta * dt * dt), {}, block(same, kVelocities), block(same, kAccelerations)};
    result.predicted = block(same, kPositions) + dt * result.velocities + dt * dt * (0.5 - beta) * result.accelerations;
    return result;
  }
  static Positions acceleration(const Motion& moving, const Positions& positions) {
    return moving.stiffness * (positions - moving.predicted);
  }

  const Body& body_;
  Positions accelerations_;
  Eigen::SparseMatrix<double> mass_;
  double time_ = 0;
  const Integration* integration_ = nullptr;
};

}  // namespace

std::unique_ptr<TimedLoad> make_dead_loads(const Body& body, std::vector<DeadLoad> loads) {
  return std::make_unique<DeadLoads>(body, std::move(loads));
}
std::unique_ptr<TimedLoad> make_surface_load(const Body& body, SurfaceLoad load) {
  return std::make_unique<TimedSurfaceForces>(body, std::move(load));
}
std::unique_ptr<TimedLoad> make_linear_springs(const Body& body, std::vector<LinearSpring> springs) {
  return std::make_unique<LinearSprings>(body, std::move(springs));
}
std::unique_ptr<Inertia> make_inertia(const Body& body, const std::vector<MassPair>& mass,
                                      const Positions& accelerations) {
  return std::make_unique<ConsistentInertia>(body, mass, accelerations);
}

}  // namespace elastin::febio
