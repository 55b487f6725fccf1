#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "c/handles.h"
#include "elastin/core/forces/load_table.h"

namespace elastin::c {
namespace {

bool is_vector(const ParameterInfo& info) {
  return info.kind == ValueKind::vector || info.kind == ValueKind::direction;
}

/// What numbers by name mean: NAME_x, NAME_y and NAME_z of a vector or direction, or NAME for each of the three; NAME
/// once for each of molecules.
LoadValues load_values(const LoadKind& load, const elastin_value* values, std::size_t count) {
  LoadValues found;
  if (count > 0) given(values, "values");
  std::vector<std::string> names;
  std::set<std::string> single;       // names that came and count once
  std::map<std::string, int> listed;  // how many numbers of a vector have come by its name alone
  for (const ParameterInfo& info : load.parameters)
    for (const char* ending : {"", "_x", "_y", "_z"})
      if (*ending == 0 || is_vector(info)) names.push_back(info.name + ending);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string key = &given(values[i].name, "a value's name");
    const double value = values[i].value;
    if (std::find(names.begin(), names.end(), key) == names.end())
      throw InputError(load.name + " has no '" + key + "'" + suggestion(key, names));
    if (!std::isfinite(value)) throw InputError(load.name + "'s " + key + " is not finite");
    for (const ParameterInfo& info : load.parameters) {
      if (key == info.name && info.kind == ValueKind::molecules) {
        if (!(std::abs(value) < 2e9 && value == std::floor(value)))
          throw InputError(load.name + "'s " + key + " must be whole numbers");
        found.molecules[key].push_back(static_cast<int>(value));
      } else if (key == info.name && is_vector(info)) {
        if (const int axis = listed[key]++; axis < 3)
          found.vectors.try_emplace(key, Vector3::Zero()).first->second[axis] = value;
      } else if (key == info.name) {
        if (!single.insert(key).second) refuse_twice(load.name, key);
        found.numbers[key] = value;
      } else if (is_vector(info) && key.size() == info.name.size() + 2 && key.starts_with(info.name)) {
        if (!single.insert(key).second) refuse_twice(load.name, key);
        found.vectors.try_emplace(info.name, Vector3::Zero()).first->second[key.back() - 'x'] = value;
      }
    }
  }
  for (const auto& [key, many] : listed)
    if (many != 3) throw InputError(load.name + "'s " + key + " has " + std::to_string(many) + " numbers; it takes 3");
  return found;
}

}  // namespace
}  // namespace elastin::c

using elastin::c::given;
using elastin::c::guarded;
using elastin::c::load_values;

extern "C" elastin_status elastin_add_load(elastin_simulation* simulation, const char* load,
                                           const elastin_value* values, size_t value_count, int* number) {
  return guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    const elastin::LoadKind& kind = *elastin::c::catalog().loads.find(&given(load, "load"));
    const int added = handle.simulation.add_load(kind, load_values(kind, values, value_count));
    if (number) *number = added;
  });
}

extern "C" elastin_status elastin_add(elastin_simulation* simulation, const char* load, const elastin_value* values,
                                      size_t value_count) {
  return elastin_add_load(simulation, load, values, value_count, nullptr);
}

extern "C" elastin_status elastin_set_load(elastin_simulation* simulation, int number, const elastin_value* values,
                                           size_t value_count) {
  return guarded([&] {
    elastin::Simulation& tissue = given(simulation, "simulation").simulation;
    tissue.set_load(number, load_values(tissue.load_kind(number), values, value_count));
  });
}

extern "C" elastin_status elastin_remove_load(elastin_simulation* simulation, int number) {
  return guarded([&] { given(simulation, "simulation").simulation.remove_load(number); });
}
