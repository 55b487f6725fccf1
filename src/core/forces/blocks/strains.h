#pragma once
#include "core/forces/blocks/rest.h"

namespace elastin::blocks {

/// A cell's strains at the points of its quadrature.
template <int d>
struct Strains {
  PointGradients<d> F;
  AtPoints<Tensor<d>> A;      ///< FᵀF − I
  AtPoints<double> swelling;  ///< det F − 1, of solids
  bool inverted = false;
};

/// det(I + H) − 1, without cancellation near H = 0.
inline double swelling_of(const Matrix3& H) {
  const double trace = H.trace(), minors = (trace * trace - (H * H).trace()) / 2;
  return trace + minors + H.determinant();
}

/// Whether C is positive definite.
template <int d>
inline bool is_stretch(const Tensor<d>& C) {
  return C(0, 0) > 0 && C(0, 0) * C(1, 1) > C(0, 1) * C(0, 1) && C.determinant() > 0;
}

template <int d>
inline void set_strains(const CellsAtRest<d>& rest, const Positions& positions, int cell, Strains<d>& now) {
  NodeVectors displacement(3, rest.nodes());
  const int* nodes = rest.block().cell(cell).data();
  for (int a = 0; a < rest.nodes(); ++a) displacement.col(a) = positions.col(nodes[a]) - rest.body().rest.col(nodes[a]);
  now.inverted = false;
  rest.set_gradients(cell, displacement, now.F);
  for (int g = 0; g < rest.points(); ++g) {
    const Gradient<d> E = rest.frame(cell, g);
    Gradient<d> H = now.F[g];
    rest.add_offset(cell, g, H);
    now.F[g] = E + H;
    const Tensor<d> linear = E.transpose() * H;
    now.A[g] = linear + linear.transpose() + H.transpose() * H;
    if constexpr (d == 3) {
      now.swelling[g] = swelling_of(H);
      now.inverted |= !(1 + now.swelling[g] > 0);
    }
  }
}

/// Sets the strains at `to`, and those with what is linear in the motion from `from` in place of the rest of it; the
/// same at points where no body could have these.
template <int d>
inline void predict_strains(const CellsAtRest<d>& rest, const Positions& from, const Positions& to, int cell,
                            Strains<d>& there, Strains<d>& predicted) {
  Strains<d> before;
  set_strains(rest, from, cell, before);
  set_strains(rest, to, cell, there);
  predicted = there;
  for (int g = 0; g < rest.points(); ++g) {
    const Gradient<d> change = there.F[g] - before.F[g];
    const Tensor<d> half = before.F[g].transpose() * change, A = before.A[g] + half + half.transpose();
    bool possible = is_stretch<d>(Tensor<d>::Identity() + A);
    if constexpr (d == 3) {
      const double swelling = before.swelling[g] + cofactors<d>(before.F[g]).cwiseProduct(change).sum();
      possible &= swelling > -1;
      if (possible) predicted.swelling[g] = swelling;
    }
    if (possible) predicted.A[g] = A;
  }
}

}  // namespace elastin::blocks
