// Intervals: quantiles against tables, a straight line against its closed form.

#include "lab/identify/fit.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace elastin;
using namespace elastin::lab;

TEST_CASE("shares of Fisher's distribution are those of tables", "[identify]") {
  CHECK(f_beyond(6.6079, 1, 5) == Approx(0.05).epsilon(1e-4));
  CHECK(f_beyond(4.1028, 2, 10) == Approx(0.05).epsilon(1e-4));
  CHECK(f_beyond(3.4793, 5, 30) == Approx(0.0134345).epsilon(1e-4));
  CHECK(f_beyond(std::pow(2.776445, 2), 1, 4) == Approx(0.05).epsilon(1e-5));  // Student's, squared
}

TEST_CASE("differences of one sign have a shape", "[identify]") {
  CHECK(sign_changes(VectorX::Ones(30)).too_few());
  CHECK(sign_changes(-VectorX::Ones(8)).too_few());
  CHECK_FALSE(sign_changes(VectorX::Ones(4)).too_few());
}

TEST_CASE("quantiles of Student's distribution are those of tables", "[identify]") {
  // Abramowitz & Stegun, table 26.10, both sides.
  CHECK(student_quantile(0.95, 1) == Approx(12.706).epsilon(1e-4));
  CHECK(student_quantile(0.95, 4) == Approx(2.776).epsilon(2e-4));
  CHECK(student_quantile(0.95, 30) == Approx(2.042).epsilon(3e-4));
  CHECK(student_quantile(0.99, 10) == Approx(3.169).epsilon(2e-4));
  CHECK(student_quantile(0.95, 1e7) == Approx(1.959964).epsilon(1e-6));
}

TEST_CASE("the uncertainty of a straight line is its closed form", "[identify]") {
  // y = a + b x: var b = s²/Σ(x − x̄)², correlation −x̄/√(mean x²).
  const VectorX x = VectorX::LinSpaced(8, 1, 8);
  VectorX residuals(8);
  residuals << 1, -1, 0.5, -0.5, 0.2, -0.2, 1, -1;
  MatrixX jacobian(8, 2);
  jacobian.col(0).setOnes(), jacobian.col(1) = x;
  VectorX values(2);
  values << 3, 4;
  const Uncertainty known = uncertainty(residuals, jacobian, values);
  const double variance = residuals.squaredNorm() / 6, spread = (x.array() - x.mean()).square().sum();
  CHECK(known.freedom == 6);
  CHECK(known.deviations[1] == Approx(std::sqrt(variance / spread)));
  CHECK(known.correlation(0, 1) == Approx(-x.mean() / std::sqrt(x.squaredNorm() / 8)));
  CHECK(known.high[1] - known.low[1] == Approx(2 * 2.4469 * known.deviations[1]).epsilon(1e-4));
}

TEST_CASE("a profile of a linear model ends where its interval does, and at a bound", "[identify]") {
  const auto squares = [](double value) { return std::optional(2 + 3 * (value - 5) * (value - 5)); };
  CHECK(profile_end(5, 0.7, INFINITY, 2, 14, squares) == Approx(7).epsilon(1e-2));
  CHECK(profile_end(5, -0.7, -INFINITY, 2, 14, squares) == Approx(3).epsilon(1e-2));
  CHECK(profile_end(5, 0.7, 6, 2, 14, squares) == 6);
}

TEST_CASE("the criterion for small samples prefers what is enough", "[identify]") {
  // A further unknown that takes nothing of the misfit costs more of few values than of many.
  const double few = small_sample_criterion(1, 8, 3) - small_sample_criterion(1, 8, 2);
  const double many = small_sample_criterion(1, 800, 3) - small_sample_criterion(1, 800, 2);
  CHECK(few > many);
  CHECK(many == Approx(2).epsilon(0.02));  // Akaike's own
  CHECK(std::isinf(small_sample_criterion(1, 4, 2)));
}

TEST_CASE("how differences scatter is seen in them", "[identify]") {
  // By turns above and below, of a constant size, of one in proportion, and of both together.
  const VectorX y = VectorX::LinSpaced(40, 0.025, 1);
  VectorX sign(40);
  for (Eigen::Index i = 0; i < 40; ++i) sign[i] = i % 2 == 0 ? 0.01 : -0.01;
  CHECK(std::isinf(scatter_constant(y, sign, 0.01)));
  CHECK(scatter_constant(y, sign.cwiseProduct(y), 0.01) == 0);
  const VectorX both = sign.cwiseProduct((y.array().square() + 0.04).sqrt().matrix());
  CHECK(scatter_constant(y, both, 0.01) == Approx(0.2).epsilon(0.35));  // to a step of its search
  CHECK(sign_changes(sign).count == 39);
  CHECK_FALSE(sign_changes(sign).too_few());
  // Of 20 above and 20 below: 20 changes with a deviation of √(20 · 19 / 39).
  CHECK(sign_changes(sign).expected == 20);
  CHECK(sign_changes(sign).deviation == Approx(std::sqrt(20. * 19 / 39)));
  CHECK(sign_changes((y.array() - 0.5).matrix()).count == 1);
  CHECK(sign_changes((y.array() - 0.5).matrix()).too_few());
}
