#include "elastin/core/model/embedded_surface.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/rows.h"
#include "core/model/carried_points.h"
#include "core/parallel/parallel.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

constexpr int kPointThreshold = 2000;

}  // namespace

EmbeddedSurface::EmbeddedSurface(const Body& body, const Positions& points, Cells<3> triangles)
    : triangles_(std::move(triangles)), body_size_(body.size()) {
  const int count = static_cast<int>(points.cols());
  std::vector<int> corners;
  for (const auto& triangle : triangles_)
    for (const int corner : triangle) {
      if (corner < 0 || corner >= count)
        throw InputError("a triangle of the surface has the point " + std::to_string(corner) + "; it has points 0 to " +
                         std::to_string(count - 1));
      corners.push_back(corner);
    }
  Rows around = rows_by_target(count, corners);
  for (int& slot : around.entries) slot /= 3;
  around_starts_ = std::move(around.start), around_ = std::move(around.entries);

  CarriedPoints carried(body, points);
  starts_ = std::move(carried.starts), molecules_ = std::move(carried.molecules);
  weights_.assign(carried.weights.begin(), carried.weights.end());
  for (const double beyond : carried.beyond) farthest_ = std::max(farthest_, beyond);
}

void EmbeddedSurface::draw(const Positions& positions, std::span<float> points, std::span<float> normals) const {
  const auto numbers = static_cast<std::size_t>(3 * size());
  if (positions.cols() != body_size_ || points.size() != numbers || (!normals.empty() && normals.size() != numbers))
    throw InputError("a surface of " + std::to_string(size()) + " points in a body of " + std::to_string(body_size_) +
                     " molecules: " + std::to_string(positions.cols()) + " positions, room for " +
                     std::to_string(points.size() / 3) + " points and " + std::to_string(normals.size() / 3) +
                     " normals");
  using View = Eigen::Map<Eigen::Matrix3Xf>;
  View at(points.data(), 3, size()), normal(normals.data(), 3, normals.empty() ? 0 : size());
  parallel_for(
      size(),
      [&](int p) {
        Vector3 sum = Vector3::Zero();
        for (int i = starts_[p]; i < starts_[p + 1]; ++i) sum += double{weights_[i]} * positions.col(molecules_[i]);
        at.col(p) = sum.cast<float>();
      },
      kPointThreshold);
  if (normals.empty()) return;
  parallel_for(
      size(),
      [&](int p) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (int i = around_starts_[p]; i < around_starts_[p + 1]; ++i) {
          const auto& [a, b, c] = triangles_[around_[i]];
          sum += (at.col(b) - at.col(a)).cross(at.col(c) - at.col(a));
        }
        const float length = sum.norm();
        normal.col(p) = length > 0 ? Eigen::Vector3f(sum / length) : Eigen::Vector3f::Zero();
      },
      kPointThreshold);
}

}  // namespace elastin
