#include "contact/box_tree.h"

#include <fcl/broadphase/detail/hierarchy_tree.h>
#include <fcl/math/bv/AABB.h>

#include <cstdint>

namespace elastin::contact {
namespace {

using FclTree = fcl::detail::HierarchyTree<fcl::AABBd>;
using FclNode = FclTree::NodeType;

/// Appends what lies below an FCL node.
void lay_out(const FclNode* from, std::vector<BoxTree::Node>& nodes) {
  const std::size_t here = nodes.size();
  nodes.emplace_back();
  if (from->isLeaf()) {
    nodes[here].item = static_cast<int>(reinterpret_cast<std::intptr_t>(from->data));
    return;
  }
  lay_out(from->children[0], nodes);
  nodes[here].second = static_cast<int>(nodes.size());
  lay_out(from->children[1], nodes);
}

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& items, const std::vector<int>& groups) {
  if (items.empty()) return;
  // Cut at the median of the longest side, down to single leaves: deterministic, and O(n log n).
  FclTree tree(1, 0);
  std::vector<FclNode*> leaves(items.size());
  for (std::size_t item = 0; item < items.size(); ++item) {
    leaves[item] = new FclNode;  // the tree owns it from init on
    leaves[item]->bv = fcl::AABBd(items[item].low, items[item].high);
    leaves[item]->parent = nullptr;
    leaves[item]->children[1] = nullptr;
    leaves[item]->data = reinterpret_cast<void*>(static_cast<std::intptr_t>(item));
  }
  tree.init(leaves);
  nodes_.reserve(2 * items.size());
  lay_out(tree.getRoot(), nodes_);
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    if (node.second < 0) {
      node.group = groups[static_cast<std::size_t>(node.item)];
    } else {
      const int first = nodes_[n + 1].group, second = nodes_[static_cast<std::size_t>(node.second)].group;
      node.group = first == second ? first : -1;
    }
  }
  refit(items);
  size_when_made_ = size_;
}

void BoxTree::refit(const std::vector<Box>& items) {
  size_ = 0;
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    if (node.second < 0) {
      node.box = items[static_cast<std::size_t>(node.item)];
      continue;
    }
    const Box &first = nodes_[n + 1].box, &second = nodes_[static_cast<std::size_t>(node.second)].box;
    node.box = {first.low.cwiseMin(second.low), first.high.cwiseMax(second.high)};
    size_ += node.box.half_diagonal();
  }
}

}  // namespace elastin::contact
