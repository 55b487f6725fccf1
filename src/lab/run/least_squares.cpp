#include "lab/run/least_squares.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>

namespace elastin::lab {
namespace {

/// All residuals as one function of all unknowns.
class AllResiduals final : public ceres::CostFunction {
 public:
  explicit AllResiduals(const LeastSquaresProblem& problem) : problem_(problem) {
    set_num_residuals(static_cast<int>(problem.residuals));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.low.size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Index count = problem_.low.size();
    const VectorX unknowns = Eigen::Map<const VectorX>(parameters[0], count);
    VectorX r(problem_.residuals);
    MatrixX J;
    const bool slopes = jacobians && jacobians[0];
    if (slopes) J.resize(problem_.residuals, count);
    ++evaluations_;
    if (!problem_.evaluate(unknowns, r, slopes ? &J : nullptr) || !r.allFinite()) return false;
    Eigen::Map<VectorX>(residuals, r.size()) = r;
    if (!slopes) return true;
    for (Eigen::Index row = 0; row < J.rows(); ++row)
      for (Eigen::Index column = 0; column < count; ++column) jacobians[0][row * count + column] = J(row, column);
    return J.allFinite();
  }
  int evaluations() const { return evaluations_; }

 private:
  const LeastSquaresProblem& problem_;
  mutable int evaluations_ = 0;
};

class Watch final : public ceres::IterationCallback {
 public:
  explicit Watch(const LeastSquaresProblem& problem) : problem_(problem) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (problem_.progress) problem_.progress(summary.iteration, 2 * summary.cost);
    enough_ = problem_.enough && problem_.enough();
    return enough_ || (problem_.stop && problem_.stop()) ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                         : ceres::SOLVER_CONTINUE;
  }
  bool enough() const { return enough_; }

 private:
  const LeastSquaresProblem& problem_;
  bool enough_ = false;
};

/// Ceres logs a search that cannot begin, which is an outcome here.
class Quiet {
 public:
  Quiet() : before_(FLAGS_minloglevel) { FLAGS_minloglevel = google::GLOG_FATAL; }
  ~Quiet() { FLAGS_minloglevel = before_; }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  int before_;
};

}  // namespace

LeastSquaresResult minimise_squares(const LeastSquaresProblem& problem, const VectorX& start) {
  LeastSquaresResult result;
  result.unknowns = start;
  AllResiduals function(problem);
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem all(ownership);
  all.AddResidualBlock(&function, nullptr, result.unknowns.data());
  for (int i = 0; i < static_cast<int>(start.size()); ++i) {
    if (std::isfinite(problem.low[i])) all.SetParameterLowerBound(result.unknowns.data(), i, problem.low[i]);
    if (std::isfinite(problem.high[i])) all.SetParameterUpperBound(result.unknowns.data(), i, problem.high[i]);
  }
  Watch watch(problem);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = problem.iterations;
  options.initial_trust_region_radius = problem.first_radius;
  options.function_tolerance = problem.tolerance;
  options.parameter_tolerance = std::min(1e-8, 100 * problem.tolerance);
  options.gradient_tolerance = 1e-14;
  options.max_num_consecutive_invalid_steps = 20;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  options.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  const Quiet quiet;
  ceres::Solve(options, &all, &summary);
  result.squares = 2 * summary.final_cost;
  result.iterations = static_cast<int>(summary.iterations.size());
  result.evaluations = function.evaluations();
  result.usable = summary.IsSolutionUsable();
  result.converged = summary.termination_type == ceres::CONVERGENCE || watch.enough();
  result.message = watch.enough()                                    ? "no further step counts"
                   : summary.termination_type == ceres::USER_SUCCESS ? "interrupted"
                                                                     : summary.message;
  return result;
}

}  // namespace elastin::lab
