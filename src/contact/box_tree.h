#pragma once
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin::contact {

/// An axis-parallel box.
struct Box {
  Vector3 low, high;
  Vector3 middle() const { return 0.5 * (low + high); }
  double half_diagonal() const { return 0.5 * (high - low).norm(); }
  /// 0 where they overlap.
  double distance(const Box& other) const { return (low - other.high).cwiseMax(other.low - high).cwiseMax(0).norm(); }
  double distance(const Vector3& point) const { return (low - point).cwiseMax(point - high).cwiseMax(0).norm(); }
};

/// A tree of boxes over boxes. FCL decides who stands beside whom; the nodes are then laid out one behind the other, so
/// that a walk and a refit run through memory once.
class BoxTree {
 public:
  struct Node {
    Box box;
    int second = -1;  ///< its second child; the first is the next node. -1 = a leaf
    int item = -1;    ///< of a leaf
    int group = -1;   ///< that all leaves below have in common; -1 = they differ
  };
  BoxTree() = default;
  /// `groups`: one an item.
  BoxTree(const std::vector<Box>& items, const std::vector<int>& groups);
  /// Takes over where the items are now. Allocates nothing.
  void refit(const std::vector<Box>& items);
  /// Whether the boxes have grown so much over each other since the tree was made that a new one would serve better.
  bool worn() const { return size_ > 2 * size_when_made_; }
  /// In preorder; empty without items.
  const std::vector<Node>& nodes() const { return nodes_; }

 private:
  std::vector<Node> nodes_;
  double size_ = 0, size_when_made_ = 0;  ///< Σ diagonals of the boxes, but for the leaves' [m]
};

}  // namespace elastin::contact
