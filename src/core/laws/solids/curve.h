#pragma once
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "core/laws/solids/curve_size.h"
#include "elastin/core/laws/simplex.h"

namespace elastin {

/// An isotropic solid that shows exactly the material's nominal curve P(ε) in uniaxial stress, and ν at every strain.
/// Hooke's law between Biot stress and Biot strain U − I, with a secant modulus that depends on the size of the strain:
///   W = V Φ(q),  Φ′ = P,  q² = (λ t² + 2μ |U − I|²)/E,  t = tr U − 3,   so that q = |ε| in uniaxial stress,
///   T = (P(q)/(E q)) (λ t I + 2μ (U − I)).             [deformation theory of Hencky 1924, in Biot's measures]
/// q is a norm and Φ convex and increasing, so W is convex in U for any increasing curve, stiffening or softening.
/// Without a curve it is linear elasticity in the frame that turns with the cell.
/// Where tension and compression differ, see CurveSize.
struct Curve {
  static constexpr int corners = 4;
  static constexpr std::string_view name = "curve";
  static constexpr std::string_view summary =
      "the material's own nominal stress-strain curve, with its nu at every strain, tetrahedra";
  static constexpr std::string_view source = "deformation theory [Hencky 1924] in Biot's stress and strain";
  static std::string unsuited(const Body& body) { return body.tetrahedra.empty() ? "needs tetrahedra" : ""; }
  static constexpr bool follows_curve = true;

  struct Constants {
    Eigen::Matrix<double, 3, 4> gradients;  ///< b_a [1/m]
    CellVector<4> rest_squared;             ///< s⁰ [m²]
    double volume, lambda, mu;              ///< [m³], λ/E, μ/E
    StressStrain curve;
  };

  /// @param rest corners [m], not flat. Throws InputError unless −1 < ν < ½.
  Constants constants(const Eigen::Matrix<double, 3, 4>& rest, const Material& material) const {
    const Simplex<4> cell(rest);
    Material unit;
    unit.youngs_modulus = 1;
    unit.poissons_ratio = material.poissons_ratio;
    const auto [lambda, mu] = lame<4>(unit);
    return {cell.gradients,
            cell.squared_lengths,
            cell.measure,
            lambda,
            mu,
            material.curve ? *material.curve : StressStrain::linear(material.youngs_modulus)};
  }

  /// q [N/m] from squared lengths s [m²].
  CellVector<4> force_densities(const Constants& k, const CellVector<4>& s) const {
    const Present now(k, s);
    CellVector<4> q;
    for (int c = 0; c < 6; ++c)
      q[c] = -k.volume * now.gradients.col(pairs[c][0]).cwiseProduct(now.gradients.col(pairs[c][1])).dot(now.stress);
    return q;
  }

  /// ∂q_c/∂s_d = V B_c : ∂S/∂C : B_d [N/m³], in the axes of C: the diagonal of S changes with the diagonal of C, and
  /// S_ij with C_ij by (S_i − S_j)/(λ_i² − λ_j²), which needs no case for equal stretches.
  CellMatrix<4> slope(const Constants& k, const CellVector<4>& s) const {
    const Present now(k, s);
    const Matrix3 H = now.hessian(k);
    const Vector3& stretch = now.stretch;
    Matrix3 direct, turning;  // dS_ii/dC_jj, dS_ij/dC_ij
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        direct(i, j) = (H(i, j) - (i == j ? now.stress[i] : 0)) / (2 * stretch[i] * stretch[j]);
        turning(i, j) = i == j ? 0 : -now.pressure / (stretch[i] * stretch[j] * (stretch[i] + stretch[j]));
      }
    std::array<Matrix3, 6> B;
    for (int c = 0; c < 6; ++c) {
      const auto a = now.gradients.col(pairs[c][0]), b = now.gradients.col(pairs[c][1]);
      B[c] = -0.5 * (a * b.transpose() + b * a.transpose());
    }
    CellMatrix<4> result;
    for (int d = 0; d < 6; ++d) {
      Matrix3 change = turning.cwiseProduct(B[d]);
      change.diagonal() = direct * B[d].diagonal();
      for (int c = 0; c <= d; ++c) result(c, d) = result(d, c) = k.volume * B[c].cwiseProduct(change).sum();
    }
    return result;
  }

  /// W [J], ≥ 0.
  double energy(const Constants& k, const CellVector<4>& s) const { return k.volume * Present(k, s).size.energy; }

 private:
  static constexpr auto pairs = corner_pairs<4>();

  struct Present {
    Vector3 stretch, hooke, stress;         ///< λ_i ≥ 1e-7; linear stress over E; S_i [Pa]
    Eigen::Matrix<double, 3, 4> gradients;  ///< b_a in the axes of C
    CurveSize size;
    double weight, pressure;  ///< T_i = pressure + weight λ_i

    Present(const Constants& k, const CellVector<4>& s) {
      Matrix3 twice_strain = Matrix3::Zero();  // C − I
      for (int c = 0; c < 6; ++c)
        twice_strain -=
            (s[c] - k.rest_squared[c]) * k.gradients.col(pairs[c][0]) * k.gradients.col(pairs[c][1]).transpose();
      const Matrix3 symmetric = (twice_strain + twice_strain.transpose()) / 2;
      const Eigen::SelfAdjointEigenSolver<Matrix3> axes(symmetric);
      const Vector3 change = axes.eigenvalues().cwiseMax(1e-14 - 1);
      stretch = (1 + change.array()).sqrt();
      const Vector3 strain = change.array() / (1 + stretch.array());
      gradients = axes.eigenvectors().transpose() * k.gradients;
      const double t = strain.sum();
      hooke = (k.lambda * t + 2 * k.mu * strain.array()).matrix();
      size =
          CurveSize(k.curve, std::sqrt(k.lambda * t * t + 2 * k.mu * strain.squaredNorm()), t, 3 * k.lambda + 2 * k.mu);
      weight = 2 * k.mu * size.secant;
      const Vector3 biot = size.secant * hooke + Vector3::Constant(size.by_t);
      pressure = k.lambda * t * size.secant + size.by_t - weight;
      stress = biot.cwiseQuotient(stretch);
    }

    /// ∂T_i/∂λ_j [Pa].
    Matrix3 hessian(const Constants& k) const {
      const Vector3 n = size.q > 0 ? Vector3(hooke / size.q) : Vector3(Vector3::Zero()), one = Vector3::Ones();
      Matrix3 H =
          (size.by_qq - size.secant) * n * n.transpose() + size.by_qt * (n * one.transpose() + one * n.transpose());
      H.array() += size.secant * k.lambda + size.by_tt;
      H.diagonal().array() += 2 * size.secant * k.mu;
      return H;
    }
  };
};

}  // namespace elastin
