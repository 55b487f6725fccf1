#pragma once
#include "core/laws/springs/van_gelder.h"

namespace elastin {

/// Van Gelder's rule without its ν term: triangles k = Σ E t |T|/c² [TP eq. 2]. The same as Lloyd's for triangles.
struct VanGelderSimplified {
  static constexpr std::string_view name = "van_gelder_simplified";
  static constexpr std::string_view summary = "van_gelder with nu = 0: never negative";
  static constexpr std::string_view source = "[TP] eq. 2";
  static constexpr bool on_cells = true;
  static std::string unsuited(const Body& body) { return VanGelder::unsuited(body); }
  VectorX constants(const Body& body, const Material& material) const {
    return VanGelder::constants(body, material, 0);
  }
};

}  // namespace elastin
