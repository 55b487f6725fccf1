#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/forces/blocks/history.h"

namespace elastin::blocks {

/// Which cells have the stiffness of another up to a factor: of a body at rest, without stress, whose hexahedra are few
/// kinds of one; a segmented image has a million of one. Knows no stiffness.
template <int d>
class AlikeCells {
 public:
  static constexpr int kCorners = 8;
  struct OfCell {
    int kind;
    double factor;
  };

  /// False, and empty, where cells are of many kinds, or few, or not at rest.
  bool find(const PointHistory<d>& points, const Positions& positions) {
    constexpr std::size_t few = 64;
    constexpr double rounding = 1e-12;
    clear();
    const CellsAtRest<d>& rest = points.rest();
    const CellVolumes<d>& volumes = points.volumes();
    if (d != 3 || rest.nodes() != kCorners || rest.size() < kManyCells || points.softened() || points.relaxes() ||
        rest.body().unstressed || rest.first_of_shape().size() > few || positions != rest.body().rest)
      return false;
    for (int cell = 0; cell < rest.size(); ++cell) {
      const Tensor<d> none = Tensor<d>::Zero();
      Tensor<d> S;
      TangentModuli<d> D;
      points.elastic().set_at(cell, none, S, D);
      const double curvature = volumes ? volumes.law(cell).curvature(0) : 0;
      const double pressure = volumes ? volumes.law(cell).slope(0) : 0;
      const auto found = std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& other) {
        const double factor = D(0, 0) / other.D(0, 0);
        return rest.shape(cell) == rest.shape(other.cell) && factor > 0 &&
               (D - factor * other.D).cwiseAbs().maxCoeff() <= rounding * D(0, 0) &&
               std::abs(curvature - factor * other.curvature) <= rounding * curvature;
      });
      const auto kind = static_cast<int>(found - kinds_.begin());
      if (!S.isZero(0) || pressure != 0 || (found == kinds_.end() && kinds_.size() == few)) {
        clear();
        return false;
      }
      if (found == kinds_.end()) kinds_.push_back({cell, D, curvature});
      of_cell_.push_back({kind, D(0, 0) / kinds_[kind].D(0, 0)});
    }
    return true;
  }
  void clear() { kinds_.clear(), of_cell_.clear(); }

  bool empty() const { return of_cell_.empty(); }
  int kinds() const { return static_cast<int>(kinds_.size()); }
  int first_of(int kind) const { return kinds_[kind].cell; }
  const OfCell& of(int cell) const { return of_cell_[cell]; }
  /// The same; where none are alike, each its own.
  int kind(int cell) const { return empty() ? cell : of_cell_[cell].kind; }
  double factor(int cell) const { return empty() ? 1 : of_cell_[cell].factor; }

 private:
  static constexpr int kManyCells = 4096;  ///< of fewer the rows are assembled, AssembledStiffness
  struct Kind {
    int cell;  ///< the first of them
    TangentModuli<d> D;
    double curvature;  ///< U″ at rest
  };

  std::vector<Kind, Eigen::aligned_allocator<Kind>> kinds_;
  std::vector<OfCell> of_cell_;
};

}  // namespace elastin::blocks
