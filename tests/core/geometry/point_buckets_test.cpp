#include "core/geometry/point_buckets.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/base/random.h"

using namespace elastin;

TEST_CASE("buckets find each point within their size, on both sides of 0", "[buckets]") {
  std::mt19937_64 generator(9);
  const auto random = [&] { return 10 * unit_random(generator) - 5; };
  std::vector<Vector3> points;
  PointBuckets buckets(1.5);
  for (int number = 0; number < 500; ++number) {
    points.emplace_back(random(), random(), random());
    buckets.add(points.back(), number);
  }
  for (int trial = 0; trial < 100; ++trial) {
    const Vector3 point(random(), random(), random());
    std::vector<int> near, visited;
    for (int number = 0; number < 500; ++number)
      if ((points[number] - point).norm() <= 1.5) near.push_back(number);
    const bool stopped = buckets.visit_near(point, [&](int number) {
      visited.push_back(number);
      return false;
    });
    CHECK_FALSE(stopped);
    std::sort(visited.begin(), visited.end());
    CHECK(std::adjacent_find(visited.begin(), visited.end()) == visited.end());
    CHECK(std::includes(visited.begin(), visited.end(), near.begin(), near.end()));
    CHECK(visited.size() < 200);
  }
}

TEST_CASE("a visit that has seen enough stops", "[buckets]") {
  PointBuckets buckets(1);
  for (int number = 0; number < 5; ++number) buckets.add({0.5, 0.5, 0.5}, number);
  int last = -1;
  CHECK(buckets.visit_near({0.5, 1.2, 0.5}, [&](int number) { return (last = number) == 2; }));
  CHECK(last == 2);
  CHECK_FALSE(buckets.visit_near({0.5, 2.2, 0.5}, [](int) { return true; }));
}

TEST_CASE("points beyond any sense are found, too", "[buckets]") {
  PointBuckets buckets(1e-3);
  buckets.add({1e300, -1e300, 0}, 7);
  CHECK(buckets.visit_near({1e300, -1e300, 0}, [](int number) { return number == 7; }));
}
