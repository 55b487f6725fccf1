#pragma once
#include "core/laws/membranes/incompressible_membrane.h"
#include "core/laws/solids/isochoric.h"
#include "elastin/core/laws/material_law.h"

namespace elastin {

/// Chains of N links each on the diagonals of a cube, the inverse Langevin function by its first five terms:
///   ψ = μ Σ C_i/N^(i−1) (Ĩ₁^i − 3^i),  C = ½, 1/20, 11/1050, 19/7000, 519/673750.        [Arruda & Boyce 1993, eq. 20]
/// Shear modulus at rest μ (1 + 3/(5N) + 99/(175N²) + 513/(875N³) + 42039/(67375N⁴)).
struct ArrudaBoyce : NearlyIncompressible<ArrudaBoyce> {
  static constexpr std::string_view name = "arruda_boyce";
  static constexpr std::string_view summary =
      "rubber of chains that become straight (eight-chain model), nearly incompressible";
  static constexpr std::string_view source = "[Arruda & Boyce 1993]";
  static constexpr std::string_view membrane_summary = "the same, triangles: incompressible, no stress across";

  struct Density {
    double mu, links;  ///< [Pa], 1

    Jet operator()(const Jet& first, const Jet&) const {
      constexpr double C[] = {1. / 2, 1. / 20, 11. / 1050, 19. / 7000, 519. / 673750};
      // I^i − 3^i = (I − 3) (I^(i−1) + … + 3^(i−1)).
      const Jet I = 3 + first;
      Jet quotient = 1, sum = 0;
      double three = 1, scale = 1;
      for (const double c : C) {
        sum = sum + c * scale * quotient;
        three *= 3, scale /= links;
        quotient = quotient * I + three;
      }
      return mu * first * sum;
    }
  };

  static MaterialLaw constants() {
    constexpr double inf = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
    MaterialLaw row;
    row.parameters = {{"mu", dimension::pressure, 0, inf, none, "μ, the shear modulus of endless chains", true,
                       ValueKind::number, true},
                      {"N", dimension::none, 1, 1e9, none, "links of a chain: it is straight at a stretch of √N", false,
                       ValueKind::number, true}};
    add_bulk_modulus(row);
    return row;
  }

  Density density(const Material& material) const {
    const ConstantsOf own(material, name);
    return {own.modulus("mu"), own.number("N")};
  }
  IsotropicShape<Density> shape(const Material& material) const { return {density(material)}; }
  IsotropicMembrane<IncompressibleMembrane<ArrudaBoyce>> membrane(const Material& material) const { return {material}; }
};

}  // namespace elastin
