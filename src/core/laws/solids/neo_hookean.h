#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/laws/membranes/neo_hookean_membrane.h"
#include "core/laws/membranes/tension_field.h"
#include "core/laws/moduli.h"
#include "elastin/core/laws/cell_kernel.h"
#include "elastin/core/laws/local.h"
#include "elastin/core/laws/volumetric.h"
#include "elastin/core/shapes/simplices.h"

namespace elastin {

/// S = λ J (J − 1) C⁻¹ + μ (I − C⁻¹), W = μ/2 (tr C − 3) − μ ln J + λ/2 (J − 1)². [L03]
///
/// Cannot distinguish an inverted cell from its mirror image; the cell driver does. A point so flat that rounding
/// decides the sign of det C (at or below 1e-14) has energy +∞; its S and tangent are finite, as if J were 1e-7: a
/// strong push apart. As a membrane it thins so that there is no stress across, see NeoHookeanDensity.
struct NeoHookean {
  static constexpr std::string_view name = "neo_hookean";
  static constexpr std::string_view summary = "compressible rubber, tetrahedra: the finite-element solid at any strain";
  static constexpr std::string_view source = "[L03]";
  static constexpr std::string_view membrane_summary =
      "rubber, triangles: thins as it stretches, no stress across; nu = 0.5 is incompressible";
  static constexpr std::string_view membrane_source = "[L03] in plane stress";
  static constexpr double kFlat = 1e-14;  ///< det C where rounding begins to decide its sign

  struct Solid {
    double lambda, mu;  ///< [Pa]

    /// Written in A: near rest μ I and μ C⁻¹ are nearly equal and far above their difference, which is
    /// I − C⁻¹ = ((det C − 1 − tr A) I + A − adj A) / det C.
    Matrix3 stress(const Matrix3& A) const {
      const Dilatation now(A);
      const double beyond_trace =
          now.flat ? now.excess - A.trace() : now.adjugate.trace() + A.col(0).dot(now.adjugate.col(0));
      const Matrix3 shear = A - now.adjugate + beyond_trace * Matrix3::Identity();
      return mu / (1 + now.excess) * shear + lambda * now.J() * now.swelling() * now.inverse;
    }

    /// ∂S_ij/∂C_kl = ½ λ J (2J − 1) G_ij G_kl − ½ g (G_ik G_jl + G_il G_jk), G = C⁻¹, g = λ J (J − 1) − μ.
    TangentModuli<3> tangent(const Matrix3& A) const {
      static constexpr std::array<std::array<int, 2>, 6> components{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
      const Dilatation now(A);
      const Matrix3& G = now.inverse;
      const double J = now.J(), g = lambda * J * now.swelling() - mu, bulk = lambda * J * (2 * J - 1);
      TangentModuli<3> result;
      for (int row = 0; row < 6; ++row)
        for (int column = 0; column <= row; ++column) {
          const auto [i, j] = components[row];
          const auto [k, l] = components[column];
          result(row, column) = result(column, row) =
              (bulk * G(i, j) * G(k, l) - g * (G(i, k) * G(j, l) + G(i, l) * G(j, k))) / 2;
        }
      return result;
    }

    /// Written in A, for near rest tr C − 3 and 2 ln J are nearly equal and far above their difference.
    double energy(const Matrix3& A) const {
      const double trace = A.trace(), minors = (trace * trace - A.cwiseProduct(A.transpose()).sum()) / 2;
      const double D = trace + minors + A.determinant();  // det C − 1
      if (!(1 + D > kFlat)) return std::numeric_limits<double>::infinity();
      const double swelling = D / (1 + std::sqrt(1 + D));  // J − 1
      return (mu * (trace - std::log1p(D)) + lambda * swelling * swelling) / 2;
    }
  };

  /// Leaves λ/2 (J − 1)² to a volume term around each molecule: `volume: averaged`, against locking near ν = ½.
  bool volume_apart = false;

  /// Throws InputError unless −1 < ν < ½.
  Solid solid(const Material& material) const {
    const auto [lambda, mu] = lame<3>(material);
    return {volume_apart ? 0 : lambda, mu};
  }
  /// W = {μ/2 (tr C − 3) − μ ln J} + {λ/2 (J − 1)²}. Throws InputError unless −1 < ν < ½.
  SplitPoint<Solid> split(const Material& material) const {
    const auto [lambda, mu] = lame<3>(material);
    return {{0, mu}, {Volumetric::Form::quadratic, volume_apart ? 0 : lambda}};
  }
  /// Throws InputError unless 0 ≤ ν ≤ ½.
  IsotropicMembrane<NeoHookeanDensity> membrane(const Material& material) const { return {material}; }
};

/// On the first-order tetrahedron, in closed form. With G_ab = b_aᵀ C⁻¹ b_b, which are the dot products of the
/// *present* gradients of the barycentric coordinates and thus follow from the present lengths alone, and
/// G⁰_ab = b_aᵀ b_b those at rest:
///   q_ab = −V (g G_ab + μ G⁰_ab),  g = λ J (J − 1) − μ,  tr C = −Σ s_ab G⁰_ab.
template <>
struct CellKernel<NeoHookean, Tetrahedron4> {
  using Shape = Tetrahedron4;

  struct Constants {
    CellVector<4> rest_squared_lengths;  ///< s⁰ [m²]
    CellVector<4> rest_products;         ///< G⁰ of each connection [1/m²]
    double volume, lambda, mu;           ///< [m³], [Pa], [Pa]
  };
  NeoHookean law = {};

  /// @param rest corners [m], not flat. Throws InputError unless −1 < ν < ½.
  Constants constants(const NodePositions<4>& rest, const Material& material) const {
    const RestCell<Tetrahedron4> cell(rest);
    const auto [lambda, mu] = law.solid(material);
    Constants k{cell.squared_lengths, {}, cell.weights[0], lambda, mu};
    for (int c = 0; c < 6; ++c)
      k.rest_products[c] = cell.gradients[0].col(pairs[c][0]).dot(cell.gradients[0].col(pairs[c][1]));
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

  /// What W makes of one corner's position alone: with J linear and tr C quadratic in it,
  ///   ∂W/∂x_a = 2 μ/2 V Σ_b −G⁰_ab (x_a − x_b) + U′(J) n_a,  ∂²W/∂x_a² = μ V G⁰_aa I + U″(J)/V n_a n_aᵀ,
  /// n_a = ∂(V J)/∂x_a, U = −μ ln J + λ/2 (J − 1)²: convex.
  void add_block(const Constants& k, const NodePositions<4>& x, int corner, LocalBlock& block) const {
    static constexpr int others[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
    static constexpr int sides[4][4] = {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}};
    const auto& [a, b, c] = others[corner];
    const Vector3 ab = x.col(b) - x.col(a), ac = x.col(c) - x.col(a), own = x.col(corner) - x.col(a);
    const Vector3 n = ab.cross(ac) / 6;
    const double J = std::max(n.dot(own) / k.volume, 1e-7);
    double sum = 0;
    Vector3 gradient = Vector3::Zero();
    for (const int other : others[corner]) {
      const double product = k.rest_products[sides[corner][other]];
      sum -= product;
      gradient -= product * (x.col(corner) - x.col(other));
    }
    block.gradient += k.mu * k.volume * gradient + (k.lambda * (J - 1) - k.mu / J) * n;
    block.hessian.diagonal().array() += k.mu * k.volume * sum;
    block.hessian += ((k.lambda + k.mu / (J * J)) / k.volume * n) * n.transpose();
  }

  NeoHookeanConstraint constraint(const Constants& k) const {
    NeoHookeanConstraint result{{}, {}, k.volume, k.lambda, k.mu};
    for (int side = 0; side < 6; ++side) result.rest_products[side] = k.rest_products[side];
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
    if (!(1 + D > NeoHookean::kFlat)) return std::numeric_limits<double>::infinity();
    const double swelling = D / (1 + std::sqrt(1 + D));  // J − 1
    return k.volume / 2 * (k.mu * (trace - std::log1p(D)) + k.lambda * swelling * swelling);
  }

 private:
  static constexpr auto pairs = node_pairs<4>();

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
      J = std::sqrt(std::max(det_C, NeoHookean::kFlat));
      G.bottomRightCorner<3, 3>() = adjugate / (J * J * rest_determinant);
      G.row(0).tail<3>() = -G.bottomRightCorner<3, 3>().colwise().sum();
      G.col(0).tail<3>() = G.row(0).tail<3>().transpose();
      G(0, 0) = -G.row(0).tail<3>().sum();
    }
  };
};

}  // namespace elastin
