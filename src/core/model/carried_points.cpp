#include "core/model/carried_points.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/rows.h"
#include "core/geometry/box_tree.h"
#include "core/model/solid_cells.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

constexpr int kNewtonSteps = 30;
constexpr double kInside = 1e-9;  ///< of a reference cell: what counts as within it
constexpr int kCarriedThreshold = 100;

/// How far outside of the reference cell ξ lies, in its units, by the planes of its faces; 0 or below is within.
double outside(const CellKind& kind, const VectorX& at) {
  double most = -1;
  for (const auto& face : kind.faces) {
    const auto node = [&](std::size_t i) -> Vector3 { return kind.reference.col(face[i]); };
    const Vector3 normal = (node(1) - node(0)).cross(node(2) - node(0)).normalized();
    most = std::max(most, normal.dot(Vector3(at) - node(0)));
  }
  return most;
}

/// ξ where the cell, continued beyond its faces, has the point; not finite where Newton's method finds none.
VectorX local_position(const CellKind& kind, const Positions& nodes, const Vector3& point) {
  VectorX at = kind.reference.rowwise().mean();
  const double size = (nodes.colwise() - nodes.col(0)).colwise().norm().maxCoeff();
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Vector3 miss = point - nodes * kind.functions(at);
    if (miss.norm() <= 1e-13 * size) return at;
    const Matrix3 jacobian = nodes * kind.function_slopes(at).transpose();
    at += jacobian.inverse() * miss;
  }
  const Vector3 left = point - nodes * kind.functions(at);
  return left.norm() <= 1e-9 * size ? at : VectorX::Constant(3, NAN);
}

}  // namespace

CarriedPoints::CarriedPoints(const Body& body, const Positions& points) {
  const std::vector<SolidCell> solid = solid_cells_of(body);
  if (solid.empty())
    throw InputError("the body has no solid cells to carry points: tetrahedra, hexahedra, prisms or a lattice's cubes");
  const auto nodes_of = [&](const SolidCell& cell) -> Positions { return body.rest(Eigen::all, cell.nodes); };
  std::vector<Box> boxes;
  boxes.reserve(solid.size());
  for (const SolidCell& cell : solid) {
    const Positions nodes = nodes_of(cell);
    boxes.push_back({nodes.rowwise().minCoeff(), nodes.rowwise().maxCoeff()});
  }
  const BoxTree tree(boxes);
  const int count = static_cast<int>(points.cols());
  for (int p = 0; p < count; ++p)
    if (!points.col(p).allFinite()) throw InputError("point " + std::to_string(p) + " is not finite");
  std::vector<std::pair<int, double>> nearest(count);
  parallel_for(
      count,
      [&](int p) {
        const Vector3 point = points.col(p);
        nearest[p] = tree.nearest(point, [&](int item) {
          const SolidCell& cell = solid[item];
          const VectorX at = local_position(*cell.kind, nodes_of(cell), point);
          if (!at.allFinite()) return std::numeric_limits<double>::infinity();
          const double out = outside(*cell.kind, at);
          return out <= kInside ? 0 : out * boxes[item].half_diagonal();
        });
      },
      kCarriedThreshold);
  for (int p = 0; p < count; ++p) {
    const Vector3 point = points.col(p);
    const auto& [found, distance] = nearest[p];
    if (found < 0)
      throw InputError("point " + std::to_string(p) + " at (" + number(point[0]) + ", " + number(point[1]) + ", " +
                       number(point[2]) + ") m lies so far outside that no cell of the body can be continued to it");
    const SolidCell& cell = solid[found];
    const VectorX own = cell.kind->functions(local_position(*cell.kind, nodes_of(cell), point));
    molecules.insert(molecules.end(), cell.nodes.begin(), cell.nodes.end());
    weights.insert(weights.end(), own.begin(), own.end());
    starts.push_back(numbered(static_cast<std::int64_t>(molecules.size()), "molecules of a body's points"));
    beyond.push_back(distance);
  }
}

}  // namespace elastin
