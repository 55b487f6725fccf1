#include "lab/experiment/homogenisation/homogenisation.h"

#include <algorithm>
#include <cmath>

#include "core/model/faces.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/solve/homogenisation.h"
#include "lab/experiment/driven.h"
#include "lab/experiment/keys.h"
#include "lab/run/ends.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

const MeasureList& homogenisation_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {"effective_modulus", pressure, "Young's modulus, Hill's mean over all directions", Role::youngs_modulus, "E"},
      {"poissons_ratio", none, "Poisson's ratio, Hill's mean over all directions", Role::poissons_ratio,
       "Poisson's ratio"},
      {"shear_modulus", pressure, "shear modulus, Hill's mean over all directions", Role::shear_modulus, "G"},
      {"bulk_modulus", pressure, "bulk modulus, Hill's mean", Role::modulus, "K"},
      {"youngs_modulus_x", pressure, "1 / compliance along x, of the stiffness matrix", Role::modulus, "E along x"},
      {"youngs_modulus_y", pressure, "1 / compliance along y", Role::modulus, "E along y"},
      {"youngs_modulus_z", pressure, "1 / compliance along z", Role::modulus, "E along z"},
      {"anisotropy_index", none, "universal: 5 G_V/G_R + K_V/K_R - 6; 0 = isotropic", Role::none, "anisotropy"},
      {"patch_residual", none, "largest force on an inner molecule under affine strain / on a surface one; 0 = exact"},
      {"stiffness_asymmetry", none, "| C - C transposed | / | C | of the stiffness matrix"}};
  return list;
}

class Homogenisation final : public Driven {
 public:
  Homogenisation(const Body& body, double grip_depth, const Matrix3& axes)
      : Driven(body, 1), axes_(axes), surface_(find_surface(body, axes, grip_depth)) {
    fix_fully(surface_.molecules);
    note_cavities(body, findings_);
  }

  std::string name() const override { return "material"; }
  MeasureList measures() const override { return homogenisation_measures(); }
  bool of_small_strains() const override { return true; }

  Measures measure(const Held& held, const Start&, const State& state, const StaticOptions& options,
                   StaticResult& solved) const override {
    const int before = solved.linear_iterations;
    Homogenised found = homogenise(held.model, surface_.molecules, surface_.volume, state.positions, axes_, options);
    solved.linear_iterations = before + found.result.linear_iterations;
    solved.residual = found.result.residual;  // of the six solves, not of the start's rounding
    solved.solver = found.result.solver;
    solved.reason = found.result.reason;
    solved.outcome = found.result.outcome;
    solved.cause = found.result.cause;
    if (solved.outcome != Outcome::converged) return {};
    Measures measures;
    read_moduli(found.stiffness, measures);
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

  static void read_moduli(const Stiffness6& stiffness, Measures& measures) {
    measures.stiffness_matrix = stiffness;
    if (const auto compliance = compliance_of(stiffness)) {
      const IsotropicMeans means = isotropic_means((stiffness + stiffness.transpose()) / 2, *compliance);
      measures.set("effective_modulus", means.youngs());
      measures.set("poissons_ratio", means.poissons_ratio());
      measures.set("shear_modulus", means.shear());
      measures.set("bulk_modulus", means.bulk());
      measures.set("youngs_modulus_x", 1 / (*compliance)(0, 0));
      measures.set("youngs_modulus_y", 1 / (*compliance)(1, 1));
      measures.set("youngs_modulus_z", 1 / (*compliance)(2, 2));
      measures.set("anisotropy_index", means.anisotropy_index());
    }
    measures.set("stiffness_asymmetry", (stiffness - stiffness.transpose()).norm() / stiffness.norm());
  }

  /// Every molecule follows the strain: the largest force left on an inner one, over the largest on the surface; the
  /// worst of the six strains.
  double patch_residual(Model& model, const State& state) const {
    const Tangent tangent(model, state);
    std::vector<char> inner(static_cast<std::size_t>(body_.size()), 1);
    for (const Fixed& fixed : fixed_) inner[fixed.molecule] = 0;
    double worst = 0;
    Positions forces(3, body_.size());
    for (int load_case = 0; load_case < 6; ++load_case) {
      tangent.apply(uniformly_strained(body_, load_case, axes_), forces);
      double largest_inner = 0, largest_outer = 0;
      for (int molecule = 0; molecule < body_.size(); ++molecule) {
        double& largest = inner[molecule] ? largest_inner : largest_outer;
        largest = std::max(largest, forces.col(molecule).norm());
      }
      if (largest_inner > 0) worst = std::max(worst, largest_inner / largest_outer);
    }
    return worst;
  }

  Matrix3 axes_;
  Surface surface_;
};

}  // namespace

std::unique_ptr<StaticExperiment> make_homogenisation(const Body& body, const HomogenisationSetup& setup,
                                                      const Matrix3& axes) {
  return std::make_unique<Homogenisation>(body, setup.grip_depth, axes);
}

ExperimentInfo material_row() {
  return with_keys(
      {.name = "material",
       .summary = "six small strains of the surface: the body's 6 × 6 stiffness matrix and its isotropic means",
       .measures = homogenisation_measures()},
      Keys<HomogenisationSetup>{grip_depth_key(&HomogenisationSetup::grip_depth)},
      [](const ExperimentContext& context, const HomogenisationSetup& setup) {
        return make_homogenisation(context.body, setup, context.rotation);
      });
}

}  // namespace elastin::lab
