#include "contact/surface_check.h"

#include <catch2/catch.hpp>
#include <limits>

#include "core/shapes/surfaces.h"

using namespace elastin;
using namespace elastin::contact;
using Catch::Contains;

namespace {

struct Surface {
  Positions points;
  Cells<3> triangles;
  std::string check() const { return check_surface(points, triangles); }
  void add(const Surface& other, const Vector3& shift) {
    const int n = static_cast<int>(points.cols());
    Positions both(3, n + other.points.cols());
    both << points, other.points.colwise() + shift;
    points = both;
    for (const auto& [a, b, c] : other.triangles) triangles.push_back({a + n, b + n, c + n});
  }
};

Surface ball(double radius = 0.1) {
  const Body body = sphere(radius, SphereMesh::icosahedron, 3);
  return {body.rest, body.triangles};
}

Surface tetrahedron() {
  Surface one{Positions(3, 4), {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  one.points << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  return one;
}

}  // namespace

TEST_CASE("closed surfaces pass, of one part, of two, and of one with a hollow", "[contact]") {
  CHECK(ball().check() == "");
  CHECK(tetrahedron().check() == "");
  Surface two = ball();
  two.add(ball(), {0.3, 0, 0});
  CHECK(two.check() == "");
  Surface hollow = ball(), inner = ball(0.05);
  for (auto& triangle : inner.triangles) std::swap(triangle[1], triangle[2]);
  hollow.add(inner, {0, 0, 0});
  CHECK(hollow.check() == "");
}

TEST_CASE("what is wrong with a surface is said, how often and where", "[contact]") {
  Surface torn = tetrahedron();
  torn.triangles.pop_back();
  CHECK(torn.check() == "it has holes: 3 sides belong to one triangle alone, the first near (0, 0.5, 0) m");

  Surface crowded = tetrahedron();
  crowded.add(tetrahedron(), {0, 0, 0});
  crowded.points.row(0).tail(4) *= -1;  // its mirror image on the other side of x = 0 …
  for (std::size_t t = 4; t < 8; ++t) {
    for (int& corner : crowded.triangles[t])
      if (corner == 4 || corner == 7) corner -= 4;  // … joined along z
    std::swap(crowded.triangles[t][1], crowded.triangles[t][2]);
  }
  crowded.points.col(6) << -1, 1, 0;
  crowded.points.col(5) << -1, -1, 0;
  CHECK(crowded.check() == "one side belongs to more than two triangles, the first near (0, 0, 0.5) m");

  Surface turned = tetrahedron();
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  CHECK(turned.check() == "triangles are turned against their neighbours at 3 sides, the first near (0, 0.5, 0) m");

  Surface inside_out = ball();
  for (auto& triangle : inside_out.triangles) std::swap(triangle[1], triangle[2]);
  CHECK(inside_out.check() == "it is inside out: its normals look inwards");

  Surface flat = tetrahedron();
  flat.points.col(3) = Vector3(0.5, 0, 0);
  CHECK_THAT(flat.check(), Contains("one triangle has no area, the first is triangle 1 near (0.5, 0, 0) m"));

  Surface soup;
  for (const auto& triangle : tetrahedron().triangles) {
    Surface one{Positions(3, 3), {{0, 1, 2}}};
    for (int k = 0; k < 3; ++k) one.points.col(k) = tetrahedron().points.col(triangle[k]);
    soup.add(one, {0, 0, 0});
  }
  CHECK_THAT(soup.check(), Contains("no two triangles share a side"));
}

TEST_CASE("surfaces that cross themselves are found", "[contact]") {
  Surface two = ball();
  two.add(ball(), {0.15, 0.013, 0.007});
  CHECK_THAT(two.check(), Contains("it crosses itself") && Contains("pairs of triangles"));
  Surface dented = ball();  // one corner is pulled through the far side
  dented.points.col(0) *= -1.3;
  CHECK_THAT(dented.check(), Contains("it crosses itself"));
  Surface shallow = ball();
  shallow.points.col(0) *= 0.7;
  CHECK(shallow.check() == "");
  // Two tetrahedra that share one corner, the smaller one standing out through the larger one's floor.
  Surface fans = tetrahedron();
  fans.add(tetrahedron(), {0, 0, 0});
  fans.points.rightCols(3) << 0.45, 0.05, 0.05,  //
      0.05, 0.45, 0.05,                          //
      -0.05, 0.05, 0.4;
  CHECK_THAT(fans.check(), Contains("crosses itself"));
  for (auto& triangle : fans.triangles)
    for (int& corner : triangle) corner = corner == 4 ? 0 : corner;
  CHECK_THAT(fans.check(), Contains("crosses itself"));
}

TEST_CASE("numbers that name no point are said first", "[contact]") {
  Surface wrong = tetrahedron();
  wrong.triangles[2][1] = 9;
  CHECK(wrong.check() == "triangle 2 has point 9; allowed: 0 to 3");
  wrong = tetrahedron();
  wrong.points(1, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK(wrong.check() == "point 2 has no finite coordinates");
  CHECK(check_surface(Positions(3, 0), {}) == "it has no triangles");
}

TEST_CASE("triangles in one plane that touch do not cross, however they are turned", "[contact]") {
  constexpr int side = 4;
  Surface sheet{Positions(3, side * side), {}};
  for (int molecule = 0; molecule < side * side; ++molecule)
    sheet.points.col(molecule) = Vector3(molecule % side, molecule / side, 0);
  for (int y = 0; y + 1 < side; ++y)
    for (int x = 0; x + 1 < side; ++x) {
      const int corner = x + side * y;
      sheet.triangles.push_back({corner, corner + 1, corner + side});
      sheet.triangles.push_back({corner + 1, corner + side + 1, corner + side});
    }
  Surface apart;  // the same with corners of its own for each triangle
  apart.points.resize(3, static_cast<Eigen::Index>(3 * sheet.triangles.size()));
  for (int turn = 1; turn <= 30; ++turn) {
    const Matrix3 rotation = Eigen::AngleAxisd(turn, Vector3(1, 2, 3).normalized()).toRotationMatrix();
    const Positions turned = rotation * sheet.points;
    CHECK(find_crossings(turned, sheet.triangles).count == 0);
    apart.triangles.clear();
    int corners = 0;
    for (const auto& triangle : sheet.triangles) {
      for (const int corner : triangle) apart.points.col(corners++) = turned.col(corner);
      apart.triangles.push_back({corners - 3, corners - 2, corners - 1});
    }
    CHECK(find_crossings(apart.points, apart.triangles).count == 0);
  }
  // A side that goes through by 1e-6 of its length does cross, from a shared corner or not.
  Surface two{Positions(3, 6), {{0, 1, 2}, {3, 4, 5}}};
  two.points << 0, 1, 0, 0, 0.3, 0.3,  //
      0, 0, 1, 0, 0.3, 0.3,            //
      0, 0, 0, 0, 1, -1e-6;
  CHECK(find_crossings(two.points, two.triangles).count == 1);
  two.triangles[1][0] = 0;
  CHECK(find_crossings(two.points, two.triangles).count == 1);
}

TEST_CASE("pairs of triangles that cut each other are found, of those that count", "[contact]") {
  Surface two = ball();
  two.add(ball(), {0.15, 0, 0});
  const std::size_t own = ball().triangles.size();
  CHECK(find_crossings(ball().points, ball().triangles).count == 0);
  const Crossings found = find_crossings(two.points, two.triangles);
  CHECK(found.count > 0);
  CHECK((static_cast<std::size_t>(found.first[0]) < own && static_cast<std::size_t>(found.first[1]) >= own));
  const auto in_one = [&](int a, int b) {
    return (static_cast<std::size_t>(a) < own) == (static_cast<std::size_t>(b) < own);
  };
  CHECK(find_crossings(two.points, two.triangles, in_one).count == 0);
}
