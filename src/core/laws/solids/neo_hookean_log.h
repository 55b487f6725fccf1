#pragma once
#include "core/laws/solids/neo_hookean.h"
#include "elastin/core/laws/material_law.h"

namespace elastin {

/// W = μ/2 (tr C − 3) − μ ln J + λ/2 (ln J)²: neo_hookean with another term of volume, as most finite-element programs
/// have it. Under large changes of volume the two differ; at small strain they are the same.    [Bonet & Wood
/// 2008, 6.27]
struct NeoHookeanLog {
  static constexpr std::string_view name = "neo_hookean_log";
  static constexpr std::string_view summary =
      "compressible rubber with lambda/2 (ln J)^2, as most finite-element programs have it";
  static constexpr std::string_view source = "[Bonet & Wood 2008, 6.27]";

  static MaterialLaw constants() {
    MaterialLaw row;
    row.from_moduli = true;
    return row;
  }

  /// All three throw InputError unless −1 < ν < ½.
  NeoHookean::Solid shape(const Material& material) const { return {0, lame<3>(material).mu}; }
  SplitPoint<NeoHookean::Solid> split(const Material& material) const {
    return {shape(material), {Volumetric::Form::logarithmic, lame<3>(material).lambda}};
  }
  SplitPoint<NeoHookean::Solid> solid(const Material& material) const { return split(material); }
};

}  // namespace elastin
