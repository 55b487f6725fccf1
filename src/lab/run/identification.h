#pragma once
#include <string>
#include <vector>

#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

struct Specimen;
struct StrategyChoice;
struct RunOptions;
struct Run;

/// What was found.
struct Identified {
  std::vector<double> polynomial;       ///< c₀, c₁ … [Pa]
  std::vector<double> standard_errors;  ///< of E at no strain, at up_to/2 and at up_to [Pa], from the misfit's scatter
  double up_to = 0;                     ///< strain
  double misfit = 0;                    ///< root of the mean of (shown/measured − 1)²
  int evaluations = 0;                  ///< load curves that were solved for it
  double modulus(double strain) const;  ///< E(|ε|) [Pa]
};

/// Why a strategy cannot be used to identify a material, or "".
std::string identification_unsuited(const StrategyChoice& choice);

/// Puts the curve found into the specimen's material and what was found into the run. Least squares of shown/measured −
/// 1 over c₀, c₁ up_to, c₂ up_to² … [Levenberg & Marquardt, MINPACK's lmdif as in Eigen], each evaluation one load
/// curve, started from the last one's equilibria. False if even the guess cannot be solved, or there are fewer values
/// than coefficients: the run says why.
bool identify_material(const Identification& wanted, Specimen& specimen, const StaticExperiment& experiment,
                       const StrategyChoice& choice, const RunOptions& options, Run& run);

}  // namespace elastin::lab
