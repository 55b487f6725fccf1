#include <cmath>

#include "lab/experiment/bending/bending.h"
#include "lab/experiment/biaxial/biaxial.h"
#include "lab/experiment/homogenisation/homogenisation.h"
#include "lab/experiment/hydrostatic/hydrostatic.h"
#include "lab/experiment/inflation/inflation.h"
#include "lab/experiment/shear/shear.h"
#include "lab/experiment/tension/tension.h"
#include "lab/experiment/torsion/torsion.h"
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

std::unique_ptr<Experiment> read_bar(Reader reader, const ExperimentContext& context, bool compression) {
  TensionSetup setup;
  setup.axis = read_axis(reader, setup.axis, context);
  const auto force = reader.find("force"), displacement = reader.find("displacement"), strain = reader.find("strain"),
             gravity = reader.find("gravity");
  if (displacement) refuse_percent(*displacement);
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
  if (strain) setup.strain = load(*strain, dimension::none);
  if (gravity) setup.gravity = load(*gravity, dimension::acceleration);
  if (strain && *setup.strain <= -1) strain->fail("'" + strain->text() + "' leaves nothing of the body's length");
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
  if (auto cycle = reader.find("cycle"))
    for (const Reader& item : cycle->items()) {
      setup.cycle.push_back(item.quantity(dimension::none, {0, 1, false}));
      const double before = setup.cycle.size() > 1 ? setup.cycle[setup.cycle.size() - 2] : 0;
      if (setup.cycle.back() == before)
        item.fail("the load is there already: each part must differ from the one before");
    }
  setup.thickness = context.material.thickness;
  reader.finish();
  const char* first = nullptr;
  for (const auto& [name, given] :
       {std::pair{"force", &force}, {"displacement", &displacement}, {"strain", &strain}, {"gravity", &gravity}}) {
    if (*given && first) (*given)->fail(std::string("there is a ") + first + " already; give one of them");
    if (*given) first = name;
  }
  if (!first) reader.fail("give a force or a displacement, or a strain, for example strain: 10 %");
  return reader.located([&] { return make_tension(context.body, setup); });
}

std::unique_ptr<Experiment> read_tension(Reader& reader, const ExperimentContext& context) {
  return read_bar(reader, context, false);
}

std::unique_ptr<Experiment> read_compression(Reader& reader, const ExperimentContext& context) {
  return read_bar(reader, context, true);
}

/// Of biaxial tension two strains or one for both; of planar tension the second is 0.
std::unique_ptr<Experiment> read_two_axes(Reader& reader, const ExperimentContext& context, bool planar) {
  BiaxialSetup setup;
  const auto axis = reader.find("axis"), across = reader.find("across");
  setup.first = context.rotation * (axis ? read_direction(*axis) : setup.first);
  setup.second = across ? read_across(*across, setup.first, context) : Vector3(context.rotation * setup.second);
  if (std::abs(setup.first.dot(setup.second)) > 1e-6)
    (across ? *across : *axis).fail("must be perpendicular to the other axis; give both `axis` and `across`");
  const Reader strain = reader.at("strain");
  const Range range{-1, 100, true};
  if (planar || strain.is_text()) {
    setup.first_strain = read_amount(strain, dimension::none, range);
    setup.second_strain = planar ? 0 : setup.first_strain;
  } else {
    const auto both = strain.items(2);
    setup.first_strain = read_amount(both[0], dimension::none, range);
    setup.second_strain = both[1].quantity(dimension::none, range);
  }
  setup.thickness = context.material.thickness;
  setup.grip_depth = read_depth(reader);
  setup.load_steps = read_steps(reader);
  reader.finish();
  return reader.located([&] { return make_biaxial(context.body, setup, planar ? "planar" : "biaxial"); });
}

std::unique_ptr<Experiment> read_biaxial(Reader& reader, const ExperimentContext& context) {
  return read_two_axes(reader, context, false);
}

std::unique_ptr<Experiment> read_planar(Reader& reader, const ExperimentContext& context) {
  return read_two_axes(reader, context, true);
}

std::unique_ptr<Experiment> read_shear(Reader reader, const ExperimentContext& context) {
  ShearSetup setup;
  setup.axis = read_axis(reader, setup.axis, context);
  setup.direction = read_across(reader.at("direction"), setup.axis, context);
  if (auto sides = reader.find("sides"))
    setup.sides = sides->choice<Sides>({{"free", Sides::free}, {"affine", Sides::affine}});
  const auto displacement = reader.find("displacement"), strain = reader.find("strain"), angle = reader.find("angle");
  constexpr double upright = 1.57;  // a right angle shears without end
  if (displacement) refuse_percent(*displacement);
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

std::unique_ptr<Experiment> read_torsion(Reader reader, const ExperimentContext& context) {
  TorsionSetup setup;
  setup.axis = read_axis(reader, setup.axis, context);
  setup.angle = read_angle(reader.at("angle"));
  setup.straight = context.statics.linear;
  setup.grip_depth = read_depth(reader);
  setup.load_steps = read_steps(reader);
  reader.finish();
  return reader.located([&] { return make_torsion(context.body, setup); });
}

std::unique_ptr<Experiment> read_hydrostatic(Reader reader, const ExperimentContext& context) {
  HydrostaticSetup setup;
  setup.strain = read_amount(reader.at("strain"), dimension::none, {-1, 100, true});
  if (auto sides = reader.find("sides"))
    setup.walls = sides->choice<Walls>({{"sliding", Walls::sliding}, {"affine", Walls::affine}});
  setup.grip_depth = read_depth(reader);
  setup.load_steps = read_steps(reader);
  reader.finish();
  return reader.located([&] { return make_hydrostatic(context.body, setup, context.rotation); });
}

std::unique_ptr<Experiment> read_bending(Reader reader, const ExperimentContext& context) {
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

std::unique_ptr<Experiment> read_homogenisation(Reader reader, const ExperimentContext& context) {
  const double depth = read_depth(reader);
  reader.finish();
  return reader.located([&] { return make_homogenisation(context.body, depth, context.rotation); });
}

std::unique_ptr<Experiment> read_inflation(Reader reader, const ExperimentContext& context) {
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

const SceneKey kSectionKey{
    "cross_section",
    "quantity",
    "m^2",
    "> 0",
    "volume over length of the cells, between the planes of `gauge` if there are any; without cells the "
    "hull of the molecules along the axis",
    "section A that carries the load"};

/// Of tension and compression, whose load pulls or presses.
std::vector<SceneKey> tension_keys() {
  const std::string grip = "whether the end is also fixed sideways";
  return {{"axis", "direction", "", "", "`z`", "axis of the bar, from the fixed end to the loaded one"},
          {"force", "quantity", "N", "", "one of four needed", "force on the loaded end; not 0"},
          {"displacement", "quantity", "m", "", "one of four needed", "displacement of the loaded end; not 0"},
          {"strain", "number", "", "", "one of four needed",
           "that displacement over the distance of the end layers; not 0"},
          {"gravity", "quantity", "m/s^2", "", "one of four needed",
           "acceleration by which the body's own weight is the load: under tension it hangs from its fixed end, under "
           "compression it stands on it; not 0"},
          {"fixed_grip", "`clamped`, `sliding`", "", "", "`sliding`", grip},
          {"loaded_grip", "`clamped`, `sliding`", "", "", "`sliding`", grip},
          {"load_sharing", "`area`, `molecules`", "", "", "`area`",
           "how the molecules of the loaded end share a force: by tributary areas, or equally"},
          {"reading", "`mean`, `corner`", "", "", "`mean`", "elongation of the loaded end, or of one corner molecule"},
          kSectionKey,
          {"gauge_length", "quantity", "m", "> 0", "between the end layers", "length l₀ to which the strain refers"},
          {"gauge", "two quantities", "m", "≥ 0, > 0", "none",
           "planes, measured from the fixed end, between which an extensometer reads"},
          kDepthKey,
          kStepsKey,
          {"cycle", "list of numbers", "", "0 … 1", "`[1]`",
           "parts of the load that are reached one after the other, each in `load_steps`: [1, 0, 1]"}};
}

}  // namespace

void refuse_percent(const Reader& length) {
  if (length.is_text() && length.text().ends_with('%'))
    length.fail("'" + length.text() + "' is no length; write strain: " + length.text());
}

std::optional<double> read_travel(Reader& reader, const char* key, const Body& body, const Vector3& axis) {
  const auto length = reader.find(key), strain = reader.find("strain");
  if (length && strain) strain->fail(std::string("there is a ") + key + " already; give one of them");
  if (length) refuse_percent(*length);
  if (length) return length->quantity(dimension::length, kPositive);
  if (!strain) return std::nullopt;
  const VectorX heights = body.rest.transpose() * axis;
  const double height = heights.maxCoeff() - heights.minCoeff();
  if (!(height > 0)) strain->fail(std::string("the body has no height along the axis: give a ") + key);
  return strain->quantity(dimension::none, kPositive) * height;
}

std::vector<ExperimentInfo> static_experiments() {
  const SceneKey axis{"axis", "direction", "", "", "`z`", "axis of the body, from the fixed end to the loaded one"};
  const SceneKey along{"axis", "direction", "", "", "`x`", "first direction, in which the body is stretched"};
  const SceneKey across{"across", "direction", "", "", "`y`", "second direction, perpendicular to it"};
  return {
      {.name = "tension",
       .summary = "a bar is pulled along its axis: effective modulus, Poisson's ratio, stress–strain curve",
       .source = "",
       .of_shares = true,
       .keys = tension_keys(),
       .read = read_tension},
      {.name = "compression",
       .summary = "a bar is pressed along its axis and measured as in tension",
       .source = "",
       .of_shares = true,
       .keys = tension_keys(),
       .read = read_compression},
      {.name = "biaxial",
       .summary = "a block or sheet is stretched along two directions between smooth grips, free along the third",
       .source = "Timoshenko & Goodier 1970, section 6",
       .of_shares = true,
       .keys = {along,
                across,
                {"strain", "number, or two numbers", "", "> −1 … 100", "needed",
                 "nominal strain along both, or along each; the first is not 0"},
                kDepthKey,
                kStepsKey},
       .read = read_biaxial},
      {.name = "planar",
       .summary = "a block or sheet is stretched along one direction and keeps its width along another: pure shear",
       .source = "Timoshenko & Goodier 1970, section 6",
       .of_shares = true,
       .keys = {along,
                across,
                {"strain", "number", "", "> −1 … 100", "needed", "nominal strain along `axis`; not 0"},
                kDepthKey,
                kStepsKey},
       .read = read_planar},
      {.name = "shear",
       .summary = "planes across the axis slide along a direction, at constant height: shear modulus",
       .source = "",
       .of_shares = true,
       .keys = {axis,
                {"direction", "direction", "", "", "needed", "direction of the displacement, perpendicular to `axis`"},
                {"displacement", "quantity", "m", "", "one of three needed", "displacement of the loaded end; not 0"},
                {"strain", "number", "", "", "one of three needed", "displacement over height; not 0"},
                {"angle", "angle", "", "−1.57 … 1.57", "one of three needed", "angle of shear; not 0"},
                {"sides", "`free`, `affine`", "", "", "`free`",
                 "whether two rigid plates carry the shear, or the whole surface follows it"},
                kSectionKey,
                kDepthKey,
                kStepsKey},
       .read = read_shear},
      {.name = "torsion",
       .summary =
           "one end of a clamped bar is turned about its axis at constant height: torque, shear modulus of a rectangle",
       .source = "Timoshenko & Goodier 1970, section 109",
       .of_shares = true,
       .keys = {axis, {"angle", "angle", "", "", "needed", "rotation of the turned end; not 0"}, kDepthKey, kStepsKey},
       .read = read_torsion},
      {.name = "hydrostatic",
       .summary = "equal strain along all directions: bulk modulus",
       .source = "",
       .of_shares = true,
       .keys = {{"strain", "number", "", "> −1 … 100", "needed", "strain of each side; negative compresses; not 0"},
                {"sides", "`sliding`, `affine`", "", "", "`sliding`",
                 "whether six smooth walls carry the strain, or the whole surface follows it"},
                kDepthKey,
                kStepsKey},
       .read = read_hydrostatic},
      {.name = "bending",
       .summary = "a cantilever bends under its own weight or a force on its tip: effective modulus, deflection",
       .source = "Timoshenko 1921, Cowper 1966",
       .of_shares = true,
       .keys = {{"axis", "direction", "", "", "`x`", "from the clamped root to the tip"},
                {"direction", "direction", "", "", "needed", "direction of the load, perpendicular to `axis`"},
                {"gravity", "quantity", "m/s^2", "", "this, `force` or both",
                 "acceleration that gives the weight; not 0"},
                {"force", "quantity", "N", "", "this, `gravity` or both", "force on the tip; not 0"},
                kDepthKey,
                kStepsKey},
       .read = read_bending},
      {.name = "inflation",
       .summary = "a closed membrane is inflated by pressure, by volume or by gas: radius, wall stress",
       .source = "",
       .keys = {{"pressure", "quantity", "Pa", "", "one of three needed", "pressure inside over that outside; not 0"},
                {"volume_ratio", "number", "", "> 0", "one of three needed", "enclosed volume over that at rest"},
                {"gas", "map", "", "", "one of three needed", "gas that is let in; its keys stand below"},
                kSymmetryKey,
                kStepsKey},
       .read = read_inflation},
      {.name = "material",
       .summary = "six small strains of the surface: the body's 6 × 6 stiffness matrix and its isotropic means",
       .source = "",
       .keys = {kDepthKey},
       .read = read_homogenisation},
  };
}

}  // namespace elastin::lab
