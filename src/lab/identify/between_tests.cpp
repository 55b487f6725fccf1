#include <cmath>

#include "lab/identify/fit.h"

namespace elastin::lab {
namespace {

/// Whether two tests would show the same curve if their specimens were the same.
bool are_of_one_kind(const DataTest& a, const DataTest& b) {
  return a.kind == b.kind && a.scene == b.scene && a.held == b.held && a.strain == b.strain && a.ramp == b.ramp &&
         a.indenter == b.indenter && a.indenter_size == b.indenter_size && a.thickness == b.thickness &&
         a.bottom == b.bottom && a.measure == b.measure;
}

/// What is left of the columns beside those of the slopes, orthonormal; those of which nothing is left go.
MatrixX beside(const MatrixX& slopes, const MatrixX& columns) {
  constexpr double nothing = 1e-6;
  const MatrixX rest = columns - slopes * slopes.completeOrthogonalDecomposition().solve(columns);
  const Eigen::ColPivHouseholderQR<MatrixX> found(rest);
  Eigen::Index rank = 0;
  while (rank < rest.cols() && std::abs(found.matrixR()(rank, rank)) > nothing * columns.norm()) ++rank;
  return MatrixX(found.householderQ() * MatrixX::Identity(rest.rows(), rank));
}

}  // namespace

std::optional<TestScatter> widen_for_other_specimens(const std::vector<WeightedTest>& tests, const Fit& fit,
                                                     Uncertainty& known) {
  constexpr double chance = 1e-3;  // with which tests that do not differ seem to
  TestScatter scatter;
  scatter.left.resize(tests.size());
  // Of each test what the residuals change with its scale; of those of one kind, what they differ by.
  MatrixX scales = MatrixX::Zero(fit.residuals.size(), static_cast<Eigen::Index>(tests.size())),
          differ(scales.rows(), 0);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    if (!(tests[i].stated->weight > 0)) continue;
    const VectorX& fitted = fit.predictions[i].values;
    const Eigen::Index count = tests[i].test->data().y.size();
    if (fitted.size() != count || tests[i].stated->kind->points) return std::nullopt;
    scales.col(static_cast<Eigen::Index>(i)).segment(row, count) = fitted.cwiseProduct(tests[i].factor());
    const MatrixX own = fit.jacobian.middleRows(row, count);
    const VectorX residuals = fit.residuals.segment(row, count);
    scatter.left[i] = residuals - own * least_squares(own, residuals);
    row += count;
  }
  std::vector<char> seen(tests.size(), 0);
  for (std::size_t i = 0; i < tests.size(); ++i) {
    std::vector<std::size_t> alike;
    for (std::size_t j = i; j < tests.size(); ++j)
      if (!seen[j] && tests[j].stated->weight > 0 && are_of_one_kind(*tests[i].stated, *tests[j].stated))
        alike.push_back(j), seen[j] = 1;
    if (alike.size() < 2) continue;
    scatter.tests.insert(scatter.tests.end(), alike.begin(), alike.end());
    VectorX before = scales.col(static_cast<Eigen::Index>(alike[0]));  // Σ of those so far [Helmert 1876]
    for (std::size_t k = 1; k < alike.size(); ++k) {
      const double n = static_cast<double>(k);
      const VectorX own = scales.col(static_cast<Eigen::Index>(alike[k]));
      differ.conservativeResize(Eigen::NoChange, differ.cols() + 1);
      differ.rightCols(1) = (n * own - before) / std::sqrt(n * (n + 1));
      before += own;
    }
  }
  if (differ.cols() == 0) return std::nullopt;
  const MatrixX basis = beside(fit.jacobian, differ);
  scatter.freedom = static_cast<int>(basis.cols());
  const double left = known.freedom - scatter.freedom;
  if (scatter.freedom == 0 || !(left > 0)) return std::nullopt;
  const double by_scale = (basis.transpose() * fit.residuals).squaredNorm(), noise = (fit.squares - by_scale) / left;
  if (!(f_beyond(by_scale / scatter.freedom / noise, scatter.freedom, left) < chance)) return std::nullopt;
  const double variance = (by_scale - scatter.freedom * noise) / (basis.transpose() * scales).squaredNorm();
  scatter.deviation = std::sqrt(variance);
  const MatrixX inverse = fit.jacobian.completeOrthogonalDecomposition().pseudoInverse(), of_scale = inverse * scales;
  const MatrixX of_noise = noise * inverse * inverse.transpose(), of_tests = variance * of_scale * of_scale.transpose(),
                covariance = of_noise + of_tests;
  for (Eigen::Index i = 0; i < fit.values.size(); ++i) {
    const double both = covariance(i, i);
    const double freedom =
        both * both / (std::pow(of_noise(i, i), 2) / left + std::pow(of_tests(i, i), 2) / scatter.freedom);
    known.deviations[i] = std::sqrt(both);
    const double half = student_quantile(0.95, freedom) * known.deviations[i];
    known.low[i] = fit.values[i] - half, known.high[i] = fit.values[i] + half;
    for (Eigen::Index j = 0; j < fit.values.size(); ++j)
      known.correlation(i, j) = covariance(i, j) / std::sqrt(both * covariance(j, j));
  }
  return scatter;
}

}  // namespace elastin::lab
