#include "core/geometry/box_tree.h"

#include <algorithm>
#include <numeric>

namespace elastin {

BoxTree::BoxTree(const std::vector<Box>& items, const std::vector<int>& groups) {
  if (items.empty()) return;
  std::vector<int> order(items.size());
  std::iota(order.begin(), order.end(), 0);
  nodes_.reserve(2 * items.size());
  lay_out(items, order);
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    if (node.second < 0) {
      node.group = groups.empty() ? 0 : groups[node.item];
    } else {
      const int first = nodes_[n + 1].group, second = nodes_[node.second].group;
      node.group = first == second ? first : -1;
    }
  }
  refit(items);
  size_when_made_ = size_;
}

/// Appends the nodes of some items.
void BoxTree::lay_out(const std::vector<Box>& items, std::span<int> order) {
  const std::size_t here = nodes_.size();
  nodes_.emplace_back();
  if (order.size() == 1) {
    nodes_[here].item = order[0];
    return;
  }
  const auto box_of = [&](int item) -> const Box& { return items[item]; };
  Vector3 low = box_of(order[0]).low, high = box_of(order[0]).high;
  for (const int item : order) low = low.cwiseMin(box_of(item).low), high = high.cwiseMax(box_of(item).high);
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t half = order.size() / 2;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                   [&](int one, int other) { return box_of(one).middle()[axis] < box_of(other).middle()[axis]; });
  lay_out(items, order.first(half));
  nodes_[here].second = static_cast<int>(nodes_.size());
  lay_out(items, order.subspan(half));
}

void BoxTree::refit(const std::vector<Box>& items) {
  size_ = 0;
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    if (node.second < 0) {
      node.box = items[node.item];
      continue;
    }
    const Box &first = nodes_[n + 1].box, &second = nodes_[node.second].box;
    node.box = {first.low.cwiseMin(second.low), first.high.cwiseMax(second.high)};
    size_ += node.box.half_diagonal();
  }
}

}  // namespace elastin
