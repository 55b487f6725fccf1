#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/dense.h"
#include "core/parallel/parallel.h"
#include "core/solve/implicit.h"
#include "core/solve/mixing.h"
#include "core/solve/steppers.h"

namespace elastin {
namespace {

constexpr int kMostIterations = 60;
constexpr int kPatience = 12;  ///< iterations in which the unbalanced force must halve
constexpr int kMemory = 5;     ///< last iterations that the next one is mixed of

/// What an elastic law says at one end of a step.
struct End {
  VectorX densities;        ///< q [N/m]
  VectorX squared_lengths;  ///< s [m²]
  double energy = 0;        ///< W [J]
};

/// The implicit midpoint rule with force densities that do exactly the work that the energy says: of any law that is
/// force densities
///   q = (q₀ + q₁)/2 + λ (s₁ − s₀),   ½ Σ q (s₁ − s₀) = W₁ − W₀,
/// along the lines between the molecules half-way. So energy and both momenta of a free body are kept, at any step
/// length and however fast it turns: the discrete gradient of [Gonzalez 2000], taken over all squared lengths at once.
/// Loads, damping and inertia are those half-way, and so is a rest that changes in time.
class EnergyMomentum final : public Implicit {
 public:
  explicit EnergyMomentum(const StaticOptions& options) : Implicit(options, 0, 0) {}

 private:
  /// Where the search stands: x₁, the unbalanced force, and the size of all that it is the sum of.
  struct Trial {
    Positions positions, unbalanced;
    double norm = 0, scale = 0;
  };

  void try_step(Model& model, State& state, double dt, StepResult& result) override {
    if (model.drive) {  // the forces that it sets are those half-way, the supports those at the end
      model.drive(state.time + dt, model.supports);
      ends_ = model.supports;
      model.drive(state.time + dt / 2, model.supports);
      model.supports = ends_;
    }
    model.begin_step(state, state.time + dt / 2);
    dt_ = dt;
    set_end(model, state.positions, begin_);
    next_.carry_over(state);
    go_to_end(model, state, result);
    if (result.outcome != Outcome::converged) return;
    // A limit of depth holds at the step's end: met half-way alone, the ends would swing about it.
    if (made_by_pushes(model, state, next_, 0.5) > 0. || model.update_multipliers(next_)) {
      const PushesAtEnd at_end(model, state, 0.5, 1);
      middle_.carry_over(next_);
      balance_with_multipliers(model, middle_, false, result, [&] {
        next_.carry_over(middle_);
        go_to_end(model, state, result);
      });
      if (result.outcome != Outcome::converged) return;
    }
    if (model.max_step_fraction(state, next_) < 1) {
      result.outcome = Outcome::limit_reached;
      result.cause = "something would be passed through within a step";
      return;
    }
    if (model.drive) model.drive(state.time + dt, model.supports);
    model.begin_step(state, state.time + dt);
    model.commit_step(next_);
    ++result.substeps;
    result.cause.clear();
    const double change = (next_.accelerations - state.accelerations).colwise().squaredNorm().maxCoeff();
    result.error = dt * dt / 12 * std::sqrt(change);
    std::swap(state, next_);
  }

  /// The step with the history, of which multipliers are a part, that `next_` has.
  void go_to_end(Model& model, const State& state, StepResult& result) {
    set_first_guess(model, state);
    if (!balance(model, state, result)) return;
    if (model.supports.empty()) keep_momentum(model, state);
    next_.positions = now_.positions;
    next_.velocities = 2 / dt_ * (now_.positions - state.positions) - state.velocities;
    if (model.supports.empty()) keep_momentum_of(model, state);
    move_with_supports(model.supports, next_.velocities);
    next_.accelerations = (next_.velocities - state.velocities) / dt_;
    next_.time = state.time + dt_;
    set_middle(state, now_.positions);
  }

  void set_middle(const State& state, const Positions& positions) {
    middle_.carry_over(next_);
    middle_.time = state.time + dt_ / 2;
    middle_.positions = 0.5 * (state.positions + positions);
    middle_.velocities = (positions - state.positions) / dt_;
  }

  void set_end(const Model& model, const Positions& positions, End& end) {
    const Body& body = model.body();
    const int connections = body.connections.size();
    end.densities.setZero(connections);
    for (const auto* law : model.edge_laws())
      law->add_force_densities(positions, end.densities, workspace_.trials.force_pass);
    end.squared_lengths.resize(connections);
    parallel_for(connections, [&](int c) {
      const auto& [a, b] = body.connections.ends[c];
      end.squared_lengths[c] = (positions.col(b) - positions.col(a)).squaredNorm();
    });
    end.energy = model.elastic_energy(positions);
  }

  /// As if nothing changed: a free body goes on turning, any other goes straight on.
  void set_first_guess(const Model& model, const State& state) {
    const Positions &x = state.positions, &v = state.velocities;
    const VectorX& mass = model.body().mass;
    now_.positions = x + dt_ * v;
    turn_ = Matrix3::Identity();
    if (model.supports.empty()) {
      const Vector3 centre = x * mass / mass.sum(), velocity = v * mass / mass.sum();
      Matrix3 inertia = Matrix3::Zero();
      Vector3 momentum = Vector3::Zero();
      for (int i = 0; i < x.cols(); ++i) {
        const Vector3 r = x.col(i) - centre;
        inertia += mass[i] * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
        momentum += mass[i] * r.cross(v.col(i) - velocity);
      }
      const Vector3 spin = symmetric_pseudoinverse(inertia) * momentum;
      const double angle = dt_ * spin.norm();
      if (angle > 1e-6 && angle < 2) {
        const Matrix3 rotation = Eigen::AngleAxisd(angle, spin.normalized()).toRotationMatrix();
        for (int i = 0; i < x.cols(); ++i) {
          const Vector3 r = x.col(i) - centre, deforming = v.col(i) - velocity - spin.cross(r);
          now_.positions.col(i) = centre + dt_ * velocity + rotation * (r + dt_ * deforming);
        }
        turn_ = (0.5 * (Matrix3::Identity() + rotation.transpose())).inverse();
      }
    }
    apply_supports(model, now_.positions);
    if (model.admissible(now_.positions)) return;
    now_.positions = x;
    turn_ = Matrix3::Identity();
    apply_supports(model, now_.positions);
  }

  /// The unbalanced force half-way of a step from `state` to the trial's positions.
  void evaluate(const Model& model, const State& state, Trial& trial) {
    set_end(model, trial.positions, end_);
    change_ = end_.squared_lengths - begin_.squared_lengths;
    mean_ = 0.5 * (begin_.densities + end_.densities);
    const int connections = static_cast<int>(change_.size());
    const double work = ordered_sum(connections, [&](int c) { return 0.5 * mean_[c] * change_[c]; });
    const double size = ordered_sum(connections, [&](int c) { return 0.5 * std::abs(mean_[c] * change_[c]); });
    const double squares = ordered_sum(connections, [&](int c) { return 0.5 * change_[c] * change_[c]; });
    const double lacking = end_.energy - begin_.energy - work;
    // Less than rounding of the energies is nothing to correct; nor is more than such forces can lack, which in a small
    // motion is rounding too, and over the motion's square a large force.
    const double noise = 8 * std::numeric_limits<double>::epsilon() * (begin_.energy + end_.energy + size);
    const double most = ordered_sum(
        connections, [&](int c) { return 0.5 * std::abs((end_.densities[c] - begin_.densities[c]) * change_[c]); });
    if (std::abs(lacking) > noise && squares > 0) mean_ += std::clamp(lacking, -most, most) / squares * change_;

    set_middle(state, trial.positions);
    trial.unbalanced.setZero(3, model.body().size());
    model.gather(middle_.positions, mean_, trial.unbalanced);
    trial.scale = ordered_norm(trial.unbalanced);
    spare_.setZero(3, model.body().size());
    model.add_other_forces(middle_, spare_, workspace_.trials.force_pass);
    trial.scale += ordered_norm(spare_);
    trial.unbalanced += spare_;
    spare_ = (2 / dt_ * (middle_.velocities - state.velocities)) * model.body().mass.asDiagonal();
    trial.scale += ordered_norm(spare_);
    trial.unbalanced -= spare_;
    keep_free(model.supports, trial.unbalanced);
    trial.norm = ordered_norm(trial.unbalanced);
  }

  /// Newton's method with half the stiffness at the step's end, turned half-way back, as the matrix: not quite the
  /// derivative, so each motion is mixed with the last ones.                                     [Anderson 1965]
  bool balance(Model& model, const State& state, StepResult& result) {
    if (model.supports.empty()) keep_momentum(model, state);
    workspace_.solver.forget();
    evaluate(model, state, now_);
    mixing_.begin(now_.positions.cols());
    cut_ = false;
    double last_norm = 0;
    for (int iteration = 0; iteration <= kMostIterations; ++iteration) {
      if (!std::isfinite(now_.norm + now_.scale)) break;
      middle_.positions = now_.positions;
      const Weights weights{2 / dt_, 4 / (dt_ * dt_)};
      if (!workspace_.tangent || &workspace_.tangent->model() != &model)
        workspace_.tangent = std::make_unique<Tangent>(model, middle_, weights);
      else
        workspace_.tangent->linearise_at(middle_, weights);
      const double floor = rounding_floor(*workspace_.tangent, now_.positions);
      if (now_.norm <= std::max(newton_.tolerance * now_.scale, 2 * floor)) return true;
      if (iteration == kMostIterations) break;
      if (iteration % kPatience == 0) {  // a shorter step gets there sooner
        if (iteration > 0 && now_.norm > 0.5 * last_norm) break;
        last_norm = now_.norm;
      }
      forces_.noalias() = 2 * turn_ * now_.unbalanced;
      keep_free(model.supports, forces_);
      UsedSolver used;
      const LinearResult solved = solve_linear(*workspace_.tangent, model.supports, forces_, 1e-3, newton_, true,
                                               motion_, used, workspace_.solver);
      ++result.newton_iterations;
      result.linear_iterations += solved.iterations;
      if (!motion_.allFinite() || !move(model, state)) break;
    }
    result.outcome = cut_ ? Outcome::inverted : Outcome::limit_reached;
    result.cause = cut_ ? "any further step would invert a cell" : "the iterations find no balance";
    return false;
  }

  /// Goes by the motion, mixed with the last ones; half as far, and alone, where that inverts a cell.
  bool move(const Model& model, const State& state) {
    mixed_ = motion_;
    mixing_.mix(now_.positions, mixed_);
    before_ = now_.positions;
    for (double part = 1; part > 1e-3; part /= 2) {
      now_.positions = before_ + part * (part == 1 ? mixed_ : motion_);
      cut_ = !model.admissible(now_.positions) || (cut_ && part < 1);
      if (!model.admissible(now_.positions)) continue;
      evaluate(model, state, now_);
      if (!std::isfinite(now_.norm)) continue;
      return true;
    }
    return false;
  }

  /// What iterations leave unbalanced of a free body's whole force would add up over the steps: it moves as one.
  void keep_momentum(const Model& model, const State& state) {
    evaluate(model, state, now_);
    const Vector3 missing = now_.unbalanced.rowwise().sum() / model.body().mass.sum();
    now_.positions.colwise() += dt_ * dt_ / 2 * missing;
  }

  /// Positions have the rounding of where the body is, which their differences in time would hand on.
  void keep_momentum_of(const Model& model, const State& state) {
    const VectorX& mass = model.body().mass;
    spare_.setZero(3, mass.size());
    model.add_other_forces(middle_, spare_, workspace_.trials.force_pass);  // those within the body cancel
    const Vector3 change = dt_ * spare_.rowwise().sum();
    const Vector3 missing = change - (next_.velocities - state.velocities) * mass;
    next_.velocities.colwise() += missing / mass.sum();
  }

  double dt_ = 0;
  std::vector<Support> ends_;  // of the step's supports
  End begin_, end_;
  Matrix3 turn_;  ///< from half-way to the end of the step, as far as the body turns as one
  Trial now_;
  State middle_, next_;
  VectorX change_, mean_;
  Positions spare_, forces_, motion_, mixed_, before_;
  Mixing mixing_{kMemory};
  bool cut_ = false;  ///< whether the last iteration went less far, for a cell that would be inverted
};

std::string unsuited_for_energy_momentum(const Model& model) {
  if (!model.nodal_laws().empty())
    return "energy_momentum needs a law that is force densities, as those of first-order cells are";
  if (!model.has_energy()) return "energy_momentum needs a law with an energy to keep";
  if (model.dissipates()) return "energy_momentum keeps the energy that this law would dissipate";
  return "";
}

}  // namespace

StepperKind energy_momentum() {
  return {{"energy_momentum",
           "implicit, order 2: keeps energy and both momenta of a free body at any step, also of one that spins",
           "[Gonzalez 2000], over force densities",
           {}},
          false,
          2,
          [](const ParameterValues&, const StaticOptions& newton) { return std::make_unique<EnergyMomentum>(newton); },
          unsuited_for_energy_momentum,
          {}};
}

}  // namespace elastin
