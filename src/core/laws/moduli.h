#pragma once
#include <string>

#include "elastin/core/base/error.h"
#include "elastin/core/model/material.h"

namespace elastin {

/// λ and μ [Pa].
struct Lame {
  double lambda, mu;
};

/// λ = E ν/((1+ν)(1−2ν)), μ = E/(2(1+ν)) of a solid (`dimensions` 3); in plane stress (2) λ = E ν/(1−ν²).
/// Throws InputError unless −1 < ν < ½; in plane stress ν = ½ is a material like others.
template <int dimensions>
Lame lame(const Material& material) {
  const double E = material.youngs_modulus, nu = material.poissons_ratio;
  if (!(nu > -1 && (dimensions == 2 ? nu <= 0.5 : nu < 0.5)))
    throw InputError("poissons_ratio " + std::to_string(nu) + ": a cell law needs more than -1 and " +
                     (dimensions == 2 ? "at most 0.5" : "less than 0.5"));
  return {dimensions == 3 ? E * nu / ((1 + nu) * (1 - 2 * nu)) : E * nu / (1 - nu * nu), E / (2 * (1 + nu))};
}

}  // namespace elastin
