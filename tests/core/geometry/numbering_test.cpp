#include "elastin/core/geometry/numbering.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>

#include "elastin/core/shapes/shapes.h"

using namespace elastin;

namespace {

/// How far apart the numbers of two joined molecules are, on average.
double mean_span(const Connections& connections, const std::vector<int>& number) {
  double sum = 0;
  for (const auto& [a, b] : connections.ends) sum += std::abs(number[a] - number[b]);
  return sum / connections.size();
}

std::vector<int> numbers_of(const std::vector<int>& order) {
  std::vector<int> number(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) number[order[i]] = static_cast<int>(i);
  return number;
}

}  // namespace

TEST_CASE("points in the order of a curve that fills space are near each other", "[numbering]") {
  const Body body = cubic_lattice({16, 16, 16}, 1e-3, {true, false, false});
  std::vector<int> shuffled(static_cast<std::size_t>(body.size())), own = shuffled;
  std::iota(shuffled.begin(), shuffled.end(), 0), own = shuffled;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(7));
  Positions positions(3, body.size());
  for (int i = 0; i < body.size(); ++i) positions.col(i) = body.rest.col(shuffled[i]);

  const std::vector<int> order = order_in_space(positions);
  std::vector<int> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  CHECK(sorted == own);
  std::vector<int> along(order.size());  // the lattice's molecules as they come
  for (std::size_t i = 0; i < order.size(); ++i) along[i] = shuffled[order[i]];
  // On the curve the lower half of each of 16 layers comes before the rest; at random a third of all lies between.
  CHECK(mean_span(body.connections, numbers_of(along)) < 1.2 * mean_span(body.connections, own));
  CHECK(mean_span(body.connections, numbers_of(shuffled)) > 10 * mean_span(body.connections, own));
  CHECK(along[0] == 0);
  CHECK(along.back() == body.size() - 1);
}

TEST_CASE("points in one place, one point and none", "[numbering]") {
  CHECK(order_in_space(Positions(3, 0)).empty());
  CHECK(order_in_space(Positions::Ones(3, 1)) == std::vector{0});
  CHECK(order_in_space(Positions::Ones(3, 4)) == std::vector{0, 1, 2, 3});
  Positions line = Positions::Zero(3, 3);
  line.row(1) << 5, -2, 1;
  CHECK(order_in_space(line) == std::vector{1, 2, 0});
}

TEST_CASE("a packing's molecules are numbered in space", "[numbering][slow]") {
  const Body body = random_packing(Vector3::Constant(10e-3), 1e-3, 1.5e-3, 3);
  std::vector<int> own(static_cast<std::size_t>(body.size()));
  std::iota(own.begin(), own.end(), 0);
  CHECK(order_in_space(body.rest) == own);
  CHECK(mean_span(body.connections, own) < body.size() / 6.);
}
