#include <set>
#include <string_view>

#include "c/handles.h"

namespace elastin::c {
namespace {

const Catalog& catalog() {
  static const Catalog built_in = built_in_catalog();
  return built_in;
}

/// What a wrapper changes goes by an ending, so those are not listed.
const std::vector<Strategy>& listed() {
  static const std::vector<Strategy> all = [] {
    std::vector<Strategy> kept;
    for (const Strategy& strategy : catalog().strategies())
      if (strategy.kind != StrategyKind::wrapper) kept.push_back(strategy);
    return kept;
  }();
  return all;
}

const Strategy& numbered(std::size_t number) {
  if (number >= listed().size())
    throw InputError("strategy " + std::to_string(number) + ": there are " + std::to_string(listed().size()) +
                     ", from 0");
  return listed()[number];
}

/// The unit's name, which lives on. Made for all strategies at once, so that threads may ask.
const char* unit_of(const Dimension& dimension) {
  static const std::set<std::string> all = [] {
    std::set<std::string> units;
    for (const Strategy& strategy : listed())
      for (const ParameterInfo& info : strategy.parameters) units.insert(si_unit(info.unit));
    return units;
  }();
  return all.find(si_unit(dimension))->c_str();
}

Scheme scheme_of(const char* name) {
  if (!name) return Scheme::symplectic_euler;
  std::vector<std::string> names;
  for (const Scheme scheme :
       {Scheme::symplectic_euler, Scheme::velocity_verlet, Scheme::backward_euler, Scheme::newmark}) {
    names.emplace_back(name_of(scheme));
    if (names.back() == name) return scheme;
  }
  throw InputError("scheme '" + std::string(name) + "' is not known" + suggestion(name, names));
}

double within(double value, double low, double high, const char* name) {
  if (value >= low && value <= high) return value;
  char text[160];
  std::snprintf(text, sizeof text, "%s is %g; it must be at least %g and at most %g", name, value, low, high);
  throw InputError(text);
}

constexpr double kMost = 1e300;
constexpr double kLeast = 1e-300;

}  // namespace

Strategy strategy_of(const char* name) {
  const std::string_view volume = "+volume", wrinkling = "+wrinkling";
  std::string base = &given(name, "strategy");
  if (base.ends_with(volume)) return with_volume(strategy_of(base.substr(0, base.size() - volume.size()).c_str()));
  if (base.ends_with(wrinkling))
    return with_wrinkling(strategy_of(base.substr(0, base.size() - wrinkling.size()).c_str()));
  const Strategy& found = catalog().find(base);
  if (found.kind == StrategyKind::wrapper)
    throw InputError("'" + base + "' changes another strategy; write for example lattice+volume");
  return found;
}

Material material_of(const elastin_material* given) {
  const elastin_material values = checked_copy(given, "elastin_material");
  Material material;
  material.youngs_modulus = within(values.youngs_modulus, kLeast, kMost, "youngs_modulus");
  material.poissons_ratio = within(values.poissons_ratio, -0.99, 0.5, "poissons_ratio");
  material.thickness = within(values.thickness, 0, kMost, "thickness");
  material.bending_rigidity = within(values.bending_rigidity, 0, kMost, "bending_rigidity");
  return material;
}

SimulationOptions options_of(const elastin_options* given, std::unique_ptr<CallbackRunner>& runner) {
  SimulationOptions options;
  if (!given) return options;
  const elastin_options values = checked_copy(given, "elastin_options");
  options.integrator.scheme = scheme_of(values.scheme);
  if (values.safety != 0) options.safety = within(values.safety, 1e-6, 1, "safety");
  if (values.max_substeps != 0)
    options.max_substeps = static_cast<int>(within(values.max_substeps, 1, 1e9, "max_substeps"));
  if (values.parameter_count > 0) c::given(values.parameters, "parameters");
  for (std::size_t i = 0; i < values.parameter_count; ++i)
    options.parameters[&c::given(values.parameters[i].name, "a parameter's name")] = values.parameters[i].value;
  options.threads = static_cast<int>(within(values.threads, 0, 4096, "threads"));
  if (values.run) {
    const int width = static_cast<int>(within(values.run_width, 1, 4096, "run_width"));
    runner = std::make_unique<CallbackRunner>(width, values.run, values.run_context);
    options.runner = runner.get();
  }
  return options;
}

}  // namespace elastin::c

using elastin::c::guarded;

extern "C" {

elastin_status elastin_strategy_count(size_t* count) {
  return guarded([&] { elastin::c::given(count, "count") = elastin::c::listed().size(); });
}

elastin_status elastin_strategy(size_t number, const char** name, const char** summary, size_t* parameter_count) {
  return guarded([&] {
    const elastin::Strategy& strategy = elastin::c::numbered(number);
    if (name) *name = strategy.name.c_str();
    if (summary) *summary = strategy.summary.c_str();
    if (parameter_count) *parameter_count = strategy.parameters.size();
  });
}

elastin_status elastin_strategy_parameter(size_t strategy, size_t number, elastin_parameter* parameter) {
  return guarded([&] {
    const auto& all = elastin::c::numbered(strategy).parameters;
    if (number >= all.size())
      throw elastin::InputError("parameter " + std::to_string(number) + ": the strategy has " +
                                std::to_string(all.size()) + ", from 0");
    const elastin::ParameterInfo& info = all[number];
    const elastin_parameter values{
        0, info.name.c_str(), elastin::c::unit_of(info.unit), info.text.c_str(), info.low, info.high, info.fallback};
    elastin::c::put(values, parameter, "elastin_parameter");
  });
}
}
