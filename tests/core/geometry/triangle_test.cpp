#include "core/geometry/triangle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>

#include "core/base/random.h"

using namespace elastin;

namespace {

const std::array<Vector3, 3> kCorners{Vector3(0, 0, 0), Vector3(3, 0, 0), Vector3(1, 2, 0)};

Vector3 random_point(std::mt19937_64& generator, double size) {
  return size * Vector3(unit_random(generator) - 0.5, unit_random(generator) - 0.5, unit_random(generator) - 0.5);
}

int zeros(const NearestPoint& nearest) {
  return static_cast<int>(std::count(nearest.weights.begin(), nearest.weights.end(), 0));
}

}  // namespace

TEST_CASE("the nearest point of a triangle: face, sides, corners", "[triangle]") {
  struct Case {
    Vector3 point, nearest;
    int zeros;
  };
  for (const auto& [point, expected, expected_zeros] :
       {Case{{1, 1, 5}, {1, 1, 0}, 0}, Case{{1, -1, 1}, {1, 0, 0}, 1}, Case{{3, 2, -1}, {2, 1, 0}, 1},
        Case{{-1, -1, 2}, {0, 0, 0}, 2}, Case{{4, -1, 0}, {3, 0, 0}, 2}, Case{{1, 4, 0}, {1, 2, 0}, 2}}) {
    const NearestPoint nearest = nearest_point(point, kCorners);
    CHECK((nearest.position - expected).norm() < 1e-14);
    CHECK(zeros(nearest) == expected_zeros);
  }
}

TEST_CASE("no sampled point of a triangle is nearer than the nearest one", "[triangle]") {
  std::mt19937_64 generator(5);
  for (int trial = 0; trial < 200; ++trial) {
    const std::array<Vector3, 3> corners{random_point(generator, 2), random_point(generator, 2),
                                         random_point(generator, 2)};
    const Vector3 point = random_point(generator, 4);
    const NearestPoint nearest = nearest_point(point, corners);
    const auto& [u, v, w] = nearest.weights;
    CHECK(std::min({u, v, w}) >= -1e-15);
    CHECK(u + v + w == Approx(1).epsilon(1e-14));
    CHECK((u * corners[0] + v * corners[1] + w * corners[2] - nearest.position).norm() < 1e-14);
    constexpr int n = 20;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        const Vector3 sample =
            corners[0] + double(i) / n * (corners[1] - corners[0]) + double(j) / n * (corners[2] - corners[0]);
        REQUIRE((sample - point).norm() >= (nearest.position - point).norm() - 1e-14);
      }
  }
}

TEST_CASE("a triangle without area gives a point of one of its sides", "[triangle]") {
  const std::array<Vector3, 3> line{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(3, 0, 0)};
  CHECK((nearest_point({2, 1, 0}, line).position - Vector3(2, 0, 0)).norm() < 1e-14);
  const std::array<Vector3, 3> point{Vector3(1, 1, 1), Vector3(1, 1, 1), Vector3(1, 1, 1)};
  CHECK(nearest_point({2, 1, 0}, point).position == Vector3(1, 1, 1));
}

TEST_CASE("slopes of the weights agree with differences", "[triangle]") {
  for (const auto& [point, move] : {std::pair{Vector3(1, 1, 0.5), Vector3(1, 0, 0)},
                                    {Vector3(1, 1, 0.5), Vector3(0, 1, 0)},
                                    {Vector3(1, -1, 0.5), Vector3(1, 0, 0)},
                                    {Vector3(3, 2, 0), Vector3(-1, 1, 0)},
                                    {Vector3(-1, -1, 0), Vector3(1, 0, 0)}}) {
    constexpr double h = 1e-6;
    const auto slopes = weight_slopes(kCorners, nearest_point(point, kCorners).weights);
    const auto after = nearest_point(point + h * move, kCorners).weights;
    const auto before = nearest_point(point - h * move, kCorners).weights;
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(slopes[i].dot(move) == Approx((after[i] - before[i]) / (2 * h)).margin(1e-9));
  }
}
