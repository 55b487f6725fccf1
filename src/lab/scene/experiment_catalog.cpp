#include "elastin/lab/experiment/experiment_catalog.h"

#include <algorithm>
#include <utility>

#include "elastin/core/base/error.h"
#include "lab/run/config_names.h"
#include "lab/scene/experiments.h"

namespace elastin::lab {
namespace {

std::unique_ptr<Experiment> make_from_parameters(Reader& reader, const ExperimentInfo& info,
                                                 const ExperimentContext& context) {
  ParameterValues values;
  for (const ParameterInfo& parameter : info.parameters) {
    const auto given = reader.find(parameter.name);
    values[parameter.name] =
        given ? given->quantity(parameter.unit, {parameter.low, parameter.high}) : parameter.fallback;
  }
  reader.finish();
  return reader.located([&] { return info.make(context, values); });
}

}  // namespace

std::vector<SceneKey> keys_of(const ExperimentInfo& info) {
  std::vector<SceneKey> keys = info.keys;
  for (const ParameterInfo& parameter : info.parameters) keys.push_back(key_of(parameter));
  return keys;
}

void ExperimentCatalog::add(ExperimentInfo info) {
  for (const ExperimentInfo& other : experiments_)
    if (other.name == info.name) throw InputError("there is an experiment '" + info.name + "' already");
  if (!info.read && !info.make) throw InputError("experiment '" + info.name + "' has neither `make` nor `read`");
  experiments_.push_back(std::move(info));
}

const ExperimentInfo& ExperimentCatalog::find(const std::string& name) const {
  std::vector<std::string> names;
  for (const ExperimentInfo& info : experiments_) {
    if (info.name == name) return info;
    names.push_back(info.name);
  }
  throw InputError("'" + name + "' is not known here" + suggested_word(name, names));
}

ExperimentCatalog built_in_experiments() {
  ExperimentCatalog catalog;
  for (const auto& rows : {static_experiments(), bubble_experiments(), contact_experiments(), timed_experiments()})
    for (const ExperimentInfo& row : rows) catalog.add(row);
  return catalog;
}

std::unique_ptr<Experiment> read_experiment(Reader reader, const ExperimentContext& context) {
  reader.set_section("experiment");
  const Reader kind = reader.at("kind");
  const ExperimentInfo info = kind.located([&] { return context.experiments.find(kind.text()); });
  reader.set_section("experiment." + info.name);
  return info.read ? info.read(reader, context) : make_from_parameters(reader, info, context);
}

std::string timed_experiment_names(const ExperimentCatalog& catalog) {
  std::vector<std::string> names;
  for (const ExperimentInfo& info : catalog.experiments())
    if (info.in_time) names.push_back(info.name);
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " and ") + names[i];
  return text;
}

}  // namespace elastin::lab
