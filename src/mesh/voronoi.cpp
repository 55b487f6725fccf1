#include "elastin/mesh/voronoi.h"

#include <algorithm>
#include <cmath>
#include <vector>
#include <voro++/voro++.hh>

#include "core/model/incidence.h"
#include "hull/convex_hull.h"

namespace elastin::mesh {
namespace {

struct Plane {
  Vector3 normal;
  double offset;  ///< normal · x ≤ offset inside
};

/// The hull of the positions, or what is wrong with them.
std::string find_hull(const Positions& x, std::vector<Plane>& planes) {
  const std::vector<double> points(x.data(), x.data() + x.size());
  return hull::visit_hull(3, points, false, [&](const hull::HullFacet& facet) {
    const Vector3 normal(facet.normal[0], facet.normal[1], facet.normal[2]);
    double offset = -INFINITY;
    for (const int corner : facet.corners) offset = std::max(offset, normal.dot(x.col(corner)));
    planes.push_back({normal, offset});
  });
}

/// Cuts a cell of the molecule at `position` by the planes that reach into it. Plane p is neighbour −10 − p.
void clip(voro::voronoicell_neighbor& cell, const Vector3& position, const std::vector<Plane>& planes) {
  std::vector<double> corners;
  cell.vertices(corners);
  for (std::size_t p = 0; p < planes.size(); ++p) {
    const Vector3& n = planes[p].normal;
    const double distance = std::max(0., planes[p].offset - n.dot(position));
    double furthest = 0;
    for (std::size_t c = 0; c < corners.size(); c += 3)
      furthest = std::max(furthest, n.x() * corners[c] + n.y() * corners[c + 1] + n.z() * corners[c + 2]);
    if (furthest <= distance) continue;
    cell.nplane(n.x(), n.y(), n.z(), 2 * distance, -10 - static_cast<int>(p));
    cell.vertices(corners);
  }
}

}  // namespace

VoronoiCells voronoi_cells(const Body& body) {
  VoronoiCells result;
  const auto failed = [&](const std::string& why) {
    result = {};
    result.problem = why;
    return result;
  };
  if (!body.triangles.empty()) return failed("needs a solid body, not a membrane");
  if (body.size() < 4) return failed("needs at least four molecules");
  // Voro++ compares with lengths of about 1.
  const Vector3 low = body.rest.rowwise().minCoeff();
  const Vector3 size = body.rest.rowwise().maxCoeff() - low;
  const double spacing = size.norm() / std::cbrt(static_cast<double>(body.size()));
  if (!(spacing > 0)) return failed("needs molecules at different positions");
  const Positions x = (body.rest.colwise() - low) / spacing;
  std::vector<Plane> planes;
  if (!find_hull(x, planes).empty()) return failed("needs molecules that do not lie in one plane");

  const Vector3 box = size / spacing;
  const auto blocks = [&](int axis) { return std::max(1, static_cast<int>(box[axis] / 2.)); };
  voro::container container(-1, box.x() + 1, -1, box.y() + 1, -1, box.z() + 1, blocks(0), blocks(1), blocks(2), false,
                            false, false, 16);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    container.put(molecule, x(0, molecule), x(1, molecule), x(2, molecule));

  const Rows incident = connections_of_molecules(body.size(), body.connections);
  result.face_area = VectorX::Zero(body.connections.proper());
  result.volume = VectorX::Zero(body.size());
  result.surface_area = Positions::Zero(3, body.size());
  voro::voronoicell_neighbor cell;
  std::vector<int> neighbours;
  std::vector<double> areas;
  voro::c_loop_all loop(container);
  if (loop.start()) do {
      if (!container.compute_cell(cell, loop)) continue;
      const int molecule = loop.pid();
      clip(cell, x.col(molecule), planes);
      cell.neighbors(neighbours);
      cell.face_areas(areas);
      result.volume[molecule] = cell.volume() * std::pow(spacing, 3);
      for (std::size_t face = 0; face < areas.size(); ++face) {
        const double area = areas[face] * spacing * spacing;
        if (neighbours[face] <= -10) result.surface_area.col(molecule) += area * planes[-10 - neighbours[face]].normal;
        for (const int c : incident[molecule]) {
          if (c >= body.connections.proper()) continue;
          const auto& [a, b] = body.connections.ends[c];
          if (a == molecule && b == neighbours[face]) result.face_area[c] = area;
        }
      }
    } while (loop.inc());

  double filled = 0;
  for (const auto& tetrahedron : body.tetrahedra) filled += signed_volume(body.rest, tetrahedron);
  if (!body.tetrahedra.empty() && filled < 0.999 * result.volume.sum()) return failed("needs a convex body");
  return result;
}

double lost_share(const Body& body, const VoronoiCells& cells) {
  double sum = 0;
  for (int c = 0; c < body.connections.proper(); ++c) sum += cells.face_area[c] * body.connections.rest_length[c];
  return 1 - sum / (3 * cells.volume.sum());
}

}  // namespace elastin::mesh
