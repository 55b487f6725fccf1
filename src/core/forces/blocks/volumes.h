#pragma once
#include <utility>
#include <vector>

#include "core/base/dense.h"
#include "core/forces/blocks/strains.h"
#include "elastin/core/laws/volumetric.h"

namespace elastin::blocks {

inline constexpr int kMostPressures = 4;
/// One number for each pressure function of a cell, zero where it has fewer.
using Pressures = Eigen::Matrix<double, kMostPressures, 1>;
using PressureMatrix = Eigen::Matrix<double, kMostPressures, kMostPressures>;
using PressureGradient = Eigen::Matrix<double, 3, kMostPressures>;  ///< ∂(∫ φ_k J)/∂x of one node

/// U(θ) of cells whose volume pressures of the whole cell keep: the pressure functions φ and what is projected to them.
/// Knows the rest and no other term of a law. Empty where laws keep the volume at their points, as of all membranes.
template <int d>
class CellVolumes {
 public:
  /// @param laws none, one for all cells, or one a cell.
  CellVolumes(std::vector<Volumetric> laws, const CellsAtRest<d>& rest) : laws_(std::move(laws)) { set_rest(rest); }
  /// The same of some of the cells.
  std::vector<Volumetric> laws_of(const std::vector<int>& cells) const {
    if (laws_.size() <= 1) return laws_;
    std::vector<Volumetric> some;
    for (const int cell : cells) some.push_back(law(cell));
    return some;
  }
  /// Where the rest has changed.
  void set_rest(const CellsAtRest<d>& rest) {
    if (!*this) return;
    const CellKind& kind = *rest.block().kind;
    functions_.assign(rest.points(), Pressures::Zero());
    for (int g = 0; g < rest.points(); ++g) {
      functions_[g][0] = 1;
      for (int k = 1; k < kind.pressures; ++k) functions_[g][k] = kind.points(k - 1, g);
    }
    inverse_mass_.clear();
    const int m = kind.pressures;
    for (const int cell : rest.first_of_shape()) {
      PressureMatrix M = PressureMatrix::Zero();
      for (int g = 0; g < rest.points(); ++g) {
        const Pressures& own = functions_[g];
        M += rest.weight(cell, g) * own * own.transpose();
      }
      PressureMatrix inverted = PressureMatrix::Zero();
      inverted.topLeftCorner(m, m) = inverse(M.topLeftCorner(m, m));
      inverse_mass_.push_back(inverted);
    }
  }

  explicit operator bool() const { return d == 3 && !laws_.empty(); }
  const Volumetric& law(int cell) const { return laws_[laws_.size() == 1 ? 0 : static_cast<std::size_t>(cell)]; }
  double at_point(const Pressures& values, int g) const { return functions_[g].dot(values); }

  /// ∫ φ v over a cell.
  template <class Value>
  Pressures integral(const CellsAtRest<d>& rest, int cell, Value value) const {
    Pressures sum = Pressures::Zero();
    for (int g = 0; g < rest.points(); ++g) sum += rest.weight(cell, g) * value(g) * functions_[g];
    return sum;
  }
  /// ∫ φ δJ, of the change δF at each point and F(g) there.
  template <class GradientAt>
  Pressures swelling_by(const CellsAtRest<d>& rest, int cell, GradientAt F, const PointGradients<d>& change) const {
    return integral(rest, cell, [&](int g) { return cofactors<d>(F(g)).cwiseProduct(change[g]).sum(); });
  }
  /// What a point with w cof F adds to ∂(∫ φ J)/∂x of the node with the slope B.
  void add_gradient(const Gradient<d>& of_volume, const Direction<d>& B, int g, PressureGradient& G) const {
    G += (of_volume * B) * functions_[g].transpose();
  }
  /// Adds the slopes by p of a function that has these, twice those off the diagonal, by the stress p J C⁻¹ of a point.
  void add_slopes(const Tensor<d>& A, const Components<d>& of_stress, int g, Pressures& of_pressures) const {
    if constexpr (d == 3) {
      const Dilatation shape(A);
      of_pressures += shape.J() * components_of<d>(shape.inverse).dot(of_stress) * functions_[g];
    }
  }
  /// P += w p cof F at each point, of the numbers of a cell's pressures [Pa].
  template <class GradientAt>
  void add_stresses(const CellsAtRest<d>& rest, int cell, const Pressures& p, GradientAt F,
                    PointGradients<d>& P) const {
    for (int g = 0; g < rest.points(); ++g) P[g] += rest.weight(cell, g) * at_point(p, g) * cofactors<d>(F(g));
  }

  /// Adds ∫ U(θ) [J].
  void add_energy(const CellsAtRest<d>& rest, int cell, const Strains<d>& now, double& sum) const {
    const Pressures theta = projected_swelling(rest, cell, now);
    for (int g = 0; g < rest.points(); ++g) sum += rest.weight(cell, g) * law(cell).energy(at_point(theta, g));
  }
  /// p at the points: the projection of U′(θ) [Pa].
  void set_pressures(const CellsAtRest<d>& rest, int cell, const Strains<d>& now, AtPoints<double>& p) const {
    const Pressures theta = projected_swelling(rest, cell, now);
    const Pressures own = projected(rest, cell, [&](int g) { return law(cell).slope(at_point(theta, g)); });
    for (int g = 0; g < rest.points(); ++g) p[g] = at_point(own, g);
  }
  /// Q in δp = Q ∫ φ δJ: M⁻¹ ∫ U″ φ φᵀ M⁻¹, times a factor.
  PressureMatrix stiffness(const CellsAtRest<d>& rest, int cell, const Strains<d>& now, double factor) const {
    const Pressures theta = projected_swelling(rest, cell, now);
    PressureMatrix sum = PressureMatrix::Zero();
    for (int g = 0; g < rest.points(); ++g) {
      const Pressures& own = functions_[g];
      sum += rest.weight(cell, g) * law(cell).curvature(at_point(theta, g)) * own * own.transpose();
    }
    const PressureMatrix& M = inverse_mass_[rest.shape(cell)];
    return factor * M * sum * M;
  }

 private:
  /// M⁻¹ ∫ φ v.
  template <class Value>
  Pressures projected(const CellsAtRest<d>& rest, int cell, Value value) const {
    return inverse_mass_[rest.shape(cell)] * integral(rest, cell, value);
  }
  /// θ − 1.
  Pressures projected_swelling(const CellsAtRest<d>& rest, int cell, const Strains<d>& now) const {
    return projected(rest, cell, [&](int g) { return now.swelling[g]; });
  }

  std::vector<Volumetric> laws_;
  std::vector<Pressures> functions_;          ///< φ at each point
  std::vector<PressureMatrix> inverse_mass_;  ///< of each shape; M = ∫ φ φᵀ
};

/// S += p J C⁻¹.
template <int d>
inline void add_pressure(double p, const Tensor<d>& A, Tensor<d>& S) {
  if constexpr (d == 3) {
    const Dilatation now(A);
    S += p * now.J() * now.inverse;
  }
}

/// The same, and D += ½ p J (G_ij G_kl − G_ik G_jl − G_il G_jk), G = C⁻¹.
template <int d>
inline void add_pressure(double p, const Tensor<d>& A, Tensor<d>& S, TangentModuli<d>& D) {
  if constexpr (d == 3) {
    const Dilatation now(A);
    const Matrix3& G = now.inverse;
    const double pJ = p * now.J();
    S += pJ * G;
    constexpr auto order = order_of_components<d>();
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column < 6; ++column) {
        const auto [i, j] = order[row];
        const auto [k, l] = order[column];
        D(row, column) += pJ / 2 * (G(i, j) * G(k, l) - G(i, k) * G(j, l) - G(i, l) * G(j, k));
      }
  }
}

/// Adds a Q bᵀ.
inline void add_pressures(const PressureGradient& a, const PressureMatrix& Q, const PressureGradient& b,
                          Matrix3& block) {
  const PressureGradient aQ = a * Q;
  block.noalias() += aQ * b.transpose();
}

}  // namespace elastin::blocks
