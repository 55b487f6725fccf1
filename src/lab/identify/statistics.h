#pragma once
#include <functional>
#include <optional>

#include "elastin/core/base/dense.h"

namespace elastin::lab {

/// The t beyond which a share (1 − confidence) of Student's distribution lies, on both sides together.
double student_quantile(double confidence, double freedom);

/// What residuals r and their slopes J say of the unknowns: with s² = Σ r²/(n − p) the covariance is s² (JᵀJ)⁻¹ where
/// the model is nearly linear in the range of the scatter.                                     [Bates & Watts 1988, 2]
struct Uncertainty {
  int freedom = 0;       ///< n − p; without any there are no intervals
  VectorX deviations;    ///< standard deviations; infinite where the residuals do not change
  VectorX low, high;     ///< 95 % intervals
  MatrixX correlation;   ///< 1 on the diagonal
  double condition = 1;  ///< largest over least singular value of J with columns of length 1; infinite: a flat valley
  VectorX flattest;      ///< the change of the unknowns, in lengths of their columns, that changes the residuals least
};
Uncertainty uncertainty(const VectorX& residuals, const MatrixX& jacobian, const VectorX& values);

/// Akaike's criterion for small samples of n residuals with p unknowns and their variance; less is better, infinite
/// where there are too few residuals.                                                        [Hurvich & Tsai 1989]
double small_sample_criterion(double squares, Eigen::Index residuals, Eigen::Index unknowns);

/// The Σ r² that is left if one unknown is kept at a value and all others are fitted; none where there is no answer.
using ProfileSquares = std::function<std::optional<double>(double value)>;

/// How far and how finely the end of a profile is sought.
struct ProfileEffort {
  int steps = 30;            ///< outward, before the end counts as infinite
  double tolerance = 0.003;  ///< of the distance to the end
};

/// The end of the interval on one side in which the profile stays below squares (1 + t²/(n − p)): that of the
/// likelihood ratio, which needs no linear model. `bound` where it does not reach that before it.        [Bates & Watts
/// 1988, 6]
double profile_end(double value, double step, double bound, double least_squares, double most_squares,
                   const ProfileSquares& squares, const ProfileEffort& effort = {});

}  // namespace elastin::lab
