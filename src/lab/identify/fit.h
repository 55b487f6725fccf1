#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/dense.h"
#include "lab/identify/measured_test.h"
#include "lab/identify/window_moduli.h"
#include "lab/run/material_numbers.h"

namespace elastin::lab {

/// The t beyond which a share (1 − confidence) of Student's distribution lies, on both sides together.
double student_quantile(double confidence, double freedom);

/// The share of Fisher's distribution with so many degrees of freedom, above and below, beyond a ratio of variances.
double f_beyond(double ratio, double above, double below);

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

/// Changes of sign along a row of differences, and how many of them scatter has, next to the signs that there are; of
/// differences of one sign, next to any signs.                                              [Wald & Wolfowitz 1940]
struct SignChanges {
  double count = 0, expected = 0, deviation = 0;
  /// Whether the differences have a shape: they change their sign too seldom for scatter.
  bool too_few() const { return deviation > 0 && count < expected - 2.5 * deviation; }
};
SignChanges sign_changes(const VectorX& differences);

/// The s with which differences from measured values y most likely scatter as √(y² + s²): infinite where they scatter
/// alike at all values, 0 where `least` is as good, by the likelihood ratio at 5 %.
double scatter_constant(const VectorX& measured, const VectorX& differences, double least);

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

/// A law with the numbers of it that are to be found.
struct UnknownMaterial {
  std::string label;                     ///< "ogden/3"
  const MaterialLaw* row = nullptr;      ///< null: no law
  Trial trial;                           ///< with the numbers from which the search begins
  std::vector<MaterialNumber> unknowns;  ///< their bounds, and where they begin
  std::string kept = {};                 ///< of the scene's material, what no number of it changes: lines of YAML
  bool plain = false;                    ///< whether the scene is in plain SI numbers
};

inline constexpr double kRounding = 1e-6;   ///< rms of a test that is met
inline constexpr Eigen::Index kFewest = 8;  ///< readings whose differences show how they scatter

/// One test with its weight.
struct WeightedTest {
  const DataTest* stated = nullptr;
  std::unique_ptr<MeasuredTest> test;
  std::vector<WindowModulus> moduli = {};
  double noise = 1;  ///< of its differences over the scale, next to those of the other tests
  /// Of automatic residuals, as their scatter shows it: see scatter_constant. 0: the data's least scale.
  double constant = 0;
  /// What differences are over, by the test's ResidualScale.
  VectorX scale() const;
  /// Readings less what this number of unknowns may take of them.
  double freedom(Eigen::Index unknowns) const;
  /// What the search multiplies differences by.
  VectorX factor() const;
};

enum class FitOutcome {
  converged,
  bound_reached,  ///< the least lies at a bound of an unknown
  flat_valley,    ///< unknowns can change together without any change of the residuals
  misfit,         ///< the least is found, and a third of the measured values is left
  not_converged,  ///< the search ran out of iterations, or was stopped
  failed,         ///< none of the starts could be solved
};
const char* name_of(FitOutcome outcome);

/// Where searches came to an end, and what they took.
struct SearchEnd {
  VectorX values;                ///< of the unknowns, SI; empty: none of the starts could be solved
  bool converged = false;        ///< no change of the unknowns makes the squares smaller
  std::string message;           ///< why they ended
  int starts = 0, agreeing = 0;  ///< searches that came somewhere, and of them those near the same least
  int iterations = 0, evaluations = 0;
  double seconds = 0;
};

struct Fit : SearchEnd {
  FitOutcome outcome = FitOutcome::failed;
  std::string cause;  ///< in words, where it did not converge
  Trial trial;        ///< with them
  double squares = 0;
  VectorX residuals;                    ///< of the tests that count, weighted
  MatrixX jacobian;                     ///< of them by the unknowns
  std::vector<Prediction> predictions;  ///< of all tests, in their order
  std::vector<std::size_t> at_bound;    ///< unknowns that lie at one
  bool rough = false;                   ///< as FitOptions
};

struct FitOptions {
  int starts = 8;
  double tolerance = 1e-13;  ///< relative change of Σ r² at which the search for the best ends
  bool keep_signs = false;   ///< whether no number may pass through 0: searched by their logarithms
  /// Whether equilibria are dear: they are as rough as the residuals allow, and the search ends where a step would move
  /// the numbers by less than a thousandth of their deviations.
  bool rough = false;
  std::function<void(const std::string& doing)> progress = {};  ///< may be empty
  std::function<bool()> stop = {};                              ///< may be empty
  /// An earlier end of the same searches: of one that converged nothing is searched again, another is where the first
  /// begins.
  std::optional<SearchEnd> known = {};
};

/// The numbers of the material with the least weighted Σ of squared residuals over all tests whose weight is not 0: of
/// several searches, from the material's own numbers and from random ones around them, the best goes on to the end. The
/// same input gives a bitwise identical result.
Fit fit_material(const UnknownMaterial& unknown, std::vector<WeightedTest>& tests, const FitOptions& options);

/// How unlike the specimens of tests of one kind are.
struct TestScatter {
  double deviation = 0;            ///< standard deviation of the tests' scales, as part of them
  int freedom = 0;                 ///< in which they differ
  std::vector<std::size_t> tests;  ///< of which at least two are of one kind
  std::vector<VectorX> left;       ///< of all tests: residuals that a fit of each alone would leave, to first order
};

/// Where tests of one kind differ in scale, by more than the scatter of their readings does by chance, their readings
/// say nothing surer than the number of specimens allows: deviations and intervals become those with a scale of each
/// test that is drawn at random. None where they do not differ.                [Satterthwaite 1946; Laird & Ware 1982]
std::optional<TestScatter> widen_for_other_specimens(const std::vector<WeightedTest>& tests, const Fit& fit,
                                                     Uncertainty& known);

/// The ends of the interval of one unknown by its profile (see profile_end), from a search for the others at each
/// value; of a rough fit from one of Gauss's steps, or two, about where the slopes foresee the others, and to a
/// twentieth of the range.
std::pair<double, double> profile_interval(const UnknownMaterial& unknown, std::vector<WeightedTest>& tests,
                                           const Fit& fit, const Uncertainty& known, std::size_t number,
                                           const std::function<bool()>& stop = {});

}  // namespace elastin::lab
