// Slopes at all points of a cell at once are those of the shape functions, whichever way they are summed.

#include "core/geometry/reference_slopes.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace elastin;

namespace {

/// Numbers without a pattern, between −1 and 1.
double scattered(int i) { return std::sin(1 + 12.9898 * i); }

template <int d>
void check(const CellKind& kind) {
  const ReferenceSlopes<d> slopes(kind);
  const auto points = kind.slopes.size();
  NodeVectors values(3, kind.nodes);
  for (Eigen::Index i = 0; i < values.size(); ++i) values.data()[i] = scattered(static_cast<int>(i));
  PointGradients<d> found, P;
  slopes.gradients(values, found);
  NodeVectors spread = NodeVectors::Ones(3, kind.nodes), expected = spread;
  for (std::size_t g = 0; g < points; ++g) {
    const Eigen::MatrixXd gradient = values * kind.slopes[g].transpose();
    CHECK((found[g] - gradient).norm() < 1e-13);
    for (Eigen::Index i = 0; i < P[g].size(); ++i)
      P[g].data()[i] = scattered(1000 + 9 * static_cast<int>(g) + static_cast<int>(i));
    expected += P[g] * kind.slopes[g];
  }
  slopes.spread(P, spread);
  CHECK((spread - expected).norm() < 1e-12);
}

}  // namespace

TEST_CASE("slopes at all points of a cell are those of its functions, and what is spread is their transpose") {
  for (const CellKind& kind : cell_kinds()) {
    INFO(kind.name);
    if (kind.dimensions == 3)
      check<3>(kind);
    else
      check<2>(kind);
  }
}
