#include "petsc/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "core/linear/linear_choice.h"
#include "core/solve/newton.h"
#include "core/solve/steppers.h"
#include "elastin/core/base/text.h"
#include "elastin/core/forces/loads.h"
#include "petsc/linear.h"

namespace elastin::petsc {
namespace {

/// The grids of boxes where the options, or a rule, choose them.
const BoxHierarchy* chosen_boxes(const Model& model, const Tangent& local, SharedSetting& setting,
                                 const StaticOptions& options, double tolerance, std::string& reason) {
  bool wanted = options.method->name == "multigrid";
  if (!options.method->make) std::tie(wanted, reason) = multigrid_is_worth_it(model, tolerance);
  if (!wanted) return nullptr;
  if (!setting.boxes) setting.boxes = std::make_unique<BoxHierarchy>(local, setting.body);
  return setting.boxes.get();
}

std::string solver_name(const std::string& preconditioner, const SharedBody& body) {
  return "petsc " + preconditioner + " on " + counted(body.processes(), "process", "processes");
}

/// Size of the fixed components of owned molecules' vectors, of all.
double fixed_norm(const SharedModel& model, const Positions& owned) {
  double sum = 0;
  for (const Support& support : model.supports()) {
    const Vector3 v = owned.col(support.molecule);
    sum += (v - support.free * v).squaredNorm();
  }
  return std::sqrt(model.body().sum(sum));
}

/// What Newton's method asks of the processes.
class Among final : public SharedProblem {
 public:
  Among(Model& given, SharedSetting& setting, const StaticOptions& options, bool of_step)
      : given_(given),
        setting_(setting),
        body_(setting.body),
        options_(options),
        model_(given, setting.body, of_step ? SharedModel::Use::step : SharedModel::Use::equilibrium) {
    if (&model_.local() != &given) add_dead_loads();
  }

  Model& model() { return model_.local(); }
  const Body& whole() const override { return body_.given(); }
  int owned() const override { return body_.owned(); }
  double sum(double own) const override { return body_.sum(own); }
  double largest(double own) const override { return body_.largest(own); }
  void add_up(Positions& forces) const override { body_.add_up(forces); }
  std::unique_ptr<Linearised> linearise(const Tangent& tangent) override {
    return std::make_unique<Stiffness>(*this, tangent);
  }

  /// On the supports of what was given; none on those of ghosts.
  Positions reactions(const State& state) {
    Positions forces;
    if (!body_.of_share()) {
      given_.set_forces(state, forces);
    } else {
      forces = model_.local().elastic_forces(state.positions);
      add_up(forces);
      forces += given_.load_forces(state_at_rest(given_.body()));
      forces.rightCols(body_.size() - owned()).setZero();
    }
    return -fixed_components(given_.supports, forces);
  }

 private:
  struct Stiffness final : Linearised {
    Stiffness(Among& a_problem, const Tangent& a_tangent) : problem(a_problem), tangent(a_problem.model_, a_tangent) {}

    double rounding_floor() const override { return tangent.rounding_floor(); }
    LinearResult solve(const Positions& rhs, double tolerance, Positions& motion, UsedSolver& used) override {
      const SharedBody& body = problem.body_;
      const Vector forces = body.make_vector(), solution = body.make_vector();
      body.write(rhs, forces);
      const BoxHierarchy* boxes = problem.model_.of_step()  // whose inertia keeps iterations few
                                      ? nullptr
                                      : chosen_boxes(problem.given_, tangent.local(), problem.setting_,
                                                     problem.options_, tolerance, used.reason);
      const SharedLinearResult linear = solve_linear(tangent, boxes, forces, tolerance, solution);
      used.name = solver_name(linear.preconditioner, body);
      body.spread(solution, motion);
      return {linear.status, linear.iterations, linear.residual};
    }
    Positions way_down(int& iterations) override {
      const Vector direction = problem.body_.make_vector();
      Positions motion;
      if (find_negative_direction(tangent, direction, iterations)) problem.body_.spread(direction, motion);
      return motion;
    }

    Among& problem;
    SharedTangent tangent;
  };

  /// On the subdomain, the forces of each load at rest: equilibria are shared out under such as stay as they are.
  void add_dead_loads() {
    const State rest = state_at_rest(given_.body());
    std::vector<int> molecules(static_cast<std::size_t>(owned()));
    std::iota(molecules.begin(), molecules.end(), 0);
    for (const auto& load : given_.loads()) {
      Positions forces = Positions::Zero(3, given_.body().size()), local;
      load->add_forces(rest, forces);
      body_.take(forces, local);
      model().add(std::make_unique<PointLoads>(model().body(), molecules, local.leftCols(owned())));
    }
  }

  Model& given_;
  SharedSetting& setting_;
  const SharedBody& body_;
  const StaticOptions& options_;
  SharedModel model_;
};

}  // namespace

StaticResult balance(Model& model, SharedSetting& setting, State& state, const StaticOptions& options,
                     const Kinematics* kinematics) {
  const SharedBody& body = setting.body;
  Among processes(model, setting, options, kinematics != nullptr);
  State own;
  if (!body.of_share()) body.take(state.positions, own.positions);
  State& solved = body.of_share() ? state : own;
  if (solved.velocities.size() == 0 && processes.model().feels_velocity()) solved.velocities.setZero(3, body.size());
  NewtonWorkspace workspace;
  StaticResult result = solve_newton(processes.model(), solved, options, kinematics, workspace, nullptr, &processes);
  if (result.solver.empty()) {  // it did not start
    result.cause = inverted_anywhere(model, state.positions) + " at the start of the step";
    return result;
  }
  if (result.newton_iterations == 0) result.solver = "newton " + solver_name("pcg", body);
  if (kinematics) return result;
  body.gather(Positions(solved.positions.leftCols(body.owned())), state.positions);
  result.reactions = processes.reactions(state);
  return result;
}

StaticResponse respond(Model& model, SharedSetting& setting, const Positions& at, const Positions& load_change,
                       const Positions& displacement, const StaticOptions& options) {
  const SharedBody& body = setting.body;
  SharedModel shared(model, body);
  Positions prescribed = Positions::Zero(3, at.cols());
  for (const Support& support : model.supports) {
    const Vector3 w = displacement.col(support.molecule);
    prescribed.col(support.molecule) = w - support.free * w;
  }
  Positions local, motion, loads, owned;
  body.take(at, local);
  State state{std::move(local), Positions()};
  if (shared.local().feels_velocity()) state.velocities.setZero(3, body.size());  // what damps looks at them
  const Tangent own(shared.local(), state);
  const SharedTangent tangent(shared, own);
  body.take(prescribed, motion);
  body.take(load_change, loads);
  Vector rhs = body.make_vector(), solution = body.make_vector();
  tangent.apply(motion, rhs);
  body.read(rhs, owned);
  owned = (loads.leftCols(body.owned()) - owned).eval();
  body.write(owned, rhs);
  const double supported = fixed_norm(shared, owned);
  shared.keep_free(rhs);
  double size = 0;
  check(VecNorm(rhs, NORM_2, &size));

  StaticResponse response;
  StaticResult& result = response.result;
  const BoxHierarchy* boxes = chosen_boxes(model, tangent.local(), setting, options, options.tolerance, result.reason);
  const SharedLinearResult linear = solve_linear(tangent, boxes, rhs, options.tolerance, solution);
  result.solver = "linear " + solver_name(linear.preconditioner, body);
  result.linear = true;
  result.newton_iterations = 1;
  result.linear_iterations = linear.iterations;
  result.scale = size + supported;
  result.residual = size > 0 ? linear.residual * size / (size + supported) : 0;
  result.unstable = linear.status == LinearStatus::negative_mode;
  if (linear.status != LinearStatus::solved && linear.residual > std::max(options.tolerance, 1e-8)) {
    const bool mode = linear.status == LinearStatus::zero_mode, negative = linear.status == LinearStatus::negative_mode;
    result.outcome = mode ? Outcome::mechanism : negative ? Outcome::diverged : Outcome::limit_reached;
    result.cause = mode       ? "the loads work on a zero-energy mode"
                   : negative ? "the stiffness has directions of negative stiffness"
                              : "the linear solver ran out of iterations";
  }
  body.spread(solution, motion);
  if (body.largest(motion.allFinite() ? 0 : 1) > 0) {
    result.outcome = Outcome::diverged;
    result.cause = "the displacements are too large for numbers";
  }
  Positions prescribed_here;
  body.take(prescribed, prescribed_here);
  motion += prescribed_here;
  tangent.apply(motion, rhs);
  body.read(rhs, owned);
  owned -= loads.leftCols(body.owned());
  Positions forces = Positions::Zero(3, body.size());
  if (body.of_share())
    forces.leftCols(body.owned()) = owned;
  else
    body.gather(owned, forces);
  result.reactions = fixed_components(model.supports, forces);
  body.gather(motion.leftCols(body.owned()), response.motion);
  return response;
}

}  // namespace elastin::petsc
