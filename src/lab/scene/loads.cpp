#include <cmath>

#include "elastin/core/forces/air.h"
#include "elastin/core/forces/floor.h"
#include "lab/experiment/faces.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

SceneLoad read_drag(Reader reader) {
  const bool stokes = reader.at("kind").choice<bool>({{"stokes", true}, {"quadratic", false}});
  if (stokes) {
    const double viscosity = reader.at("viscosity").quantity(dimension::viscosity, kNotNegative);
    reader.finish();
    return {[=](Model& model) { model.add(make_stokes_drag(model.body(), viscosity)); }, false};
  }
  const double density = reader.at("density").quantity(dimension::density, kNotNegative);
  const double coefficient = reader.at("drag_coefficient").quantity(dimension::none, kNotNegative);
  reader.finish();
  return {[=](Model& model) { model.add(make_quadratic_drag(model.body(), density, coefficient)); }, false};
}

SceneLoad read_damping(const Reader& reader, const Body&) {
  const double coefficient = reader.quantity(dimension::damping, kNotNegative);
  return {[=](Model& model) { model.add(make_damping(coefficient)); }, false};
}

SceneLoad read_cell_damping(Reader reader, const Body& body) {
  const double bulk = reader.at("bulk").quantity(dimension::viscosity, kNotNegative);
  const double shear = reader.at("shear").quantity(dimension::viscosity, kNotNegative);
  reader.finish();
  if (body.tetrahedra.empty()) reader.fail("needs a body with tetrahedra; `damping` works on connections");
  return {[=](Model& model) { model.add(make_cell_damping(model.body(), bulk, shear)); }, false};
}

/// Rayleigh's: α M + β K.
SceneLoad read_rayleigh(Reader reader) {
  const auto mass = reader.find("mass"), stiffness = reader.find("stiffness");
  const double rate = mass ? mass->quantity({0, 0, -1}, kNotNegative) : 0;
  const double time = stiffness ? stiffness->quantity(dimension::time, kNotNegative) : 0;
  reader.finish();
  if (!mass && !stiffness) reader.fail("give mass (a rate), stiffness (a time), or both");
  return {[=](Model& model) {
            if (rate > 0) model.add(make_mass_damping(model.body(), rate));
            if (time > 0)
              for (const auto& law : model.elasticity()) model.add(make_stiffness_damping(model.body(), *law, time));
          },
          false};
}

SceneLoad read_floor(Reader reader, const Body& body, const Material& material, const Matrix3& rotation) {
  Floor floor;
  floor.point = rotation * reader.at("point").vector(dimension::length);
  floor.normal = rotation * read_direction(reader.at("normal"));
  floor.stiffness = default_floor_stiffness(body, material);
  if (auto stiffness = reader.find("stiffness")) floor.stiffness = stiffness->quantity(dimension::stiffness, kPositive);
  if (auto damping = reader.find("damping")) floor.damping = damping->quantity(dimension::damping, kNotNegative);
  reader.finish();
  return {[=](Model& model) {
    model.add(make_floor(model.body(), floor));
    if (floor.damping > 0) model.add(make_floor_damping(model.body(), floor));
  }};
}

SceneLoad read_air(Reader reader, const Body& body, const Matrix3& rotation) {
  Air air;
  if (auto density = reader.find("density")) air.density = density->quantity(dimension::density, kNotNegative);
  if (auto drag = reader.find("drag_coefficient")) air.drag_coefficient = drag->quantity(dimension::none, kNotNegative);
  if (auto skin = reader.find("skin_coefficient")) air.skin_coefficient = skin->quantity(dimension::none, kNotNegative);
  if (auto caught = reader.find("pressure_coefficient"))
    air.pressure_coefficient = caught->quantity(dimension::none, kNotNegative);
  if (auto wind = reader.find("wind")) air.wind = rotation * wind->vector(dimension::velocity);
  reader.finish();
  if (body.triangles.empty()) reader.fail("air drags on triangles and the body has none; `drag` works on molecules");
  return {[=](Model& model) { model.add(make_air(model.body(), air)); }, air.wind.norm() > 0};
}

/// Adds loads as functions of time.
void vary_loads(Model& model, const std::function<void(Model&)>& add, const TimeFunction& function) {
  Model apart(model.body());
  add(apart);
  for (auto& load : apart.extract_loads()) model.add(make_varying(std::move(load), function));
}

SceneLoad read_point(Reader reader, const Body& body, const Matrix3& rotation) {
  std::vector<int> molecules;
  for (const Reader& item : reader.at("molecules").items()) molecules.push_back(item.whole(0, body.size() - 1));
  const Vector3 force = rotation * reader.at("force").vector(dimension::force);
  reader.finish();
  return {[=](Model& model) {
    model.add(std::make_unique<PointLoads>(model.body(), molecules,
                                           force.replicate(1, static_cast<Eigen::Index>(molecules.size()))));
  }};
}

SceneLoad read_face(Reader reader, const Body& body, const Matrix3& rotation) {
  const Vector3 side = rotation * read_direction(reader.at("side"));
  const Vector3 traction = rotation * reader.at("traction").vector(dimension::pressure);
  reader.finish();
  const Face face = reader.located([&] { return end_face(body, side, 0); });
  if (!(face.area > 0)) reader.fail("the molecules on this side span no area");
  return {[=](Model& model) {
    model.add(
        std::make_unique<PointLoads>(model.body(), face.molecules, face.area * traction * face.share.transpose()));
  }};
}

}  // namespace

double default_floor_stiffness(const Body& body, const Material& material) {
  return material.youngs_modulus * 2 * body.radius.mean();
}

TimeFunction read_time_function(Reader reader) {
  if (!reader.is_map()) reader.fail("write {ramp: …}, {step: …}, {sine: …} or {table: [[time, factor], …]}");
  const auto ramp = reader.find("ramp"), step = reader.find("step"), sine = reader.find("sine"),
             table = reader.find("table");
  reader.finish();
  if (ramp.has_value() + step.has_value() + sine.has_value() + table.has_value() != 1)
    reader.fail("a function of time is one of ramp, step, sine, table");
  const auto only = [](Reader map, const char* key, const Range& range) {
    const double value = map.at(key).quantity(dimension::time, range);
    map.finish();
    return value;
  };
  if (ramp) return TimeFunction::ramp(only(*ramp, "duration", kPositive));
  if (step) return TimeFunction::step(only(*step, "at", kNotNegative));
  if (table) {
    std::vector<std::pair<double, double>> points;
    for (const Reader& item : table->items()) {
      const auto pair = item.items(2);
      points.emplace_back(pair[0].quantity(dimension::time), pair[1].quantity(dimension::none));
      if (points.size() > 1 && points.back().first < points[points.size() - 2].first)
        pair[0].fail("the times of a table must not fall");
    }
    return table->located([&] { return TimeFunction(std::move(points)); });
  }
  Reader wave = *sine;
  const double frequency = wave.at("frequency").quantity({0, 0, -1}, kPositive);
  const auto phase = wave.find("phase"), mean = wave.find("mean");
  wave.finish();
  return TimeFunction::sine(frequency, phase ? phase->quantity(dimension::none) : 0,
                            mean ? mean->quantity(dimension::none) : 0);
}

SceneLoad read_load(Reader reader, const Body& body, const Material& material, const Matrix3& rotation) {
  using Read = std::function<SceneLoad(const Reader&)>;
  const std::vector<std::pair<std::string, Read>> kinds{
      {"gravity",
       [&](const Reader& value) -> SceneLoad {
         const Vector3 acceleration = rotation * value.vector(dimension::acceleration);
         return {[=](Model& model) { model.add(make_gravity(model.body(), acceleration)); }};
       }},
      {"drag", read_drag},
      {"air", [&](const Reader& value) { return read_air(value, body, rotation); }},
      {"damping", [&](const Reader& value) { return read_damping(value, body); }},
      {"cell_damping", [&](const Reader& value) { return read_cell_damping(value, body); }},
      {"rayleigh", read_rayleigh},
      {"floor", [&](const Reader& value) { return read_floor(value, body, material, rotation); }},
      {"point", [&](const Reader& value) { return read_point(value, body, rotation); }},
      {"face", [&](const Reader& value) { return read_face(value, body, rotation); }},
      {"pressure", [&](const Reader& value) { return read_pressure(value, body); }},
      {"gas", [&](const Reader& value) { return read_gas_load(value, body); }}};
  std::vector<std::pair<Reader, Read>> found;
  std::string names;
  for (const auto& [name, read] : kinds) {
    if (auto value = reader.find(name)) found.emplace_back(*value, read);
    names += (names.empty() ? "" : ", ") + name;
  }
  const auto in_time = reader.find("in_time");
  reader.finish();
  if (found.size() != 1) reader.fail("a load is one of " + names + "; write each as an item of its own");
  const auto& [value, read] = found.front();
  SceneLoad load = read(value);
  if (!in_time) return load;
  const TimeFunction function = read_time_function(*in_time);
  if (!load.acts_at_rest) in_time->fail("damping and drag do not change in time");
  return {[add = load.add, function](Model& model) { vary_loads(model, add, function); }, true, true};
}

}  // namespace elastin::lab
