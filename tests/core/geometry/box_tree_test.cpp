#include "core/geometry/box_tree.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/base/random.h"

using namespace elastin;

namespace {

std::vector<Box> random_boxes(int count, unsigned seed) {
  std::mt19937_64 generator(seed);
  const auto random = [&] { return Vector3(unit_random(generator), unit_random(generator), unit_random(generator)); };
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) {
    const Vector3 low = 10 * random();
    boxes.push_back({low, low + random()});
  }
  return boxes;
}

bool contains(const Box& outer, const Box& inner) {
  return (outer.low.array() <= inner.low.array()).all() && (outer.high.array() >= inner.high.array()).all();
}

/// Below which all items are, once each, and each box holds those below it.
void check_tree(const BoxTree& tree, std::size_t count) {
  std::vector<int> seen;
  const auto& nodes = tree.nodes();
  REQUIRE(nodes.size() == 2 * count - 1);
  for (std::size_t n = 0; n < nodes.size(); ++n)
    if (nodes[n].second < 0) {
      seen.push_back(nodes[n].item);
    } else {
      REQUIRE(contains(nodes[n].box, nodes[n + 1].box));
      REQUIRE(contains(nodes[n].box, nodes[nodes[n].second].box));
    }
  std::sort(seen.begin(), seen.end());
  for (std::size_t i = 0; i < count; ++i) REQUIRE(seen[i] == static_cast<int>(i));
}

}  // namespace

TEST_CASE("a tree of boxes holds each item once, also after a refit", "[box tree]") {
  const std::vector<Box> boxes = random_boxes(97, 1), moved = random_boxes(97, 2);
  BoxTree tree(boxes);
  check_tree(tree, boxes.size());
  CHECK_FALSE(tree.worn());
  tree.refit(moved);
  check_tree(tree, moved.size());
  CHECK(tree.worn());  // what stood together is all over the place
  CHECK(BoxTree(std::vector<Box>{}).nodes().empty());
  CHECK(BoxTree(std::vector<Box>{}).nearest(Vector3::Zero(), [](int) { return 0.; }).first == -1);
}

TEST_CASE("a node has the group that all its items have", "[box tree]") {
  std::vector<Box> boxes = random_boxes(40, 3);
  std::vector<int> groups(40, 0);
  for (std::size_t i = 20; i < 40; ++i) {
    groups[i] = 1;
    boxes[i].low.x() += 100, boxes[i].high.x() += 100;
  }
  const BoxTree tree(boxes, groups);
  CHECK(tree.nodes()[0].group == -1);
  CHECK(tree.nodes()[1].group == 0);
  CHECK(tree.nodes()[tree.nodes()[0].second].group == 1);
}

TEST_CASE("the nearest item is that of a search through all, with few of them asked", "[box tree]") {
  const std::vector<Box> boxes = random_boxes(1000, 4);
  const BoxTree tree(boxes);
  std::mt19937_64 generator(7);
  int asked = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Vector3 point = 12 * Vector3(unit_random(generator), unit_random(generator), unit_random(generator));
    const auto distance_to = [&](int item) { return (boxes[item].middle() - point).norm(); };
    double least = 1e9;
    for (int item = 0; item < 1000; ++item) least = std::min(least, distance_to(item));
    const auto [item, distance] = tree.nearest(point, [&](int i) { return ++asked, distance_to(i); });
    CHECK(distance == least);
    CHECK(distance_to(item) == least);
  }
  CHECK(asked < 100 * 100);
}
