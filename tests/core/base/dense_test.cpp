#include "core/base/dense.h"

#include <catch2/catch.hpp>

using namespace elastin;

TEST_CASE("a hexahedron's product has the same bits in vectors of any width, Eigen's to rounding", "[dense]") {
  Eigen::Matrix<double, 24, 24> A;
  Eigen::Matrix<double, 24, 1> x;
  for (int i = 0; i < 24; ++i) {
    x[i] = std::sin(1.3 * i + .2);
    for (int j = 0; j < 24; ++j) A(i, j) = std::cos(.7 * i * j + .1 * i) * std::pow(10., i % 7 - 3);
  }
  const Eigen::Matrix<double, 24, 1> expected = 2.5 * (A * x);
  Eigen::Matrix<double, 24, 1> plain, y;
  ways_to_multiply24().front()(A.data(), x.data(), 2.5, plain.data());
  const double largest = 2.5 * (A.cwiseAbs() * x.cwiseAbs()).maxCoeff();
  CHECK((plain - expected).cwiseAbs().maxCoeff() < 1e-14 * largest);
  for (const Multiply24 way : ways_to_multiply24()) {
    way(A.data(), x.data(), 2.5, y.data());
    CHECK(y == plain);
  }
  multiply24(A.data(), x.data(), 2.5, y.data());
  CHECK(y == plain);
}
