#include <functional>
#include <map>

#include "c/handles.h"
#include "elastin/core/forces/floor.h"
#include "elastin/core/forces/loads.h"
#include "elastin/core/forces/viscosity.h"

namespace elastin::c {
namespace {

using Values = std::map<std::string, double>;

/// A load by name: what its values are called and what they are where nothing is given, and what it adds to a model.
struct NamedLoad {
  Values defaults;
  std::function<void(Model&, const Values&)> add;
};

double not_negative(const Values& values, const char* name) {
  const double value = values.at(name);
  if (value >= 0) return value;
  throw InputError(std::string(name) + " is " + std::to_string(value) + "; it must be at least 0");
}

Vector3 vector(const Values& values, const char* x, const char* y, const char* z) {
  return {values.at(x), values.at(y), values.at(z)};
}

void add_floor(Model& model, const Values& values) {
  const Vector3 normal = vector(values, "normal_x", "normal_y", "normal_z");
  if (!(normal.norm() > 0)) throw InputError("the floor's normal is zero");
  const Floor floor{vector(values, "x", "y", "z"), normal.normalized(), not_negative(values, "stiffness"),
                    not_negative(values, "damping")};
  if (!(floor.stiffness > 0)) throw InputError("stiffness is 0; give the floor one above 0 [N/m]");
  model.add(make_floor(model.body(), floor));
  if (floor.damping > 0) model.add(make_floor_damping(model.body(), floor));
}

const std::map<std::string, NamedLoad>& known_loads() {
  static const std::map<std::string, NamedLoad> all{
      {"gravity",
       {{{"x", 0}, {"y", 0}, {"z", 0}},
        [](Model& model, const Values& values) {
          model.add(make_gravity(model.body(), vector(values, "x", "y", "z")));
        }}},
      {"stokes_drag",
       {{{"viscosity", 0}},
        [](Model& model, const Values& values) {
          model.add(make_stokes_drag(model.body(), not_negative(values, "viscosity")));
        }}},
      {"quadratic_drag",
       {{{"density", 0}, {"drag_coefficient", 0}},
        [](Model& model, const Values& values) {
          model.add(make_quadratic_drag(model.body(), not_negative(values, "density"),
                                        not_negative(values, "drag_coefficient")));
        }}},
      {"mass_damping",
       {{{"rate", 0}},
        [](Model& model, const Values& values) {
          model.add(make_mass_damping(model.body(), not_negative(values, "rate")));
        }}},
      {"connection_damping",
       {{{"coefficient", 0}},
        [](Model& model, const Values& values) { model.add(make_damping(not_negative(values, "coefficient"))); }}},
      {"floor",
       {{{"x", 0},
         {"y", 0},
         {"z", 0},
         {"normal_x", 0},
         {"normal_y", 0},
         {"normal_z", 1},
         {"stiffness", 0},
         {"damping", 0}},
        add_floor}}};
  return all;
}

template <class Map>
std::vector<std::string> names_of(const Map& map) {
  std::vector<std::string> names;
  for (const auto& [name, _] : map) names.push_back(name);
  return names;
}

void add_load(Model& model, const std::string& name, const elastin_value* values, std::size_t count) {
  const auto load = known_loads().find(name);
  if (load == known_loads().end())
    throw InputError("load '" + name + "' is not known" + suggestion(name, names_of(known_loads())));
  Values taken = load->second.defaults;
  if (count > 0) given(values, "values");
  for (std::size_t i = 0; i < count; ++i) {
    const std::string key = &given(values[i].name, "a value's name");
    if (!taken.contains(key)) throw InputError(name + " has no '" + key + "'" + suggestion(key, names_of(taken)));
    if (!std::isfinite(values[i].value)) throw InputError(name + "'s " + key + " is not finite");
    taken[key] = values[i].value;
  }
  load->second.add(model, taken);
}

}  // namespace
}  // namespace elastin::c

extern "C" elastin_status elastin_add(elastin_simulation* simulation, const char* load, const elastin_value* values,
                                      size_t value_count) {
  using elastin::c::given;
  return elastin::c::guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    if (handle.stepped) throw elastin::InputError("loads are added before the first step");
    elastin::c::add_load(handle.simulation.model(), &given(load, "load"), values, value_count);
  });
}
