#include "elastin/core/geometry/numbering.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace elastin {
namespace {

/// The 21 lowest bits, two zeros after each.
std::uint64_t spread(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x001f00000000ffff;
  bits = (bits | bits << 16) & 0x001f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  return (bits | bits << 2) & 0x1249249249249249;
}

}  // namespace

std::vector<int> order_in_space(const Positions& positions) {
  std::vector<int> order(positions.cols());
  std::iota(order.begin(), order.end(), 0);
  if (order.empty()) return order;
  const Vector3 low = positions.rowwise().minCoeff();
  const double side = (positions.rowwise().maxCoeff() - low).maxCoeff();
  if (!(side > 0)) return order;
  std::vector<std::uint64_t> along(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Vector3 cell = (positions.col(static_cast<Eigen::Index>(i)) - low) / side * 0x1fffff;
    for (int axis = 0; axis < 3; ++axis) along[i] |= spread(static_cast<std::uint64_t>(cell[axis])) << axis;
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return along[a] < along[b]; });
  return order;
}

}  // namespace elastin
