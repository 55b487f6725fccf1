#include "elastin/core/solve/homogenisation.h"

#include <algorithm>

#include "core/base/dense.h"

namespace elastin {
namespace {

constexpr int kVoigt[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};

/// Strain tensor whose Voigt number `load_case` is 1: engineering shear.
Matrix3 unit_strain(int load_case) {
  const auto [i, j] = kVoigt[load_case];
  Matrix3 strain = Matrix3::Zero();
  strain(i, j) += 0.5;
  strain(j, i) += 0.5;
  return strain;
}

}  // namespace

Matrix3 virial(const Positions& forces, const std::vector<int>& molecules, const Positions& positions,
               const Vector3& middle) {
  Matrix3 sum = Matrix3::Zero();
  for (std::size_t i = 0; i < molecules.size(); ++i)
    sum += forces.col(static_cast<Eigen::Index>(i)) * (positions.col(molecules[i]) - middle).transpose();
  return sum;
}

Positions uniformly_strained(const Body& body, int load_case, const Matrix3& axes) {
  return (axes * unit_strain(load_case) * axes.transpose()) * (body.rest.colwise() - body.rest.rowwise().mean());
}

Homogenised homogenise(Model& model, const std::vector<int>& surface, double volume, const Positions& at,
                       const Matrix3& axes, const StaticOptions& options) {
  const Body& body = model.body();
  Homogenised found;
  for (int load_case = 0; load_case < 6; ++load_case) {
    StaticResponse response =
        static_response(model, at, Positions::Zero(3, body.size()), uniformly_strained(body, load_case, axes), options);
    response.result.linear_iterations += found.result.linear_iterations;
    response.result.residual = std::max(response.result.residual, found.result.residual);
    found.result = std::move(response.result);
    if (found.result.outcome != Outcome::converged) return {Stiffness6::Zero(), std::move(found.result)};
    const Matrix3 stress =
        axes.transpose() * virial(found.result.reactions, surface, at, at.rowwise().mean()) * axes / volume;
    for (int row = 0; row < 6; ++row) {
      const auto [i, j] = kVoigt[row];
      found.stiffness(row, load_case) = (stress(i, j) + stress(j, i)) / 2;
    }
  }
  return found;
}

std::optional<Stiffness6> compliance_of(const Stiffness6& stiffness) {
  const Stiffness6 symmetric = (stiffness + stiffness.transpose()) / 2;
  const VectorX eigenvalues = symmetric_eigenvalues(symmetric);
  if (!(eigenvalues.minCoeff() > 1e-9 * eigenvalues.maxCoeff())) return std::nullopt;
  return Stiffness6(inverse(symmetric));
}

IsotropicMeans isotropic_means(const Stiffness6& stiffness, const Stiffness6& compliance) {
  const auto sums = [](const Stiffness6& m) {
    struct {
      double axial, across, shear;
    } result{m(0, 0) + m(1, 1) + m(2, 2), m(0, 1) + m(0, 2) + m(1, 2), m(3, 3) + m(4, 4) + m(5, 5)};
    return result;
  };
  const auto c = sums(stiffness), s = sums(compliance);
  return {(c.axial + 2 * c.across) / 9, 1 / (s.axial + 2 * s.across), (c.axial - c.across + 3 * c.shear) / 15,
          15 / (4 * (s.axial - s.across) + 3 * s.shear)};
}

}  // namespace elastin
