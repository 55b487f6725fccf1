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
  double poissons_ratio = 0;  ///< what the body then measures
  bool met = false;           ///< whether that is the material's
};

/// Measured E [Pa] and ν of a body in a linear solve; nothing if that fails, or if a negative volume term leaves the
/// body unstable.
using MeasureModuli = std::function<std::optional<std::pair<double, double>>(double volume_modulus)>;

/// Fits both scalars by linear solves of the springs as they are with a changing volume term: the first solve of the
/// springs alone, two where strain is affine, 40 at most. E comes out exactly, for all stiffness scales with
/// it. It ends when ν is within 0.001, near ½ within a tenth of what is left to it. ν is a hyperbola of κ: with
/// q = K + G/3 of isotropic springs a straight line in 1/(κ + q) from ½ for κ → ∞, else one that three solves
/// determine; between a κ whose ν is too small and one whose ν is too large no guess leaves the two, and bad guesses
/// are replaced by their middle. Where the stiffest term and the last stable one are on one side of the target, those
/// between them are tried, and the nearest is the fit. Returns nothing if the springs alone, or with a positive term,
/// measure no E > 0.
std::optional<VolumeFit> fit_volume(const Material& material, const MeasureModuli& measure);

}  // namespace elastin
