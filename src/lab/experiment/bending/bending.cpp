#include "lab/experiment/bending/bending.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/model/share.h"
#include "lab/experiment/keys.h"
#include "lab/run/common_measures.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

const MeasureList& bending_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"effective_modulus", pressure, "Young's modulus of the beam with this deflection", Role::youngs_modulus, "E"},
       {"tip_deflection", length, "displacement of the tip's centre along the load"},
       {"tip_shortening", length, "displacement of the tip's centre back along the axis"},
       {"force", force, "load on the beam, its weight included; beyond preload", Role::force}},
      {{"load", "tip_deflection", true}}};
  return list;
}

/// Beyond this part of the length the linear beam is off by more than half a hundredth.
constexpr double kSmallDeflection = 0.1;

/// Least relative difference of the body's section from its hull's that distinguishes a tube from a coarse round bar.
constexpr double kSameSection = 0.05;

class Bending final : public StaticExperiment {
 public:
  Bending(const Body& body, const BendingSetup& setup, const Material& material) : body_(body), setup_(setup) {
    Ends ends(body, setup.axis, setup);
    findings_ = std::move(ends.findings);
    root_ = std::move(ends.fixed);
    held_ = std::move(ends.held);
    const Face& tip = ends.loaded;
    if (ends.moved.size() > tip.molecules.size())
      throw InputError(
          "the tip is rigid, and a force moves no rigid body: bend the other body alone, or give this one "
          "a stiff material in place of `rigid`");
    choose_tip(tip);
    full_forces_ = setup.gravity * setup.direction * body.mass.transpose();
    for (std::size_t i = 0; i < tip.molecules.size(); ++i)
      full_forces_.col(tip.molecules[i]) += setup.force * tip.share[static_cast<Eigen::Index>(i)] * setup.direction;
    const double root_height =
        end_of_grip(body, root_.molecules, setup.axis, setup.axis.dot(middle_of(body, root_, body.rest)));
    length_ = setup.axis.dot(middle_of(body, tip, body.rest)) - root_height;
    find_beam_deflection(root_height, ends.low, ends.high, material);
  }

  std::string name() const override { return "bending"; }
  MeasureList measures() const override { return bending_measures(); }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;
  ResponseMeasures response_measures() const override { return {"tip_deflection", ""}; }
  int load_steps() const override { return setup_.load_steps; }
  Matrix3 against_load(const Vector3& /*at*/) const override { return setup_.direction * setup_.direction.transpose(); }

  std::vector<MainMeasure> main_measures(const Material& material, const Measures& /*measured*/) const override {
    const double target = apparent() ? std::numeric_limits<double>::quiet_NaN() : material.youngs_modulus;
    return {{"effective_modulus", target}, {"tip_deflection"}, {"tip_shortening"}};
  }

  bool apparent() const override { return !apparent_.empty(); }
  std::string no_reference() const override {
    return apparent() ? "the beam's modulus is apparent (" + apparent_ +
                            "); compare with the solid itself (neo_hookean, refined)"
                      : "";
  }
  std::vector<std::string> notes() const override {
    if (!apparent()) return {};
    return {"effective_modulus is apparent: " + apparent_};
  }

  std::string remark(const Measures& measures) const override {
    const double part = std::abs(measures.get("tip_deflection")) / length_;
    if (!(part > kSmallDeflection) || std::isfinite(measures.get("effective_modulus"))) return "";
    char text[160];
    std::snprintf(text, sizeof text,
                  "the tip sinks by %.3g %% of the length, too far for the formula that gives effective_modulus",
                  100 * part);
    return text;
  }

 private:
  friend class BendingRig;
  void choose_tip(const Face& tip) {
    const Vector3 middle = middle_of(body_, tip, body_.rest);
    const auto plane = across(setup_.axis);
    std::vector<double> distance;
    for (const int molecule : tip.molecules)
      distance.push_back((plane.transpose() * (body_.rest.col(molecule) - middle)).norm());
    double nearest = std::numeric_limits<double>::infinity(), furthest = 0;
    for (const double own : distance) nearest = std::min(nearest, own), furthest = std::max(furthest, own);
    const double rounding = 1e-6 * largest_over(body_, furthest), reach = least_over(body_, nearest) + rounding;
    std::array<double, 4> sums{0, 0, 0, 0};  // of the nearest: their number and places from the middle
    for (std::size_t i = 0; i < distance.size(); ++i) {
      const int molecule = tip.molecules[i];
      if (distance[i] > reach || molecule >= owned_molecules(body_)) continue;
      tip_.emplace_back(molecule, 1);
      ++sums[0];
      for (int axis = 0; axis < 3; ++axis) sums[axis + 1] += (body_.rest.col(molecule) - middle)[axis];
    }
    sum_over(body_, sums);
    if ((plane.transpose() * Vector3(sums[1], sums[2], sums[3])).norm() <= rounding * sums[0]) {
      for (auto& [molecule, share] : tip_) share /= sums[0];
      return;
    }
    tip_.clear();  // what is nearest is not the centre, and goes another way where the tip turns
    for (std::size_t i = 0; i < distance.size(); ++i)
      if (tip.molecules[i] < owned_molecules(body_))
        tip_.emplace_back(tip.molecules[i], tip.share[static_cast<Eigen::Index>(i)]);
  }

  /// A section's area [m²], second moment [m⁴], and E times the deflection by a shear force of 1 N over 1 m.
  struct BeamSection {
    double area = 0, moment = 0, shear = 0;
  };

  /// Of the deflection along a load that has the direction of the first coordinate: 1 / n·M⁻¹n. Where that is no
  /// principal axis the beam goes aside, too, and is softer than by its own moment.   [Timoshenko & Goodier 1970, §102]
  static double moment_along_load(const Eigen::Matrix2d& moments) {
    constexpr double principal = 1e-9;
    const double mixed = std::pow(moments(0, 1), 2);
    if (mixed <= principal * moments(0, 0) * moments.trace()) return moments(0, 0);
    return moments(0, 0) - mixed / moments(1, 1);
  }

  /// E A over the shear stiffness is (12 + 11ν)/5 of rectangles and 4 + 3ν of thin round tubes.          [Cowper 1966]
  BeamSection beam_section(double low, double high, const Material& material) {
    Eigen::Matrix<double, 3, 2> plane;
    plane << setup_.direction, setup_.axis.cross(setup_.direction);
    const double rectangle = (12 + 11 * material.poissons_ratio) / 5, tube = 4 + 3 * material.poissons_ratio;
    const auto wall = wall_section(body_, setup_.axis, plane, low, high, material.thickness);
    if (wall && wall->section.area > 0) {
      const double area = wall->section.area, moment = moment_along_load(wall->second_moment);
      if (!(moment > 1e-9 * wall->second_moment.trace()))
        throw InputError(
            "the load bends a flat sheet out of its plane, for which effective_modulus has no formula; `kind: loads` "
            "bends it by a `point` load or its weight, and reads the displacement");
      if (wall->kind == WallSection::Kind::other || !wall->section.prism())
        apparent_ = "its formula is that of flat strips and round tubes, and the body is neither";
      return {area, moment, (wall->kind == WallSection::Kind::tube ? tube : rectangle) / area};
    }
    const Points2 hull = hull_of_section(body_, root_, plane);
    const double area = polygon_area(hull), moment = moment_along_load(polygon_second_moments(hull));
    if (!(area > 0 && moment > 0))
      throw InputError(
          "the body's molecules span no cross-section that could bend; `kind: loads` bends a sheet or a line of "
          "molecules by a `point` load or its weight, and reads the displacement");
    const Section solid = find_section(body_, setup_.axis, low, high, 0);
    if (wall || !solid.prism() || std::abs(solid.area / area - 1) > kSameSection)
      apparent_ = "its formula takes the convex hull for the section, and the body is hollow, notched or tapered";
    else if (const auto of_cells = second_moments_of_cells(body_, plane, solid.area))
      return {solid.area, moment_along_load(*of_cells), rectangle / solid.area};
    return {area, moment, rectangle / area};
  }

  /// E times the deflection of the beam's tip: Σ F (x² (3L − x) / (6 I) + x s) over the forces F at distance x from the
  /// root.                                                                                        [Timoshenko 1921]
  void find_beam_deflection(double root_height, double low, double high, const Material& material) {
    const BeamSection section = beam_section(low, high, material);
    for (int molecule = 0; molecule < owned_molecules(body_); ++molecule) {
      const double x = std::max(0., setup_.axis.dot(body_.rest.col(molecule)) - root_height);
      const double force = setup_.direction.dot(full_forces_.col(molecule));
      deflection_times_modulus_ += force * (x * x * (3 * length_ - x) / (6 * section.moment) + x * section.shear);
    }
    deflection_times_modulus_ = sum_over(body_, deflection_times_modulus_);
  }

  const Body& body_;
  BendingSetup setup_;
  Face root_;
  std::vector<int> held_;                    // molecules of the root, with all of a rigid body there
  std::vector<std::pair<int, double>> tip_;  // owned molecules whose mean is the tip's middle, with their shares of it
  Positions full_forces_;
  double length_ = 0, deflection_times_modulus_ = 0;
  std::string apparent_;  // why the modulus depends on the shape; "": it does not
};

class BendingRig final : public StaticRig {
 public:
  BendingRig(const Bending& experiment, Model& model)
      : experiment_(experiment), setup_(experiment.setup_), body_(experiment.body_), model_(model) {
    for (const int molecule : experiment_.held_) model.supports.push_back({molecule, Matrix3::Zero(), Vector3::Zero()});
    std::vector<int> all(static_cast<std::size_t>(body_.size()));
    for (int molecule = 0; molecule < body_.size(); ++molecule) all[molecule] = molecule;
    auto load = std::make_unique<PointLoads>(body_, std::move(all), experiment_.full_forces_);
    load_ = load.get();
    model.add(std::move(load));
  }

  void set_load(double factor) override {
    load_->set_factor(factor);
    factor_ = factor;
  }

  void release(const State& /*loaded*/) override { set_load(0); }

  Measures measure(const Start& start, const State& state, const StaticOptions&, StaticResult& solved) const override {
    Vector3 motion = Vector3::Zero();
    for (const auto& [molecule, share] : experiment_.tip_)
      motion += share * (state.positions.col(molecule) - start.positions.col(molecule));
    motion = vector_sum_over(body_, motion);
    const double deflection = setup_.direction.dot(motion);
    const int owned = owned_molecules(body_);
    const Vector3 weight =
        vector_sum_over(body_, Vector3(factor_ * experiment_.full_forces_.leftCols(owned).rowwise().sum()));
    Measures measures;
    const double part = deflection / experiment_.length_;
    if (is_strained(part) && (std::abs(part) <= kSmallDeflection || solved.linear))
      measures.set("effective_modulus", factor_ * experiment_.deflection_times_modulus_ / deflection);
    measures.set("tip_deflection", deflection);
    measures.set("tip_shortening", -setup_.axis.dot(motion));
    measures.set("force", weight.norm());
    add_state(model_, state, solved, weight.norm(), measures);
    return measures;
  }

 private:
  const Bending& experiment_;
  const BendingSetup& setup_;
  const Body& body_;
  Model& model_;
  double factor_ = 1;
  PointLoads* load_ = nullptr;  // owned by the model
};

std::unique_ptr<StaticRig> Bending::make_rig(Model& model) const { return std::make_unique<BendingRig>(*this, model); }

}  // namespace

std::unique_ptr<StaticExperiment> make_bending(const Body& body, const BendingSetup& setup, const Material& material) {
  return std::make_unique<Bending>(body, setup, material);
}

ExperimentInfo bending_row() {
  using S = BendingSetup;
  return with_keys(
      {.name = "bending",
       .summary = "a cantilever bends under its own weight or a force on its tip: effective modulus, deflection",
       .source = "Timoshenko 1921, Cowper 1966",
       .of_shares = true,
       .measures = bending_measures()},
      Keys<S>{axis_key(&S::axis, "from the clamped root to the tip"),
              direction_across_key(&S::direction, &S::axis, "direction of the load"),
              any_of<S>("give gravity, a force on the tip, or both",
                        {not_zero(key::quantity("gravity", &S::gravity, dimension::acceleration,
                                                "acceleration that gives the weight; not 0"),
                                  &S::gravity),
                         not_zero(key::quantity("force", &S::force, dimension::force, "force on the tip; not 0"),
                                  &S::force)}),
              grip_keys<S>(), load_steps_key(&S::load_steps)},
      [](const ExperimentContext& context, const S& setup) {
        return make_bending(context.body, setup, context.material);
      });
}

}  // namespace elastin::lab
