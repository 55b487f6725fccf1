#include "elastin/core/forces/load_table.h"

#include <algorithm>
#include <cmath>

#include "core/base/named.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

/// Checks vectors, directions and molecules.
void check_value(const std::string& key, const ParameterInfo& info, const Body& body, LoadValues& values) {
  if (auto vector = values.vectors.find(info.name); vector != values.vectors.end()) {
    if (!vector->second.allFinite()) throw InputError(key + ": must be three finite numbers");
    if (info.kind == ValueKind::direction) {
      if (!(vector->second.norm() > 0)) throw InputError(key + ": a direction must not be zero");
      if (std::abs(vector->second.norm() - 1) > 1e-15) vector->second.normalize();
    }
  }
  if (const auto molecules = values.molecules.find(info.name); molecules != values.molecules.end()) {
    if (molecules->second.empty() && !body.share) throw InputError(key + ": names no molecule");
    for (const int molecule : molecules->second)
      if (molecule < 0 || molecule >= body.size())
        throw InputError(key + ": no molecule " + std::to_string(molecule) + ": the body has molecules 0 to " +
                         std::to_string(body.size() - 1));
  }
}

bool fits(ValueKind kind, const LoadValues& values, const std::string& name) {
  if (values.vectors.contains(name)) return kind == ValueKind::vector || kind == ValueKind::direction;
  if (values.molecules.contains(name)) return kind == ValueKind::molecules;
  return kind == ValueKind::number || kind == ValueKind::whole;
}

void check_name(const LoadKind& load, const LoadValues& values, const std::string& name) {
  const ParameterInfo& info = named(load.parameters, name, load.name + " has no '" + name + "'");
  if (!fits(info.kind, values, name)) throw InputError(load.name + "." + name + ": must be a " + name_of(info.kind));
}

}  // namespace

bool LoadValues::has(const std::string& name) const {
  return numbers.contains(name) || vectors.contains(name) || molecules.contains(name);
}

LoadValues checked_values(const LoadKind& load, const Body& body, LoadValues values) {
  for (const auto& [name, value] : values.numbers) check_name(load, values, name);
  for (const auto& [name, value] : values.vectors) check_name(load, values, name);
  for (const auto& [name, value] : values.molecules) check_name(load, values, name);
  for (const ParameterInfo& info : load.parameters) {
    const std::string key = load.name + "." + info.name;
    if (info.required && !values.has(info.name)) throw InputError(key + " is missing: " + info.text);
    check_value(key, info, body, values);
  }
  values.numbers = complete_values(load.name, load.parameters, values.numbers);
  load.check(body, values);
  return values;
}

void add_load(Model& model, const LoadKind& load, LoadValues values, const Material* material) {
  load.add(model, checked_values(load, model.body(), std::move(values)), material);
}

}  // namespace elastin
