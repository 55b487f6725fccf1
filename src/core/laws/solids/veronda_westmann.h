#pragma once
#include "core/laws/membranes/incompressible_membrane.h"
#include "core/laws/solids/isochoric.h"
#include "elastin/core/laws/material_law.h"

namespace elastin {

/// ψ = c₁ (e^(c₂ (Ĩ₁ − 3)) − 1) − c₁ c₂/2 (Ĩ₂ − 3), shear modulus at rest c₁ c₂.       [Veronda & Westmann 1970]
struct VerondaWestmann : NearlyIncompressible<VerondaWestmann> {
  static constexpr std::string_view name = "veronda_westmann";
  static constexpr std::string_view summary = "skin that stiffens exponentially, nearly incompressible";
  static constexpr std::string_view source = "[Veronda & Westmann 1970]";
  static constexpr std::string_view membrane_summary = "skin, triangles: incompressible, no stress across";

  struct Density {
    double c1, c2;  ///< [Pa], 1

    Jet operator()(const Jet& first, const Jet& second) const { return c1 * expm1(c2 * first) - c1 * c2 / 2 * second; }
  };

  static MaterialLaw constants() {
    constexpr double inf = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
    MaterialLaw row;
    row.parameters = {{"c1", dimension::pressure, 0, inf, none, "c₁", true, ValueKind::number, true},
                      {"c2", dimension::none, 0, inf, none, "c₂, of the exponent", true, ValueKind::number, true}};
    add_bulk_modulus(row);
    return row;
  }

  Density density(const Material& material) const {
    const ConstantsOf own(material, name);
    return {own.modulus("c1"), own.number("c2")};
  }
  IsotropicShape<Density> shape(const Material& material) const { return {density(material)}; }
  IsotropicMembrane<IncompressibleMembrane<VerondaWestmann>> membrane(const Material& material) const {
    return {material};
  }
};

}  // namespace elastin
