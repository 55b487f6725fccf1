#pragma once
#include <tuple>
#include <vector>

#include "elastin/core/model/body.h"
#include "elastin/core/model/rest.h"

namespace elastin {

/// A body's rest as numbers: F_g at the points where laws of cells see it, the middles of simplices and the points of
/// the cells of blocks; of each connection its length without stress over its rest length.
struct SampledRest {
  std::vector<RestPoint> points;
  std::vector<double> factors;
};

inline auto members(RestPoint& point) { return std::tie(point.place, point.middle, point.growth); }
inline auto members(SampledRest& rest) { return std::tie(rest.points, rest.factors); }

/// A part of Body::unstressed, after the body has moved from rest to `positions` [m]: F_g F⁻¹, F of that motion (of
/// sheets the normal onto the normal), and lengths over how many times as long connections have become.
SampledRest sampled_rest(const Body& body, const Positions& positions, double part);
/// All of it acts at any time.
Rest rest_of(const Body& body, SampledRest samples);

}  // namespace elastin
