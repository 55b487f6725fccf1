#pragma once
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "elastin/core/laws/law.h"

namespace elastin {

/// A law at work at the points of any cell, without its type: what a driver of cells calls once a cell for all its
/// points. A = C − I, S [Pa] or [N/m], ∂S/∂C as PointLaw has them.
template <int dimensions>
class PointLaws {
 public:
  virtual ~PointLaws() = default;
  virtual bool has_energy() const = 0;
  virtual void stresses(int cell, std::span<const Tensor<dimensions>> A, std::span<Tensor<dimensions>> S) const = 0;
  virtual void tangents(int cell, std::span<const Tensor<dimensions>> A,
                        std::span<TangentModuli<dimensions>> D) const = 0;
  /// Σ w W over the points [J].
  virtual double energy(int cell, std::span<const Tensor<dimensions>> A, std::span<const double> weights) const = 0;
};

namespace detail {
template <int dimensions, class Point>
class TypedPointLaws final : public PointLaws<dimensions> {
 public:
  /// @param points one for all cells, or one a cell.
  explicit TypedPointLaws(std::vector<Point> points) : points_(std::move(points)) {}

  bool has_energy() const override { return HasEnergyDensity<Point, dimensions>; }
  void stresses(int cell, std::span<const Tensor<dimensions>> A, std::span<Tensor<dimensions>> S) const override {
    const Point& law = of(cell);
    for (std::size_t g = 0; g < A.size(); ++g) S[g] = law.stress(A[g]);
  }
  void tangents(int cell, std::span<const Tensor<dimensions>> A,
                std::span<TangentModuli<dimensions>> D) const override {
    const Point& law = of(cell);
    for (std::size_t g = 0; g < A.size(); ++g) D[g] = law.tangent(A[g]);
  }
  double energy(int cell, std::span<const Tensor<dimensions>> A, std::span<const double> weights) const override {
    double sum = 0;
    if constexpr (HasEnergyDensity<Point, dimensions>) {
      const Point& law = of(cell);
      for (std::size_t g = 0; g < A.size(); ++g) sum += weights[g] * law.energy(A[g]);
    }
    return sum;
  }

 private:
  const Point& of(int cell) const { return points_[points_.size() == 1 ? 0 : static_cast<std::size_t>(cell)]; }
  std::vector<Point> points_;
};
}  // namespace detail

/// @param points the law at work, one for all cells or one a cell.
template <int dimensions, class Point>
std::shared_ptr<const PointLaws<dimensions>> make_point_laws(std::vector<Point> points) {
  return std::make_shared<detail::TypedPointLaws<dimensions, Point>>(std::move(points));
}

}  // namespace elastin
