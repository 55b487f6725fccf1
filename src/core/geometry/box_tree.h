#pragma once
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// An axis-parallel box.
struct Box {
  Vector3 low, high;
  Vector3 middle() const { return 0.5 * (low + high); }
  double half_diagonal() const { return 0.5 * (high - low).norm(); }
  /// 0 where they overlap.
  double distance(const Box& other) const { return (low - other.high).cwiseMax(other.low - high).cwiseMax(0).norm(); }
  double distance(const Vector3& point) const { return (low - point).cwiseMax(point - high).cwiseMax(0).norm(); }
};

/// A tree of boxes over boxes, cut at the median of the longest side down to single items: deterministic, and made in
/// O(n log n). The nodes lie one behind the other, so that a walk and a refit run through memory once.
class BoxTree {
 public:
  struct Node {
    Box box;
    int second = -1;  ///< its second child; the first is the next node. -1 = a leaf
    int item = -1;    ///< of a leaf
    int group = -1;   ///< that all leaves below have in common; -1 = they differ
  };
  BoxTree() = default;
  /// `groups`: one an item; none = all in group 0.
  explicit BoxTree(const std::vector<Box>& items, const std::vector<int>& groups = {});
  /// Takes over where the items are now. Allocates nothing.
  void refit(const std::vector<Box>& items);
  /// Whether the boxes overlap so far since the tree was made that a new one would serve better.
  bool worn() const { return size_ > 2 * size_when_made_; }
  /// In preorder; empty without items.
  const std::vector<Node>& nodes() const { return nodes_; }
  /// Calls distance_to(item) [m] for the items that can be the nearest to a point, nearer boxes first; returns the one
  /// of the least distance, the first visited where several are equal, and that distance; −1 without items. Allocates
  /// nothing.
  template <class DistanceTo>
  std::pair<int, double> nearest(const Vector3& point, const DistanceTo& distance_to) const {
    std::pair<int, double> best{-1, std::numeric_limits<double>::infinity()};
    if (!nodes_.empty()) visit(0, nodes_[0].box.distance(point), point, distance_to, best);
    return best;
  }

 private:
  template <class DistanceTo>
  void visit(std::size_t node, double at_least, const Vector3& point, const DistanceTo& distance_to,
             std::pair<int, double>& best) const {
    if (!(at_least < best.second)) return;
    if (nodes_[node].second < 0) {
      const double distance = distance_to(nodes_[node].item);
      if (distance < best.second) best = {nodes_[node].item, distance};
      return;
    }
    std::size_t near = node + 1, far = static_cast<std::size_t>(nodes_[node].second);
    double to_near = nodes_[near].box.distance(point), to_far = nodes_[far].box.distance(point);
    if (to_far < to_near) std::swap(near, far), std::swap(to_near, to_far);
    visit(near, to_near, point, distance_to, best);
    visit(far, to_far, point, distance_to, best);
  }
  void lay_out(const std::vector<Box>& items, std::span<int> order);

  std::vector<Node> nodes_;
  double size_ = 0, size_when_made_ = 0;  ///< Σ diagonals of the boxes, but for the leaves' [m]
};

}  // namespace elastin
