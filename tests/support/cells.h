#pragma once
#include <cmath>
#include <cstdint>
#include <random>

#include "elastin/core/laws/cell_kernel.h"
#include "elastin/core/shapes/simplices.h"

namespace elastin::testing {

template <int corners>
using CornerPositions = NodePositions<corners>;
template <int corners>
using Simplex = std::conditional_t<corners == 4, Tetrahedron4, Triangle3>;

/// A law as the cell driver runs it on first-order simplices.
template <class Law>
using OnTetrahedron = CellKernel<Law, Tetrahedron4>;
template <class Law>
using OnTriangle = CellKernel<Law, Triangle3>;

/// Numbers in [−1, 1), the same with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : generator_(seed) {}
  double number() { return static_cast<double>(generator_() >> 11) * 0x1p-52 - 1; }
  template <int rows, int columns>
  Eigen::Matrix<double, rows, columns> matrix() {
    return Eigen::Matrix<double, rows, columns>::NullaryExpr([this] { return number(); });
  }
  Matrix3 rotation() { return Eigen::Quaterniond(matrix<4, 1>().normalized()).toRotationMatrix(); }

 private:
  std::mt19937_64 generator_;
};

/// The neo-Hookean solid in uniaxial tension, E = 1: Poisson's ratio, stretch, nominal stress and lateral stretch to
/// the printed digits. [L03]
struct UniaxialRow {
  double poissons_ratio, stretch, nominal, lateral;
};
inline constexpr UniaxialRow kNeoHookeanUniaxial[] = {{.3, .5, -0.833333, 1.154701},  {.3, .8, -0.235620, 1.063057},
                                                      {.3, 1.2, 0.176170, 0.943583},  {.3, 2, 0.652380, 0.779503},
                                                      {.45, .5, -1.070463, 1.342450}, {.45, .8, -0.249496, 1.104006},
                                                      {.45, 1.2, 0.170332, 0.920459}, {.45, 2, 0.599117, 0.724652}};

/// A cell of about 5 mm, no thinner than a tenth of what it could be.
template <int corners>
CornerPositions<corners> random_cell(Random& random) {
  for (;;) {
    const CornerPositions<corners> cell = 0.005 * random.matrix<3, corners>();
    const RestCell<Simplex<corners>> simplex(cell);
    const double side2 = simplex.squared_lengths.maxCoeff();
    if (simplex.measure() > (corners == 4 ? 0.012 * side2 * std::sqrt(side2) : 0.04 * side2)) return cell;
  }
}

/// I + a change of up to 40 %, not inverted.
inline Matrix3 random_deformation(Random& random) {
  for (;;) {
    const Matrix3 F = Matrix3::Identity() + 0.4 * random.matrix<3, 3>();
    if (F.determinant() > 0.2) return F;
  }
}

template <int corners>
CellVector<corners> squared_lengths(const CornerPositions<corners>& positions) {
  CellVector<corners> s;
  for (int a = 0, connection = 0; a < corners; ++a)
    for (int b = a + 1; b < corners; ++b) s[connection++] = (positions.col(b) - positions.col(a)).squaredNorm();
  return s;
}

/// f_a = Σ_b q_ab (x_b − x_a) [N].
template <int corners>
CornerPositions<corners> forces(const CornerPositions<corners>& positions, const CellVector<corners>& q) {
  CornerPositions<corners> f = CornerPositions<corners>::Zero();
  for (int a = 0, connection = 0; a < corners; ++a)
    for (int b = a + 1; b < corners; ++b) {
      const Vector3 pull = q[connection++] * (positions.col(b) - positions.col(a));
      f.col(a) += pull;
      f.col(b) -= pull;
    }
  return f;
}

inline Material material_of(double E, double nu) {
  Material material;
  material.youngs_modulus = E;
  material.poissons_ratio = nu;
  material.thickness = 0.001;
  return material;
}

}  // namespace elastin::testing
