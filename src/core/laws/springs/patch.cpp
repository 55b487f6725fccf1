#include "core/laws/springs/patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/dense.h"
#include "core/geometry/boundary.h"
#include "core/model/incidence.h"
#include "core/parallel/parallel.h"

namespace elastin {
namespace {

/// A fully symmetric third-order tensor: components 111 222 333 112 113 122 223 133 233 123, each times the root of how
/// often it occurs, so that a dot product is the full contraction.
constexpr int kComponents = 10;
using Tensor = Eigen::Matrix<double, kComponents, 1>;
using Tensors = Eigen::Matrix<double, kComponents, Eigen::Dynamic>;
/// A column a molecule: a tensor, and one more for its volume.
using Equations = Eigen::Matrix<double, kComponents + 1, Eigen::Dynamic>;
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

/// C_iijj.
double trace(const Stiffness& C) {
  const auto row = [&](int first, int second, int third, int column) {
    return C(first, column) + (C(second, column) + C(third, column)) / kRoot3;
  };
  return row(0, 5, 7, 0) + row(1, 3, 8, 1) + row(2, 4, 6, 2);
}

/// What the surrounding solid asks of each molecule's connections: −C : A, A its surface [m²] over ℓ².
Tensors wanted(const Stiffness& C, const Positions& areas, double length2) { return -C * areas / length2; }

/// A molecule's part of the surface and of the volume. Tetrahedra share the volume among their corners as
/// their diagonals happen to lie, so they come last.
enum class Source { cubes, voronoi, tetrahedra, none };

Source source_of(const Body& body) {
  if (!body.cubes.empty()) return Source::cubes;
  if (body.voronoi && body.voronoi->problem.empty()) return Source::voronoi;
  return body.tetrahedra.empty() ? Source::none : Source::tetrahedra;
}

/// Outward surface-area vector of each molecule [m²]: a third of each triangle outside; of a cube's face, the mean over
/// the two cuts of it into triangles (a quarter each, where it is a parallelogram). So Σ x_i A_iᵀ = V I exactly.
/// Of Voronoi cells x A lacks the part of V that hangs on the molecules next to the surface but not in it.
Positions surface_areas(const Body& body) {
  if (source_of(body) == Source::voronoi) return body.voronoi->surface_area;
  Positions areas = Positions::Zero(3, body.size());
  const auto add_triangle = [&](int a, int b, int c, double part) {
    const Vector3 area = (body.rest.col(b) - body.rest.col(a)).cross(body.rest.col(c) - body.rest.col(a)) / 2;
    for (const int molecule : {a, b, c}) areas.col(molecule) += part / 3 * area;
  };
  if (source_of(body) == Source::tetrahedra) {
    for (const auto& [a, b, c] : boundary_of(body.tetrahedra)) add_triangle(a, b, c, 1);
  } else {
    for (const auto& [a, b, c, d] : boundary_of(body.cubes)) {
      add_triangle(a, b, c, 0.5), add_triangle(a, c, d, 0.5);
      add_triangle(b, c, d, 0.5), add_triangle(b, d, a, 0.5);
    }
  }
  return areas;
}

/// The part of the body's volume that belongs to each molecule [m³]: a quarter of its tetrahedra, an eighth of its
/// cubes (cut into six tetrahedra), or its Voronoi cell.
VectorX molecule_volumes(const Body& body) {
  if (source_of(body) == Source::voronoi) return body.voronoi->volume;
  VectorX volumes = VectorX::Zero(body.size());
  constexpr std::array<std::array<int, 4>, 6> kuhn{
      {{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}}};
  if (source_of(body) == Source::tetrahedra)
    for (const auto& cell : body.tetrahedra)
      for (const int molecule : cell) volumes[molecule] += signed_volume(body.rest, cell) / 4;
  else
    for (const auto& cube : body.cubes) {
      double volume = 0;
      for (const auto& [a, b, c, d] : kuhn) volume += signed_volume(body.rest, {cube[a], cube[b], cube[c], cube[d]});
      for (const int molecule : cube) volumes[molecule] += volume / 8;
    }
  return volumes;
}

/// Weight of each molecule's volume relative to its balance. Inside, balance needs nothing but a sum of zero: where
/// few connections cannot balance, the fit must not get out of it by going soft, the more so the deeper inside. Where
/// they are as many as the equations, balance does. On the surface the share that a molecule's connections have in the
/// stiffness is that of its volume only if they run in all directions alike: not so those that stand for fibres.
VectorX volume_weights(const Rows& incident, const Positions& areas, double length2, bool on_surface) {
  double connections = 0, inner = 0;
  VectorX weights = VectorX::Constant(areas.cols(), kPatchVolumeWeight);
  for (int molecule = 0; molecule < areas.cols(); ++molecule)
    if (areas.col(molecule).norm() > 1e-6 * length2) {
      if (!on_surface) weights[molecule] = 0;
    } else {
      ++inner;
      connections += static_cast<double>(incident[molecule].size());
    }
  const bool balanced = inner > 0 && connections >= 2 * kComponents * inner;
  return balanced ? VectorX::Zero(areas.cols()) : weights;
}

/// The patch test as a linear least-squares problem, without units: unknown y = k L/(E ℓ²), ℓ² the mean L², and
/// residuals of each molecule Σ_j y n n n + C : A/(E ℓ²), and w (Σ_j y L/ℓ − 2 C_iijj V/(E ℓ³)).
struct PatchTest {
  const Connections& connections;
  Rows incident;
  Tensors tensor;   ///< n n n, n from the first to the second end
  VectorX length;   ///< L [m]
  double length2;   ///< ℓ² [m²]
  VectorX weight;   ///< w, one a molecule
  VectorX share;    ///< L/ℓ
  Equations right;  ///< the right side of each molecule's equations
  VectorX uniform;  ///< where y is drawn to: the one constant for all that has the body's mean stiffness, or 0

  /// @param C over E, without unit.
  PatchTest(const Body& body, const Stiffness& C, bool volume_on_surface)
      : connections(body.connections),
        incident(connections_of_molecules(body.size(), body.connections)),
        tensor(kComponents, body.connections.size()),
        length(body.connections.size()) {
    for (int c = 0; c < connections.size(); ++c) {
      const auto& [a, b] = connections.ends[c];
      const Vector3 gap = body.rest.col(b) - body.rest.col(a);
      length[c] = gap.norm();
      tensor.col(c) = triple(gap / length[c]);
    }
    length2 = length.squaredNorm() / static_cast<double>(length.size());
    const Positions areas = surface_areas(body);
    const VectorX volumes = molecule_volumes(body);
    weight = volume_weights(incident, areas, length2, volume_on_surface);
    share = length / std::sqrt(length2);
    right.resize(kComponents + 1, body.size());
    right.topRows<kComponents>() = wanted(C, areas, length2);
    right.row(kComponents) = 2 * trace(C) / std::pow(length2, 1.5) * weight.cwiseProduct(volumes).transpose();
    // The trace of the patch test, summed over the body, is Σ k L² = C_iijj V.
    uniform = trace(C) * volumes.sum() / length.squaredNorm() / length2 * length;
  }

  /// Σ_j y n n n and w Σ_j y L/ℓ of each molecule.
  Equations sums(const VectorX& y) const {
    Equations result(kComponents + 1, right.cols());
    parallel_for(
        static_cast<int>(right.cols()),
        [&](int molecule) {
          Tensor sum = Tensor::Zero();
          double stretch = 0;
          for (const int c : incident[molecule]) {
            sum += (connections.ends[c][0] == molecule ? y[c] : -y[c]) * tensor.col(c);
            stretch += share[c] * y[c];
          }
          result.col(molecule) << sum, weight[molecule] * stretch;
        },
        kParallelThreshold / kComponents);
    return result;
  }

  /// The transpose of sums.
  VectorX gather(const Equations& values) const {
    VectorX result(connections.size());
    parallel_for(connections.size(), [&](int c) {
      const auto& [a, b] = connections.ends[c];
      const Tensor difference = values.col(a).head<kComponents>() - values.col(b).head<kComponents>();
      result[c] = tensor.col(c).dot(difference) +
                  share[c] * (weight[a] * values(kComponents, a) + weight[b] * values(kComponents, b));
    });
    return result;
  }

  /// No eigenvalue of gather(sums(·)) is greater: a connection counts for two molecules.
  double largest_eigenvalue() const {
    double largest = 0;
    for (int molecule = 0; molecule < right.cols(); ++molecule) {
      Eigen::Matrix<double, kComponents + 1, kComponents + 1> own;
      own.setZero();
      for (const int c : incident[molecule]) {
        Eigen::Matrix<double, kComponents + 1, 1> column;
        column << (connections.ends[c][0] == molecule ? 1 : -1) * tensor.col(c), weight[molecule] * share[c];
        own += column * column.transpose();
      }
      largest = std::max(largest, symmetric_eigenvalues(own)[kComponents]);
    }
    return 2 * largest;
  }
};

/// The y ≥ 0 of least |sums(y) − right|² + pull |y − uniform|²: conjugate gradients on the positive unknowns; a step
/// that would turn some negative is projected and followed by a step of fixed length down the free gradient; unknowns
/// held at zero are released together once their gradient outweighs the free one (MPRGP) [Dostál 2009, ch. 5]. Ends
/// when the projected gradient is small, or, where no constants pass the patch test, when 100 steps no longer lower the
/// misfit by 1 %: at 1e5 connections and 15 % jitter four times as many steps would gain 2 % more.
VectorX non_negative_least_squares(const PatchTest& test) {
  constexpr double pull = 1e-6, tolerance = 1e-7, worthwhile = 0.99;
  constexpr int most_steps = 5000, window = 100;
  const auto apply = [&](const VectorX& v) -> VectorX { return test.gather(test.sums(v)) + pull * v; };
  const VectorX right = test.gather(test.right) + pull * test.uniform;
  const double fixed_step = 1.95 / (test.largest_eigenvalue() + pull);  // 2 is where it could go uphill
  VectorX y = test.uniform, gradient = apply(y) - right;
  const auto free_components = [&]() -> VectorX { return (y.array() > 0).select(gradient, 0.); };
  VectorX direction = free_components();
  double last_misfit = std::numeric_limits<double>::infinity();
  for (int steps = 0; steps < most_steps; ++steps) {
    const VectorX free = free_components(), held = (y.array() > 0).select(0., gradient.cwiseMin(0));
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
      y = (y - fixed_step * free_components()).cwiseMax(0).eval();
      gradient = apply(y) - right;
      direction = free_components();
    } else {
      const VectorX left = free_components();
      direction = release ? left : VectorX(left - left.dot(change) / curvature * direction);
    }
  }
  return y;
}

}  // namespace

std::string Patch::unsuited(const Body& body) {
  if (source_of(body) != Source::none) return "";
  return body.voronoi ? body.voronoi->problem : "needs tetrahedra, cubes or the Voronoi cells of its molecules";
}

VectorX Patch::constants(const Body& body, const Material& material) const {
  const PatchTest test(body, 0.4 * isotropic(), true);
  const VectorX y = non_negative_least_squares(test);
  return material.youngs_modulus * test.length2 * y.cwiseQuotient(test.length);
}

VectorX fibre_sections(const Body& body, const Vector3& direction) {
  PatchTest test(body, triple(direction) * direction.transpose(), false);
  test.uniform.setZero();
  return test.length2 * non_negative_least_squares(test).cwiseQuotient(test.length);
}

}  // namespace elastin
