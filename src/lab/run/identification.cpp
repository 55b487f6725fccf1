#include "lab/run/run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/dense.h"
#include "elastin/core/base/error.h"
#include "elastin/core/simulation/parts.h"
#include "lab/run/least_squares.h"
#include "lab/run/load_path.h"
#include "lab/run/specimen.h"

namespace elastin::lab {
namespace {

/// Solves the experiment's load curve for one material after the other.
class Curves {
 public:
  Curves(const Identification& wanted, const Specimen& specimen, const StaticExperiment& experiment,
         const StrategyChoice& choice, const RunOptions& options)
      : wanted_(wanted),
        specimen_(specimen),
        experiment_(experiment),
        choice_(choice),
        options_(options),
        curve_(factors(wanted.values.size()), options.statics) {}

  /// The relative misfit of each value; none if the material cannot be, or its load curve cannot be solved.
  std::optional<VectorX> misfits(const VectorX& scaled) {
    ++evaluations;
    Material material = specimen_.material;
    try {
      material.curve = StressStrain::secant_polynomial(coefficients(scaled), wanted_.up_to);
    } catch (const InputError&) {
      return std::nullopt;
    }
    material.youngs_modulus = material.curve->modulus(0);
    Model model(specimen_.body);
    model.add(choice_.strategy.make(specimen_.body, material, choice_.values));
    add_companions(model, choice_.strategy, material);
    for (const SpecimenLoad& load : specimen_.loads) load.add(model);
    const auto rig = experiment_.static_rig(model);
    VectorX values(static_cast<Eigen::Index>(wanted_.values.size()));
    const Start start{specimen_.body.rest, Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size()))};
    const bool found = curve_.solve(model, *rig, [&](std::size_t step, const State& state, StaticResult& solved) {
      const double shown = rig->measure(start, state, options_.statics, solved).get(wanted_.measure);
      values[static_cast<Eigen::Index>(step)] = shown / wanted_.values[step] - 1;
      return std::isfinite(shown);
    });
    return found ? std::optional(std::move(values)) : std::nullopt;
  }

  /// Coefficients over this make numbers of one size.
  std::vector<double> coefficients(const VectorX& scaled) const {
    std::vector<double> result;
    for (Eigen::Index k = 0; k < scaled.size(); ++k)
      result.push_back(scaled[k] * modulus * std::pow(wanted_.up_to, -static_cast<double>(k)));
    return result;
  }

  double modulus = 1;  ///< [Pa]
  int evaluations = 0;

 private:
  static std::vector<double> factors(std::size_t count) {
    std::vector<double> factors;
    for (std::size_t step = 1; step <= count; ++step)
      factors.push_back(static_cast<double>(step) / static_cast<double>(count));
    return factors;
  }

  const Identification& wanted_;
  const Specimen& specimen_;
  const StaticExperiment& experiment_;
  const StrategyChoice& choice_;
  const RunOptions& options_;
  RepeatedCurve curve_;
};

/// The misfits and, by forward differences, their slopes: equilibria are known to about 1e-9, so differences over 1e-4
/// of a coefficient lose nothing in them. False where a material cannot be.
bool evaluate(Curves& curves, const VectorX& scaled, VectorX& misfits, MatrixX* jacobian) {
  const std::optional<VectorX> now = curves.misfits(scaled);
  if (!now) return false;
  misfits = *now;
  for (Eigen::Index k = 0; jacobian && k < scaled.size(); ++k) {
    VectorX moved = scaled;
    moved[k] += scaled[k] == 0 ? 1e-4 : 1e-4 * std::abs(scaled[k]);
    const std::optional<VectorX> there = curves.misfits(moved);
    if (!there) return false;
    jacobian->col(k) = (*there - *now) / (moved[k] - scaled[k]);
  }
  return true;
}

/// The guess as scaled coefficients, of the highest degree that can be solved.
std::optional<VectorX> first_guess(const Identification& wanted, Curves& curves) {
  const auto points = static_cast<Eigen::Index>(wanted.guess.size());
  for (int degree = std::min<int>(wanted.degree, static_cast<int>(points) - 1); degree >= 0; --degree) {
    Eigen::MatrixXd powers(points, degree + 1);
    VectorX moduli(points);
    for (Eigen::Index row = 0; row < points; ++row) {
      const auto& [strain, modulus] = wanted.guess[row];
      moduli[row] = modulus / curves.modulus;
      for (int term = 0; term <= degree; ++term) powers(row, term) = std::pow(strain / wanted.up_to, term);
    }
    VectorX scaled = VectorX::Zero(wanted.degree + 1);
    scaled.head(degree + 1) = least_squares(powers, moduli);
    if (curves.misfits(scaled)) return scaled;
  }
  return std::nullopt;
}

/// Standard errors of E at no strain, half way and at the end: s² (JᵀJ)⁻¹, s² the misfits' variance.
std::vector<double> standard_errors(const Eigen::MatrixXd& jacobian, double squares, double modulus) {
  const Eigen::Index spare = jacobian.rows() - jacobian.cols();
  if (spare <= 0) return {};
  const Eigen::MatrixXd covariance =
      inverse(transposed_product(jacobian, jacobian)) * (squares / static_cast<double>(spare));
  std::vector<double> errors;
  for (const double at : {0., 0.5, 1.}) {
    VectorX powers(jacobian.cols());
    for (Eigen::Index k = 0; k < powers.size(); ++k) powers[k] = std::pow(at, static_cast<double>(k));
    errors.push_back(modulus * std::sqrt(powers.dot(covariance * powers)));
  }
  return errors;
}

}  // namespace

double Identified::modulus(double strain) const {
  double sum = 0;
  for (auto c = polynomial.rbegin(); c != polynomial.rend(); ++c) sum = sum * std::abs(strain) + *c;
  return sum;
}

std::string identification_unsuited(const StrategyChoice& choice) {
  if (choice.name.calibrated || choice.name.fitted || !choice.strategy.follows_curve)
    return "does not follow a material's curve (or is calibrated to one): none can be identified with it";
  return "";
}

bool identify_material(const Identification& wanted, Specimen& specimen, const StaticExperiment& experiment,
                       const StrategyChoice& choice, const RunOptions& options, Run& run) {
  if (options.progress) options.progress("identifying the material");
  const auto fail = [&](Outcome outcome, const std::string& why) {
    run.outcome = outcome, run.cause = why;
    return false;
  };
  const int unknowns = wanted.degree + 1, equations = static_cast<int>(wanted.values.size());
  if (equations < unknowns)
    return fail(Outcome::limit_reached, std::to_string(equations) + " measured values do not settle " +
                                            std::to_string(unknowns) + " coefficients");
  Curves curves(wanted, specimen, experiment, choice, options);
  for (const auto& point : wanted.guess) curves.modulus = std::max(curves.modulus, point.modulus);
  std::optional<VectorX> scaled = first_guess(wanted, curves);
  if (!scaled) return fail(Outcome::diverged, "no load curve could be solved for an initial guess of the material");

  LeastSquaresProblem problem;
  problem.residuals = equations;
  problem.low = VectorX::Constant(unknowns, -std::numeric_limits<double>::infinity());
  problem.high = -problem.low;
  problem.evaluate = [&](const VectorX& at, VectorX& misfits, MatrixX* jacobian) {
    return evaluate(curves, at, misfits, jacobian);
  };
  problem.tolerance = 1e-9;
  problem.iterations = 60;
  const LeastSquaresResult fit = minimise_squares(problem, *scaled);
  if (!fit.converged)
    run.warnings.push_back("the material was not settled within " + std::to_string(curves.evaluations) +
                           " load curves");

  Identified found;
  found.polynomial = curves.coefficients(fit.unknowns);
  found.up_to = wanted.up_to;
  VectorX misfits(equations);
  MatrixX jacobian(equations, unknowns);
  if (!evaluate(curves, fit.unknowns, misfits, &jacobian))
    return fail(Outcome::diverged, "the load curve of the material found could not be solved");
  found.misfit = std::sqrt(misfits.squaredNorm() / equations);
  found.standard_errors = standard_errors(jacobian, misfits.squaredNorm(), curves.modulus);
  found.evaluations = curves.evaluations;
  specimen.material.curve = StressStrain::secant_polynomial(found.polynomial, found.up_to);
  specimen.material.youngs_modulus = specimen.material.curve->modulus(0);
  run.identified = found;
  return true;
}

}  // namespace elastin::lab
