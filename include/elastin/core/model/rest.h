#pragma once
#include <functional>

#include "elastin/core/base/types.h"

namespace elastin {

/// The shape in which a body is unstressed, where that is not the body at rest: growth, swelling, heat, prestretch.
/// A law of cells sees F_g⁻ᵀ C F_g⁻¹ with the weight w det F_g (of membranes within their surface, whose thickness
/// stays); a connection along the unit vector e is unstressed at |F_g e| times its rest length. Spring constants,
/// masses and the angles at which sheets bend stay those of the body at rest.       [Rodriguez, Hoger & McCulloch 1994]
struct Rest {
  /// F_g, det F_g > 0, at a place of the body at rest [m], of an element with this middle [m].
  std::function<Matrix3(const Vector3& place, const Vector3& middle)> metric;
  /// The part of it that acts: at a time [s], of experiments at rest under a part of the load (0 … 1). Empty: all of it
  /// at any time, and as much of it as of the load.
  std::function<double(double at)> part = {};

  /// I + part (F_g − I)
  Matrix3 at(const Vector3& place, const Vector3& middle, double part_of_it) const {
    return Matrix3::Identity() + part_of_it * (metric(place, middle) - Matrix3::Identity());
  }
};

}  // namespace elastin
