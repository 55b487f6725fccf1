#include "lab/experiment/homogenisation.h"

#include <algorithm>
#include <cmath>

#include "elastin/core/base/dense.h"
#include "elastin/core/forces/tangent.h"
#include "lab/experiment/driven.h"
#include "lab/experiment/faces.h"
#include "lab/experiment/moduli.h"

namespace elastin::lab {
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

class Homogenisation final : public Driven {
 public:
  Homogenisation(const Body& body, double grip_depth, const Matrix3& axes) : Driven(body, 1), axes_(axes) {
    const Surface surface = find_surface(body, axes, grip_depth);
    fix_fully(surface.molecules);
    volume_ = surface.volume;
  }

  std::string name() const override { return "material"; }

  Measures measure(const Held& held, const Start&, const State& state, const StaticOptions& options,
                   StaticResult& solved) const override {
    Stiffness6 stiffness;
    solved.residual = 0;  // of the six solves, not of the start's rounding
    for (int load_case = 0; load_case < 6; ++load_case) {
      const Positions displacement = strained(load_case);
      const StaticResponse response =
          static_response(held.model, state.positions, Positions::Zero(3, body_.size()), displacement, options);
      solved.linear_iterations += response.result.linear_iterations;
      solved.residual = std::max(solved.residual, response.result.residual);
      solved.solver = response.result.solver;
      solved.reason = response.result.reason;
      if (response.result.outcome != Outcome::converged) {
        solved.outcome = response.result.outcome;
        solved.cause = response.result.cause;
        return {};
      }
      const Matrix3 stress = axes_.transpose() * virial(response.result.reactions, state.positions) * axes_ / volume_;
      for (int row = 0; row < 6; ++row) {
        const auto [i, j] = kVoigt[row];
        stiffness(row, load_case) = (stress(i, j) + stress(j, i)) / 2;
      }
    }
    Measures measures;
    read_moduli(stiffness, measures);
    measures.set("patch_residual", patch_residual(held.model, state));
    return measures;
  }

  std::vector<MainMeasure> main_measures(const Material& material, const Measures& /*measured*/) const override {
    return {{"effective_modulus", material.youngs_modulus},
            {"poissons_ratio", material.poissons_ratio},
            {"shear_modulus", lab::shear_modulus(material)},
            {"bulk_modulus", lab::bulk_modulus(material)},
            {"anisotropy_index"},
            {"patch_residual"}};
  }

  std::string remark(const Measures& measures) const override {
    if (std::isfinite(measures.get("effective_modulus"))) return "";
    return "the stiffness matrix is singular or not positive: the body has no moduli";
  }

 private:
  Vector3 displacement(std::size_t, double) const override { return Vector3::Zero(); }

  Positions strained(int load_case) const {
    return (axes_ * unit_strain(load_case) * axes_.transpose()) * (body_.rest.colwise() - body_.rest.rowwise().mean());
  }

  static void read_moduli(const Stiffness6& stiffness, Measures& measures) {
    measures.stiffness_matrix = stiffness;
    const Stiffness6 symmetric = (stiffness + stiffness.transpose()) / 2;
    const VectorX eigenvalues = symmetric_eigenvalues(symmetric);
    if (eigenvalues.minCoeff() > 1e-9 * eigenvalues.maxCoeff()) {
      const Stiffness6 compliance = inverse(symmetric);
      const IsotropicMeans means = isotropic_means(symmetric, compliance);
      measures.set("effective_modulus", means.youngs());
      measures.set("poissons_ratio", means.poissons_ratio());
      measures.set("shear_modulus", means.shear());
      measures.set("bulk_modulus", means.bulk());
      measures.set("youngs_modulus_x", 1 / compliance(0, 0));
      measures.set("youngs_modulus_y", 1 / compliance(1, 1));
      measures.set("youngs_modulus_z", 1 / compliance(2, 2));
      measures.set("anisotropy_index", means.anisotropy_index());
    }
    measures.set("stiffness_asymmetry", (stiffness - stiffness.transpose()).norm() / stiffness.norm());
  }

  /// Every molecule follows the strain: the largest force left on an inner one, over the largest on the surface; the
  /// worst of the six strains.
  double patch_residual(Model& model, const State& state) const {
    const Tangent tangent(model, state);
    std::vector<char> inner(static_cast<std::size_t>(body_.size()), 1);
    for (const Fixed& fixed : fixed_) inner[static_cast<std::size_t>(fixed.molecule)] = 0;
    double worst = 0;
    Positions forces(3, body_.size());
    for (int load_case = 0; load_case < 6; ++load_case) {
      tangent.apply(strained(load_case), forces);
      double largest_inner = 0, largest_outer = 0;
      for (int molecule = 0; molecule < body_.size(); ++molecule) {
        double& largest = inner[static_cast<std::size_t>(molecule)] ? largest_inner : largest_outer;
        largest = std::max(largest, forces.col(molecule).norm());
      }
      if (largest_inner > 0) worst = std::max(worst, largest_inner / largest_outer);
    }
    return worst;
  }

  Matrix3 axes_;
  double volume_ = 0;
};

}  // namespace

std::unique_ptr<StaticProtocol> make_homogenisation(const Body& body, double grip_depth, const Matrix3& axes) {
  return std::make_unique<Homogenisation>(body, grip_depth, axes);
}

}  // namespace elastin::lab
