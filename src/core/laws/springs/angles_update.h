#pragma once
#include <array>

#include "core/laws/springs/angles.h"

namespace elastin {

/// The angles rule, computed again from the present places at every evaluation: not conservative, so it has no energy.
/// [M03, Table 1 "angles (update)"]
struct AnglesUpdate {
  static constexpr std::string_view name = "angles_update";
  static constexpr std::string_view summary = "angles, computed again from the present geometry at every evaluation";
  static constexpr std::string_view source = "[M03] Table 1";
  double exponent = 1;
  static constexpr std::array parameters{
      Parameter<AnglesUpdate>{"exponent", &AnglesUpdate::exponent, dimension::none, -4, 4,
                              "exponent p of (l_i/l0)^p; 1 is the paper's derivation"}};

  VectorX constants(const Body& body, const Material& material, const Positions& positions) const {
    return Angles{exponent}.constants(body, material, positions);
  }
};

}  // namespace elastin
