#pragma once
#include <functional>
#include <optional>
#include <utility>

#include "elastin/core/model/material.h"

namespace elastin {

/// Springs and volume term with which a body measures E and ν of a material.
struct VolumeFit {
  double spring_factor = 1;   ///< of the spring constants
  double volume_modulus = 0;  ///< κ [Pa]
  double poissons_ratio = 0;  ///< what the last solve measured
};

/// Measured E [Pa] and ν of a body in a linear solve, or nothing if that fails.
using MeasureModuli = std::function<std::optional<std::pair<double, double>>(double volume_modulus)>;

/// Fits both scalars by linear solves of the springs as they are with a changing volume term, ending when ν is within
/// 0.001: the first solve of the springs alone, two where strain is affine, at most `most_solves`. E comes out exactly,
/// for all stiffness scales with it. ν is a hyperbola of κ: with q = K + G/3 of isotropic springs a straight line in
/// 1/(κ + q) from ½ for κ → ∞, else one that three solves determine. Returns nothing if a solve fails or measures no E
/// > 0.
std::optional<VolumeFit> fit_volume(const Material& material, const MeasureModuli& measure, int most_solves = 4);

}  // namespace elastin
