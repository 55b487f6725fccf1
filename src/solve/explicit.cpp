#include "solve/explicit.h"

#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "solve/newton.h"

namespace elastin {
namespace {

/// A molecule's part of an update costs as much as some ten connections.
constexpr int kMoleculeThreshold = kParallelThreshold / 10;

void set_accelerations(const Model& model, State& state, Scratch& scratch) {
  model.set_forces(state, state.accelerations, scratch);
  keep_free(model.supports, state.accelerations);
  const VectorX& mass = model.body().mass;
  parallel_for(
      model.body().size(), [&](int i) { state.accelerations.col(i) /= mass[i]; }, kMoleculeThreshold);
}

/// Passes over the molecules are bound by memory: each array is read and written as seldom as can be.
class Explicit final : public Integrator {
 public:
  explicit Explicit(Scheme scheme) : scheme_(scheme) {}
  Scheme scheme() const override { return scheme_; }

  StepResult advance(Model& model, State& state, double dt) override {
    const int n = model.body().size();
    const bool verlet = scheme_ == Scheme::velocity_verlet;
    if (!verlet || state.accelerations.cols() != n) set_accelerations(model, state, scratch_);
    next_.positions.resize(3, n);
    next_.velocities.resize(3, n);
    next_.time = state.time + dt;
    if (model.drive) model.drive(next_.time, model.supports);
    StepResult result;
    const double largest = verlet ? verlet_step(model, state, dt) : euler_step(state, dt);
    place_supports(model, next_.positions);
    move_with_supports(model.supports, next_.velocities);
    // Local error: Verlet's is dt³/6 of the third derivative, as in central differences; Euler's dt²/2 of the second.
    result.error = dt * dt / (verlet ? 6 : 2) * std::sqrt(largest);
    if (!std::isfinite(largest)) {
      result.outcome = Outcome::diverged;
      result.cause = "the next step has no finite velocities: the step is too long";
    } else if (!model.admissible(next_.positions)) {
      result.outcome = Outcome::inverted;
      result.cause = turned_over_text(model.body(), next_.positions);
    } else {
      std::swap(state, next_);
      return result;
    }
    if (model.drive) model.drive(state.time, model.supports);
    return result;
  }

 private:
  /// Kick, drift. The largest square of an acceleration, infinity if something is not finite.
  double euler_step(const State& state, double dt) {
    next_.accelerations.resize(3, 0);
    return largest_of(
        static_cast<int>(state.positions.cols()),
        [&](int i) {
          const Vector3 velocity = state.velocities.col(i) + dt * state.accelerations.col(i);
          const Vector3 position = state.positions.col(i) + dt * velocity;
          next_.velocities.col(i) = velocity;
          next_.positions.col(i) = position;
          return finite(position, velocity, state.accelerations.col(i).squaredNorm());
        },
        kMoleculeThreshold);
  }

  /// Half a kick, drift, half a kick. The largest square of a change of acceleration, infinity if something is not
  /// finite.
  double verlet_step(const Model& model, const State& state, double dt) {
    const int n = static_cast<int>(state.positions.cols());
    // Forces that depend on velocity see a guess of the whole kick.
    const bool guess = model.feels_velocity();
    parallel_for(
        n,
        [&](int i) {
          const Vector3 velocity = state.velocities.col(i) + dt / 2 * state.accelerations.col(i);
          next_.positions.col(i) = state.positions.col(i) + dt * velocity;
          if (guess) next_.velocities.col(i) = velocity + dt / 2 * state.accelerations.col(i);
        },
        kMoleculeThreshold);
    place_supports(model, next_.positions);
    if (guess) move_with_supports(model.supports, next_.velocities);
    model.set_forces(next_, next_.accelerations, scratch_);
    keep_free(model.supports, next_.accelerations);
    const VectorX& mass = model.body().mass;
    return largest_of(
        n,
        [&](int i) {
          const Vector3 acceleration = next_.accelerations.col(i) / mass[i], before = state.accelerations.col(i);
          const Vector3 velocity = state.velocities.col(i) + dt / 2 * (before + acceleration);
          next_.accelerations.col(i) = acceleration;
          next_.velocities.col(i) = velocity;
          return finite(next_.positions.col(i), velocity, (acceleration - before).squaredNorm());
        },
        kMoleculeThreshold);
  }

  static double finite(const Vector3& position, const Vector3& velocity, double value) {
    return std::isfinite(position.squaredNorm() + velocity.squaredNorm()) ? value
                                                                          : std::numeric_limits<double>::infinity();
  }

  Scheme scheme_;
  State next_;
  Scratch scratch_;
};

}  // namespace

std::string turned_over_text(const Body& body, const Positions& positions) {
  const std::vector<int> cells = flat_or_inverted_cells(body, positions);
  return cells.empty() ? "a cell is flat or turned over" : flat_or_inverted_text(cells, body.tetrahedra.size());
}

void move_with_supports(const std::vector<Support>& supports, Positions& velocities) {
  for (const Support& support : supports) {
    const Vector3 off = support.velocity - velocities.col(support.molecule);
    velocities.col(support.molecule) += off - support.free * off;
  }
}

void set_accelerations(const Model& model, State& state) {
  Scratch scratch;
  set_accelerations(model, state, scratch);
}

std::unique_ptr<Integrator> make_explicit(Scheme scheme) { return std::make_unique<Explicit>(scheme); }

}  // namespace elastin
