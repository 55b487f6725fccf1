#pragma once
#include <array>

#include "core/laws/membranes/incompressible_membrane.h"
#include "core/laws/solids/isochoric.h"
#include "elastin/core/laws/material_law.h"

namespace elastin {

/// ψ = Σ c_i (Ĩ₁ − 3)^i of up to 6 terms, shear modulus at rest 2 c₁.                                  [Yeoh 1993]
struct Yeoh : NearlyIncompressible<Yeoh> {
  static constexpr std::string_view name = "yeoh";
  static constexpr std::string_view summary =
      "rubber that stiffens: a polynomial in the first invariant, nearly incompressible";
  static constexpr std::string_view source = "[Yeoh 1993]";
  static constexpr std::string_view membrane_summary =
      "rubber that stiffens, triangles: incompressible, no stress across";

  static constexpr int kMost = 6;

  struct Density {
    std::array<double, kMost> c;  ///< [Pa]
    int terms;

    Jet operator()(const Jet& first, const Jet&) const {
      Jet sum = 0;
      for (int i = terms; i-- > 0;) sum = first * (c[i] + sum);
      return sum;
    }
  };

  static MaterialLaw constants() {
    constexpr double inf = std::numeric_limits<double>::infinity();
    MaterialLaw row;
    row.columns = {{"c", dimension::pressure, -inf, inf, 0, "c_i of Σ c_i (Ĩ₁ − 3)^i, in order"}};
    row.most_terms = kMost;
    add_bulk_modulus(row);
    return row;
  }

  Density density(const Material& material) const {
    const ConstantsOf own(material, name);
    Density result{{}, static_cast<int>(own.terms().size())};
    for (std::size_t i = 0; i < own.terms().size(); ++i) result.c.at(i) = own.scale() * own.terms()[i].at(0);
    return result;
  }
  IsotropicShape<Density> shape(const Material& material) const { return {density(material)}; }
  IsotropicMembrane<IncompressibleMembrane<Yeoh>> membrane(const Material& material) const { return {material}; }
};

}  // namespace elastin
