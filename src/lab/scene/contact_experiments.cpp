#include <algorithm>
#include <cmath>

#include "elastin/core/model/parts.h"
#include "lab/experiment/indentation/indentation.h"
#include "lab/experiment/press/press.h"
#include "lab/experiment/sliding/sliding.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

contact::ContactOptions& contact_of_scene(const Reader& reader, const ExperimentContext& context) {
  if (!context.contact)
    reader.fail("needs contact: key 'contact' of the scene is missing, for example contact: {friction: 0.3}");
  return *context.contact;
}

Vector3 read_direction_of_motion(Reader& reader, const ExperimentContext& context) {
  const auto axis = reader.find("axis");
  return context.rotation * (axis ? read_direction(*axis) : Vector3(-Vector3::UnitZ()));
}

Grip read_grip(const Reader& reader) {
  return reader.choice<Grip>({{"clamped", Grip::clamped}, {"sliding", Grip::sliding}});
}

/// sphere: {radius: 5 mm}, flat: {radius: 5 mm}, or an obstacle's name.
void read_indenter(Reader reader, IndentationSetup& setup) {
  if (reader.is_text()) {
    setup.shape = IndenterShape::obstacle;
    setup.obstacle = reader.text();
    return;
  }
  const auto sphere = reader.find("sphere"), flat = reader.find("flat");
  reader.finish();
  if (sphere.has_value() == flat.has_value())
    reader.fail("write {sphere: {radius: 5 mm}}, {flat: {radius: 5 mm}}, or the name of an obstacle");
  setup.shape = sphere ? IndenterShape::sphere : IndenterShape::flat;
  Reader form = sphere ? *sphere : *flat;
  setup.radius = form.at("radius").quantity(dimension::length, kPositive);
  form.finish();
}

std::vector<int> molecules_named(const Reader& name, const Body& body) {
  return name.located([&] { return molecules_of(find_part(body, name.text())); });
}

std::unique_ptr<Experiment> read_indentation(Reader reader, const ExperimentContext& context) {
  IndentationSetup setup;
  setup.axis = read_direction_of_motion(reader, context);
  read_indenter(reader.at("indenter"), setup);
  setup.depth = read_travel(reader, "depth", context.body, setup.axis);
  const auto force = reader.find("force"), at = reader.find("at");
  if (force) setup.force = force->quantity(dimension::force, kPositive);
  if (at) setup.at = context.rotation * at->vector(dimension::length);
  if (auto bottom = reader.find("bottom")) setup.bottom = read_grip(*bottom);
  if (auto grip = reader.find("grip_depth")) setup.grip_depth = grip->quantity(dimension::length, kPositive);
  if (auto symmetry = reader.find("symmetry"))
    for (const Reader& item : symmetry->items()) {
      const Vector3 normal = context.rotation * read_direction(item);
      if (std::abs(normal.dot(setup.axis)) > 1e-9) item.fail("must be perpendicular to the indenter's axis");
      for (const Vector3& other : setup.symmetry)
        if (std::abs(other.dot(normal)) > 1e-9) item.fail("must be perpendicular to the planes before it");
      setup.symmetry.push_back(normal);
    }
  if (auto steps = reader.find("load_steps")) setup.load_steps = steps->whole(1, 100000);
  reader.finish();
  if (setup.depth.has_value() == force.has_value()) reader.fail("give one of depth, strain and force");
  if (force && setup.shape == IndenterShape::obstacle) force->fail("of an obstacle give the depth");
  if (at && setup.shape == IndenterShape::obstacle) at->fail("an obstacle begins where the scene has it");
  contact::ContactOptions& contact = contact_of_scene(reader, context);
  return reader.located([&] { return make_indentation(context.body, setup, context.material, contact); });
}

std::unique_ptr<Experiment> read_press(Reader reader, const ExperimentContext& context) {
  PressSetup setup;
  setup.axis = read_direction_of_motion(reader, context);
  setup.displacement = read_travel(reader, "displacement", context.body, setup.axis);
  const auto force = reader.find("force");
  if (force) setup.force = force->quantity(dimension::force, kPositive);
  const auto move = reader.find("move"), fixed = reader.find("fix");
  if (move) setup.moved = molecules_named(*move, context.body);
  if (fixed) setup.fixed = molecules_named(*fixed, context.body);
  // What is rigid and is not moved stays where it is.
  const auto stays = [&](const Part& part) { return part.rigid && part.name != move->text(); };
  if (move && !fixed && std::any_of(context.body.parts.begin(), context.body.parts.end(), stays)) setup.fixed.emplace();
  if (auto grip = reader.find("grip")) setup.grip = read_grip(*grip);
  if (auto grip = reader.find("grip_depth")) setup.grip_depth = grip->quantity(dimension::length, kPositive);
  if (auto steps = reader.find("load_steps")) setup.load_steps = steps->whole(1, 100000);
  reader.finish();
  if (setup.displacement.has_value() == force.has_value()) reader.fail("give one of displacement, strain and force");
  contact_of_scene(reader, context);
  return reader.located([&] { return make_press(context.body, setup); });
}

std::unique_ptr<Experiment> read_sliding(Reader reader, const ExperimentContext& context) {
  constexpr Range slope{0, 1.57, false};  // up to a right angle
  SlidingSetup setup;
  const auto up = reader.find("up"), along = reader.find("along");
  setup.up = context.rotation * (up ? read_direction(*up) : setup.up);
  setup.along = context.rotation * (along ? read_direction(*along) : setup.along);
  if (std::abs(setup.up.dot(setup.along)) > 1e-6)
    (along ? *along : up ? *up : reader).fail("`along` must be perpendicular to `up`, the normal of the plane");
  if (auto gravity = reader.find("gravity")) setup.gravity = gravity->quantity(dimension::acceleration, kPositive);
  if (auto floor = reader.find("floor")) setup.floor = floor->text();
  auto incline = reader.find("incline"), sled = reader.find("sled"), threshold = reader.find("threshold");
  reader.finish();
  if (incline.has_value() + sled.has_value() + threshold.has_value() != 1)
    reader.fail("give one of incline: {angle}, sled: {speed} and threshold: {from, rate}");
  if (incline) setup.angle = incline->at("angle").angle(slope);
  if (sled) setup.speed = sled->at("speed").quantity(dimension::velocity, kPositive);
  if (threshold) {
    setup.angle = threshold->at("from").angle(slope);
    setup.rate = threshold->at("rate").quantity({0, 0, -1}, kPositive);
  }
  (incline ? *incline : sled ? *sled : *threshold).finish();
  setup.kind = incline ? SlidingKind::incline : sled ? SlidingKind::sled : SlidingKind::threshold;
  contact::ContactOptions& contact = contact_of_scene(reader, context);
  return reader.located([&] { return make_sliding(context.body, setup, contact); });
}

}  // namespace

std::vector<ExperimentInfo> contact_experiments() {
  const SceneKey axis{"axis", "direction", "", "", "`-z`", "direction of the motion"};
  return {
      {.name = "indentation",
       .summary = "a rigid indenter is pressed into a body that stands on its far end: force, indentation modulus; "
                  "needs `contact`",
       .source = "Johnson 1985, ch. 3, 4",
       .keys = {axis,
                {"indenter", "map, or an obstacle's name", "", "", "needed", "what is pressed into the body"},
                {"indenter.sphere.radius", "quantity", "m", "> 0", "this, or `flat`", "radius of a sphere"},
                {"indenter.flat.radius", "quantity", "m", "> 0", "this, or `sphere`", "radius of a flat punch"},
                {"depth", "quantity", "m", "> 0", "one of three needed", "depth from the first contact point"},
                travel_strain_key("depth", "one of three needed"),
                {"force", "quantity", "N", "> 0", "one of three needed",
                 "force, of the whole body, that ends the motion; not of an obstacle"},
                {"at", "vector", "m", "", "the middle", "a position on the indenter's axis; not of an obstacle"},
                {"bottom", "`clamped`, `sliding`", "", "", "`clamped`", "how the far end is fixed"},
                kDepthKey,
                kSymmetryKey,
                kStepsKey},
       .read = read_indentation},
      {.name = "press",
       .summary =
           "a body, or the near end of one, is pressed onto what lies before it: force, contact area; needs `contact`",
       .source = "",
       .keys = {axis,
                {"displacement", "quantity", "m", "> 0", "one of three needed", "displacement of what is moved"},
                travel_strain_key("displacement", "one of three needed"),
                {"force", "quantity", "N", "> 0", "one of three needed", "force that ends the motion"},
                {"move", "a body's name", "", "", "the near end", "what is moved"},
                {"fix", "a body's name", "", "", "the far end, or rigid bodies", "what is fixed"},
                {"grip", "`clamped`, `sliding`", "", "", "`clamped`", "how both are fixed across the axis"},
                kDepthKey,
                kStepsKey},
       .read = read_press},
      {.name = "sliding",
       .summary = "a body lies on a plane that is tilted, or slides along it: friction, slip angle; needs `contact`",
       .source = "",
       .in_time = true,
       .keys = {{"up", "direction", "", "", "`z`", "normal of the plane"},
                {"along", "direction", "", "", "`x`", "direction down the slope, perpendicular to `up`"},
                {"gravity", "quantity", "m/s^2", "> 0", "9.81", "acceleration of the weight"},
                {"floor", "an obstacle's name", "", "", "a plane of its own", "what the body stands on"},
                {"incline.angle", "angle", "", "0 … 1.57", "one of three needed", "constant slope"},
                {"sled.speed", "quantity", "m/s", "> 0", "one of three needed", "initial speed along a level floor"},
                {"threshold.from", "angle", "", "0 … 1.57", "one of three needed", "slope at time 0, which grows"},
                {"threshold.rate", "quantity", "1/s", "> 0", "needed with `from`", "rate at which the slope grows"}},
       .read = read_sliding},
  };
}

}  // namespace elastin::lab
