#include "solve/explicit.h"

#include <cmath>

#include "base/parallel.h"
#include "solve/newton.h"

namespace elastin {
namespace {

/// A molecule's part of an update costs as much as some ten connections.
constexpr int kMoleculeThreshold = kParallelThreshold / 10;

class Explicit final : public Integrator {
 public:
  explicit Explicit(Scheme scheme) : scheme_(scheme) {}
  Scheme scheme() const override { return scheme_; }

  StepResult advance(Model& model, State& state, double dt) override {
    const int n = model.body().size();
    const bool verlet = scheme_ == Scheme::velocity_verlet;
    if (verlet ? state.accelerations.cols() != n : true) set_accelerations(model, state);
    next_.positions.resize(3, n);
    next_.velocities.resize(3, n);
    next_.accelerations.resize(3, n);
    next_.time = state.time + dt;
    if (model.drive) model.drive(next_.time, model.supports);
    // Verlet: half a kick, and a guess of the whole one for forces that depend on velocity; Euler: the whole kick.
    const double kick = verlet ? dt / 2 : dt;
    parallel_for(
        n,
        [&](int i) {
          const Vector3 velocity = state.velocities.col(i) + kick * state.accelerations.col(i);
          next_.positions.col(i) = state.positions.col(i) + dt * velocity;
          next_.velocities.col(i) = verlet ? Vector3(velocity + kick * state.accelerations.col(i)) : velocity;
        },
        kMoleculeThreshold);
    place_supports(model, next_.positions);
    move_with_supports(model.supports, next_.velocities);
    StepResult result;
    if (verlet) {
      set_accelerations(model, next_);
      parallel_for(
          n,
          [&](int i) {
            next_.velocities.col(i) =
                state.velocities.col(i) + kick * (state.accelerations.col(i) + next_.accelerations.col(i));
          },
          kMoleculeThreshold);
      move_with_supports(model.supports, next_.velocities);
      // Local error of central differences, dt³/6 of the third derivative.
      result.error = dt * dt / 6 * largest(next_.accelerations, state.accelerations);
    } else {
      next_.accelerations.resize(3, 0);
      result.error = dt * dt / 2 * largest(state.accelerations, Positions::Zero(3, 0));
    }
    if (!finite(next_)) {
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
  /// Largest size of a column of a − b, b perhaps empty.
  static double largest(const Positions& a, const Positions& b) {
    double square = 0;
    for (Eigen::Index i = 0; i < a.cols(); ++i)
      square = std::max(square, b.cols() ? (a.col(i) - b.col(i)).squaredNorm() : a.col(i).squaredNorm());
    return std::sqrt(square);
  }
  static bool finite(const State& state) {
    const double sum = ordered_sum(
        static_cast<int>(state.positions.cols()),
        [&](int i) { return state.velocities.col(i).squaredNorm() + state.positions.col(i).squaredNorm(); }, 0.,
        kMoleculeThreshold);
    return std::isfinite(sum);
  }

  Scheme scheme_;
  State next_;
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
  model.set_forces(state, state.accelerations);
  const VectorX& mass = model.body().mass;
  parallel_for(
      model.body().size(), [&](int i) { state.accelerations.col(i) /= mass[i]; }, kMoleculeThreshold);
  keep_free(model.supports, state.accelerations);
}

std::unique_ptr<Integrator> make_explicit(Scheme scheme) { return std::make_unique<Explicit>(scheme); }

}  // namespace elastin
