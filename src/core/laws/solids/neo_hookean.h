#pragma once
#include <algorithm>
#include <limits>

#include "elastin/core/laws/simplex.h"

namespace elastin {

/// S = λ J (J − 1) C⁻¹ + μ (I − C⁻¹), W = V (μ/2 (tr C − 3) − μ ln J + λ/2 (J − 1)²). [L03]
///
/// With G_ab = b_aᵀ C⁻¹ b_b, which are the dot products of the *present* gradients of the barycentric coordinates and
/// thus follow from the present lengths alone, and G⁰_ab = b_aᵀ b_b those at rest:
///   q_ab = −V (g G_ab + μ G⁰_ab),  g = λ J (J − 1) − μ,  tr C = −Σ s_ab G⁰_ab.
/// Cannot tell an inverted cell from its mirror image; see forces/elastic. A cell so flat that rounding decides the
/// sign of det C (at or below 1e-14) has energy +∞; its q and slope are finite, as if J were 1e-7: a strong push apart.
struct NeoHookean {
  static constexpr int corners = 4;
  static constexpr std::string_view name = "neo_hookean";
  static constexpr std::string_view summary = "compressible rubber, tetrahedra: the finite-element solid at any strain";
  static constexpr std::string_view source = "[L03]";
  static std::string unsuited(const Body& body) { return body.tetrahedra.empty() ? "needs tetrahedra" : ""; }
  /// Leaves λ/2 (J − 1)² to a volume term around each molecule: `volume: averaged`, against locking near ν = ½.
  bool volume_apart = false;

  struct Constants {
    CellVector<4> rest_squared_lengths;  ///< s⁰ [m²]
    CellVector<4> rest_products;         ///< G⁰ of each connection [1/m²]
    double volume, lambda, mu;           ///< [m³], [Pa], [Pa]
  };

  /// @param rest corners [m], not flat. Throws InputError unless −1 < ν < ½.
  Constants constants(const Eigen::Matrix<double, 3, 4>& rest, const Material& material) const {
    const Simplex<4> cell(rest);
    const auto [lambda, mu] = lame<4>(material);
    Constants k{cell.squared_lengths, {}, cell.measure, volume_apart ? 0 : lambda, mu};
    for (int c = 0; c < 6; ++c) k.rest_products[c] = -cell.basis(c).trace();
    return k;
  }

  /// q [N/m] from squared lengths s [m²].
  CellVector<4> force_densities(const Constants& k, const CellVector<4>& s) const {
    const Present now(k, s);
    const double g = k.lambda * now.J * (now.J - 1) - k.mu;
    CellVector<4> q;
    for (int c = 0; c < 6; ++c) q[c] = -k.volume * (g * now.G(pairs[c][0], pairs[c][1]) + k.mu * k.rest_products[c]);
    return q;
  }

  /// ∂q_ab/∂s_cd = V (½ λ J (2J − 1) G_ab G_cd − ½ g (G_ac G_bd + G_ad G_bc)) [N/m³]: V B : ∂S/∂C : B, symmetric.
  CellMatrix<4> slope(const Constants& k, const CellVector<4>& s) const {
    const auto [G, J] = Present(k, s);
    const double g = k.lambda * J * (J - 1) - k.mu, bulk = k.lambda * J * (2 * J - 1);
    CellMatrix<4> result;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j <= i; ++j) {
        const auto [a, b] = pairs[i];
        const auto [c, d] = pairs[j];
        result(i, j) = result(j, i) =
            k.volume / 2 * (bulk * G(a, b) * G(c, d) - g * (G(a, c) * G(b, d) + G(a, d) * G(b, c)));
      }
    return result;
  }

  /// W [J], ≥ 0; +∞ for a flat cell. Written in the changes of s, for near rest tr C − 3 and 2 ln J are nearly equal
  /// and far above their difference: A = C − I in the frame of the edges from corner 0, whose dot products it comes
  /// from.
  double energy(const Constants& k, const CellVector<4>& s) const {
    const CellVector<4> d = s - k.rest_squared_lengths;
    const CellVector<4>& r = k.rest_products;
    const double xy = (d[0] + d[1] - d[3]) / 2, xz = (d[0] + d[2] - d[4]) / 2, yz = (d[1] + d[2] - d[5]) / 2;
    Matrix3 change, inverse;  // of the dot products; of those at rest
    change << d[0], xy, xz, xy, d[1], yz, xz, yz, d[2];
    inverse << -(r[0] + r[3] + r[4]), r[3], r[4],  //
        r[3], -(r[1] + r[3] + r[5]), r[5],         //
        r[4], r[5], -(r[2] + r[4] + r[5]);
    const Matrix3 A = inverse * change;
    const double trace = A.trace(), minors = (trace * trace - A.cwiseProduct(A.transpose()).sum()) / 2;
    const double D = trace + minors + A.determinant();  // det C − 1
    if (!(1 + D > kFlat)) return std::numeric_limits<double>::infinity();
    const double swelling = D / (1 + std::sqrt(1 + D));  // J − 1
    return k.volume / 2 * (k.mu * (trace - std::log1p(D)) + k.lambda * swelling * swelling);
  }

 private:
  static constexpr auto pairs = corner_pairs<4>();
  static constexpr double kFlat = 1e-14;  ///< det C where rounding begins to decide its sign

  struct Present {
    Eigen::Matrix4d G;  ///< [1/m²]
    double J;           ///< present over rest volume, ≥ 1e-7

    Present(const Constants& k, const CellVector<4>& s) {
      // Dot products of the edges from corner 0; their inverse is G without corner 0.
      const double xy = (s[0] + s[1] - s[3]) / 2, xz = (s[0] + s[2] - s[4]) / 2, yz = (s[1] + s[2] - s[5]) / 2;
      Matrix3 adjugate;
      adjugate << s[1] * s[2] - yz * yz, xz * yz - xy * s[2], xy * yz - xz * s[1],  //
          xz * yz - xy * s[2], s[0] * s[2] - xz * xz, xy * xz - yz * s[0],          //
          xy * yz - xz * s[1], xy * xz - yz * s[0], s[0] * s[1] - xy * xy;
      const double determinant = s[0] * adjugate(0, 0) + xy * adjugate(1, 0) + xz * adjugate(2, 0);
      const double rest_determinant = 36 * k.volume * k.volume, det_C = determinant / rest_determinant;
      J = std::sqrt(std::max(det_C, kFlat));
      G.bottomRightCorner<3, 3>() = adjugate / (J * J * rest_determinant);
      G.row(0).tail<3>() = -G.bottomRightCorner<3, 3>().colwise().sum();
      G.col(0).tail<3>() = G.row(0).tail<3>().transpose();
      G(0, 0) = -G.row(0).tail<3>().sum();
    }
  };
};

}  // namespace elastin
