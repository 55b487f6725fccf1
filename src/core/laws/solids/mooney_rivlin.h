#pragma once
#include "core/laws/membranes/incompressible_membrane.h"
#include "core/laws/solids/isochoric.h"
#include "elastin/core/laws/material_law.h"

namespace elastin {

/// ψ = c₁ (Ĩ₁ − 3) + c₂ (Ĩ₂ − 3), shear modulus at rest 2 (c₁ + c₂).                     [Mooney 1940, Rivlin 1948]
struct MooneyRivlin : NearlyIncompressible<MooneyRivlin> {
  static constexpr std::string_view name = "mooney_rivlin";
  static constexpr std::string_view summary =
      "rubber and soft tissue by both invariants of shape, nearly incompressible";
  static constexpr std::string_view source = "[Mooney 1940; Rivlin 1948]";
  static constexpr std::string_view membrane_summary = "the same, triangles: incompressible, no stress across";

  struct Density {
    double c1, c2;  ///< [Pa]
    Jet operator()(const Jet& first, const Jet& second) const { return c1 * first + c2 * second; }
  };

  static MaterialLaw constants() {
    constexpr double inf = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
    MaterialLaw row;
    row.parameters = {{"c1", dimension::pressure, -inf, inf, none, "c₁", false, ValueKind::number, true},
                      {"c2", dimension::pressure, -inf, inf, 0, "c₂; 0: neo-Hookean"}};
    add_bulk_modulus(row);
    return row;
  }

  Density density(const Material& material) const {
    const ConstantsOf own(material, name);
    return {own.modulus("c1"), own.modulus("c2")};
  }
  IsotropicShape<Density> shape(const Material& material) const { return {density(material)}; }
  IsotropicMembrane<IncompressibleMembrane<MooneyRivlin>> membrane(const Material& material) const {
    return {material};
  }
};

}  // namespace elastin
