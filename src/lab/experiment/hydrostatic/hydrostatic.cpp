#include "lab/experiment/hydrostatic/hydrostatic.h"

#include <cmath>

#include "core/model/faces.h"
#include "elastin/core/model/share.h"
#include "lab/experiment/driven.h"
#include "lab/experiment/keys.h"
#include "lab/run/ends.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

const MeasureList& hydrostatic_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"bulk_modulus", pressure, "secant modulus K = - pressure / volume strain", Role::modulus, "K"},
       {"pressure", pressure, "- mean of the normal stresses, volume mean"},
       {"volume_strain", none, "volume / volume at rest - 1", Role::share}},
      {{"volume_strain", "pressure", true}}};
  return list;
}

class Hydrostatic final : public Driven {
 public:
  Hydrostatic(const Body& body, const HydrostaticSetup& setup, const Matrix3& axes)
      : Driven(body, setup.load_steps), strain_(setup.strain), middle_(middle_of_whole(body)) {
    if (setup.walls == Walls::affine) {
      const Surface surface = find_surface(body, axes, setup.grip_depth);
      fix_fully(surface.molecules);
      note_cavities(body, findings_);
      volume_ = surface.volume;
      return;
    }
    const BoxSides box = find_box(body, axes, setup.grip_depth);
    volume_ = box.size.prod();
    std::vector<Matrix3> free(static_cast<std::size_t>(body.size()), Matrix3::Identity());
    for (std::size_t side = 0; side < 6; ++side)
      for (const int molecule : box.sides[side].molecules) {
        const Vector3 normal = axes.col(static_cast<Eigen::Index>(side / 2));
        Matrix3& left = free[molecule];
        left -= left * normal * normal.transpose();
      }
    for (int molecule = 0; molecule < body.size(); ++molecule)
      if (const Matrix3& left = free[molecule]; left != Matrix3::Identity()) fixed_.push_back({molecule, left});
  }

  std::string name() const override { return "hydrostatic"; }
  MeasureList measures() const override { return hydrostatic_measures(); }
  ResponseMeasures response_measures() const override { return {"volume_strain", "pressure"}; }

  Measures measure(const Held& held, const Start& start, const State& state, const StaticOptions&,
                   StaticResult& solved) const override {
    const Positions pull = pull_of(start, solved);
    const double strain = held.factor * strain_, growth = std::pow(1 + strain, 3);
    const double volume_strain = solved.linear ? 3 * strain : growth - 1;
    const double volume = solved.linear ? volume_ : volume_ * growth;
    const auto pressure_of = [&](const Positions& forces, const Positions& positions, double own) {
      return -virial(forces, solved.linear ? body_.rest : positions).trace() / (3 * own);
    };
    const double pressure =
        pressure_of(solved.reactions, state.positions, volume) - pressure_of(start.reactions, start.positions, volume_);
    Measures measures;
    if (is_strained(volume_strain)) measures.set("bulk_modulus", -pressure / volume_strain);
    measures.set("pressure", pressure);
    measures.set("volume_strain", volume_strain);
    add_state(held.model, state, solved, sum_over(body_, pull.colwise().norm().sum()), measures);
    return measures;
  }

  Matrix3 against_load(const Vector3& /*at*/) const override { return Matrix3::Identity(); }

  std::optional<UniformTest> uniform(const Measures& measured) const override {
    const HydrostaticSetup own{.strain = std::cbrt(1 + measured.get("volume_strain")) - 1, .walls = Walls::affine};
    const auto make = [own](const Body& block) { return make_hydrostatic(block, own, Matrix3::Identity()); };
    return UniformTest{own.strain, Matrix3::Identity(), make};
  }

  std::vector<MainMeasure> main_measures(const Material& material, const Measures& /*measured*/) const override {
    return {{"bulk_modulus", lab::bulk_modulus(material)}, {"pressure"}};
  }

 private:
  Vector3 displacement(std::size_t index, double factor) const override {
    return factor * strain_ * (body_.rest.col(fixed_[index].molecule) - middle_);
  }

  double strain_;
  Vector3 middle_;
  double volume_ = 0;  // at rest
};

}  // namespace

std::unique_ptr<StaticExperiment> make_hydrostatic(const Body& body, const HydrostaticSetup& setup,
                                                   const Matrix3& axes) {
  return std::make_unique<Hydrostatic>(body, setup, axes);
}

ExperimentInfo hydrostatic_row() {
  using S = HydrostaticSetup;
  return with_keys({.name = "hydrostatic",
                    .summary = "equal strain along all directions: bulk modulus",
                    .of_shares = true,
                    .measures = hydrostatic_measures()},
                   Keys<S>{not_zero(key::quantity("strain", &S::strain, dimension::none,
                                                  "strain of each side; negative compresses; not 0", {-1, 100, true}),
                                    &S::strain)
                               .needed(),
                           key::choice("sides", &S::walls, {{"sliding", Walls::sliding}, {"affine", Walls::affine}},
                                       "whether six smooth walls carry the strain, or the whole surface follows it"),
                           grip_depth_key(&S::grip_depth), load_steps_key(&S::load_steps)},
                   [](const ExperimentContext& context, const S& setup) {
                     return make_hydrostatic(context.body, setup, context.rotation);
                   });
}

}  // namespace elastin::lab
