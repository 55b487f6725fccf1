#include "lab/experiment/inflation/inflation.h"

#include <cmath>
#include <string>

#include "core/forces/pressure.h"
#include "core/geometry/rim.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "lab/experiment/keys.h"
#include "lab/run/common_measures.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

const MeasureList& inflation_measures() {
  using namespace dimension;
  static const MeasureList list{
      {{"radius", length, "mean distance from the middle, by area at rest"},
       {"stretch", none, "mean radius / that at rest"},
       {"radius_spread", none, "(largest - smallest distance from the middle) / mean"},
       {"corner_radius", length, "mean distance from the middle of the molecules on the axes"},
       {"pressure", pressure, "pressure inside over that outside"},
       {"enclosed_volume", volume, "volume inside, of the whole where planes of symmetry cut the body"},
       {"wall_stress", pressure, "p R / (2 t), t the thickness at rest"}},
      {{"stretch", "pressure"}, {"load", "radius"}}};
  return list;
}

/// A volume that is controlled counts as met when it is this near.
constexpr double kVolumeTolerance = 1e-6;
/// Stiffness of volume control over E t/(R V): a membrane's experiment, and how fast its pressure can fall, is some 0.1
/// of that. High enough to pass any pressure limit and to be met after a few corrections; rounding of the volume makes
/// that many times more rounding of the pressure.
constexpr double kControlStiffness = 100;
/// Of the radius at rest: by no more does one part of a controlled volume grow or shrink. Further from its volume the
/// pressure that controls it can turn the surface inside out, which is an equilibrium too.
constexpr double kLongestGrowth = 0.25;

class Inflation final : public StaticExperiment {
 public:
  Inflation(const Body& body, const InflationSetup& setup, const Material& material)
      : body_(body), setup_(setup), thickness_(mean_thickness(body, material.thickness)) {
    if (body.triangles.empty()) throw InputError("inflation needs a body with triangles");
    if (!(thickness_ > 0)) throw InputError("inflation needs a membrane: give material.thickness");
    fix_in_planes(body, setup.symmetry, fixed_);
    require_closed();
    const std::size_t pieces = setup.symmetry.empty() ? pieces_of(body.triangles, body.size()).size() : 1;
    if (pieces > 1)
      throw InputError("inflation measures one membrane, and the body has " + std::to_string(pieces) +
                       " that share no molecule: `kind: loads` inflates each, by `pressure` or `gas` among `loads`");
    apex_ = setup.symmetry.empty() ? Vector3(body.rest.rowwise().mean()) : Vector3(Vector3::Zero());
    rest_volume_ = enclosed_volume(body.triangles, body.rest, apex_);
    if (!(rest_volume_ > 0)) throw InputError("the body encloses no volume: its triangles look inwards, or it is flat");
    if (setup_.gas && setup_.gas->amount > 0)
      setup_.gas->start_pressure = setup_.gas->amount / (copies() * rest_volume_);
    share_ = VectorX::Zero(body.size());
    for (const auto& triangle : body.triangles)
      for (const int corner : triangle) share_[corner] += area_vector(body.rest, triangle).norm();
    share_ /= share_.sum();
    find_corners();
    rest_radius_ = radii(body.rest).dot(share_);
    control_stiffness_ = kControlStiffness * material.youngs_modulus * thickness_ / rest_radius_;
  }

  std::string name() const override { return "inflation"; }
  MeasureList measures() const override { return inflation_measures(); }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;
  int load_steps() const override { return setup_.load_steps; }
  double copies() const override { return std::pow(2, setup_.symmetry.size()); }

  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    return {{"radius"}, {"corner_radius"}, {"radius_spread"}, {"pressure"}};
  }

 private:
  friend class InflationRig;
  /// Every side that one triangle alone has must lie in a plane of symmetry.
  void require_closed() const {
    int open = 0;
    for (const auto& [a, b] : boundary_of(body_.triangles)) open += !in_one_plane(a, b);
    if (open > 0)
      throw InputError("inflation needs a closed surface: " + std::to_string(open) +
                       (open == 1 ? " side of a triangle is" : " sides of triangles are") +
                       " at a rim outside the planes of symmetry" +
                       (setup_.symmetry.empty() ? "; of an octant write symmetry: [x, y, z]" : ""));
  }

  bool in_one_plane(int a, int b) const {
    const double near = 1e-9 * body_.rest.cwiseAbs().maxCoeff();
    for (const Vector3& normal : setup_.symmetry)
      if (std::abs(normal.dot(body_.rest.col(a))) <= near && std::abs(normal.dot(body_.rest.col(b))) <= near)
        return true;
    return false;
  }

  /// Corners are the molecules on the axes through the centre.
  void find_corners() {
    const Vector3 centre = centre_of(body_.rest);
    for (int molecule = 0; molecule < body_.size(); ++molecule) {
      const Vector3 arm = setup_.axes.transpose() * (body_.rest.col(molecule) - centre);
      if (arm.norm() - arm.cwiseAbs().maxCoeff() < 1e-9 * arm.norm()) corners_.push_back(molecule);
    }
  }

  /// The middle of the surface; in the planes of symmetry where there are any.
  Vector3 centre_of(const Positions& positions) const {
    Vector3 centre = positions * share_;
    for (const Vector3& normal : setup_.symmetry) centre -= normal.dot(centre) * normal;
    return centre;
  }

  VectorX radii(const Positions& positions) const {
    return (positions.colwise() - centre_of(positions)).colwise().norm().transpose();
  }

  const Body& body_;
  InflationSetup setup_;
  double thickness_;
  FixedMolecules fixed_;
  VectorX share_;  // of the surface at rest, a molecule; sum 1
  std::vector<int> corners_;
  Vector3 apex_;
  double rest_volume_ = 0, rest_radius_ = 0, control_stiffness_ = 0;  // the last times a volume: [Pa]
};

class InflationRig final : public StaticRig {
 public:
  InflationRig(const Inflation& experiment, Model& model)
      : experiment_(experiment), setup_(experiment.setup_), model_(model) {
    for (const auto& [molecule, free] : experiment_.fixed_) model.supports.push_back({molecule, free, Vector3::Zero()});
    auto load = std::make_unique<Pressure>(experiment_.body_, constant_pressure(0), experiment_.apex_, true);
    load_ = load.get();
    model.add(std::move(load));
  }

  void set_load(double factor) override {
    pressure_ = factor == 0 ? 0 : met_pressure_;
    if (setup_.pressure) {
      load_->set_law(constant_pressure(factor * *setup_.pressure));
    } else if (setup_.volume_ratio) {
      volume_ = experiment_.rest_volume_ * std::pow(1 + factor * (std::cbrt(*setup_.volume_ratio) - 1), 3);
      control();
    } else {
      const auto& [_, start, exponent, ambient] = *setup_.gas;
      const double absolute = ambient + factor * (start - ambient);
      load_->set_law(factor == 0 ? constant_pressure(0)
                                 : enclosed_gas(absolute * experiment_.rest_volume_, exponent, ambient));
    }
  }

  bool seeks_load() const override { return setup_.volume_ratio.has_value(); }
  bool adjust(const State& state) override {
    if (!setup_.volume_ratio) return false;
    pressure_ = load_->pressure_state(state.positions).pressure;
    if (std::abs(load_->volume(state.positions) - volume_) <= kVolumeTolerance * volume_) {
      met_pressure_ = pressure_;
      return false;
    }
    control();
    return true;
  }

  double longest_step() const override {
    const double growth = setup_.volume_ratio ? std::abs(std::cbrt(*setup_.volume_ratio) - 1) : 0;
    return growth > kLongestGrowth ? kLongestGrowth / growth : 1;
  }

  Measures measure(const Start&, const State& state, const StaticOptions&, StaticResult& solved) const override {
    const VectorX radius = experiment_.radii(state.positions);
    const double mean = radius.dot(experiment_.share_), pressure = load_->pressure_state(state.positions).pressure;
    Measures measures;
    measures.set("radius", mean);
    measures.set("stretch", mean / experiment_.rest_radius_);
    measures.set("radius_spread", (radius.maxCoeff() - radius.minCoeff()) / mean);
    if (!experiment_.corners_.empty()) {
      double sum = 0;
      for (const int corner : experiment_.corners_) sum += radius[corner];
      measures.set("corner_radius", sum / static_cast<double>(experiment_.corners_.size()));
    }
    measures.set("pressure", pressure);
    measures.set("enclosed_volume", experiment_.copies() * load_->volume(state.positions));
    measures.set("wall_stress", pressure * mean / (2 * experiment_.thickness_));
    const double copies = experiment_.copies(), loads = model_.load_forces(state).colwise().norm().sum();
    add_state(model_, state, solved, copies * loads, measures, copies);
    return measures;
  }

 private:
  void control() { load_->set_law(controlled_volume(volume_, experiment_.control_stiffness_ / volume_, pressure_)); }

  const Inflation& experiment_;
  const InflationSetup& setup_;
  Model& model_;
  double volume_ = 0, pressure_ = 0;  // volume control: the target, and the pressure found last
  double met_pressure_ = 0;           // at the last volume that was met
  Pressure* load_ = nullptr;          // owned by the model
};

std::unique_ptr<StaticRig> Inflation::make_rig(Model& model) const {
  return std::make_unique<InflationRig>(*this, model);
}

}  // namespace

std::unique_ptr<StaticExperiment> make_inflation(const Body& body, const InflationSetup& setup,
                                                 const Material& material) {
  return std::make_unique<Inflation>(body, setup, material);
}

const Keys<GasSetup>& gas_keys() {
  using S = GasSetup;
  static const Keys<S> keys{
      one_of<S>(
          "give one of amount (absolute pressure times volume, n R T) and start_pressure (absolute)",
          {key::quantity("amount", &S::amount, dimension::energy, "absolute pressure times volume, n R T", kPositive),
           key::quantity("start_pressure", &S::start_pressure, dimension::pressure,
                         "absolute pressure in the volume at rest", kPositive)}),
      key::quantity("exponent", &S::exponent, dimension::none,
                    "1: constant temperature; 1.4: air without exchange of heat", {1, 2}),
      key::quantity("ambient", &S::ambient, dimension::pressure, "absolute pressure outside", kNotNegative)};
  return keys;
}

ExperimentInfo inflation_row() {
  using S = InflationSetup;
  return with_keys({.name = "inflation",
                    .summary = "a closed membrane is inflated by pressure, by volume or by gas: radius, wall stress",
                    .measures = inflation_measures()},
                   Keys<S>{one_of<S>("give one of pressure, volume_ratio (volume over that at rest) and gas",
                                     {not_zero(key::quantity("pressure", &S::pressure, dimension::pressure,
                                                             "pressure inside over that outside; not 0"),
                                               &S::pressure),
                                      key::quantity("volume_ratio", &S::volume_ratio, dimension::none,
                                                    "enclosed volume over that at rest", kPositive),
                                      Key<S>({"gas", "map", "", "", "none", "gas that is let in; its keys stand below"},
                                             [](const Reader& value, S& setup, const Frame&) {
                                               Reader map = value;
                                               map.set_section("gas");
                                               setup.gas = gas_keys().read(map);
                                             })}),
                           symmetry_key(&S::symmetry), load_steps_key(&S::load_steps)},
                   [](const ExperimentContext& context, S setup) {
                     setup.axes = context.rotation;
                     return make_inflation(context.body, setup, context.material);
                   });
}

}  // namespace elastin::lab
