#include "core/shapes/surfaces.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>

#include "core/geometry/rim.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

Body body_of(const std::vector<Vector3>& positions, Cells<3> triangles) {
  Body body;
  body.rest.resize(3, static_cast<Eigen::Index>(positions.size()));
  for (std::size_t molecule = 0; molecule < positions.size(); ++molecule)
    body.rest.col(static_cast<Eigen::Index>(molecule)) = positions[molecule];
  body.triangles = std::move(triangles);
  body.connections = connections_of_cells(body.rest, body.triangles, {});
  return body;
}

struct Solid {
  std::vector<Vector3> corners;
  Cells<3> faces;  ///< counter-clockwise from outside
};

Solid octahedron() {
  Solid solid{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}, {}};
  for (const int x : {0, 3})
    for (const int y : {1, 4})
      for (const int z : {2, 5}) {
        const bool mirrored = ((x == 3) + (y == 4) + (z == 5)) % 2;
        solid.faces.push_back(mirrored ? std::array{x, z, y} : std::array{x, y, z});
      }
  return solid;
}

Solid icosahedron() {
  const double g = std::numbers::phi;
  Solid solid;
  for (const double one : {-1., 1.})
    for (const double golden : {-g, g})
      for (const Vector3& corner : {Vector3(0, one, golden), Vector3(one, golden, 0), Vector3(golden, 0, one)})
        solid.corners.push_back(corner);
  // Corners 2 apart are neighbours; the next nearest are 2 g apart.
  const auto joined = [&](int a, int b) { return (solid.corners[a] - solid.corners[b]).norm() < 2.5; };
  for (int a = 0; a < 12; ++a)
    for (int b = a + 1; b < 12; ++b)
      for (int c = b + 1; c < 12; ++c)
        if (joined(a, b) && joined(b, c) && joined(a, c)) {
          const bool outwards = solid.corners[a].dot(solid.corners[b].cross(solid.corners[c])) > 0;
          solid.faces.push_back(outwards ? std::array{a, b, c} : std::array{a, c, b});
        }
  return solid;
}

/// Cuts the faces of a solid into n² triangles each and pushes their corners out to the sphere. A point is known by the
/// weights of the solid's corners in it, so that faces share those on their sides.
class RoundSolid {
 public:
  RoundSolid(Solid solid, double radius, int divisions) : solid_(std::move(solid)), radius_(radius), n_(divisions) {}

  Body cut(bool turn_corners) {
    Cells<3> triangles;
    for (const auto& face : solid_.faces) {
      const auto add = [&](const Weights& a, const Weights& b, const Weights& c) {
        triangles.push_back({molecule(face, a), molecule(face, b), molecule(face, c)});
      };
      for (int i = 0; i < n_; ++i)
        for (int j = 0; i + j < n_; ++j) {
          const int k = n_ - 1 - i - j;
          const bool at_corner = turn_corners && std::max({i, j, k}) == n_ - 1;
          if (!at_corner) add({i + 1, j, k}, {i, j + 1, k}, {i, j, k + 1});
          const bool across_corner = turn_corners && std::max({i, j, k - 1}) == n_ - 2;
          if (k > 0 && !across_corner) add({i, j + 1, k}, {i + 1, j, k}, {i + 1, j + 1, k - 1});
        }
      if (!turn_corners) continue;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const auto at = [&](int own, int next, int last) {
          Weights weights;
          weights[corner] = own, weights[(corner + 1) % 3] = next, weights[(corner + 2) % 3] = last;
          return weights;
        };
        add(at(n_, 0, 0), at(n_ - 1, 1, 0), at(n_ - 2, 1, 1));
        add(at(n_, 0, 0), at(n_ - 2, 1, 1), at(n_ - 1, 0, 1));
      }
    }
    return body_of(positions_, std::move(triangles));
  }

 private:
  using Weights = std::array<int, 3>;

  int molecule(const std::array<int, 3>& face, const Weights& weights) {
    std::vector<std::pair<int, int>> key;
    for (std::size_t corner = 0; corner < 3; ++corner)
      if (weights[corner] > 0) key.push_back({face[corner], weights[corner]});
    std::sort(key.begin(), key.end());
    const auto [found, fresh] = molecules_.try_emplace(key, static_cast<int>(positions_.size()));
    if (fresh) {
      Vector3 position = Vector3::Zero();
      for (const auto& [corner, weight] : key) position += weight * solid_.corners[corner];
      positions_.push_back(radius_ * position.normalized());
    }
    return found->second;
  }

  Solid solid_;
  double radius_;
  int n_;
  std::map<std::vector<std::pair<int, int>>, int> molecules_;
  std::vector<Vector3> positions_;
};

Body round_body(Solid solid, double radius, SphereMesh mesh, int divisions) {
  const int least = mesh == SphereMesh::type_2 ? 3 : 1;
  if (divisions < least)
    throw InputError("divisions " + std::to_string(divisions) + ": this mesh needs at least " + std::to_string(least));
  return RoundSolid(std::move(solid), radius, divisions).cut(mesh == SphereMesh::type_2);
}

/// Squares between lines along y and along x, those that `taken` says; a molecule at each corner that a square has.
Body grid(const std::vector<double>& x, const std::vector<double>& y, SheetPattern pattern,
          const std::function<bool(int, int)>& taken) {
  std::vector<Vector3> positions;
  Cells<3> triangles;
  std::map<std::pair<int, int>, int> molecules;
  const auto molecule = [&](int i, int j) {
    const auto [found, fresh] = molecules.try_emplace({j, i}, static_cast<int>(positions.size()));
    if (fresh) positions.emplace_back(x[i], y[j], 0);
    return found->second;
  };
  for (int j = 0; j + 1 < static_cast<int>(y.size()); ++j)
    for (int i = 0; i + 1 < static_cast<int>(x.size()); ++i) {
      if (!taken(i, j)) continue;
      const int a = molecule(i, j), b = molecule(i + 1, j), c = molecule(i + 1, j + 1), d = molecule(i, j + 1);
      if (pattern == SheetPattern::crossed) {
        const int middle = static_cast<int>(positions.size());
        positions.push_back((positions[a] + positions[c]) / 2);
        for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, d}, {d, a}})
          triangles.push_back({from, to, middle});
      } else if (pattern == SheetPattern::alternating && (i + j) % 2) {
        triangles.push_back({a, b, d});
        triangles.push_back({b, c, d});
      } else {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
      }
    }
  return body_of(positions, std::move(triangles));
}

/// Appends `parts` equal steps up to `end`.
void divide(std::vector<double>& lines, double end, int divisions) {
  const double start = lines.back();
  for (int division = 1; division <= divisions; ++division)
    lines.push_back(start + (end - start) * division / divisions);
}

}  // namespace

Body sphere(double radius, SphereMesh mesh, int divisions) {
  return round_body(mesh == SphereMesh::icosahedron ? icosahedron() : octahedron(), radius, mesh, divisions);
}

Body sphere_octant(double radius, SphereMesh mesh, int divisions) {
  if (mesh == SphereMesh::icosahedron) throw InputError("an octant has no icosahedron mesh; allowed: type_1, type_2");
  Solid octant = octahedron();
  octant.faces.resize(1);  // the first is that of +x, +y, +z
  return round_body(std::move(octant), radius, mesh, divisions);
}

Body disc(double radius, int rings) {
  std::vector<Vector3> positions{Vector3::Zero()};
  Cells<3> triangles;
  const auto molecule = [](int ring, int slot) {
    return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1) + slot % (6 * ring);
  };
  for (int ring = 1; ring <= rings; ++ring)
    for (int slot = 0; slot < 6 * ring; ++slot) {
      const double angle = std::numbers::pi / 3 * slot / ring;
      positions.push_back(radius * ring / rings * Vector3(std::cos(angle), std::sin(angle), 0));
    }
  for (int ring = 1; ring <= rings; ++ring)
    for (int sector = 0; sector < 6; ++sector)
      for (int i = 0; i < ring; ++i) {
        const int outer = sector * ring + i, inner = sector * (ring - 1) + i;
        triangles.push_back({molecule(ring - 1, inner), molecule(ring, outer), molecule(ring, outer + 1)});
        if (i + 1 < ring)
          triangles.push_back({molecule(ring - 1, inner), molecule(ring, outer + 1), molecule(ring - 1, inner + 1)});
      }
  return body_of(positions, std::move(triangles));
}

Body rectangular_sheet(const std::array<double, 2>& size, const std::array<int, 2>& squares, SheetPattern pattern) {
  std::vector<double> x{0}, y{0};
  divide(x, size[0], squares[0]);
  divide(y, size[1], squares[1]);
  return grid(x, y, pattern, [](int, int) { return true; });
}

Body cross_canopy(double width, double span, int squares) {
  if (!(span > width)) throw InputError("the span of a cross must be more than its width");
  const double arm = (span - width) / 2;
  const int along = std::max(1, static_cast<int>(std::lround(arm / width * squares)));
  std::vector<double> lines{-span / 2};
  divide(lines, -width / 2, along);
  divide(lines, width / 2, squares);
  divide(lines, span / 2, along);
  const auto inside = [&](int i) { return i >= along && i < along + squares; };
  return grid(lines, lines, SheetPattern::alternating, [&](int i, int j) { return inside(i) || inside(j); });
}

void hang_load(Body& body, HungFrom from, const Vector3& position, double stiffness, double mass, double radius) {
  const int load = body.size();
  body.between.clear();  // what hangs lies between no others
  std::vector<char> chosen(load, 0);
  if (from == HungFrom::rim) {
    for (const int molecule : rim_of(body.triangles)) chosen[molecule] = 1;
  } else {
    const Vector3 low = body.rest.rowwise().minCoeff(), high = body.rest.rowwise().maxCoeff();
    const double near = 1e-6 * (high - low).norm();
    for (int molecule = 0; molecule < load; ++molecule)
      for (int k = 0; k < 2; ++k)
        if (std::min(body.rest(k, molecule) - low[k], high[k] - body.rest(k, molecule)) <= near) chosen[molecule] = 1;
  }
  body.rest.conservativeResize(3, load + 1);
  body.mass.conservativeResize(load + 1);
  body.radius.conservativeResize(load + 1);
  body.rest.col(load) = position;
  body.mass[load] = mass;
  body.radius[load] = radius;
  for (int molecule = 0; molecule < load; ++molecule) {
    if (!chosen[molecule]) continue;
    const double length = (body.rest.col(molecule) - position).norm();
    if (!(length > 0)) throw InputError("a molecule of the body lies where the load hangs");
    body.cables.push_back({body.connections.size(), stiffness});
    body.connections.ends.push_back({molecule, load});
    body.connections.rest_length.push_back(length);
  }
}

Vector3 area_vector(const Positions& positions, const std::array<int, 3>& triangle) {
  const Vector3 origin = positions.col(triangle[0]);
  return (positions.col(triangle[1]) - origin).cross(positions.col(triangle[2]) - origin) / 2;
}

std::vector<int> flat_triangles(const Body& body, const Positions& positions) {
  std::vector<int> flat;
  for (std::size_t cell = 0; cell < body.triangles.size(); ++cell) {
    const auto& [a, b, c] = body.triangles[cell];
    const double longest = std::max({(positions.col(b) - positions.col(a)).squaredNorm(),
                                     (positions.col(c) - positions.col(b)).squaredNorm(),
                                     (positions.col(a) - positions.col(c)).squaredNorm()});
    if (!(area_vector(positions, body.triangles[cell]).norm() > 1e-12 * longest))
      flat.push_back(static_cast<int>(cell));
  }
  return flat;
}

}  // namespace elastin
