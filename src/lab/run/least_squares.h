#pragma once
#include <functional>
#include <string>

#include "core/base/dense.h"

namespace elastin::lab {

/// Residuals r of unknowns, and ∂r/∂unknowns where it is requested.
struct LeastSquaresProblem {
  Eigen::Index residuals = 0;
  VectorX low, high;  ///< bounds of the unknowns; infinite: none
  /// False where there is no answer: the search turns back. `jacobian` may be null.
  std::function<bool(const VectorX& unknowns, VectorX& residuals, MatrixX* jacobian)> evaluate;
  std::function<bool()> stop = {};    ///< called after each iteration; may be empty
  std::function<bool()> enough = {};  ///< whether what the last slopes promise is worth no step more; may be empty
  std::function<void(int iteration, double squares)> progress = {};  ///< called after each; may be empty
  int iterations = 300;
  double first_radius = 1e4;  ///< of the steps, over the slopes' lengths; a large one begins with Gauss's own steps
  double tolerance = 1e-13;   ///< relative change of Σ r² at which the search ends
};

struct LeastSquaresResult {
  VectorX unknowns;
  double squares = 0;  ///< Σ r²
  int iterations = 0, evaluations = 0;
  bool usable = false;     ///< something was found
  bool converged = false;  ///< and no change of the unknowns makes it smaller
  std::string message;
};

/// The unknowns with the least Σ r² near `start`, by Levenberg and Marquardt's method within the bounds [Ceres Solver].
LeastSquaresResult minimise_squares(const LeastSquaresProblem& problem, const VectorX& start);

}  // namespace elastin::lab
