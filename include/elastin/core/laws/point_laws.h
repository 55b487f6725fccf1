#pragma once
#include <span>

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

}  // namespace elastin
