#include "elastin/core/model/rest.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "core/geometry/box_tree.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

/// Elements by where they lie and a second place, found again by the nearest.
class Nearest {
 public:
  void add(const Vector3& place, const Vector3& second) {
    boxes_.push_back({place, place}), seconds_.push_back(second);
  }
  void finish() { tree_ = BoxTree(boxes_); }
  /// @param distance_to of the second place [m]
  template <class Distance>
  std::size_t find(const Vector3& place, const Distance& distance_to) const {
    return static_cast<std::size_t>(tree_
                                        .nearest(place,
                                                 [&](int i) {
                                                   const auto element = static_cast<std::size_t>(i);
                                                   return (boxes_[element].low - place).norm() +
                                                          distance_to(seconds_[element]);
                                                 })
                                        .first);
  }

 private:
  std::vector<Box> boxes_;
  std::vector<Vector3> seconds_;
  BoxTree tree_;
};

}  // namespace

Rest rest_at(std::vector<RestPoint> points, std::vector<std::array<Vector3, 2>> connections,
             std::vector<double> factors) {
  if (points.empty() && connections.empty()) throw InputError("growth: no values are given");
  const auto cells = std::make_shared<Nearest>(), springs = std::make_shared<Nearest>();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double grown = points[i].growth.determinant();
    if (!points[i].growth.allFinite() || !(grown > 0))
      throw InputError("growth[" + std::to_string(i) + "]: its determinant is " + number(grown) +
                       "; it must be above 0");
    cells->add(points[i].place, points[i].middle);
  }
  for (std::size_t c = 0; c < connections.size(); ++c) {
    if (!(factors[c] > 0))
      throw InputError("the length of connection " + std::to_string(c) + " has the factor " + number(factors[c]) +
                       "; it must be above 0");
    springs->add((connections[c][0] + connections[c][1]) / 2, connections[c][1] - connections[c][0]);
  }
  cells->finish(), springs->finish();
  Rest rest;
  rest.metric = [cells, all = std::move(points)](const Vector3& place, const Vector3& middle) -> Matrix3 {
    if (all.empty()) return Matrix3::Identity();
    return all[cells->find(place, [&](const Vector3& other) { return (other - middle).norm(); })].growth;
  };
  if (!connections.empty())
    rest.length = [springs, all = std::move(factors)](const Vector3& first, const Vector3& second) {
      const Vector3 along = second - first;
      return all[springs->find((first + second) / 2, [&](const Vector3& other) {
        return std::min((other - along).norm(), (other + along).norm());
      })];
    };
  return rest;
}

}  // namespace elastin
