#include <cmath>

#include "lab/experiment/bending.h"
#include "lab/experiment/homogenisation.h"
#include "lab/experiment/hydrostatic.h"
#include "lab/experiment/inflation.h"
#include "lab/experiment/shear.h"
#include "lab/experiment/tension.h"
#include "lab/experiment/torsion.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// `fallback` is a direction of the scene, as one that stands there is.
Vector3 read_axis(Reader& reader, const Vector3& fallback, const ExperimentContext& context) {
  const auto axis = reader.find("axis");
  return context.rotation * (axis ? read_direction(*axis) : fallback);
}

/// A direction that must stand across the axis.
Vector3 read_across(const Reader& value, const Vector3& axis, const ExperimentContext& context) {
  const Vector3 direction = context.rotation * read_direction(value);
  if (std::abs(direction.dot(axis)) > 1e-6) value.fail("must be perpendicular to the axis");
  return direction;
}

double read_depth(Reader& reader) {
  const auto depth = reader.find("grip_depth");
  return depth ? depth->quantity(dimension::length, kPositive) : 0;
}

int read_steps(Reader& reader) {
  const auto steps = reader.find("load_steps");
  return steps ? steps->whole(1, 100000) : 1;
}

double not_zero(const Reader& value, double amount) {
  if (amount == 0) value.fail("a load of zero moves nothing: nothing can be measured");
  return amount;
}

/// A quantity that must not be zero, or there is nothing to measure.
double read_amount(const Reader& value, const Dimension& dimension, const Range& range = {}) {
  return not_zero(value, value.quantity(dimension, range));
}

/// The same of an angle [rad].
double read_angle(const Reader& value, const Range& range = {}) { return not_zero(value, value.angle(range)); }

std::unique_ptr<Protocol> read_tension(Reader reader, const ExperimentContext& context) {
  TensionSetup setup;
  const bool compression = reader.at("kind").choice<bool>({{"tension", false}, {"compression", true}});
  setup.axis = read_axis(reader, setup.axis, context);
  const auto force = reader.find("force"), displacement = reader.find("displacement");
  const auto load = [&](const Reader& value, const Dimension& dimension) {
    const double amount = value.quantity(dimension);
    if (amount == 0) value.fail("a load of zero stretches nothing: no modulus can be measured");
    if (compression && amount < 0)
      value.fail("'" + value.text() + "' would pull: compression presses by a positive amount; write " +
                 value.text().substr(value.text().find('-') + 1) + ", or kind: tension to pull");
    return compression ? -amount : amount;
  };
  if (force) setup.force = load(*force, dimension::force);
  if (displacement) setup.displacement = load(*displacement, dimension::length);
  const std::vector<std::pair<std::string, Grip>> grips{{"clamped", Grip::clamped}, {"sliding", Grip::sliding}};
  if (auto grip = reader.find("fixed_grip")) setup.fixed_grip = grip->choice(grips);
  if (auto grip = reader.find("loaded_grip")) setup.loaded_grip = grip->choice(grips);
  if (auto sharing = reader.find("load_sharing"))
    setup.sharing = sharing->choice<LoadSharing>({{"area", LoadSharing::area}, {"molecules", LoadSharing::molecules}});
  if (auto reading = reader.find("reading"))
    setup.reading = reading->choice<Reading>({{"mean", Reading::mean}, {"corner", Reading::corner}});
  if (auto area = reader.find("cross_section")) setup.cross_section = area->quantity(dimension::area, kPositive);
  if (auto length = reader.find("gauge_length")) setup.gauge_length = length->quantity(dimension::length, kPositive);
  if (auto gauge = reader.find("gauge")) {
    const auto planes = gauge->items(2);
    setup.gauge = {planes[0].quantity(dimension::length, kNotNegative),
                   planes[1].quantity(dimension::length, kPositive)};
  }
  setup.grip_depth = read_depth(reader);
  setup.load_steps = read_steps(reader);
  setup.thickness = context.material.thickness;
  reader.finish();
  if (force && displacement) displacement->fail("there is a force already; give one of them");
  if (!force && !displacement) reader.fail("give a force or a displacement");
  return reader.located([&] { return make_tension(context.body, setup); });
}

std::unique_ptr<Protocol> read_shear(Reader reader, const ExperimentContext& context) {
  ShearSetup setup;
  setup.axis = read_axis(reader, setup.axis, context);
  setup.direction = read_across(reader.at("direction"), setup.axis, context);
  if (auto sides = reader.find("sides"))
    setup.sides = sides->choice<Sides>({{"free", Sides::free}, {"affine", Sides::affine}});
  const auto displacement = reader.find("displacement"), strain = reader.find("strain"), angle = reader.find("angle");
  constexpr double upright = 1.57;  // a right angle shears without end
  if (displacement) setup.displacement = read_amount(*displacement, dimension::length);
  if (strain) setup.strain = read_amount(*strain, dimension::none);
  if (angle) setup.strain = std::tan(read_angle(*angle, {-upright, upright, false}));
  if (auto area = reader.find("cross_section")) setup.cross_section = area->quantity(dimension::area, kPositive);
  setup.grip_depth = read_depth(reader);
  setup.load_steps = read_steps(reader);
  reader.finish();
  if (displacement.has_value() + strain.has_value() + angle.has_value() != 1)
    reader.fail("give one of displacement, strain (displacement over height) and angle");
  return reader.located([&] { return make_shear(context.body, setup, context.rotation); });
}

std::unique_ptr<Protocol> read_torsion(Reader reader, const ExperimentContext& context) {
  TorsionSetup setup;
  setup.axis = read_axis(reader, setup.axis, context);
  setup.angle = read_angle(reader.at("angle"));
  setup.straight = context.statics.linear;
  setup.grip_depth = read_depth(reader);
  setup.load_steps = read_steps(reader);
  reader.finish();
  return reader.located([&] { return make_torsion(context.body, setup); });
}

std::unique_ptr<Protocol> read_hydrostatic(Reader reader, const ExperimentContext& context) {
  HydrostaticSetup setup;
  setup.strain = read_amount(reader.at("strain"), dimension::none, {-1, 100, true});
  if (auto sides = reader.find("sides"))
    setup.walls = sides->choice<Walls>({{"sliding", Walls::sliding}, {"affine", Walls::affine}});
  setup.grip_depth = read_depth(reader);
  setup.load_steps = read_steps(reader);
  reader.finish();
  return reader.located([&] { return make_hydrostatic(context.body, setup, context.rotation); });
}

std::unique_ptr<Protocol> read_bending(Reader reader, const ExperimentContext& context) {
  BendingSetup setup;
  setup.axis = read_axis(reader, setup.axis, context);
  setup.direction = read_across(reader.at("direction"), setup.axis, context);
  const auto gravity = reader.find("gravity"), force = reader.find("force");
  if (gravity) setup.gravity = read_amount(*gravity, dimension::acceleration);
  if (force) setup.force = read_amount(*force, dimension::force);
  setup.grip_depth = read_depth(reader);
  setup.load_steps = read_steps(reader);
  reader.finish();
  if (!gravity && !force) reader.fail("give gravity, a force on the tip, or both");
  return reader.located([&] { return make_bending(context.body, setup, context.material); });
}

std::unique_ptr<Protocol> read_homogenisation(Reader reader, const ExperimentContext& context) {
  const double depth = read_depth(reader);
  reader.finish();
  return reader.located([&] { return make_homogenisation(context.body, depth, context.rotation); });
}

std::unique_ptr<Protocol> read_inflation(Reader reader, const ExperimentContext& context) {
  InflationSetup setup;
  setup.axes = context.rotation;
  const auto pressure = reader.find("pressure"), volume = reader.find("volume_ratio"), gas = reader.find("gas");
  if (pressure) setup.pressure = read_amount(*pressure, dimension::pressure);
  if (volume) setup.volume_ratio = volume->quantity(dimension::none, kPositive);
  if (gas) setup.gas = read_gas(*gas);
  if (auto symmetry = reader.find("symmetry"))
    for (const Reader& item : symmetry->items()) {
      setup.symmetry.push_back(context.rotation * read_direction(item));
      for (std::size_t other = 0; other + 1 < setup.symmetry.size(); ++other)
        if (std::abs(setup.symmetry[other].dot(setup.symmetry.back())) > 1e-9)
          item.fail("must be perpendicular to the planes before it");
    }
  setup.load_steps = read_steps(reader);
  reader.finish();
  if (pressure.has_value() + volume.has_value() + gas.has_value() != 1)
    reader.fail("give one of pressure, volume_ratio (volume over that at rest) and gas");
  return reader.located([&] { return make_inflation(context.body, setup, context.material); });
}

const ExperimentKey kSectionKey{"cross_section", "m^2", "without it the hull of all molecules seen along the axis"};

/// Of tension and compression, whose `load` pulls or presses.
std::vector<ExperimentKey> tension_keys(const std::string& load) {
  return {{"axis", "direction", "along which the bar lies; z without it"},
          {"force", "N", load + "; it or a displacement is given"},
          {"displacement", "m", load + "; it or a force is given"},
          {"fixed_grip", "clamped | sliding", "whether the fixed end may slide sideways; sliding without it"},
          {"loaded_grip", "clamped | sliding", "whether the loaded end may slide sideways; sliding without it"},
          {"load_sharing", "area | molecules", "how the loaded end's molecules share a force; by area without it"},
          {"reading", "mean | corner", "where the elongation is read on the loaded end; its mean without it"},
          kSectionKey,
          {"gauge_length", "m", "to which the strain refers; without it the distance between the ends"},
          {"gauge", "[m, m]", "planes from the fixed end between which the elongation is read"},
          kDepthKey,
          kStepsKey};
}

}  // namespace

std::vector<ExperimentInfo> static_experiments() {
  const ExperimentKey axis{"axis", "direction", "along which the body lies; z without it"};
  return {
      {.name = "tension",
       .summary = "a bar is pulled along its axis: effective modulus, Poisson's ratio, stress-strain curve",
       .source = "",
       .keys = tension_keys("on the loaded end, positive pulls"),
       .read = read_tension},
      {.name = "compression",
       .summary = "a bar is pressed along its axis, measured as in tension",
       .source = "",
       .keys = tension_keys("on the loaded end, positive presses"),
       .read = read_tension},
      {.name = "shear",
       .summary = "planes across the axis slide along a direction, at constant height: shear modulus",
       .source = "",
       .keys = {axis,
                {"direction", "direction", "in which the planes slide, across the axis"},
                {"displacement", "m", "of the loaded end; it, strain or angle is given"},
                {"strain", "", "displacement over height"},
                {"angle", "angle", "of shear, below a right angle"},
                {"sides", "free | affine", "whether the whole surface follows the simple shear; free without it"},
                kSectionKey,
                kDepthKey,
                kStepsKey},
       .read = read_shear},
      {.name = "torsion",
       .summary = "one end of a clamped bar is turned about its axis: torque, shear modulus of a rectangle",
       .source = "Timoshenko & Goodier 1970, section 109",
       .keys = {axis, {"angle", "angle", "by which the end is turned"}, kDepthKey, kStepsKey},
       .read = read_torsion},
      {.name = "hydrostatic",
       .summary = "equal strain along all directions: bulk modulus",
       .source = "",
       .keys = {{"strain", "", "of each side, above -1; negative compresses"},
                {"sides", "sliding | affine",
                 "whether smooth walls or the whole surface carry the strain; sliding without it"},
                kDepthKey,
                kStepsKey},
       .read = read_hydrostatic},
      {.name = "bending",
       .summary = "a cantilever bends under its own weight or a force on its tip: effective modulus, deflection",
       .source = "Timoshenko 1921, Cowper 1966",
       .keys = {{"axis", "direction", "from the root to the tip; x without it"},
                {"direction", "direction", "of the load, across the axis"},
                {"gravity", "m/s^2", "acceleration that gives the weight; it, a force or both are given"},
                {"force", "N", "on the tip"},
                kDepthKey,
                kStepsKey},
       .read = read_bending},
      {.name = "inflation",
       .summary = "a closed membrane is blown up by pressure, volume control or gas: radius, wall stress",
       .source = "",
       .keys = {{"pressure", "Pa", "over that outside; it, volume_ratio or gas is given"},
                {"volume_ratio", "", "enclosed volume over that at rest"},
                {"gas", "map", "{amount or start_pressure, exponent, ambient}: gas that is let in"},
                {"symmetry", "[direction, ...]", "normals of planes of symmetry through the origin"},
                kStepsKey},
       .read = read_inflation},
      {.name = "material",
       .summary = "six small strains of the surface: the body's 6 x 6 stiffness matrix and its isotropic means",
       .source = "",
       .keys = {kDepthKey},
       .read = read_homogenisation},
  };
}

}  // namespace elastin::lab
