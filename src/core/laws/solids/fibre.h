#pragma once
#include <algorithm>

#include "elastin/core/laws/simplex.h"

namespace elastin {

/// The material's fibres in a tetrahedron, to be added to any law of the matrix: W = V ψ(λ − 1), ψ′ the fibres' nominal
/// stress, λ² = aᵀ C a = Σ_c s_c g_c the squared stretch along them, g_ab = −(a·b_a)(a·b_b), which is linear in the
/// squared lengths: q_c = V (ψ′/λ) g_c. [fibre term of Weiss, Maker & Govindjee 1996, without their matrix]
struct FibreLaw {
  static constexpr int corners = 4;
  static constexpr std::string_view name = "fibre";
  static constexpr std::string_view summary = "the material's fibres, added to the law of the matrix; tetrahedra";
  static constexpr std::string_view source = "fibre-reinforced solids";

  struct Constants {
    CellVector<4> weight;        ///< g [1/m²]
    CellVector<4> rest_squared;  ///< s⁰ [m²]
    double volume;               ///< V [m³]
    StressStrain curve;
  };

  /// @param rest corners [m], not flat. The material must have fibres.
  Constants constants(const Eigen::Matrix<double, 3, 4>& rest, const Material& material) const {
    const Simplex<4> cell(rest);
    const Eigen::Vector4d along = cell.gradients.transpose() * material.fibre->direction;
    CellVector<4> weight;
    for (int c = 0; c < 6; ++c) weight[c] = -along[pairs[c][0]] * along[pairs[c][1]];
    return {weight, cell.squared_lengths, cell.measure, material.fibre->curve};
  }

  /// q [N/m] from squared lengths s [m²].
  CellVector<4> force_densities(const Constants& k, const CellVector<4>& s) const {
    const double strain = strain_of(k, s);
    return k.volume * k.curve.stress(strain) / (1 + strain) * k.weight;
  }

  /// ∂q_c/∂s_d = V/(2 λ²) (ψ″ − ψ′/λ) g_c g_d [N/m³].
  CellMatrix<4> slope(const Constants& k, const CellVector<4>& s) const {
    const double strain = strain_of(k, s), stretch = 1 + strain;
    const double change = (k.curve.modulus(strain) - k.curve.stress(strain) / stretch) / (2 * stretch * stretch);
    return k.volume * change * k.weight * k.weight.transpose();
  }

  /// W [J], ≥ 0.
  double energy(const Constants& k, const CellVector<4>& s) const {
    return k.volume * k.curve.energy_density(strain_of(k, s));
  }

 private:
  static constexpr auto pairs = corner_pairs<4>();

  /// λ − 1 from λ² − 1, without cancellation; λ no smaller than 1e-7.
  static double strain_of(const Constants& k, const CellVector<4>& s) {
    const double change = std::max(k.weight.dot(s - k.rest_squared), 1e-14 - 1);
    return change / (1 + std::sqrt(1 + change));
  }
};

}  // namespace elastin
