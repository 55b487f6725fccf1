#include <algorithm>
#include <limits>

#include "core/model/faces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/share.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

constexpr const char* kFace = "face";

/// The row that stands on the ends of an experiment.
LoadKind face() {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  LoadKind load{
      {kFace,
       "a dead traction on the end of a body or the edge of a sheet, in proportion to the molecules' shares of it",
       "",
       {}}};
  load.parameters = {
      {"side", dimension::none, -1, 1, NAN, "outward normal of the end", false, ValueKind::direction, true},
      {"traction", dimension::pressure, -infinity, infinity, NAN, "force over area at rest", false, ValueKind::vector,
       true}};
  load.check = [](const Body& body, const LoadValues& values) {
    if (!(end_face(body, values.vectors.at("side"), 0).area > 0) && body.triangles.empty())
      throw InputError("the molecules on this side span no area");
  };
  load.add = [](Model& model, const LoadValues& values, const Material* material) {
    const Body& body = model.body();
    const Vector3 side = values.vectors.at("side");
    const Face end = end_face(body, side, 0);
    double area = end.area;
    if (!any_over(body, !body.tetrahedra.empty()) && any_over(body, !body.triangles.empty())) {
      const VectorX own = side_areas(body, end.molecules, side, material ? material->thickness : 0);
      const auto owned = std::count_if(end.molecules.begin(), end.molecules.end(),
                                       [&](int molecule) { return molecule < owned_molecules(body); });
      area = sum_over(body, own.head(owned).sum());  // which come first
    }
    if (!(area > 0)) throw InputError("face: the edge of a sheet needs `material.thickness`");
    model.add(std::make_unique<PointLoads>(body, end.molecules,
                                           area * values.vectors.at("traction") * end.share.transpose()));
  };
  load.of_shares = true;
  return load;
}

/// One value of a load, in the scene's axes.
void read_value(const Reader& reader, const ParameterInfo& info, const Body& body, const Matrix3& rotation,
                LoadValues& values) {
  if (info.kind == ValueKind::direction) {
    values.vectors[info.name] = rotation * reader.direction();
  } else if (info.kind == ValueKind::vector) {
    values.vectors[info.name] = rotation * reader.vector(info.unit, {info.low, info.high, info.above_low});
  } else if (info.kind == ValueKind::molecules) {
    values.molecules[info.name] = read_molecules(reader, body, rotation);
  } else {
    values.numbers[info.name] = read_parameter(reader, info);
  }
}

/// The value that may stand for the whole map: of a load that needs one alone. Else null.
const ParameterInfo* single_value(const LoadKind& load) {
  const auto needed = [](const ParameterInfo& info) { return info.required; };
  if (std::count_if(load.parameters.begin(), load.parameters.end(), needed) != 1) return nullptr;
  return &*std::find_if(load.parameters.begin(), load.parameters.end(), needed);
}

/// A map of values; or, of a load that needs one value alone, that value.
LoadValues read_values(Reader reader, const LoadKind& load, const Body& body, const Matrix3& rotation) {
  LoadValues values;
  if (const ParameterInfo* single = single_value(load); single && !reader.is_map()) {
    read_value(reader, *single, body, rotation, values);
    return values;
  }
  for (const ParameterInfo& info : load.parameters) {
    const auto value = info.required ? std::optional(reader.at(info.name)) : reader.find(info.name);
    if (value) read_value(*value, info, body, rotation, values);
  }
  reader.finish();
  return values;
}

/// Of a gas that the pressure outside presses in from the start: its own may be meant as that over the one outside.
std::string warning_of(const LoadValues& values) {
  if (!values.has("start_pressure") || !values.has("ambient")) return "";
  const double start = values.numbers.at("start_pressure"), ambient = values.numbers.at("ambient");
  if (!(start < ambient)) return "";
  return "start_pressure is absolute, and " + number(start, 6) + " Pa is below `ambient`, " + number(ambient, 6) +
         " Pa: the surface is pressed in from the start; for a pressure of " + number(start, 6) +
         " Pa over that outside, write " + number(ambient + start, 9) + " Pa";
}

/// Adds loads as functions of time.
void vary_loads(Model& model, const std::function<void(Model&)>& add, const TimeFunction& function) {
  Model apart(model.body());
  add(apart);
  for (auto& load : apart.extract_loads()) model.add(make_varying(std::move(load), function));
}

}  // namespace

elastin::Table<LoadKind> scene_loads(const Catalog& catalog) {
  elastin::Table<LoadKind> loads = catalog.loads;
  loads.add(face());
  return loads;
}

/// The first load that has all of these keys; "" where there is none.
std::string load_with(const elastin::Table<LoadKind>& loads, const std::vector<std::string>& keys) {
  for (const auto& load : loads)
    if (!keys.empty() && std::all_of(keys.begin(), keys.end(), [&](const std::string& key) {
          return find_named(load->parameters, key) != nullptr;
        }))
      return load->name;
  return "";
}

SceneLoad read_load(Reader reader, const elastin::Table<LoadKind>& loads, const Body& body, const Material& material,
                    const Matrix3& rotation) {
  const std::vector<std::string> keys = reader.keys();
  if (std::find(keys.begin(), keys.end(), "drag") != keys.end())
    reader.at("drag").fail(
        "is two loads now: write stokes_drag: {viscosity: …} or quadratic_drag: {density: …, drag_coefficient: …}");
  for (const char* key : {"kind", "type", "load"})
    if (std::find(keys.begin(), keys.end(), key) != keys.end())
      if (const Reader kind = reader.at(key); std::any_of(loads.begin(), loads.end(), [&](const auto& load) {
            return kind.is_text() && load->name == kind.text();
          }))
        kind.fail("a load is named by the key before its own: write " + kind.text() + ": {…}, without '" + key + "'");
  std::vector<std::pair<Reader, std::shared_ptr<const LoadKind>>> found;
  std::string names;
  for (const auto& load : loads) {
    if (auto value = reader.find(load->name)) found.emplace_back(*value, load);
    names += (names.empty() ? "" : ", ") + load->name;
  }
  const auto in_time = reader.find("in_time");
  if (found.empty()) {
    std::vector<std::string> own = keys;
    std::erase(own, "in_time");
    if (const std::string meant = load_with(loads, own); !meant.empty())
      reader.fail("a load is named before its own keys: write " + meant + ": {" +
                  joined(own, [](const std::string& key) { return key + ": …"; }) + "}");
  }
  reader.finish();
  if (found.size() != 1) reader.fail("a load is one of " + names + "; write each as an item of its own");
  const Reader value = found.front().first;
  const std::shared_ptr<const LoadKind> kind = found.front().second;
  LoadValues values = read_values(value, *kind, body, rotation);
  values = value.located([&] { return checked_values(*kind, body, std::move(values)); });
  const bool acts_at_rest = kind->acts_at_rest(values);
  const auto add = [kind, values, material](Model& model) { kind->add(model, values, &material); };
  if (!in_time && kind->name == kFace) return {{add}, acts_at_rest};
  const std::string warning = warning_of(values);
  if (!in_time) return {{add, std::pair(kind->name, values)}, acts_at_rest, false, warning};
  const TimeFunction function = read_time_function(*in_time);
  if (!acts_at_rest) in_time->fail("damping and drag do not change in time");
  return {{[add, function](Model& model) { vary_loads(model, add, function); }}, true, true, warning};
}

std::vector<KeySection> load_keys(const Catalog& catalog) {
  std::vector<SceneKey> keys;
  for (const auto& load : scene_loads(catalog)) {
    SceneKey own{load->name, "map", "", "", "none", load->summary};
    const ParameterInfo* single = single_value(*load);
    if (single) {  // it may stand for the map
      own = key_of(*single);
      own.name = load->name;
      own.type += ", or map";
      own.fallback = "none";
      own.text = load->summary;
    }
    keys.push_back(std::move(own));
    for (const ParameterInfo& info : load->parameters) keys.push_back(key_of(info, load->name + "."));
  }
  keys.push_back({"in_time", "time function", "", "", "constant",
                  "factor of this load; not of damping and drag, and not in experiments at rest"});
  return {{"loads", "Loads", "Each item of `loads` is one load, with `in_time` if it changes:", std::move(keys)}};
}

}  // namespace elastin::lab
