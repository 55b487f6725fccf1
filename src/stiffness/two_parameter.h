#pragma once
#include <algorithm>

#include "stiffness/simplex.h"

namespace elastin {

/// Membrane by the strains along and across each side. [TP, eqs 5–17, in force form: nothing is divided by a strain]
/// Tension of side b, a and c the other two:  F_b = Q b₀ (a₀² q_a − b₀² q_b + c₀² q_c),
///   Q = E t/(8 (1−ν²) |T₀|),  q_s = ε_n(s) + ν ε_τ(s),  ε_τ = s/s₀ − 1,  ε_n = h/h₀ − 1, h the height on side s.
/// At small strain it is plane stress, on any triangle; at finite strain it has no energy: ∂q/∂s is not symmetric.
/// A triangle falling flat has finite forces, but its heights change ever faster: below an area of 2.5e-8 (a²+b²+c²)
/// the slope is the one at that area. A side shorter than 1e-8 of its rest length counts as that long.
struct TwoParameter {
  static constexpr int corners = 3;
  static constexpr std::string_view name = "two_parameter";
  static constexpr std::string_view summary = "membrane from the strain along and across each side; not conservative";
  static constexpr std::string_view source = "[TP] eqs. 5-17";
  static std::string unsuited(const Body& body) { return body.triangles.empty() ? "needs triangles" : ""; }

  struct Constants {
    CellMatrix<3> weight;        ///< F = weight · q: −Q b₀³ on the diagonal, Q b₀ a₀² beside it [N]
    CellVector<3> rest_squared;  ///< [m²]
    double rest_area, nu;        ///< [m²], 1
  };

  /// @param rest corners [m], not flat; the material's thickness t [m] counts. Throws InputError unless −1 < ν < ½.
  Constants constants(const Eigen::Matrix<double, 3, 3>& rest, const Material& material) const {
    const Simplex<3> cell(rest);
    const auto [lambda, mu] = lame<3>(material);
    const double Q = (lambda + 2 * mu) * material.thickness / (8 * cell.measure);  // λ + 2μ = E/(1−ν²)
    const CellVector<3>& s0 = cell.squared_lengths;
    const CellMatrix<3> sign = CellMatrix<3>::Ones() - 2 * CellMatrix<3>::Identity();
    return {Q * s0.cwiseSqrt().asDiagonal() * sign * s0.asDiagonal(), s0, cell.measure, material.poissons_ratio};
  }

  /// q [N/m] from squared lengths s [m²]: each tension over the present length.
  CellVector<3> force_densities(const Constants& k, const CellVector<3>& s) const {
    return Present(k, s).force_densities(k);
  }

  /// ∂q/∂s [N/m³], not symmetric away from rest.
  CellMatrix<3> slope(const Constants& k, const CellVector<3>& s) const {
    const Present now(k, s);
    // 16 T² = (Σs)² − 2 Σs², hence ∂T/∂s = (Σs − 2s)/(16 T).
    const double sum = now.s.sum();
    const CellVector<3> area_slope = (sum - 2 * now.s.array()) / (16 * std::max(now.area, 2.5e-8 * sum)) / k.rest_area;
    const CellVector<3> stretch_slope = (2 * now.stretch.cwiseProduct(k.rest_squared)).cwiseInverse();
    CellMatrix<3> strain_slope = now.stretch.cwiseInverse() * area_slope.transpose();
    strain_slope.diagonal().array() +=
        (k.nu - now.area / k.rest_area / now.stretch.array().square()) * stretch_slope.array();
    CellMatrix<3> result = now.s.cwiseSqrt().cwiseInverse().asDiagonal() * k.weight * strain_slope;
    result.diagonal() -= now.force_densities(k).cwiseQuotient(2 * now.s);
    return result;
  }

 private:
  struct Present {
    CellVector<3> s, stretch;
    double area;

    Present(const Constants& k, const CellVector<3>& squared) : s(squared.cwiseMax(1e-16 * k.rest_squared)) {
      stretch = s.cwiseQuotient(k.rest_squared).cwiseSqrt();
      const double sum = s.sum();
      area = std::sqrt(std::max(0., sum * sum - 2 * s.squaredNorm())) / 4;
    }

    CellVector<3> force_densities(const Constants& k) const {
      const CellVector<3> across = area / k.rest_area * stretch.cwiseInverse(), one = CellVector<3>::Ones();
      return (k.weight * (across - one + k.nu * (stretch - one))).cwiseQuotient(s.cwiseSqrt());
    }
  };
};

}  // namespace elastin
