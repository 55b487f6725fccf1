#pragma once
#include "core/laws/springs/section.h"
#include "elastin/core/laws/law.h"

namespace elastin {

/// k = E A / L: each connection is a bar of its molecules' cross-section. [M03, eq. 14]
/// Too stiff as soon as connections share the cross-section: a lattice with diagonals measures 2 to 4 E.
struct Standard {
  static constexpr std::string_view name = "standard";
  static constexpr std::string_view summary = "k = E A / L, A the molecule's cross-section, L the rest length";
  static constexpr std::string_view source = "[M03] eq. 14";

  VectorX constants(const Body& body, const Material& material) const {
    VectorX k(body.connections.size());
    for (int c = 0; c < k.size(); ++c)
      k[c] = material.youngs_modulus * connection_section(body, c) / body.connections.rest_length[c];
    return k;
  }
};

}  // namespace elastin
