#pragma once
#include <array>
#include <functional>
#include <vector>

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
  /// Unstressed length over rest length of a connection between these places of the body at rest [m], > 0. Empty:
  /// |F_g e|.
  std::function<double(const Vector3& first, const Vector3& second)> length = {};

  /// I + part (F_g − I)
  Matrix3 at(const Vector3& place, const Vector3& middle, double part_of_it) const {
    return Matrix3::Identity() + part_of_it * (metric(place, middle) - Matrix3::Identity());
  }
};

/// F_g of an element that has this middle, at a place of the body at rest [m].
struct RestPoint {
  Vector3 place, middle;
  Matrix3 growth = Matrix3::Identity();
};

/// A rest of which single values are known: each place has those of the nearest point, and of the nearest connection
/// (by its two ends [m]) the factor of its length. Throws InputError without points, or on factors that are not above
/// 0, or F_g with a determinant that is not.
Rest rest_at(std::vector<RestPoint> points, std::vector<std::array<Vector3, 2>> connections = {},
             std::vector<double> factors = {});

}  // namespace elastin
