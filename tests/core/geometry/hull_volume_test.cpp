#include "core/geometry/hull_volume.h"

#include <catch2/catch.hpp>
#include <random>

#include "elastin/core/shapes/arrays.h"
#include "elastin/core/shapes/shapes.h"

using namespace elastin;

TEST_CASE("the hull of points has their volume, however it is turned", "[geometry]") {
  const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  for (const int side : {2, 3, 8}) {
    const Positions grid = cubic_lattice({side, side, side}, 0.01 / (side - 1), {true, true, false}).rest;
    CHECK(hull_volume(grid) == Approx(1e-6).epsilon(1e-12));
    CHECK(hull_volume(turn * grid) == Approx(1e-6).epsilon(1e-12));
  }
  Positions octahedron(3, 7);
  octahedron << 1, -1, 0, 0, 0, 0, 0, 0, 0, 1, -1, 0, 0, 0, 0, 0, 0, 0, 1, -1, 0;
  CHECK(hull_volume(octahedron) == Approx(4. / 3).epsilon(1e-14));
  CHECK(hull_volume(turn * Positions(octahedron.array() * 0.001)) == Approx(4e-9 / 3).epsilon(1e-12));
  Positions ball(3, 4000);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < ball.cols(); ++i)
    ball.col(i) = Vector3(normal(random), normal(random), normal(random)).normalized() * (i % 4 ? 0.5 : 1.);
  const double volume = hull_volume(ball);
  CHECK(volume < 4.18879);
  CHECK(volume > 0.98 * 4.18879);
  CHECK(hull_volume(turn * ball) == Approx(volume).epsilon(1e-12));
  Positions flat = ball;
  flat.row(2).setZero();
  CHECK(hull_volume(flat) == 0);
  CHECK(hull_volume(turn * flat) == 0);
}

TEST_CASE("molecules without cells weigh the same however their body is turned", "[geometry][shapes]") {
  Body straight = cubic_lattice({3, 4, 9}, 0.01, {true, true, false}), turned = straight;
  turned.rest = Eigen::AngleAxisd(0.6, Vector3(1, -1, 0.5).normalized()).toRotationMatrix() * straight.rest;
  set_matter(straight, 1000, 0);
  set_matter(turned, 1000, 0);
  CHECK(straight.mass.sum() == Approx(1000 * 0.02 * 0.03 * 0.08));
  CHECK(turned.mass.sum() == Approx(straight.mass.sum()).epsilon(1e-12));
}
