#include "stiffness/patch.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/parallel.h"
#include "model/incidence.h"

namespace elastin {
namespace {

/// A fully symmetric third-order tensor: components 111 222 333 112 113 122 223 133 233 123, each times the root of how
/// often it occurs, so that a dot product is the full contraction.
constexpr int kComponents = 10;
using Tensor = Eigen::Matrix<double, kComponents, 1>;
using Tensors = Eigen::Matrix<double, kComponents, Eigen::Dynamic>;
const double kRoot3 = std::sqrt(3.), kRoot6 = std::sqrt(6.);

/// n ⊗ n ⊗ n.
Tensor triple(const Vector3& n) {
  const double x = n.x(), y = n.y(), z = n.z();
  return Tensor{{x * x * x, y * y * y, z * z * z, kRoot3 * x * x * y, kRoot3 * x * x * z, kRoot3 * x * y * y,
                 kRoot3 * y * y * z, kRoot3 * x * z * z, kRoot3 * y * z * z, kRoot6 * x * y * z}};
}

/// A fully symmetric fourth-order tensor as a map from vectors to third-order ones, C_ijkl A_l: all that central
/// springs can have of a stiffness.
using Stiffness = Eigen::Matrix<double, kComponents, 3>;

/// δ_ij δ_kl + δ_ik δ_jl + δ_il δ_jk; C of the isotropic solid with ν = ¼ is 0.4 E of it.
Stiffness isotropic() {
  Stiffness C = Stiffness::Zero();
  C.row(0)[0] = C.row(1)[1] = C.row(2)[2] = 3;
  C.row(3)[1] = C.row(4)[2] = C.row(5)[0] = C.row(6)[2] = C.row(7)[0] = C.row(8)[1] = kRoot3;
  return C;
}

/// What the surrounding solid asks of each molecule's connections: −C : A, A its surface [m²] over ℓ².
Tensors wanted(const Stiffness& C, const Positions& areas, double length2) { return -C * areas / length2; }

/// The faces that only one cell has; `faces` are corner numbers, counter-clockwise seen from outside.
template <std::size_t corners, std::size_t face_count, std::size_t sides>
std::vector<std::array<int, sides>> surface(const std::vector<std::array<int, corners>>& cells,
                                            const std::array<std::array<int, sides>, face_count>& faces) {
  struct Face {
    std::array<int, sides> sorted, turned;
  };
  std::vector<Face> all;
  all.reserve(cells.size() * face_count);
  for (const auto& cell : cells)
    for (const auto& face : faces) {
      Face& added = all.emplace_back();
      for (std::size_t side = 0; side < sides; ++side) added.turned[side] = cell[face[side]];
      added.sorted = added.turned;
      std::sort(added.sorted.begin(), added.sorted.end());
    }
  std::sort(all.begin(), all.end(), [](const Face& a, const Face& b) { return a.sorted < b.sorted; });
  std::vector<std::array<int, sides>> outside;
  for (std::size_t f = 0; f < all.size(); ++f)
    if ((f == 0 || all[f].sorted != all[f - 1].sorted) && (f + 1 == all.size() || all[f].sorted != all[f + 1].sorted))
      outside.push_back(all[f].turned);
  return outside;
}

/// Outward surface-area vector of each molecule [m²]: a third of each triangle outside; of a cube's face, the mean over
/// the two ways to cut it into triangles (a quarter each, where it is a parallelogram). So Σ x_i A_iᵀ = V I exactly.
/// Without cells, those of the Voronoi cells: there x A lacks the part of V that hangs on the molecules next to the
/// surface but not in it.
Positions surface_areas(const Body& body) {
  if (Patch::needs_voronoi(body)) return body.voronoi->surface_area;
  Positions areas = Positions::Zero(3, body.size());
  const auto add_triangle = [&](int a, int b, int c, double part) {
    const Vector3 area = (body.rest.col(b) - body.rest.col(a)).cross(body.rest.col(c) - body.rest.col(a)) / 2;
    for (const int molecule : {a, b, c}) areas.col(molecule) += part / 3 * area;
  };
  if (!body.tetrahedra.empty()) {
    constexpr std::array<std::array<int, 3>, 4> faces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
    for (const auto& [a, b, c] : surface(body.tetrahedra, faces)) add_triangle(a, b, c, 1);
  } else {
    constexpr std::array<std::array<int, 4>, 6> faces{
        {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
    for (const auto& [a, b, c, d] : surface(body.cubes, faces)) {
      add_triangle(a, b, c, 0.5), add_triangle(a, c, d, 0.5);
      add_triangle(b, c, d, 0.5), add_triangle(b, d, a, 0.5);
    }
  }
  return areas;
}

/// The patch test as a linear least-squares problem, without units: unknown y = k L/(E ℓ²), ℓ² the mean L², and
/// residual Σ_j y n n n + 0.4 (δ A + …)/ℓ² for each molecule.
struct PatchTest {
  const Connections& connections;
  Rows incident;
  Tensors direction;  ///< n n n from the first to the second end
  Tensors right;      ///< what each molecule is asked for
  VectorX uniform;    ///< y of the one constant for all that has the body's mean stiffness
  double length2;     ///< ℓ² [m²]
  VectorX length;     ///< L [m]

  explicit PatchTest(const Body& body)
      : connections(body.connections),
        incident(connections_of_molecules(body.size(), body.connections)),
        direction(kComponents, body.connections.size()),
        length(body.connections.size()) {
    for (int c = 0; c < connections.size(); ++c) {
      const auto& [a, b] = connections.ends[c];
      const Vector3 gap = body.rest.col(b) - body.rest.col(a);
      length[c] = gap.norm();
      direction.col(c) = triple(gap / length[c]);
    }
    length2 = length.squaredNorm() / static_cast<double>(length.size());
    const Positions areas = surface_areas(body);
    right = wanted(0.4 * isotropic(), areas, length2);
    // The trace of the patch test, summed over the body, is Σ k L² = 6 E V; and 3 V = Σ x · A.
    const double volume = body.rest.cwiseProduct(areas).sum() / 3;
    uniform = 6 * volume / length.squaredNorm() / length2 * length;
  }

  /// Σ_j y n n n of each molecule.
  Tensors sums(const VectorX& y) const {
    Tensors result(kComponents, right.cols());
    parallel_for(static_cast<int>(right.cols()), [&](int molecule) {
      Tensor sum = Tensor::Zero();
      for (const int c : incident[molecule])
        sum += (connections.ends[c][0] == molecule ? y[c] : -y[c]) * direction.col(c);
      result.col(molecule) = sum;
    });
    return result;
  }

  /// The transpose of sums.
  VectorX gather(const Tensors& tensors) const {
    VectorX result(connections.size());
    parallel_for(connections.size(), [&](int c) {
      const auto& [a, b] = connections.ends[c];
      result[c] = direction.col(c).dot(tensors.col(a) - tensors.col(b));
    });
    return result;
  }

  /// No eigenvalue of gather(sums(·)) is greater: a connection counts for two molecules.
  double largest_eigenvalue() const {
    double largest = 0;
    for (int molecule = 0; molecule < right.cols(); ++molecule) {
      Eigen::Matrix<double, kComponents, kComponents> own = Eigen::Matrix<double, kComponents, kComponents>::Zero();
      for (const int c : incident[molecule]) own += direction.col(c) * direction.col(c).transpose();
      const Eigen::SelfAdjointEigenSolver<decltype(own)> solver(own, Eigen::EigenvaluesOnly);
      largest = std::max(largest, solver.eigenvalues()[kComponents - 1]);
    }
    return 2 * largest;
  }
};

/// The y ≥ 0 of least |sums(y) − right|² + pull |y − uniform|²: conjugate gradients on the positive unknowns; a step
/// that would turn some negative is projected and followed by a step of fixed length down the free gradient; unknowns
/// held at zero are let go together once their gradient outweighs the free one (MPRGP) [Dostál 2009, ch. 5]. Ends when
/// the projected gradient is small, or, where no constants pass the patch test, when 100 steps no longer lower the
/// misfit by 1 %: at 1e5 connections and 15 % jitter four times as many steps would gain 2 % more.
VectorX non_negative_least_squares(const PatchTest& test) {
  constexpr double pull = 1e-6, tolerance = 1e-7, worthwhile = 0.99;
  constexpr int most_steps = 5000, window = 100;
  const auto apply = [&](const VectorX& v) -> VectorX { return test.gather(test.sums(v)) + pull * v; };
  const VectorX right = test.gather(test.right) + pull * test.uniform;
  const double fixed_step = 1.95 / (test.largest_eigenvalue() + pull);  // 2 is where it could go uphill
  VectorX y = test.uniform, gradient = apply(y) - right;
  const auto free_part = [&]() -> VectorX { return (y.array() > 0).select(gradient, 0.); };
  VectorX direction = free_part();
  double last_misfit = std::numeric_limits<double>::infinity();
  for (int steps = 0; steps < most_steps; ++steps) {
    const VectorX free = free_part(), held = (y.array() > 0).select(0., gradient.cwiseMin(0));
    if (!((free + held).norm() > tolerance * right.norm())) break;
    if (steps % window == 0) {
      const double misfit = (test.sums(y) - test.right).norm();
      if (misfit > worthwhile * last_misfit) break;
      last_misfit = misfit;
    }
    const bool release = held.squaredNorm() > free.cwiseMin(y / fixed_step).dot(free);
    if (release) direction = held;
    const VectorX change = apply(direction);
    const double curvature = direction.dot(change), length = gradient.dot(direction) / curvature;
    y -= length * direction;
    gradient -= length * change;
    if (y.minCoeff() < 0) {
      y = y.cwiseMax(0).eval();
      y = (y - fixed_step * free_part()).cwiseMax(0).eval();
      gradient = apply(y) - right;
      direction = free_part();
    } else {
      const VectorX left = free_part();
      direction = release ? left : VectorX(left - left.dot(change) / curvature * direction);
    }
  }
  return y;
}

}  // namespace

std::string Patch::unsuited(const Body& body) {
  if (!needs_voronoi(body)) return "";
  return body.voronoi ? body.voronoi->problem : "needs tetrahedra, cubes or the Voronoi cells of its molecules";
}

VectorX Patch::constants(const Body& body, const Material& material) const {
  const PatchTest test(body);
  const VectorX y = non_negative_least_squares(test);
  return material.youngs_modulus * test.length2 * y.cwiseQuotient(test.length);
}

}  // namespace elastin
