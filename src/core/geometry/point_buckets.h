#pragma once
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// Numbered points in the cubes of an endless grid, for those that are near: O(1) a question. Points so far out that
/// 21 bits an axis do not distinguish their cubes share some.
class PointBuckets {
 public:
  /// @param size side of a cube [m], > 0: the largest distance that is searched.
  explicit PointBuckets(double size) : size_(size) {}

  void add(const Vector3& point, int number) { members_[key(cube_of(point))].push_back(number); }

  /// Calls visit(number) for all points of the cube that contains `point` and of the 26 around it, in a fixed order,
  /// until it returns true. Returns whether it did.
  template <class Visit>
  bool visit_near(const Vector3& point, const Visit& visit) const {
    const Cube home = cube_of(point);
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          const auto found = members_.find(key(home + Cube(dx, dy, dz)));
          if (found == members_.end()) continue;
          for (const int number : found->second)
            if (visit(number)) return true;
        }
    return false;
  }

 private:
  using Cube = Eigen::Matrix<std::int64_t, 3, 1>;
  Cube cube_of(const Vector3& point) const {
    constexpr double most = 1e15;
    return (point / size_).array().floor().max(-most).min(most).cast<std::int64_t>();
  }
  static std::uint64_t key(const Cube& cube) {
    constexpr std::int64_t offset = 1 << 20, mask = (1 << 21) - 1;
    const auto part = [&](int axis) { return static_cast<std::uint64_t>((cube[axis] + offset) & mask); };
    return part(0) << 42 | part(1) << 21 | part(2);
  }

  double size_;
  std::unordered_map<std::uint64_t, std::vector<int>> members_;
};

}  // namespace elastin
