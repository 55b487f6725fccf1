#include <algorithm>
#include <cmath>

#include "contact/search.h"
#include "core/geometry/boundary.h"
#include "core/model/block_geometry.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/model/parts.h"

namespace elastin::contact {
namespace {

template <class List>
List sorted(List corners) {
  std::sort(corners.begin(), corners.end());
  return corners;
}

/// ∂x/∂ξ₁ × ∂x/∂ξ₂ of a quadrilateral at the point next to each corner where integrals are taken, and the corners'
/// weights there, a column a point.                                                         [Gauss, 2 × 2 points]
struct QuadrilateralPoints {
  static Eigen::Matrix4d weights() {
    const double near = (1 + 1 / std::sqrt(3.)) / 2, far = 1 - near;
    Eigen::Matrix4d all;
    for (int point = 0; point < 4; ++point)
      for (int k = 0; k < 4; ++k) {
        const int apart = (k - point + 4) % 4;
        all((point + apart) % 4, point) = apart == 0 ? near * near : apart == 2 ? far * far : near * far;
      }
    return all;
  }
  static double spread(const Positions& at, const std::array<int, 4>& corners, int point) {
    const double near = (1 + 1 / std::sqrt(3.)) / 2, far = 1 - near;
    const auto x = [&](int k) -> Vector3 { return at.col(corners[(point + k) % 4]); };
    const Vector3 along = near * (x(1) - x(0)) + far * (x(2) - x(3)),
                  across = near * (x(3) - x(0)) + far * (x(2) - x(1));
    return along.cross(across).norm();
  }
};

double area_of(const Positions& at, const std::array<int, 3>& triangle) { return area_vector(at, triangle).norm(); }
double area_of(const Positions& at, const std::array<int, 4>& corners) {
  double area = 0;
  for (int point = 0; point < 4; ++point) area += QuadrilateralPoints::spread(at, corners, point) / 4;
  return area;
}

/// Collects sides; those that cells of second order make share the area of the cells' own side.
class Collector {
 public:
  explicit Collector(const Body& body) : body_(body) {}
  void add(const std::array<int, 3>& corners, double scale = 1) {
    sides_.triangles.push_back(corners);
    of_triangles_.push_back(scale * area_of(body_.rest, corners));
  }
  void add(const std::array<int, 4>& corners, double scale = 1) {
    sides_.quadrilaterals.push_back(corners);
    of_quadrilaterals_.push_back(scale * area_of(body_.rest, corners));
  }
  void add(const CellKind& kind, std::span<const int> nodes) {
    const auto visit = [&](const auto& visitor) {
      for (const auto& polyhedron : kind.polyhedra) {
        const std::vector<int>& own = polyhedron.front();
        if (own.size() == 3)
          visitor(std::array{nodes[own[0]], nodes[own[1]], nodes[own[2]]});
        else
          visitor(std::array{nodes[own[0]], nodes[own[1]], nodes[own[2]], nodes[own[3]]});
      }
    };
    const Eigen::MatrixXd at = positions_of(body_.rest, nodes);
    double area = 0, flat = 0;
    for (std::size_t g = 0; g < kind.slopes.size(); ++g)
      area += kind.weights[static_cast<Eigen::Index>(g)] * measure_of(at * kind.slopes[g].transpose());
    visit([&](const auto& corners) { flat += area_of(body_.rest, corners); });
    visit([&](const auto& corners) { add(corners, area / flat); });
  }
  SurfaceSides sides() {
    sides_.areas = std::move(of_triangles_);
    sides_.areas.insert(sides_.areas.end(), of_quadrilaterals_.begin(), of_quadrilaterals_.end());
    return std::move(sides_);
  }

 private:
  const Body& body_;
  SurfaceSides sides_;
  std::vector<double> of_triangles_, of_quadrilaterals_;
};

}  // namespace

Cells<3> surface_triangles(const Body& body) {
  Cells<3> found = boundary_of(body.tetrahedra);
  for (const auto& [a, b, c, d] : boundary_of(body.cubes)) {
    found.push_back({a, b, c});
    found.push_back({a, c, d});
  }
  if (body.triangles.empty()) return found;
  Cells<3> taken = faces_of(body.tetrahedra);
  for (auto& face : taken) face = sorted(face);
  std::sort(taken.begin(), taken.end());
  for (const auto& triangle : body.triangles)
    if (!std::binary_search(taken.begin(), taken.end(), sorted(triangle))) found.push_back(triangle);
  return found;
}

SurfaceSides surface_sides(const Body& body) {
  Collector collector(body);
  std::vector<std::vector<int>> taken;  // sides of solid cells, which a skin of membranes repeats
  if (has_blocks(body, 3)) {
    for (const BlockFace& face : boundary_faces(body)) {
      collector.add(*face.kind, face.nodes);
      taken.push_back(sorted(face.nodes));
    }
  } else {
    for (const auto& triangle : boundary_of(body.tetrahedra)) collector.add(triangle);
    for (const auto& triangle : faces_of(body.tetrahedra))
      taken.push_back(sorted(std::vector(triangle.begin(), triangle.end())));
  }
  for (const auto& face : boundary_of(body.cubes)) collector.add(face);
  std::sort(taken.begin(), taken.end());
  const auto is_free = [&](std::span<const int> nodes) {
    return !std::binary_search(taken.begin(), taken.end(), sorted(std::vector(nodes.begin(), nodes.end())));
  };
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; block.kind->dimensions == 2 && cell < block.size(); ++cell)
      if (is_free(block.cell(cell))) collector.add(*block.kind, block.cell(cell));
  if (!has_blocks(body, 2))
    for (const auto& triangle : body.triangles)
      if (is_free(triangle)) collector.add(triangle);
  return collector.sides();
}

std::vector<std::string> parts_without(const SurfaceSides& sides, const Body& body) {
  std::vector<char> met(static_cast<std::size_t>(body.size()), 0);
  const auto mark = [&](const auto& cells) {
    for (const auto& cell : cells)
      for (const int molecule : cell) met[molecule] = 1;
  };
  mark(sides.triangles), mark(sides.quadrilaterals);
  std::vector<std::string> names;
  for (const Part& part : body.parts) {
    const std::vector<int> own = molecules_of(part);
    if (std::none_of(own.begin(), own.end(), [&](int molecule) { return met[molecule]; })) names.push_back(part.name);
  }
  return names;
}

std::vector<int> surface_molecules(const Body& body) {
  std::vector<char> inside(body.size(), 0);
  const auto mark = [&](const auto& cells, char what) {
    for (const auto& cell : cells)
      for (const int molecule : cell) inside[molecule] = what;
  };
  mark(body.tetrahedra, 1);
  mark(body.cubes, 1);
  mark(surface_triangles(body), 0);
  std::vector<int> found;
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (!inside[molecule]) found.push_back(molecule);
  return found;
}

std::vector<Sample> sphere_samples(const Body& body, const std::vector<int>& molecules) {
  const std::vector<int> piece_of = inspect(body).piece_of;
  std::vector<Sample> samples;
  samples.reserve(molecules.size());
  for (const int molecule : molecules) {
    Sample sample;
    sample.molecules[0] = molecule;
    sample.weights[0] = 1;
    sample.radius = body.radius[molecule];
    sample.area = 4 * sample.radius * sample.radius;
    sample.piece = piece_of[molecule];
    samples.push_back(sample);
  }
  return samples;
}

std::vector<Sample> side_samples(const Body& body, const SurfaceSides& sides) {
  const std::vector<int> piece_of = inspect(body).piece_of;
  const Eigen::Matrix4d of_quadrilateral = QuadrilateralPoints::weights();
  std::vector<Sample> samples;
  samples.reserve(3 * sides.triangles.size() + 4 * sides.quadrilaterals.size());
  const auto add = [&](const auto& corners, int point, double area) {
    Sample& sample = samples.emplace_back();
    sample.count = static_cast<int>(corners.size());
    for (int k = 0; k < sample.count; ++k) {
      sample.molecules[k] = corners[k];
      sample.weights[k] = sample.count == 4 ? of_quadrilateral(k, point) : k == point ? 2. / 3 : 1. / 6;
    }
    sample.area = area;
    sample.piece = piece_of[corners[0]];
  };
  std::size_t side = 0;
  for (const auto& triangle : sides.triangles) {
    for (int point = 0; point < 3; ++point) add(triangle, point, sides.areas[side] / 3);
    ++side;
  }
  for (const auto& corners : sides.quadrilaterals) {
    const double whole = 4 * area_of(body.rest, corners);
    for (int point = 0; point < 4; ++point)
      add(corners, point, sides.areas[side] * QuadrilateralPoints::spread(body.rest, corners, point) / whole);
    ++side;
  }
  return samples;
}

}  // namespace elastin::contact
