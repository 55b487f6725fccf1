#include "lab/experiment/shear/shear.h"

#include <array>
#include <cmath>
#include <limits>

#include "elastin/core/base/error.h"
#include "elastin/core/model/share.h"
#include "lab/experiment/driven.h"
#include "lab/experiment/keys.h"
#include "lab/run/ends.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

const MeasureList& shear_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"shear_modulus", pressure, "secant modulus G = shear stress / strain", Role::shear_modulus, "G"},
       {"stress", pressure, "shear stress: F / A", Role::stress},
       {"strain", none, "lateral displacement / height", Role::strain},
       {"force", force, "shear force on the loaded end; beyond preload", Role::force},
       {"axial_force", force, "force along the axis; positive = the plate pulls the body up"}},
      {{"strain", "stress", true}, {"load", "strain"}}};
  return list;
}

class Shear final : public Driven {
 public:
  Shear(const Body& body, const ShearSetup& setup, const Matrix3& axes)
      : Driven(body, setup.load_steps), setup_(setup), rise_(body.rest.transpose() * setup.axis) {
    const double low = least_over(body, rise_.minCoeff()), high = largest_over(body, rise_.maxCoeff());
    rise_.array() -= low;
    const auto choose_section = [&](double from, double to) {
      const double section = find_section(body, setup.axis, from, to, setup.thickness).area;
      area_ = setup.cross_section > 0 ? setup.cross_section : section;
      note_stated_section(body, setup.axis, setup.cross_section, section, findings_);
      if (!(area_ > 0)) throw InputError("the body's molecules span no cross-section: give cross_section");
    };
    if (setup.sides == Sides::affine) {
      if (any_over(body, !body.triangles.empty()) && !any_over(body, !body.tetrahedra.empty()))
        throw InputError("`sides: affine` shears a solid, and the body is a membrane of triangles: leave `sides` out");
      choose_section(low, high);
      follow_shear(axes, high - low);
    } else {
      Ends ends(body, setup.axis, setup);
      findings_ = std::move(ends.findings);
      choose_section(ends.low, ends.high);
      clamp_ends(ends);
    }
  }

  std::string name() const override { return "shear"; }
  MeasureList measures() const override { return shear_measures(); }
  ResponseMeasures response_measures() const override { return {"strain", "force"}; }
  std::optional<std::size_t> first_released() const override {
    if (volume_ > 0) return std::nullopt;
    return fixed_.size() - static_cast<std::size_t>(loaded_);
  }

  Measures measure(const Held& held, const Start& start, const State& state, const StaticOptions&,
                   StaticResult& solved) const override {
    const Positions pull = pull_of(start, solved);
    const double strain =
        held.released ? mean_displacement(state.positions) * strain_ / displacement_ : held.factor * strain_;
    // Simple shear keeps the volume and the area of the sheared planes: first Piola-Kirchhoff = Cauchy on them.
    const Vector3 traction =
        volume_ > 0 ? Vector3(virial(pull, body_.rest) * setup_.axis / volume_) : Vector3(loaded_sum(pull) / area_);
    const double stress = traction.dot(setup_.direction);
    Measures measures;
    if (is_strained(strain)) measures.set("shear_modulus", stress / strain);
    measures.set("stress", stress);
    measures.set("strain", strain);
    measures.set("force", stress * area_);
    measures.set("axial_force", traction.dot(setup_.axis) * area_);
    add_state(held.model, state, solved, std::abs(stress * area_), measures);
    return measures;
  }

  std::optional<UniformTest> uniform(const Measures& measured) const override {
    ShearSetup own;
    own.axis = setup_.axis, own.direction = setup_.direction, own.strain = measured.get("strain");
    own.sides = Sides::affine;
    Matrix3 frame;
    frame << own.direction, own.axis, own.direction.cross(own.axis);
    return UniformTest{own.strain, frame, [own, frame](const Body& block) { return make_shear(block, own, frame); }};
  }

  Matrix3 against_load(const Vector3& /*at*/) const override { return setup_.direction * setup_.direction.transpose(); }

  bool apparent() const override {
    const auto extent = [&](const Vector3& along) {
      const VectorX heights = body_.rest.transpose() * along;
      return largest_over(body_, heights.maxCoeff()) - least_over(body_, heights.minCoeff());
    };
    constexpr double flat = 0.1;  // height over width from which bending shows
    return setup_.sides != Sides::affine && extent(setup_.axis) >= flat * extent(setup_.direction);
  }
  std::string no_reference() const override {
    return apparent() ? "the ends are clamped and the sides free, so that the body bends as it shears and its modulus "
                        "is apparent; compare with the solid itself (neo_hookean, refined)"
                      : "";
  }
  std::string remark(const Measures& /*measures*/) const override {
    return apparent() ? "the ends are clamped and the sides free: the body bends as it shears, and shows a smaller "
                        "modulus than its material has; sides: affine shows that of the material"
                      : "";
  }

  std::vector<MainMeasure> main_measures(const Material& material, const Measures& /*measured*/) const override {
    const double target = apparent() ? std::numeric_limits<double>::quiet_NaN() : lab::shear_modulus(material);
    return {{"shear_modulus", target}, {"force"}, {"axial_force"}};
  }

 private:
  void clamp_ends(const Ends& ends) {
    fix_fully(ends.held);
    fix_fully(ends.moved);
    loaded_ = static_cast<Eigen::Index>(ends.moved.size());
    const auto end_of = [&](const Face& grip) {
      return end_of_grip(body_, grip.molecules, setup_.axis, setup_.axis.dot(middle_of(body_, grip, body_.rest)));
    };
    const double height = end_of(ends.loaded) - end_of(ends.fixed);
    displacement_ = setup_.displacement != 0 ? setup_.displacement : setup_.strain * height;
    strain_ = displacement_ / height;
  }

  Vector3 loaded_sum(const Positions& pull) const {
    return vector_sum_over(body_, Vector3(pull.rightCols(loaded_).rowwise().sum()));
  }

  void follow_shear(const Matrix3& axes, double height) {
    const Surface surface = find_surface(body_, axes, setup_.grip_depth);
    fix_fully(surface.molecules);
    note_cavities(body_, findings_);
    volume_ = surface.volume;
    strain_ = setup_.displacement != 0 ? setup_.displacement / height : setup_.strain;
  }

  Vector3 displacement(std::size_t index, double factor) const override {
    if (volume_ > 0) return factor * strain_ * rise_[fixed_[index].molecule] * setup_.direction;
    const bool loaded = index + static_cast<std::size_t>(loaded_) >= fixed_.size();
    return loaded ? Vector3(factor * displacement_ * setup_.direction) : Vector3::Zero();
  }

  /// Displacement of the loaded end along the shear [m].
  double mean_displacement(const Positions& positions) const {
    std::array<double, 2> sums{0, 0};
    for (std::size_t i = fixed_.size() - static_cast<std::size_t>(loaded_); i < fixed_.size(); ++i) {
      const int molecule = fixed_[i].molecule;
      if (molecule >= owned_molecules(body_)) continue;
      sums[0] += setup_.direction.dot(positions.col(molecule) - body_.rest.col(molecule));
      ++sums[1];
    }
    sum_over(body_, sums);
    return sums[0] / sums[1];
  }

  ShearSetup setup_;
  VectorX rise_;             // of each molecule above the lowest
  Eigen::Index loaded_ = 0;  // the last of the held molecules
  double displacement_ = 0, strain_ = 0;
  double area_ = 0, volume_ = 0;  // volume: affine sides only
};

}  // namespace

std::unique_ptr<StaticExperiment> make_shear(const Body& body, const ShearSetup& setup, const Matrix3& axes) {
  return std::make_unique<Shear>(body, setup, axes);
}

ExperimentInfo shear_row() {
  using S = ShearSetup;
  constexpr double upright = 1.57;  // a right angle shears without end
  return with_keys(
      {.name = "shear",
       .summary = "planes across the axis slide along a direction, at constant height: shear modulus",
       .of_shares = true,
       .measures = shear_measures()},
      Keys<S>{
          axis_key(&S::axis, "axis of the body, from the fixed end to the loaded one"),
          direction_across_key(&S::direction, &S::axis, "direction of the displacement"),
          one_of<S>("give one of displacement, strain (displacement over height) and angle",
                    {not_zero(key::quantity("displacement", &S::displacement, dimension::length,
                                            "displacement of the loaded end; not 0"),
                              &S::displacement)
                         .first(refuse_percent),
                     not_zero(key::quantity("strain", &S::strain, dimension::none, "displacement over height; not 0"),
                              &S::strain),
                     not_zero(key::angle("angle", &S::angle, "angle of shear; not 0", {-upright, upright, false}),
                              &S::angle)}),
          key::choice("sides", &S::sides, {{"free", Sides::free}, {"affine", Sides::affine}},
                      "whether two rigid plates carry the shear, or the whole surface follows it"),
          cross_section_key(&S::cross_section), grip_keys<S>(), load_steps_key(&S::load_steps)},
      [](const ExperimentContext& context, S setup) {
        setup.thickness = context.material.thickness;
        if (setup.angle != 0) setup.strain = std::tan(setup.angle);
        return make_shear(context.body, setup, context.rotation);
      });
}

}  // namespace elastin::lab
