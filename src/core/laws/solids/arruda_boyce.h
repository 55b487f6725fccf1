#pragma once
#include <array>

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
  static constexpr std::string_view membrane_summary = "rubber of chains, triangles: incompressible, no stress across";

  static constexpr std::array C{1. / 2, 1. / 20, 11. / 1050, 19. / 7000, 519. / 673750};

  /// In powers of x = Ĩ₁ − 3, Ĩ₁^i − 3^i = Σ_k binomial(i, k) 3^(i−k) x^k: all terms are positive.
  struct Density {
    std::array<double, C.size()> factors;  ///< [Pa], of x, x², …

    Jet operator()(const Jet& first, const Jet&) const {
      Jet sum = 0;
      for (std::size_t k = factors.size(); k-- > 0;) sum = first * (factors[k] + sum);
      return sum;
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
    Density result{};
    double scale = own.modulus("mu");
    for (std::size_t i = 1; i <= C.size(); ++i, scale /= own.number("N")) {
      double binomial = 1, power = 1;  // of k = i, i − 1, …
      for (std::size_t k = i; k > 0; --k) {
        result.factors.at(k - 1) += C.at(i - 1) * scale * binomial * power;
        binomial *= static_cast<double>(k) / static_cast<double>(i - k + 1), power *= 3;
      }
    }
    return result;
  }
  IsotropicShape<Density> shape(const Material& material) const { return {density(material)}; }
  IsotropicMembrane<IncompressibleMembrane<ArrudaBoyce>> membrane(const Material& material) const { return {material}; }
};

}  // namespace elastin
