#include "c/handles.h"
#ifdef ELASTIN_C_LAB
#include "elastin/mesh/voronoi.h"
#endif

namespace elastin::c {
namespace {

double within(double value, double low, double high, const char* name) {
  if (value >= low && value <= high) return value;
  char text[160];
  std::snprintf(text, sizeof text, "%s is %g; it must be at least %g and at most %g", name, value, low, high);
  throw InputError(text);
}

constexpr double kMost = 1e300;
constexpr double kLeast = 1e-300;

ParameterValues values_of(const elastin_value* values, std::size_t count, const char* name) {
  ParameterValues found;
  if (count > 0) c::given(values, name);
  for (std::size_t i = 0; i < count; ++i) found[&c::given(values[i].name, "a parameter's name")] = values[i].value;
  return found;
}

}  // namespace

const Catalog& catalog() {
  static const Catalog built_in = built_in_catalog();
  return built_in;
}

Strategy strategy_of(const char* name) { return catalog().find(&given(name, "strategy")); }

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
#ifdef ELASTIN_C_LAB
  options.make_voronoi = mesh::voronoi_cells;
#endif
  if (!given) return options;
  const elastin_options values = checked_copy(given, "elastin_options");
  if (values.scheme) options.integrator.scheme = catalog().steppers.find(values.scheme);
  options.integrator.parameters =
      values_of(values.scheme_parameters, values.scheme_parameter_count, "scheme_parameters");
  if (values.safety != 0) options.safety = within(values.safety, 1e-6, 1, "safety");
  if (values.max_substeps != 0)
    options.max_substeps = static_cast<int>(within(values.max_substeps, 1, 1e9, "max_substeps"));
  options.parameters = values_of(values.parameters, values.parameter_count, "parameters");
  options.threads = static_cast<int>(within(values.threads, 0, 4096, "threads"));
  if (values.run) {
    const int width = static_cast<int>(within(values.run_width, 1, 4096, "run_width"));
    runner = std::make_unique<CallbackRunner>(width, values.run, values.run_context);
    options.runner = runner.get();
  }
  return options;
}

}  // namespace elastin::c
