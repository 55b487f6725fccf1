#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lab/identify/fit.h"

namespace elastin::lab {

/// A factor of the material's stiffness in each cell of a body that was found from readings.
struct FoundField {
  std::shared_ptr<const Body> shape;  ///< its molecules and solid cells at rest
  VectorX factors, deviations;        ///< one a cell; standard deviations of their logarithms
  Positions middles;                  ///< of the cells at rest
  double smoothness = 0;              ///< α
  std::string chosen_by;              ///< why this one
  double misfit = 0;                  ///< mean square of differences over what scatter alone leaves; 0: no sigma
  bool only_ratios = false;           ///< whether readings leave a common factor open: its mean logarithm is then 0
  /// What each smoothness that was tried leaves of the squares, and how uneven its field is, eᵀ L e.
  struct Tried {
    double smoothness, squares, unevenness;
  };
  std::vector<Tried> tried;
  int equilibria = 0, linear_solves = 0;  ///< of all loads
  std::vector<VectorX> readings;          ///< of each test
  double seconds = 0;
  bool converged = true;
};

struct FieldOptions {
  std::function<void(const std::string& doing)> progress = {};  ///< may be empty
  std::function<bool()> stop = {};                              ///< may be empty
};

/// The factors e^e of all cells' stiffness with the least Σ ((computed − measured) / σ)² + α eᵀ L e over all tests that
/// count, eᵀ L e = ∫ |∇e|² dV / V^(1/3), by Gauss and Newton's steps. Each is found by conjugate gradients from
/// products with the slopes J and Jᵀ, by one linear solve at each load, whatever the number of cells. α is the stated
/// one, or by the discrepancy principle [Morozov 1966], or, where no
/// sigma is known, by generalised cross-validation [Golub, Heath & Wahba 1979].
/// Deviations are those of 24 draws of readings and fields about what was found. Throws InputError where the tests are
/// not of one body of solid cells, or the strategy has no elements to make stiffer.
FoundField find_field(const FieldChoice& choice, std::vector<WeightedTest>& tests, const FieldOptions& options);

}  // namespace elastin::lab
