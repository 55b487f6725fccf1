#pragma once
#include "elastin/core/laws/law.h"

namespace elastin {
namespace detail {

/// The law at work, on as many dimensions as the cell has.
template <int dimensions, class Law>
auto at_work(const Law& law, const Material& material) {
  if constexpr (dimensions == 3)
    return law.solid(material);
  else
    return law.membrane(material);
}

}  // namespace detail

/// Any law on any shape, at the quadrature points g: A = C − I = −½ Σ_ab (s − s⁰)_ab (B_a B_bᵀ + B_b B_aᵀ) from the
/// changes of the squared lengths, q_ab = −Σ_g w_g B_aᵀ S_g B_b. What is called here, a thousand times a millisecond,
/// is all compiled into one function (flatten), whatever else its source has and links.
template <class Law, CellShape CellShape_>
struct PointKernel {
  using Shape = CellShape_;
  static constexpr int nodes = Shape::nodes, dimensions = Shape::dimensions;
  static constexpr std::size_t points = Shape::points.size();
  using Point = decltype(detail::at_work<dimensions>(std::declval<Law>(), std::declval<Material>()));

  struct Constants {
    RestCell<Shape> rest;
    Point law;
  };
  Law law = {};

  /// @param rest nodes [m], the cell not flat. Throws InputError if the law does not take the material.
  Constants constants(const NodePositions<nodes>& rest, const Material& material) const {
    return constants(rest, point(material));
  }
  /// The same for cells that share the law at work.
  Constants constants(const NodePositions<nodes>& rest, const Point& shared) const {
    return {RestCell<Shape>(rest), shared};
  }
  Point point(const Material& material) const { return detail::at_work<dimensions>(law, material); }

  /// q [N/m] from squared lengths s [m²].
  [[gnu::flatten]] CellVector<nodes> force_densities(const Constants& k, const CellVector<nodes>& s) const {
    const CellVector<nodes> change = s - k.rest.squared_lengths;
    CellVector<nodes> q = CellVector<nodes>::Zero();
    for (std::size_t g = 0; g < points; ++g) {
      const Gradients& B = k.rest.gradients[g];
      if constexpr (is_simplex) {
        add_force_densities(k.law.stress(strain(B, change)), B, k.rest.weights[g], q);
        continue;
      }
      const Gradients SB = k.law.stress(strain(B, change)) * B;
      for (int c = 0; c < q.size(); ++c) q[c] -= k.rest.weights[g] * B.col(pairs[c][0]).dot(SB.col(pairs[c][1]));
    }
    return q;
  }

  /// ∂q_ab/∂s_cd = Σ_g w_g B_ab : ∂S/∂C : B_cd [N/m³], B_ab = −½ (B_a B_bᵀ + B_b B_aᵀ).
  [[gnu::flatten]] CellMatrix<nodes> slope(const Constants& k, const CellVector<nodes>& s) const {
    const CellVector<nodes> change = s - k.rest.squared_lengths;
    CellMatrix<nodes> result = CellMatrix<nodes>::Zero();
    for (std::size_t g = 0; g < points; ++g) {
      const Gradients& B = k.rest.gradients[g];
      const Bases bases = bases_of(B);
      const Bases changes = k.rest.weights[g] * k.law.tangent(strain(B, change)) * bases;
      result.noalias() += bases.transpose() * changes;
    }
    return result;
  }

  /// W [J], ≥ 0.
  double energy(const Constants& k, const CellVector<nodes>& s) const requires HasEnergyDensity<Point, dimensions> {
    const CellVector<nodes> change = s - k.rest.squared_lengths;
    double sum = 0;
    for (std::size_t g = 0; g < points; ++g)
      sum += k.rest.weights[g] * k.law.energy(strain(k.rest.gradients[g], change));
    return sum;
  }

 private:
  static constexpr auto pairs = node_pairs<nodes>();
  using Gradients = typename RestCell<Shape>::Gradients;
  using Bases = Eigen::Matrix<double, dimensions*(dimensions + 1) / 2, pairs_of(nodes)>;

  /// Of a simplex, whose edges from node 0 say it all: A = E ΔG Eᵀ, E the gradients of the other nodes and ΔG the
  /// change of the edges' dot products.
  static constexpr bool is_simplex = nodes == dimensions + 1;
  using Edges = Tensor<dimensions>;

  /// T M Tᵀ of a symmetric M. In space the first two rows go together, as processors multiply two numbers at once.
  static Edges congruent(const Edges& T, const Edges& M) {
    Edges result;
    if constexpr (dimensions == 3) {
      Eigen::Vector2d top[3], first[3], column[3];
      double last[3];
      for (int k = 0; k < 3; ++k) top[k] = {T(0, k), T(1, k)};
      for (int j = 0; j < 3; ++j) {
        first[j] = top[0] * M(0, j) + top[1] * M(1, j) + top[2] * M(2, j);
        last[j] = T(2, 0) * M(0, j) + T(2, 1) * M(1, j) + T(2, 2) * M(2, j);
      }
      for (int j = 0; j < 3; ++j) column[j] = first[0] * T(j, 0) + first[1] * T(j, 1) + first[2] * T(j, 2);
      const double end = last[0] * T(2, 0) + last[1] * T(2, 1) + last[2] * T(2, 2);
      result << column[0][0], column[0][1], column[2][0],  //
          column[0][1], column[1][1], column[2][1],        //
          column[2][0], column[2][1], end;
    } else {
      const Edges first = T * M;
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i <= j; ++i) result(i, j) = result(j, i) = first(i, 0) * T(j, 0) + first(i, 1) * T(j, 1);
    }
    return result;
  }

  static void add_force_densities(const Tensor<dimensions>& S, const Gradients& B, double weight,
                                  CellVector<nodes>& q) {
    const Edges products = congruent(B.template rightCols<dimensions>().transpose(), S);
    for (int i = 0, pair = dimensions; i < dimensions; ++i) {
      q[i] += weight * products(i, i);
      for (int j = i + 1; j < dimensions; ++j, ++pair) {
        const double across = weight * products(i, j);
        q[pair] -= across;
        q[i] += across;
        q[j] += across;
      }
    }
  }

  [[gnu::always_inline]] static Tensor<dimensions> strain(const Gradients& B, const CellVector<nodes>& change) {
    if constexpr (is_simplex) {
      Edges products;
      for (int i = 0, pair = dimensions; i < dimensions; ++i) {
        products(i, i) = change[i];
        for (int j = i + 1; j < dimensions; ++j, ++pair)
          products(i, j) = products(j, i) = (change[i] + change[j] - change[pair]) / 2;
      }
      return congruent(B.template rightCols<dimensions>(), products);
    }
    Tensor<dimensions> sum = Tensor<dimensions>::Zero();
    for (int c = 0; c < change.size(); ++c)
      sum.noalias() -= (change[c] * B.col(pairs[c][0])) * B.col(pairs[c][1]).transpose();
    return (sum + sum.transpose()) / 2;
  }

  /// B_ab of each pair, its components off the diagonal twice: what it is contracted with has them once.
  static Bases bases_of(const Gradients& B) {
    Bases bases;
    for (int c = 0; c < bases.cols(); ++c) {
      const auto a = B.col(pairs[c][0]), b = B.col(pairs[c][1]);
      for (int i = 0; i < dimensions; ++i) bases(i, c) = -a[i] * b[i];
      for (int i = 0, row = dimensions; i < dimensions; ++i)
        for (int j = i + 1; j < dimensions; ++j, ++row) bases(row, c) = -(a[i] * b[j] + a[j] * b[i]);
    }
    return bases;
  }
};

/// How the cell driver runs a law on a shape: at the quadrature points. Where a law has a closed form in the lengths of
/// a shape, a specialisation next to the law gives it: the same numbers, sooner.
template <class Law, CellShape Shape>
struct CellKernel : PointKernel<Law, Shape> {};

}  // namespace elastin
