#include "hull/delaunay.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "elastin/core/base/error.h"
#include "hull/convex_hull.h"

namespace elastin::hull {
namespace {

constexpr double kSliver = 1e-4;

/// Volume over the cube of the longest side.
double flatness(const Positions& positions, const std::array<int, 4>& cell) {
  double longest = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j) longest = std::max(longest, (positions.col(cell[i]) - positions.col(cell[j])).norm());
  return signed_volume(positions, cell) / (longest * longest * longest);
}

/// The cells below the hull of (x, |x|² − weight) in four dimensions; x in mean spacings from the middle.
Cells<4> lower_hull(const Positions& x, const VectorX& weights, const Positions& positions) {
  std::vector<double> lifted;
  lifted.reserve(4 * static_cast<std::size_t>(x.cols() + 1));
  for (Eigen::Index molecule = 0; molecule < x.cols(); ++molecule)
    lifted.insert(lifted.end(),
                  {x(0, molecule), x(1, molecule), x(2, molecule), x.col(molecule).squaredNorm() - weights[molecule]});
  // One more point, high above all, makes the upper side simple and four molecules enough.
  const int top = static_cast<int>(x.cols());
  lifted.insert(lifted.end(), {0, 0, 0, 1 + 2 * x.colwise().squaredNorm().maxCoeff()});
  Cells<4> cells;
  const std::string problem = visit_hull(4, lifted, true, [&](const HullFacet& facet) {
    if (facet.corners.size() != 4 || std::find(facet.corners.begin(), facet.corners.end(), top) != facet.corners.end())
      return;
    std::array<int, 4> cell{};
    std::copy_n(facet.corners.begin(), 4, cell.begin());
    std::sort(cell.begin(), cell.end());
    if (signed_volume(positions, cell) < 0) std::swap(cell[2], cell[3]);
    // Facets that stand upright on a plane of the surface are no cells.
    if (facet.normal[3] < -1e-9 && flatness(positions, cell) > 1e-9) cells.push_back(cell);
  });
  if (!problem.empty()) throw InputError("no tetrahedra fit between the molecules: " + problem);
  std::sort(cells.begin(), cells.end());
  return cells;
}

}  // namespace

Cells<4> delaunay_tetrahedra(const Positions& positions, const std::function<bool(const std::array<int, 4>&)>& matter) {
  if (positions.cols() < 4) throw InputError("tetrahedra need at least four molecules");
  const Vector3 middle = positions.rowwise().mean();
  const double spread = (positions.colwise() - middle).colwise().norm().maxCoeff();
  const double spacing = spread / std::cbrt(static_cast<double>(positions.cols()));
  if (!(spread > 0)) throw InputError("the molecules lie at one position");
  const Positions x = (positions.colwise() - middle) / spacing;
  std::mt19937_64 generator(1);
  const auto draw = [&](double most) { return most * static_cast<double>(generator() >> 11) * 0x1.0p-53; };
  VectorX weights(positions.cols());
  for (double& weight : weights) weight = draw(0.01);
  const auto is_sliver = [&](const std::array<int, 4>& cell) {
    return flatness(positions, cell) < kSliver && (!matter || matter(cell));
  };
  const auto count = [&](const Cells<4>& of) { return std::count_if(of.begin(), of.end(), is_sliver); };
  Cells<4> best = lower_hull(x, weights, positions);
  auto fewest = count(best);
  Cells<4> cells = best;
  constexpr int rounds = 8;
  for (int round = 0; round < rounds && fewest > 0; ++round) {
    for (const auto& cell : cells)
      if (is_sliver(cell))
        for (const int molecule : cell) weights[molecule] = draw(0.05);
    cells = lower_hull(x, weights, positions);
    const auto slivers = count(cells);
    if (slivers < fewest) fewest = slivers, best = cells;
  }
  return best;
}

int count_slivers(const Positions& positions, const Cells<4>& tetrahedra) {
  return static_cast<int>(std::count_if(tetrahedra.begin(), tetrahedra.end(),
                                        [&](const auto& cell) { return flatness(positions, cell) < kSliver; }));
}

}  // namespace elastin::hull
