#include "lab/experiment/torsion/torsion.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "elastin/core/model/share.h"
#include "lab/experiment/driven.h"
#include "lab/experiment/keys.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

const MeasureList& torsion_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"torque", dimension::energy, "torque about the axis on the turned end; beyond preload", Role::torque, "",
        "N m"},
       {"axial_force", force, "force along the axis; positive = the plate pulls the body up"},
       {"angle", none, "angle by which the loaded end is turned", Role::none, "", "rad"},
       {"torsional_stiffness", dimension::energy, "torque / angle [a radian]", Role::modulus, "", "N m"},
       {"shear_modulus", pressure, "secant modulus G: torque / twist of the bar", Role::shear_modulus, "G"}},
      {{"angle", "torque", true}, {"load", "angle", true}}};
  return list;
}

/// How a section takes torsion.
struct TorsionSection {
  double constant = 0;  ///< J [m⁴]; 0: not known
  bool round = false;   ///< so that it does not warp
};

/// Of a section whose outline is, within 2 %, a rectangle or a circle, of the same area; nothing of any other, of
/// hollow ones, and of bodies that are no prism.
TorsionSection torsion_section(const Points2& hull, const Section& section) {
  const Eigen::Index count = hull.cols();
  if (count < 3 || !section.prism()) return {};
  double area = 0, box = std::numeric_limits<double>::infinity();
  Eigen::Vector2d sides, centre = Eigen::Vector2d::Zero();
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2d a = hull.col(i), b = hull.col((i + 1) % count), u = (b - a).normalized(), v(-u.y(), u.x());
    const double part = (a.x() * b.y() - a.y() * b.x()) / 2;
    area += part, centre += part * (a + b) / 3;
    const auto along = (u.transpose() * hull).eval(), over = (v.transpose() * hull).eval();
    const Eigen::Vector2d own(along.maxCoeff() - along.minCoeff(), over.maxCoeff() - over.minCoeff());
    if (own.prod() < box) box = own.prod(), sides = own;
  }
  centre /= area, area = std::abs(area);
  if (std::abs(section.area - area) > 0.03 * area) return {};
  if (area > 0.98 * box) return {torsion_constant(sides[0], sides[1]) * std::pow(section.area / box, 2)};
  const auto radii = (hull.colwise() - centre).colwise().norm().eval();
  if (!(count > 6 && radii.maxCoeff() < 1.02 * radii.minCoeff())) return {};
  return {std::pow(section.area, 2) / (2 * std::numbers::pi), true};
}

class Torsion final : public Driven {
 public:
  Torsion(const Body& body, const TorsionSetup& setup, double thickness)
      : Driven(body, setup.load_steps), setup_(setup) {
    Ends ends(body, setup.axis, setup);
    findings_ = std::move(ends.findings);
    fix_fully(ends.held);
    first_loaded_ = fixed_.size();
    fix_fully(ends.moved);
    middle_ = middle_of(body, ends.loaded, body.rest);
    const auto end_of = [&](const Face& grip) {
      return end_of_grip(body, grip.molecules, setup.axis, setup.axis.dot(middle_of(body, grip, body.rest)));
    };
    const double from = end_of(ends.fixed);
    length_ = end_of(ends.loaded) - from;
    const auto plane = across(setup.axis);
    if (const auto wall = wall_section(body, setup.axis, plane, from, from + length_, thickness)) {
      if (wall->kind == WallSection::Kind::tube && wall->section.prism()) section_ = {wall->torsion, true};
      return;
    }
    section_ = torsion_section(hull_of_section(body, ends.fixed, plane),
                               find_section(body, setup.axis, from, from + length_, 0));
  }

  std::string name() const override { return "torsion"; }
  MeasureList measures() const override { return torsion_measures(); }
  ResponseMeasures response_measures() const override { return {"angle", "torque"}; }
  std::optional<std::size_t> first_released() const override { return first_loaded_; }

  Matrix3 against_load(const Vector3& at) const override {
    return setup_.axis * setup_.axis.cross(at - middle_).transpose();
  }

  std::string no_reference() const override {
    if (!(section_.constant > 0))
      return "the section is none whose torsion constant is known, so that the torque alone is measured; compare with "
             "the material's own law, refined";
    return section_.round
               ? ""
               : "the ends are clamped, so that the section cannot warp there and no bar shows the material's "
                 "G; compare with the solid itself (neo_hookean, refined)";
  }

  Measures measure(const Held& held, const Start& start, const State& state, const StaticOptions&,
                   StaticResult& solved) const override {
    const Positions pull = pull_of(start, solved);
    const Positions &at_start = solved.linear ? body_.rest : start.positions,
                    &positions = solved.linear ? body_.rest : state.positions;
    std::array<double, 3> sums{0, 0, 0};
    for (std::size_t i = first_loaded_; i < fixed_.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      const Vector3 force = pull.col(column);
      const auto torque_of = [&](const Positions& forces, const Positions& all) {  // the arms turn with the end
        const Vector3 arm = all.col(fixed_[i].molecule) - middle_;
        return setup_.axis.dot(arm.cross(Vector3(forces.col(column))));
      };
      sums[0] += torque_of(solved.reactions, positions) - torque_of(start.reactions, at_start);
      sums[1] += setup_.axis.dot(force);
      sums[2] += force.norm();
    }
    sum_over(body_, sums);
    const auto [torque, axial, size] = sums;
    const double angle = held.released ? turn_of(state.positions) : held.factor * setup_.angle;
    Measures measures;
    measures.set("torque", torque);
    measures.set("axial_force", axial);
    measures.set("angle", angle);
    if (is_strained(angle)) measures.set("torsional_stiffness", torque / angle);
    if (is_strained(angle) && section_.constant > 0)
      measures.set("shear_modulus", torque * length_ / (section_.constant * angle));
    add_state(held.model, state, solved, size, measures);
    return measures;
  }

  std::vector<MainMeasure> main_measures(const Material& material, const Measures& measured) const override {
    constexpr double little =
        0.02;  // of the torque over the length: of small angles the axial force is next to nothing
    std::vector<MainMeasure> measures{{"torque"}};
    if (!(std::abs(measured.get("axial_force")) * length_ < little * std::abs(measured.get("torque"))))
      measures.push_back({"axial_force"});
    if (section_.constant > 0) measures.insert(measures.begin(), {"shear_modulus", lab::shear_modulus(material)});
    return measures;
  }

 private:
  Vector3 displacement(std::size_t index, double factor) const override {
    if (index < first_loaded_) return Vector3::Zero();
    const Vector3 arm = body_.rest.col(fixed_[index].molecule) - middle_;
    const double angle = factor * setup_.angle;
    if (setup_.straight) return angle * setup_.axis.cross(arm);
    return Eigen::AngleAxisd(angle, setup_.axis) * arm - arm;
  }

  Vector3 displacement_slope(std::size_t index, double factor) const override {
    if (index < first_loaded_) return Vector3::Zero();
    const Vector3 arm = body_.rest.col(fixed_[index].molecule) - middle_;
    const double angle = setup_.straight ? 0 : factor * setup_.angle;
    return setup_.angle * setup_.axis.cross(Eigen::AngleAxisd(angle, setup_.axis) * arm);
  }

  double longest_step() const override {
    constexpr double quarter = std::numbers::pi / 2;
    return setup_.straight || std::abs(setup_.angle) <= quarter ? 1 : quarter / std::abs(setup_.angle);
  }

  /// Angle [rad] by which the end has turned in the mean.
  double turn_of(const Positions& positions) const {
    std::array<double, 2> sums{0, 0};  // across, along
    for (std::size_t i = first_loaded_; i < fixed_.size(); ++i) {
      const int molecule = fixed_[i].molecule;
      if (molecule >= owned_molecules(body_)) continue;
      Vector3 arm = body_.rest.col(molecule) - middle_;
      arm -= setup_.axis.dot(arm) * setup_.axis;
      const Vector3 now = positions.col(molecule) - middle_;
      sums[0] += setup_.axis.dot(arm.cross(now));
      sums[1] += arm.dot(now);
    }
    sum_over(body_, sums);
    return std::atan2(sums[0], sums[1]);
  }

  TorsionSetup setup_;
  std::size_t first_loaded_ = 0;
  Vector3 middle_;
  double length_ = 0;
  TorsionSection section_;
};

}  // namespace

std::unique_ptr<StaticExperiment> make_torsion(const Body& body, const TorsionSetup& setup, double thickness) {
  return std::make_unique<Torsion>(body, setup, thickness);
}

ExperimentInfo torsion_row() {
  using S = TorsionSetup;
  return with_keys(
      {.name = "torsion",
       .summary = "one end of a clamped bar is turned about its axis at constant height: torque, shear "
                  "modulus of a rectangle",
       .source = "Timoshenko & Goodier 1970, section 109",
       .of_shares = true,
       .measures = torsion_measures()},
      Keys<S>{axis_key(&S::axis, "axis of the body, from the fixed end to the loaded one"),
              not_zero(key::angle("angle", &S::angle, "rotation of the turned end; not 0"), &S::angle).needed(),
              grip_keys<S>(), load_steps_key(&S::load_steps)},
      [](const ExperimentContext& context, S setup) {
        setup.straight = context.statics.linear;
        return make_torsion(context.body, setup, context.material.thickness);
      });
}

}  // namespace elastin::lab
