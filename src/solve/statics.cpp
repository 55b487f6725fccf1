#include "elastin/solve/statics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "solve/linear_solver.h"

namespace elastin {
namespace {

/// Below this many molecules a factorisation beats iterations; above the second limit it is never tried.
constexpr int kTinyBody = 60, kDirectLimit = 2500;

/// Newton iterations in which a body that was stable at the start is followed down past negative modes before saddles
/// are tried: nearly incompressible ones pass through pressures that are not there at the end.
constexpr int kDownhillSteps = 25;

std::unique_ptr<LinearSolver> make_solver(LinearMethod method, int molecules) {
  const bool direct = method == LinearMethod::direct || (method == LinearMethod::automatic && molecules <= kTinyBody);
  return direct ? make_direct() : make_pcg();
}

/// Falls back on the factorisation where iterations met what they cannot handle and the body is small enough for it; on
/// a negative mode only if `through_saddles`: to go down it is the better way where it passes.
LinearResult solve_linear(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                          double tolerance, const StaticOptions& options, bool through_saddles, Positions& solution,
                          std::string& used) {
  const int molecules = tangent.model().body().size();
  auto solver = make_solver(options.method, molecules);
  LinearResult result = solver->solve(tangent, supports, rhs, tolerance, solution);
  const bool iterated = std::string(solver->name()) == "pcg";
  const bool downhill = result.status == LinearStatus::negative_mode && !through_saddles;
  if (result.status != LinearStatus::solved && !downhill && iterated && options.method == LinearMethod::automatic &&
      molecules <= kDirectLimit) {
    Positions other;
    auto direct = make_direct();
    const LinearResult second = direct->solve(tangent, supports, rhs, tolerance, other);
    if (second.residual <= std::max(result.residual, tolerance)) {
      solution = other;
      solver = std::move(direct);
      result = {second.status, result.iterations + second.iterations, second.residual, second.negative_modes};
    }
  }
  used = solver->name();
  return result;
}

Positions held_parts(const std::vector<Support>& supports, const Positions& vectors) {
  Positions parts(3, static_cast<Eigen::Index>(supports.size()));
  for (std::size_t i = 0; i < supports.size(); ++i) {
    const Vector3 v = vectors.col(supports[i].molecule);
    parts.col(static_cast<Eigen::Index>(i)) = v - supports[i].free * v;
  }
  return parts;
}

/// Puts every supported molecule where its support wants it, in the held directions.
void place_supports(const Model& model, Positions& positions) {
  for (const Support& support : model.supports) {
    const Vector3 wanted = model.body().rest.col(support.molecule) + support.displacement;
    const Vector3 off = wanted - positions.col(support.molecule);
    positions.col(support.molecule) += off - support.free * off;
  }
}

struct Balance {
  Positions unbalanced;  ///< elastic + load forces in the free directions [N]
  double norm = 0;       ///< its size
  double scale = 0;      ///< size of loads and reactions
};

Balance balance(const Model& model, const State& state) {
  const Positions loads = model.load_forces(state);
  Balance result{model.elastic_forces(state.positions), 0, 0};
  result.unbalanced += loads;
  result.scale = ordered_norm(loads) + held_parts(model.supports, result.unbalanced).norm();
  keep_free(model.supports, result.unbalanced);
  result.norm = ordered_norm(result.unbalanced);
  return result;
}

/// The unbalanced force that rounding of the positions alone makes: nothing smaller can be asked for.
double rounding_floor(const Tangent& tangent, const Positions& positions) {
  const double reach = positions.cwiseAbs().maxCoeff();
  double sum = 0;
  for (const Matrix3& block : tangent.diagonal()) sum += block.squaredNorm();
  return std::numeric_limits<double>::epsilon() * reach * std::sqrt(sum);
}

/// The body stretched with the mean motion that moved supports impose is a far better start than a torn first layer:
/// one linear solve about the present state, with the supports' way as its only load.
void follow_supports(Model& model, State& state, const StaticOptions& options, StaticResult& result) {
  Positions moved = state.positions;
  place_supports(model, moved);
  const Positions way = moved - state.positions;
  if (way.cwiseAbs().maxCoeff() == 0) return;
  StaticOptions rough = options;
  rough.tolerance = 1e-3;
  const StaticResponse response = static_response(model, state.positions, Positions::Zero(3, way.cols()), way, rough);
  result.linear_iterations += response.result.linear_iterations;
  const Positions stretched = state.positions + response.motion;
  const bool usable = response.motion.allFinite() && std::isfinite(model.elastic_energy(stretched));
  state.positions = usable ? stretched : moved;
}

StaticResult solve_linear_statics(Model& model, State& state, const StaticOptions& options) {
  const State rest = state_at_rest(model.body());
  Positions way = rest.positions;
  place_supports(model, way);
  way -= rest.positions;
  StaticResponse response = static_response(
      model, rest.positions, model.load_forces(rest) + model.elastic_forces(rest.positions), way, options);
  if (response.result.outcome == Outcome::converged) state.positions = rest.positions + response.motion;
  return response.result;
}

/// Where a line search stands: total energy (where there is one) and unbalanced force.
struct Trial {
  State state;
  Balance forces;
  double energy;  ///< +infinity where a cell is flat or turned over
  double noise;   ///< what rounding of the positions does to the energy [J]
};

Trial evaluate(const Model& model, State state, bool with_energy) {
  Trial trial{std::move(state), {}, 0, 0};
  const Positions& positions = trial.state.positions;
  trial.energy = model.elastic_energy(positions) + model.load_energy(trial.state);
  if (with_energy && std::isfinite(trial.energy)) {
    const VectorX densities = model.force_densities(positions);
    const auto& ends = model.body().connections.ends;
    const double pull = ordered_sum(model.body().connections.size(), [&](int c) {
      return std::abs(densities[c]) * (positions.col(ends[c][1]) - positions.col(ends[c][0])).norm();
    });
    trial.noise = 4 * std::numeric_limits<double>::epsilon() * positions.cwiseAbs().maxCoeff() * pull;
  }
  if (std::isfinite(trial.energy)) trial.forces = balance(model, trial.state);
  return trial;
}

/// Halves the step until the energy falls (Armijo) or, where rounding hides that or there is no energy, the unbalanced
/// force does; and while a cell is turned over, with or without an energy. Returns false if no step helps.
bool line_search(const Model& model, const Positions& motion, bool with_energy, Trial& now, bool& inverted) {
  const double slope = -ordered_sum(static_cast<int>(motion.cols()),
                                    [&](int i) { return now.forces.unbalanced.col(i).dot(motion.col(i)); });
  inverted = false;
  for (double step = 1; step > 1e-9; step /= 2) {
    State state = now.state;
    state.positions += step * motion;
    Trial trial = evaluate(model, std::move(state), with_energy);
    inverted |= std::isinf(trial.energy);
    if (!std::isfinite(trial.energy) || !std::isfinite(trial.forces.norm)) continue;
    const bool falls = with_energy && slope < 0 && trial.energy <= now.energy + 1e-4 * step * slope;
    const bool calmer = trial.forces.norm < (1 - 1e-4 * step) * now.forces.norm;
    // Near the answer the energy differs by less than its rounding; far from it, a calmer force alone may be a saddle.
    const bool same_energy = !with_energy || trial.energy - now.energy <= trial.noise;
    if (falls || (calmer && same_energy)) {
      now = std::move(trial);
      return true;
    }
  }
  return false;
}

StaticResult solve_newton(Model& model, State& state, const StaticOptions& options) {
  StaticResult result;
  follow_supports(model, state, options, result);
  const bool with_energy = model.has_energy();
  Trial now = evaluate(model, state, with_energy);
  if (!std::isfinite(now.energy)) {
    result.outcome = Outcome::inverted;
    const std::vector<int> cells = flat_or_inverted_cells(model.body(), now.state.positions);
    result.cause = (cells.empty() ? "a cell is flat or turned over"
                                  : flat_or_inverted_text(cells, model.body().tetrahedra.size())) +
                   " at the start of the step";
    return result;
  }
  std::string used = options.method == LinearMethod::direct ? "direct" : "pcg";
  bool stable_start = false;
  double forcing = 1e-3, last = now.forces.norm;
  while (true) {
    const Tangent tangent(model, now.state.positions);
    const double floor = rounding_floor(tangent, now.state.positions);
    result.residual = now.forces.scale > 0 ? now.forces.norm / now.forces.scale : 0;
    const double goal = std::max(options.tolerance * now.forces.scale, 2 * floor);
    if (now.forces.norm <= goal) break;
    if (result.newton_iterations == options.newton_limit) {
      result.outcome = Outcome::limit_reached;
      result.cause = "no equilibrium within " + std::to_string(options.newton_limit) + " Newton iteration" +
                     (options.newton_limit == 1 ? "" : "s");
      break;
    }
    // Solve each step no further than the next unbalanced force can use. [Eisenstat & Walker 1996, choice 2]
    if (result.newton_iterations > 0) forcing = std::min(1e-2, 0.5 * std::pow(now.forces.norm / last, 2));
    forcing = std::max(forcing, 0.1 * goal / now.forces.norm);
    last = now.forces.norm;
    Positions motion;
    const LinearResult linear = solve_linear(tangent, model.supports, now.forces.unbalanced, forcing, options,
                                             !stable_start || result.newton_iterations >= kDownhillSteps, motion, used);
    const bool negative = linear.status == LinearStatus::negative_mode || linear.negative_modes > 0;
    if (result.newton_iterations == 0) stable_start = with_energy && !negative;
    result.linear_iterations += linear.iterations;
    ++result.newton_iterations;
    result.unstable = negative;
    // A direction without stiffness has no length of its own: no molecule goes further than half its connections' mean.
    if (linear.status != LinearStatus::solved && linear.residual > 0.9) {
      const auto& lengths = model.body().connections.rest_length;
      double mean = 0;
      for (const double length : lengths) mean += length / static_cast<double>(lengths.size());
      const double furthest = std::sqrt(motion.colwise().squaredNorm().maxCoeff());
      if (furthest > 0.5 * mean) motion *= 0.5 * mean / furthest;
    }
    // A full answer of an indefinite stiffness leads to a saddle of the energy: there only the force can be a guide.
    const bool to_saddle = linear.negative_modes > 0;
    bool inverted = false;
    const bool found = motion.allFinite() && line_search(model, motion, with_energy && !to_saddle, now, inverted);
    result.cut_steps += inverted;
    if (!found) {
      const bool mechanism = linear.status == LinearStatus::zero_mode;
      result.outcome = mechanism ? Outcome::mechanism : inverted ? Outcome::inverted : Outcome::diverged;
      result.cause = mechanism  ? "the loads work on a zero-energy mode that does not stiffen"
                     : inverted ? "every further step would turn a cell over"
                                : "no step lowers the unbalanced force";
      break;
    }
  }
  state = now.state;
  result.solver = "newton " + used;
  result.reactions = -held_parts(model.supports, model.elastic_forces(state.positions) + model.load_forces(state));
  return result;
}

}  // namespace

const char* name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::converged:
      return "converged";
    case Outcome::limit_reached:
      return "limit_reached";
    case Outcome::inverted:
      return "inverted";
    case Outcome::diverged:
      return "diverged";
    case Outcome::mechanism:
      return "mechanism";
  }
  return "";
}

StaticResult solve_static(Model& model, State& state, const StaticOptions& options) {
  return options.linear ? solve_linear_statics(model, state, options) : solve_newton(model, state, options);
}

StaticResponse static_response(Model& model, const Positions& at, const Positions& load_change, const Positions& way,
                               const StaticOptions& options) {
  StaticResponse response;
  StaticResult& result = response.result;
  Positions held_way = Positions::Zero(3, way.cols());
  for (const Support& support : model.supports) {
    const Vector3 w = way.col(support.molecule);
    held_way.col(support.molecule) = w - support.free * w;
  }
  const Tangent tangent(model, at);
  Positions forces(3, way.cols()), motion;
  tangent.apply(held_way, forces);
  Positions rhs = load_change - forces;
  const double held = held_parts(model.supports, rhs).norm();
  keep_free(model.supports, rhs);
  std::string used;
  const LinearResult linear =
      solve_linear(tangent, model.supports, rhs, options.tolerance, options, true, motion, used);
  result.solver = "linear " + used;
  result.linear = true;
  result.newton_iterations = 1;
  result.linear_iterations = linear.iterations;
  const double size = ordered_norm(rhs);
  result.residual = size > 0 ? linear.residual * size / (size + held) : 0;
  result.unstable = linear.negative_modes > 0 || linear.status == LinearStatus::negative_mode;
  // An indefinite stiffness still has its one answer, which a factorisation finds and iterations do not.
  if (linear.status != LinearStatus::solved && linear.residual > std::max(options.tolerance, 1e-8)) {
    const bool mode = linear.status == LinearStatus::zero_mode, negative = linear.status == LinearStatus::negative_mode;
    result.outcome = mode ? Outcome::mechanism : negative ? Outcome::diverged : Outcome::limit_reached;
    result.cause = mode       ? "the loads work on a zero-energy mode"
                   : negative ? "the stiffness has directions of negative stiffness"
                              : "the linear solver ran out of iterations";
  }
  response.motion = held_way + motion;
  tangent.apply(response.motion, forces);
  result.reactions = held_parts(model.supports, forces - load_change);
  return response;
}

}  // namespace elastin
