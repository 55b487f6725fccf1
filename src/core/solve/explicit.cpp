#include "core/solve/steppers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/parallel/parallel.h"
#include "core/solve/newton.h"
#include "core/solve/transposed_step.h"
#include "elastin/core/base/error.h"
#include "elastin/core/model/share.h"

namespace elastin {
namespace {

/// Of one step.
constexpr double kMaxSubsteps = 10000;
/// Of a body's size, by forces within one step: a stable step moves no molecule by more than four times the amplitude.
constexpr double kMostMotion = 1000;

void set_accelerations(const Model& model, const State& state, Positions& accelerations, Workspace& workspace) {
  model.set_forces(state, accelerations, workspace);
  keep_free(model.supports, accelerations);
  const VectorX& mass = model.body().mass;
  parallel_for(
      model.body().size(), [&](int i) { accelerations.col(i) /= mass[i]; }, kMoleculeThreshold);
}

/// Passes over the molecules are bound by memory: each array is read and written as seldom as can be.
class Explicit final : public Stepper, public FrequencyWatch, public SharedStep, public TransposedStep {
 public:
  explicit Explicit(bool verlet) : verlet_(verlet) {}
  void watch(const SeenFrequency& before) override { watches_ = true, seen_ = before; }
  const SeenFrequency& seen() const override { return seen_; }
  void set_own(double square_frequency, double damping_rate) override {
    own_square_ = square_frequency, own_rate_ = damping_rate;
  }

  /// In substeps where a stiffness sets in that the step is too long for, or something would be passed through.
  StepResult advance(Model& model, State& state, double dt) override {
    if (state.history.empty() && !model.history().empty()) {
      model.declare_history(state);
      model.begin_step(state, state.time);  // the first forces are those of the history that begins here
    }
    model.declare_history(state);
    const double substeps = substeps_for(model, dt, dt * std::sqrt(model.square_frequency(state, dt)));
    if (!(substeps > 1)) return step(model, state, dt);
    before_ = state;
    StepResult result = in_substeps(model, state, dt, std::min(substeps, kMaxSubsteps));
    if (result.outcome != Outcome::converged) go_back(model, state, before_);
    return result;
  }

  bool begins_with_forces() const override { return !verlet_; }
  void transpose(Model& model, const State& from, const State& to, StateSlopes& slopes, const Visit& visit) override {
    const double dt = to.time - from.time;
    for (const auto& load : model.loads())
      load->visit_points([](int, double, double) { throw InputError("a coupling has no transposed explicit step"); });
    transpose_commit(model, from, to, slopes);
    for (Positions* each : {&slopes.positions, &slopes.velocities}) keep_free(model.supports, *each);
    TransposedForces forces(model);
    State at = verlet_ ? to : from;
    Positions lambda = verlet_ ? Positions(slopes.accelerations + dt / 2 * slopes.velocities)
                               : Positions(dt * (slopes.velocities + dt * slopes.positions));
    keep_free(model.supports, lambda);
    lambda *= model.body().mass.cwiseInverse().asDiagonal();
    if (!verlet_) {
      at.accelerations = (to.velocities - from.velocities) / dt;
      slopes.velocities += dt * slopes.positions;
      forces.begin(from, from.time, at, dt);
      forces.add(lambda, slopes);
    } else {
      const Positions of_velocities = slopes.velocities;
      if (model.feels_velocity()) at.velocities = from.velocities + dt * from.accelerations;
      move_with_supports(model.supports, at.velocities);
      slopes.velocities.setZero();  // by the guess, until the positions are known
      forces.begin(from, to.time, at, dt);
      forces.add(lambda, slopes);
      for (Positions* each : {&slopes.positions, &slopes.velocities}) keep_free(model.supports, *each);
      slopes.accelerations = dt / 2 * of_velocities + dt * dt / 2 * slopes.positions + dt * slopes.velocities;
      slopes.velocities += of_velocities + dt * slopes.positions;
    }
    for (Positions* each : {&slopes.positions, &slopes.velocities}) keep_free(model.supports, *each);
    visit(at, lambda);
  }

 private:
  /// The limit of a mass on a spring and a dashpot, where a step turns positions and velocities round (λ = −1), is
  /// (ω Δt)²/4 + c Δt = 1, c the damping rate; with half of c where the forces are of the step's start (Euler). Of what
  /// acts together these shares add up: the largest eigenvalue of a sum is at most the sum of both.
  double own_share(double dt) const { return own_square_ * dt * dt / 4 + (verlet_ ? 1. : 0.5) * own_rate_ * dt; }

  /// So many that what sets in, of the `frequency` [rad] a step, has its room next to the body's own share. Frequencies
  /// count what damps them so that 1 is stable: the share of a damped one is then at most the frequency.
  double substeps_for(const Model& model, double dt, double frequency) const {
    if (!(frequency > 0)) return 1;
    const bool damped =
        std::any_of(model.loads().begin(), model.loads().end(), [](const auto& load) { return load->resists(); });
    const auto share = [&](double substeps) {
      const double part = frequency / substeps;
      return damped ? (verlet_ ? 1. : 0.5) * part : part * part / 4;
    };
    double substeps = std::max(1., std::ceil(frequency));
    while (substeps < kMaxSubsteps && own_share(dt / substeps) + share(substeps) > 1) ++substeps;
    return substeps;
  }

  static void go_back(Model& model, State& state, const State& before) {
    state = before;
    if (model.drive) model.drive(state.time, model.supports);
  }

  StepResult in_substeps(Model& model, State& state, double dt, double substeps) {
    const double end = state.time + dt;
    StepResult all;
    for (int substep = 0; substep < substeps; ++substep) {
      StepResult result = step(model, state, dt / substeps);
      result.substeps += substep > 0 ? all.substeps : 0;
      result.error = std::max(result.error, all.error);
      all = std::move(result);
      if (all.outcome != Outcome::converged) return all;
    }
    state.time = end;
    return all;
  }

  /// May call itself, with shorter steps: each keeps where it began.
  StepResult again_in_substeps(Model& model, State& state, double dt, double substeps) {
    const State before = state;
    if (model.drive) model.drive(state.time, model.supports);
    StepResult result = in_substeps(model, state, dt, std::min(kMaxSubsteps, substeps));
    if (result.outcome != Outcome::converged) go_back(model, state, before);
    return result;
  }

  StepResult step(Model& model, State& state, double dt) {
    const int n = model.body().size();
    if (!verlet_) {
      set_forces(model, state, forces_);
      take_points_at_end(model, state, dt);
    } else if (state.accelerations.cols() != n)
      set_accelerations(model, state, state.accelerations, workspace_);
    next_.positions.resize(3, n);
    next_.velocities.resize(3, n);
    next_.carry_over(state);
    next_.time = state.time + dt;
    model.begin_step(state, next_.time);
    if (model.drive) model.drive(next_.time, model.supports);
    StepResult result;
    const double most = verlet_ ? verlet_step(model, state, dt) : euler_step(model.body().mass, state, dt);
    apply_supports(model, next_.positions);
    move_with_supports(model.supports, next_.velocities);
    std::array<double, 2> worst{most, model.admissible(next_.positions) ? 0. : 1.};
    largest_over(model.body(), worst);
    const auto [largest, inverted] = worst;
    const double moved = dt * dt * std::sqrt(largest);
    // Local error: Verlet's is dt³/6 of the third derivative, as in central differences; Euler's dt²/2 of the second.
    result.error = moved / (verlet_ ? 6 : 2);
    if (!std::isfinite(largest)) {
      result.outcome = Outcome::diverged;
      result.cause = "the next step has no finite velocities: the step is too long";
    } else if (moved > kMostMotion * size_of(model.body())) {
      result.outcome = Outcome::diverged;
      result.cause = "forces move a molecule by over a thousand times the size of the body in a step: it is too long";
    } else if (inverted != 0) {
      result.outcome = Outcome::inverted;
      result.cause = inverted_anywhere(model, next_.positions);
    } else if (const double fraction = model.max_step_fraction(state, next_); fraction < 1) {
      return again_in_substeps(model, state, dt, std::ceil(1 / fraction));
    } else {
      model.commit_step(next_);
      std::swap(state, next_);
      return result;
    }
    if (model.drive) model.drive(state.time, model.supports);
    return result;
  }

  /// Without what supports take.
  void set_forces(const Model& model, const State& state, Positions& forces) {
    forces.setZero(3, model.body().size());
    model.add_elastic_forces(state.positions, forces, workspace_);
    if (watches_) look(model, state.positions, forces);
    model.add_other_forces(state, forces, workspace_);
    model.spread(forces);
    keep_free(model.supports, forces);
  }

  /// From one state to the next the elastic forces change by Δf = −K Δx, K the mean stiffness in between: so
  /// ω² = |M^−½ Δf|² / (−Δx·Δf) is at most the largest of M⁻¹ K, and the more of what vibrates fastest there is in the
  /// motion, the nearer to it. What the steps are too long for grows until it is most of Δf, long before it shows.
  void look(const Model& model, const Positions& positions, const Positions& elastic) {
    if (!model.has_energy() || model.dissipates()) {  // forces change by themselves there
      watches_ = false;
      return;
    }
    const int turn = std::exchange(seen_.turn, (seen_.turn + 1) % kBetweenLooks);
    if (turn == 0) {
      seen_.positions = positions, seen_.elastic_forces = elastic;
    }
    if (turn != 1) return;
    const VectorX& mass = model.body().mass;
    const Vector3 sums = ordered_sum<Vector3>(
        static_cast<int>(positions.cols()),
        [&](int i) {
          const Vector3 force = elastic.col(i) - seen_.elastic_forces.col(i),
                        motion = positions.col(i) - seen_.positions.col(i);
          return Vector3(force.squaredNorm() / mass[i], -force.dot(motion), mass[i] * positions.col(i).squaredNorm());
        },
        Vector3::Zero(), kMoleculeThreshold);
    const double square = sums[0] / sums[1];
    // Nothing is seen in what rounding of the positions does to the forces.
    const double rounding = 8 * std::numeric_limits<double>::epsilon() * square * std::sqrt(sums[2]);
    if (sums[1] > 0 && std::sqrt(sums[0]) > 1e3 * rounding)
      seen_.frequency = std::max(seen_.frequency, std::sqrt(square));
  }

  /// −k (x − p) − c (v − w) as it is at the end of the step, where x and v are dt v' and dt a' on: the rest of the
  /// forces stays. (m + dt c + dt² k) a' = F − dt k v. Stable with any k and c where the step is without them.
  void take_points_at_end(const Model& model, const State& state, double dt) {
    points_.clear();
    for (const auto& load : model.loads())
      load->visit_points([this](int molecule, double stiffness, double damping) {
        for (Point& known : points_)
          if (known.molecule == molecule) return void((known.stiffness += stiffness, known.damping += damping));
        points_.push_back({molecule, stiffness, damping});
      });
    for (const auto& [molecule, stiffness, damping] : points_) {
      const double mass = model.body().mass[molecule];
      forces_.col(molecule) = mass / (mass + dt * (damping + dt * stiffness)) *
                              (forces_.col(molecule) - dt * stiffness * state.velocities.col(molecule));
    }
  }

  /// Molecules of one block: what one loop leaves for the next stays in the cache.
  static constexpr int kBlock = 64;

  static void set_inverse(const double* mass, int count, double* inverse) {
    double own[kBlock];
    for (int i = 0; i < count; ++i) own[i] = 1 / mass[i];
    for (int i = 0; i < count; ++i) inverse[3 * i] = inverse[3 * i + 1] = inverse[3 * i + 2] = own[i];
  }

  /// Kick, drift. The largest square of an acceleration, infinity if something is not finite.
  double euler_step(const VectorX& mass, const State& state, double dt) {
    next_.accelerations.resize(3, 0);
    return largest_of_ranges(
        static_cast<int>(state.positions.cols()),
        [&](int begin, int end) {
          double inverse[3 * kBlock], squares[3 * kBlock], sizes[3 * kBlock] = {}, most = 0;
          for (int first = begin; first < end; first += kBlock) {
            const int count = std::min(kBlock, end - first);
            set_inverse(mass.data() + first, count, inverse);
            const double *x = state.positions.data() + 3 * first, *v = state.velocities.data() + 3 * first,
                         *f = forces_.data() + 3 * first;
            double *next_x = next_.positions.data() + 3 * first, *next_v = next_.velocities.data() + 3 * first;
            for (int i = 0; i < 3 * count; ++i) {
              const double acceleration = f[i] * inverse[i], velocity = v[i] + dt * acceleration;
              squares[i] = acceleration * acceleration;
              sizes[i] += velocity * velocity;
              next_v[i] = velocity;
              next_x[i] = x[i] + dt * velocity;
            }
            most = largest_square(squares, count, most);
          }
          return all_finite(sizes) ? most : std::numeric_limits<double>::infinity();
        },
        kMoleculeThreshold);
  }

  /// Half a kick, drift, half a kick. The largest square of a change of acceleration, infinity if something is not
  /// finite.
  double verlet_step(const Model& model, const State& state, double dt) {
    const int n = static_cast<int>(state.positions.cols());
    const double *x = state.positions.data(), *v = state.velocities.data(), *a = state.accelerations.data();
    double *next_x = next_.positions.data(), *next_v = next_.velocities.data();
    const double half = dt / 2;
    // Forces that depend on velocity see a guess of the whole kick.
    const bool guess = model.feels_velocity();
    parallel_ranges(
        n,
        [&](int begin, int end) {
          constexpr int block = 1024;  // molecules: what one loop reads is still in the cache for the next
          for (int first = begin; first < end; first += block) {
            const int last = 3 * std::min(end, first + block);
            for (int i = 3 * first; i < last; ++i) next_x[i] = x[i] + dt * (v[i] + half * a[i]);
            if (!guess) continue;
            for (int i = 3 * first; i < last; ++i) next_v[i] = v[i] + dt * a[i];
          }
        },
        kMoleculeThreshold);
    apply_supports(model, next_.positions);
    if (guess) move_with_supports(model.supports, next_.velocities);
    set_forces(model, next_, next_.accelerations);
    return largest_of_ranges(
        n, [&](int begin, int end) { return kick(model.body().mass, state, half, begin, end); }, kMoleculeThreshold);
  }

  /// The second half of a kick, from the forces in next_.accelerations, which become accelerations.
  double kick(const VectorX& mass, const State& state, double half, int begin, int end) {
    double inverse[3 * kBlock], changes[3 * kBlock], sizes[3 * kBlock] = {}, most = 0;
    for (int first = begin; first < end; first += kBlock) {
      const int count = std::min(kBlock, end - first);
      set_inverse(mass.data() + first, count, inverse);
      const double *v = state.velocities.data() + 3 * first, *a = state.accelerations.data() + 3 * first;
      double *next_v = next_.velocities.data() + 3 * first, *next_a = next_.accelerations.data() + 3 * first;
      for (int i = 0; i < 3 * count; ++i) {
        const double now = next_a[i] * inverse[i], velocity = v[i] + half * (a[i] + now);
        changes[i] = (now - a[i]) * (now - a[i]);
        sizes[i] += velocity * velocity;
        next_a[i] = now;
        next_v[i] = velocity;
      }
      most = largest_square(changes, count, most);
    }
    return all_finite(sizes) ? most : std::numeric_limits<double>::infinity();
  }

  /// The largest of `most` and the squares of `count` vectors.
  static double largest_square(const double* squares, int count, double most) {
    for (int i = 0; i < 3 * count; i += 3) {
      const double value = squares[i] + squares[i + 1] + squares[i + 2];
      most = value > most ? value : most;
    }
    return most;
  }

  /// Of sums of squares of velocities: a position that is not finite gives forces that are not, and those velocities.
  static bool all_finite(const double* sums) {
    return std::all_of(sums, sums + 3 * kBlock, [](double sum) { return std::isfinite(sum); });
  }

  /// [m]; infinite where nothing joins molecules, so that nothing grows by steps that are too long.
  double size_of(const Body& body) {
    if (sized_ != &body) {
      const auto [low, high] = outline_of_whole(body);
      const bool joined = body.connections.size() > 0 || !body.blocks.empty();
      size_ = any_over(body, joined) ? (high - low).norm() : std::numeric_limits<double>::infinity();
      sized_ = &body;
    }
    return size_;
  }

  struct Point {
    int molecule;
    double stiffness, damping;
  };

  static constexpr int kBetweenLooks = 8;  ///< steps

  bool verlet_, watches_ = false;
  const Body* sized_ = nullptr;
  double size_ = 0;  // of that body
  double own_square_ = 0, own_rate_ = 0;
  SeenFrequency seen_;
  std::vector<Point> points_;  // forces on single molecules, each molecule once
  State next_, before_;
  Positions forces_;  // of a step's start
  Workspace workspace_;
};

}  // namespace

std::string inverted_text(const Body& body, const Positions& positions) {
  const std::vector<int> cells = flat_or_inverted_cells(body, positions);
  return cells.empty() ? "a cell is flat or inverted" : flat_or_inverted_text(cells, solid_cells(body));
}

std::string inverted_anywhere(const Model& model, const Positions& positions) {
  const bool here = !model.body().share || !model.admissible(positions);
  return first_over(model.body(), here ? inverted_text(model.body(), positions) : "");
}

void move_with_supports(const std::vector<Support>& supports, Positions& velocities) {
  for (const Support& support : supports) {
    const Vector3 off = support.velocity - velocities.col(support.molecule);
    velocities.col(support.molecule) += off - support.free * off;
  }
}

void set_accelerations(const Model& model, State& state) {
  Workspace workspace;
  set_accelerations(model, state, state.accelerations, workspace);
}

StepperKind symplectic_euler() {
  StepperKind row{
      {"symplectic_euler", "explicit, order 1: v += dt a(x, v), x += dt v; no energy drift", "[Hairer 2006]"},
      true,
      1,
      [](const ParameterValues&, const StaticOptions&) { return std::make_unique<Explicit>(false); }};
  row.points_at_end = true;
  row.of_shares = true;
  return row;
}

StepperKind velocity_verlet() {
  StepperKind row{{"velocity_verlet", "explicit, order 2: half a kick, drift, half a kick", "[Swope 1982]"},
                  true,
                  2,
                  [](const ParameterValues&, const StaticOptions&) { return std::make_unique<Explicit>(true); }};
  row.of_shares = true;
  return row;
}

}  // namespace elastin
