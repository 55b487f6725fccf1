#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/laws/exponential.h"
#include "core/laws/membranes/ogden_membrane.h"
#include "core/laws/solids/principal.h"
#include "elastin/core/laws/material_law.h"

namespace elastin {

/// ψ = Σ c_i/m_i² (λ̃₁^m_i + λ̃₂^m_i + λ̃₃^m_i − 3) of up to 6 terms, shear modulus at rest ½ Σ c_i.      [Ogden 1972]
/// Terms [μ, α] are written in one of three conventions: α = m throughout, and c = μ α (`ogden`, the paper's own
/// Σ μ/α (…)), c = 2 μ (`abaqus`, Σ 2 μ/α² (…)) or c = μ (`febio`).
///
/// In the axes of C, with ẽ_i = ln λ̃_i: τ_i = ∂ψ/∂ln λ_i = β_i − mean β, β_i = Σ c/m e^(m ẽ_i), and S_i = τ_i/C_i. All
/// differences are those of e^y − 1, so that equal and nearly equal stretches are no special case.
struct Ogden : NearlyIncompressible<Ogden> {
  static constexpr std::string_view name = "ogden";
  static constexpr std::string_view summary =
      "rubber and soft tissue by powers of the stretches, nearly incompressible";
  static constexpr std::string_view source = "[Ogden 1972]";
  static constexpr std::string_view membrane_summary =
      "rubber by powers of the stretches, triangles: incompressible, no stress across";

  static constexpr int kMost = 6;
  using Terms = OgdenTerms;

  struct Shape {
    Terms terms;

    Matrix3 stress(const Matrix3& A) const {
      const Vector3 values = principal_values(A);
      return principal_function(A, values, Present(*this, values).stress);
    }

    TangentModuli<3> tangent(const Matrix3& A) const {
      const SymmetricEigen3 solved = symmetric_eigen3(A);
      const Present now(*this, solved.values);
      // ∂τ_i/∂ln λ_j = b_i δ_ij − (b_i + b_j)/3 + Σ b/9,  b_i = Σ c e^(m ẽ_i).
      Vector3 b = Vector3::Zero();
      for (int t = 0; t < terms.count; ++t) b += terms.c(t) * (1 + now.powers.col(t).array()).matrix();
      Matrix3 direct;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const double slope = (i == j ? b[i] : 0) - (b[i] + b[j]) / 3 + b.sum() / 9;
          direct(i, j) = (slope - (i == j ? 2 * now.stress[i] * now.C[i] : 0)) / (2 * now.C[i] * now.C[j]);
        }
      std::array<double, 3> turning;
      for (int pair = 0; pair < 3; ++pair) {
        const auto [i, j] = kComponents[3 + pair];
        // (τ_i − τ_j)/(C_i − C_j)/C_i − τ_j/(C_i C_j)
        turning[pair] = (now.divided_difference(*this, i, j) - now.stress[j]) / now.C[i];
      }
      return PrincipalAxes{solved.vectors}.tangent(direct, turning);
    }

    /// Σ c/m² Σ_i (e^y − 1 − y), y = m ẽ_i: Σ ẽ_i = 0.
    double energy(const Matrix3& A) const {
      const Present now(*this, symmetric_eigen3(A).values);
      double sum = 0;
      for (int t = 0; t < terms.count; ++t)
        for (int i = 0; i < 3; ++i) sum += terms.c(t) / (terms.m(t) * terms.m(t)) * above_line(terms.m(t) * now.log[i]);
      return sum;
    }

   private:
    /// e^y − 1 − y, which cancels near 0.
    static double above_line(double y) {
      y = std::clamp(y, -kMostPower, kMostPower);
      if (std::abs(y) > 0.3) return std::expm1(y) - y;
      double series = 0;
      for (int n = 14; n > 2; --n) series = (1 + series) * y / n;
      return (1 + series) * y * y / 2;
    }

    struct Present {
      Vector3 C, log, own_log, stress;         ///< λ_i², ẽ_i, ln λ_i, S_i
      Eigen::Matrix<double, 3, kMost> powers;  ///< e^(m ẽ_i) − 1, a column a term

      /// @param values of A
      Present(const Shape& law, const Vector3& values) {
        const Vector3 change = values.cwiseMax(Dilatation::kFlat - 1);
        C = (1 + change.array()).matrix();
        for (int i = 0; i < 3; ++i) own_log[i] = short_log1p(change[i]) / 2;
        log = (own_log.array() - own_log.mean()).matrix();
        for (int t = 0; t < law.terms.count; ++t) powers.col(t) = law.terms.m(t) * log;
        double* power = powers.data();
        for (int n = 0; n < 3 * law.terms.count; ++n) power[n] = limited_expm1(power[n]);
        Vector3 beta = Vector3::Zero();
        for (int t = 0; t < law.terms.count; ++t) beta += law.terms.scale(t) * powers.col(t);
        stress = (beta.array() - beta.mean()).matrix().cwiseQuotient(C);
      }

      /// (τ_i − τ_j)/(C_i − C_j): with x = |ln λ_i − ln λ_j|, e^a − e^b = e^a (1 − e^(b − a)) above and below, a the
      /// larger power.
      double divided_difference(const Shape& law, int i, int j) const {
        const int longer = own_log[i] > own_log[j] ? i : j, shorter = i + j - longer;
        const double x = own_log[longer] - own_log[shorter], below = C[longer] * limited_expm1(-2 * x);
        double sum = 0;
        for (int t = 0; t < law.terms.count; ++t) {
          const double m = law.terms.m(t), power = 1 + powers(m > 0 ? longer : shorter, t);
          const double difference = m > 0 ? limited_expm1(-m * x) : -limited_expm1(m * x);
          sum += law.terms.c(t) / m * power * (below == 0 ? m / (2 * C[longer]) : difference / below);
        }
        return sum;
      }
    };
  };

  static MaterialLaw constants() {
    constexpr double inf = std::numeric_limits<double>::infinity();
    MaterialLaw row;
    row.columns = {{"mu", dimension::pressure, -inf, inf, 0, "μ of the convention"},
                   {"alpha", dimension::none, -100, 100, 0, "exponent α, not 0"}};
    row.most_terms = kMost;
    row.words = {{"convention",
                  {"ogden", "abaqus", "febio"},
                  "what μ is, in terms of Σ c/α² (λ̃₁^α + λ̃₂^α + λ̃₃^α − 3): c = μ α, c = 2 μ or c = μ"}};
    add_bulk_modulus(row);
    return row;
  }

  /// Throws InputError on an exponent 0.
  static Terms terms(const Material& material) {
    const ConstantsOf own(material, name);
    const std::string convention = own.word("convention");
    Terms result;
    for (const auto& term : own.terms()) {
      const double mu = own.scale() * term.at(0), alpha = term.at(1);
      if (alpha == 0) throw InputError("ogden: a term has the exponent 0, and no stress; leave it out");
      result.add(convention == "abaqus" ? 2 * mu : convention == "febio" ? mu : mu * alpha, alpha);
    }
    return result;
  }
  Shape shape(const Material& material) const { return {terms(material)}; }
  IsotropicMembrane<OgdenMembrane> membrane(const Material& material) const {
    return IsotropicMembrane<OgdenMembrane>(material);
  }
};

inline OgdenMembrane::OgdenMembrane(const Material& m) : thickness(m.thickness), terms(Ogden::terms(m)) {}

}  // namespace elastin
