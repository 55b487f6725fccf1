#include "core/base/dense.h"

#include <algorithm>
#include <array>
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
  // Wherever they lie: a matrix of another's member has the alignment of its numbers, and no more.
  std::array<double, 24 * 24 + 4> matrix;
  std::array<double, 24 + 4> result;
  for (std::size_t offset = 0; offset < 4; ++offset) {
    std::copy_n(A.data(), A.size(), matrix.data() + offset);
    for (const Multiply24 way : ways_to_multiply24()) {
      way(matrix.data() + offset, x.data(), 2.5, result.data() + offset);
      CHECK(std::equal(plain.data(), plain.data() + 24, result.data() + offset));
    }
  }
  multiply24(A.data(), x.data(), 2.5, y.data());
  CHECK(y == plain);
}
