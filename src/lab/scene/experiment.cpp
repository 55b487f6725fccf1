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

std::unique_ptr<Experiment> read_tension(Reader reader, const ExperimentContext& context) {
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
  reader.finish();
  if (force && displacement) displacement->fail("there is a force already; give one of them");
  if (!force && !displacement) reader.fail("give a force or a displacement");
  return reader.located([&] { return make_tension(context.body, setup); });
}

std::unique_ptr<Experiment> read_shear(Reader reader, const ExperimentContext& context) {
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

}  // namespace

std::unique_ptr<Experiment> read_experiment(Reader reader, const ExperimentContext& context) {
  const Reader kind = reader.at("kind");
  if (auto timed = read_timed_experiment(reader, kind.text(), context)) return timed;
  const auto read = kind.choice<std::unique_ptr<Experiment> (*)(Reader, const ExperimentContext&)>(
      {{"tension", read_tension},
       {"compression", read_tension},
       {"shear", read_shear},
       {"torsion", read_torsion},
       {"hydrostatic", read_hydrostatic},
       {"bending", read_bending},
       {"inflation", read_inflation},
       {"bubble", read_bubble},
       {"material", read_homogenisation},
       {"indentation", read_indentation},
       {"press", read_press},
       // Known here for the list of names; read above.
       {"motion", nullptr},
       {"release", nullptr},
       {"creep", nullptr},
       {"relaxation", nullptr},
       {"shake", nullptr},
       {"drop", nullptr},
       {"sliding", nullptr},
       {"parachute", nullptr},
       {"vibration", nullptr}});
  return read(reader, context);
}

}  // namespace elastin::lab
