#include "core/geometry/tributary.h"

#include <catch2/catch.hpp>
#include <random>

using namespace elastin;

TEST_CASE("tributary areas of a square grid: quarters at corners, halves at edges", "[tributary]") {
  Points2 points(2, 16);
  for (int i = 0; i < 16; ++i) points.col(i) = 0.5 * Eigen::Vector2d(i % 4, i / 4);
  const Points2 hull = convex_hull(points);
  CHECK(hull.cols() == 4);
  CHECK(polygon_area(hull) == Approx(2.25));
  const auto areas = tributary_areas(points, hull);
  for (int i = 0; i < 16; ++i) {
    const int sides = (i % 4 == 0 || i % 4 == 3) + (i / 4 == 0 || i / 4 == 3);
    CHECK(areas[i] == Approx(0.25 / (1 << sides)).epsilon(1e-12));
  }
}

TEST_CASE("a hull keeps its corners where rounding bends its sides", "[tributary]") {
  for (const double bend : {-1e-18, 1e-18}) {  // a point of the first side before its lower corner, or behind it
    Points2 points(2, 6);
    points << 0, bend, 0, 0.03, 0.03 + bend, 0.03, 0, 0.014, 0.03, 0, 0.017, 0.03;
    CHECK(polygon_area(convex_hull(points)) == Approx(9e-4).epsilon(1e-12));
    CHECK(convex_hull(points).cols() == 4);
  }
}

TEST_CASE("tributary areas of random points sum to the hull and equal a count of nearest points", "[tributary]") {
  std::mt19937_64 generator(4);
  const auto unit = [&] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  Points2 points(2, 60);
  for (int i = 0; i < 60; ++i) points.col(i) = Eigen::Vector2d(3 * unit() - 7, unit() * unit());
  const Points2 hull = convex_hull(points);
  const auto areas = tributary_areas(points, hull);
  double sum = 0;
  for (const double area : areas) sum += area;
  CHECK(sum == Approx(polygon_area(hull)).epsilon(1e-12));
  // Monte Carlo over the hull.
  std::vector<int> hits(60, 0);
  int inside = 0;
  for (int shot = 0; shot < 200000; ++shot) {
    const Eigen::Vector2d p(3 * unit() - 7, unit());
    bool in = true;
    for (int i = 0; i < hull.cols(); ++i) {
      const Eigen::Vector2d side = hull.col((i + 1) % hull.cols()) - hull.col(i), to = p - hull.col(i);
      in &= side.x() * to.y() - side.y() * to.x() >= 0;
    }
    if (!in) continue;
    ++inside;
    Eigen::Index nearest = 0;
    (points.colwise() - p).colwise().squaredNorm().minCoeff(&nearest);
    ++hits[nearest];
  }
  for (std::size_t i = 0; i < 60; ++i) {
    const double share = static_cast<double>(hits[i]) / inside;
    CHECK(share == Approx(areas[i] / sum).margin(5 * std::sqrt(share / inside) + 1e-4));  // five standard deviations
  }
}

TEST_CASE("points on a line have no area", "[tributary]") {
  Points2 points(2, 5);
  for (int i = 0; i < 5; ++i) points.col(i) = Eigen::Vector2d(i, 2 * i);
  CHECK(polygon_area(convex_hull(points)) == 0);
}

TEST_CASE("second moments of area: rectangle, triangle, a shifted one", "[tributary]") {
  Points2 rectangle(2, 4), triangle(2, 3);
  rectangle << 0, 2, 2, 0, 0, 0, 3, 3;  // b h³/12 about its middle
  triangle << 0, 6, 0, 0, 0, 4;         // b h³/36, h along the first coordinate
  const Eigen::Matrix2d of_rectangle = polygon_second_moments(rectangle),
                        of_triangle = polygon_second_moments(triangle);
  CHECK(of_rectangle.isApprox(Eigen::Matrix2d(Eigen::Vector2d(3 * 8 / 12., 2 * 27 / 12.).asDiagonal()), 1e-12));
  CHECK(of_triangle(0, 0) == Approx(4 * 216 / 36.).epsilon(1e-12));
  CHECK(of_triangle(1, 1) == Approx(6 * 64 / 36.).epsilon(1e-12));
  CHECK(of_triangle(0, 1) == Approx(-36 * 16 / 72.).epsilon(1e-12));  // −b² h²/72
  triangle.colwise() += Eigen::Vector2d(1e4, -3e3);
  CHECK(polygon_second_moments(triangle).isApprox(of_triangle, 1e-10));
  CHECK(polygon_second_moments(Points2(2, 0)).isZero(0));
}
