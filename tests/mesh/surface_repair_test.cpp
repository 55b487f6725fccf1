#include "mesh/surface_repair.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/shapes/surfaces.h"
#include "elastin/core/base/text.h"
#include "elastin/mesh/mesh_file.h"
#include "mesh/fill.h"

using namespace elastin;
using namespace elastin::mesh;

namespace {

double volume(const Positions& points, const Cells<3>& triangles) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles) sum += points.col(a).dot(Vector3(points.col(b)).cross(points.col(c))) / 6;
  return sum;
}

/// A box of [mm] a by b by c, each face of n × n squares of two triangles.
Body box(int n, const Vector3& size) {
  Body body;
  std::vector<Vector3> points;
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {0, 1}) {
      const auto first = static_cast<int>(points.size());
      for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) {
          Vector3 at;
          at[axis] = side, at[(axis + 1) % 3] = 1. * i / n, at[(axis + 2) % 3] = 1. * j / n;
          points.push_back(at.cwiseProduct(size));
        }
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const int a = first + i * (n + 1) + j, b = a + n + 1, c = b + 1, d = a + 1;
          if (side == 1)
            body.triangles.insert(body.triangles.end(), {{a, b, c}, {a, c, d}});
          else
            body.triangles.insert(body.triangles.end(), {{a, c, b}, {a, d, c}});
        }
    }
  std::vector<int> same(points.size());
  std::vector<Vector3> kept;
  for (std::size_t p = 0; p < points.size(); ++p) {
    std::size_t found = 0;
    while (found < kept.size() && (kept[found] - points[p]).norm() > 1e-9) ++found;
    if (found == kept.size()) kept.push_back(points[p]);
    same[p] = static_cast<int>(found);
  }
  body.rest.resize(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t p = 0; p < kept.size(); ++p) body.rest.col(static_cast<Eigen::Index>(p)) = kept[p];
  for (auto& triangle : body.triangles)
    for (int& corner : triangle) corner = same[corner];
  return body;
}

}  // namespace

TEST_CASE("surfaces with faults: what is done, and the volume inside", "[surface_repair]") {
  struct Expected {
    const char* file;
    double volume;        ///< [file's unit³]
    const char* repairs;  ///< the reader's, then those of the surface
  };
  for (const Expected& expected :
       std::vector<Expected>{{"surf_near_points.stl", 1000, "2 triangles without area dropped"},
                             {"surf_zero_area.stl", 1000, "1 triangle without area dropped"},
                             {"surf_needle_T.stl", 1000, "1 triangle without area dropped"},
                             {"surf_inside_out.stl", 1000, "1 shell that was inside out turned"},
                             {"surf_one_turned.stl", 1000, "1 triangle turned like the neighbours"},
                             {"surf_one_triangle_missing.stl", 1000, "1 hole closed, the widest 1.41e+04 mm across"},
                             {"surf_double.stl", 1000, "12 triangles that stood twice dropped"},
                             {"surf_spare_triangle.stl", 1000, "1 spare triangle dropped"},
                             {"surf_two_touch_face.stl", 2000, "2 pairs of triangles back to back dropped"},
                             {"surf_cavity.stl", 936, ""},
                             {"surf_cavity_same_normals.stl", 936, "1 inner shell turned to bound a cavity"},
                             {"surf_two_apart.stl", 2000, ""}}) {
    INFO(expected.file);
    const Mesh mesh = load_mesh(std::string(ELASTIN_TEST_DATA) + "/mesh/data/brought/" + expected.file);
    const RepairedSurface surface = repair_surface(mesh.points, mesh.triangles);
    std::vector<std::string> said = mesh.repairs;
    said.insert(said.end(), surface.repairs.begin(), surface.repairs.end());
    CHECK(listed(said) == expected.repairs);
    CHECK(volume(surface.points, surface.triangles) == Approx(expected.volume).epsilon(1e-6));
    CHECK(surface.widest_hole == 0);
    const RepairedSurface again = repair_surface(surface.points, surface.triangles);
    CHECK(again.repairs.empty());
    CHECK(again.triangles == surface.triangles);
  }
}

TEST_CASE("a small hole is closed, a wide one is left and its width given", "[surface_repair]") {
  Body body = box(6, {6e-3, 6e-3, 6e-3});
  CHECK(repair_surface(body.rest, body.triangles).repairs.empty());
  body.triangles.erase(body.triangles.begin() + 2 * 14, body.triangles.begin() + 2 * 15);  // a square of 1 mm²
  const RepairedSurface closed = repair_surface(body.rest, body.triangles);
  CHECK(listed(closed.repairs) == "1 hole closed, the widest 1.41 mm across");
  CHECK(volume(closed.points, closed.triangles) == Approx(216e-9));
  body.triangles.erase(body.triangles.begin(), body.triangles.begin() + 2 * 36 - 2);  // a whole face
  const RepairedSurface open = repair_surface(body.rest, body.triangles);
  CHECK(open.repairs.empty());
  CHECK(open.widest_hole == Approx(std::sqrt(72.) * 1e-3));
}

TEST_CASE("the winding number tells inside from outside, on an open and on a double surface", "[surface_repair]") {
  Body body = sphere(1, SphereMesh::icosahedron, 12);
  const WindingNumber closed(body.rest, body.triangles);
  for (const double x : {0., 0.3, 0.9}) CHECK(closed.at({x, 0.1, 0}) == Approx(1).margin(0.02));
  for (const double x : {1.1, 2., 40.}) CHECK(closed.at({x, 0.1, 0}) == Approx(0).margin(0.02));
  // Half of a sphere is seen from its middle under half of all directions.
  Cells<3> half;
  for (const auto& t : body.triangles)
    if (body.rest(2, t[0]) + body.rest(2, t[1]) + body.rest(2, t[2]) > 0) half.push_back(t);
  CHECK(WindingNumber(body.rest, half).at(Vector3::Zero()) == Approx(0.5).margin(0.02));
}

TEST_CASE("surfaces that stay open or overlap are filled by their winding number", "[surface_repair]") {
  FillOptions options;
  options.spacing = 1e-3;
  const Mesh two = load_mesh(std::string(ELASTIN_TEST_DATA) + "/mesh/data/brought/surf_two_overlapping.stl");
  const RepairedSurface surface = repair_surface(1e-3 * two.points, two.triangles);
  CHECK(surface.repairs.empty());
  const FillRegion inside(surface.points, surface.triangles, true);
  CHECK(inside.shells() == 1);
  CHECK(inside.filled_as_one() == 2);
  const Filling filling = inside.fill(options);
  CHECK(filling.volume == Approx(1.875e-6).epsilon(0.03));
  CHECK(filling.surface_volume == Approx(1.875e-6).epsilon(0.005));  // by points
}
