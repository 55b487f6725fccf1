#include <algorithm>

#include "c/handles.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/prepare.h"
#ifdef ELASTIN_C_LAB
#include "elastin/lab/study/laboratory.h"
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
  for (std::size_t i = 0; i < count; ++i) {
    const std::string key = &c::given(values[i].name, "a parameter's name");
    if (!found.emplace(key, values[i].value).second) refuse_twice(name, key);
  }
  return found;
}

/// "mu" and 2 of "mu_2"; 0 where the name does not end so.
std::pair<std::string, std::size_t> term_of(const std::string& name) {
  const std::size_t at = name.rfind('_');
  if (at == std::string::npos || at + 1 == name.size()) return {name, 0};
  std::size_t number = 0;
  for (std::size_t i = at + 1; i < name.size(); ++i) {
    if (name[i] < '0' || name[i] > '9' || number > 1000) return {name, 0};
    number = 10 * number + static_cast<std::size_t>(name[i] - '0');
  }
  return {name.substr(0, at), number};
}

/// Whether the value is one of a term, of a direction or a word, and stands in the constants now.
bool put_constant(const MaterialLaw& row, const std::string& name, double value, LawConstants& constants) {
  const auto [column_name, term] = term_of(name);
  for (std::size_t column = 0; column < row.columns.size(); ++column)
    if (term > 0 && row.columns[column].name == column_name) {
      if (constants.terms.size() < term) constants.terms.resize(term, std::vector<double>(row.columns.size(), 0));
      constants.terms[term - 1][column] = value;
      return true;
    }
  for (const ParameterInfo& info : row.parameters)
    for (int axis = 0; axis < 3; ++axis)
      if (info.kind == ValueKind::direction && name == info.name + "_" + "xyz"[axis]) {
        constants.directions.try_emplace(info.name, Vector3::Zero()).first->second[axis] = value;
        return true;
      }
  for (const WordInfo& info : row.words)
    for (const std::string& word : info.words)
      if (name == info.name + "_" + word) {
        if (value != 0) constants.words[info.name] = word;
        return true;
      }
  return false;
}

void set_law(const elastin_law* given_law, Material& material) {
  const elastin_law law = checked_copy(given_law, "elastin_law");
  const auto row = catalog().material_laws.find(&c::given(law.name, "the law's name"));
  if (!row->from_moduli && (material.youngs_modulus != 0 || material.poissons_ratio != 0))
    throw InputError("youngs_modulus and poissons_ratio follow from the constants of " + row->name + "; leave them 0");
  LawConstants constants{.law = row->name};
  for (const auto& [name, value] : values_of(law.constants, law.constant_count, "constants"))
    if (!put_constant(*row, name, value, constants)) constants.numbers[name] = value;
  for (auto& [name, direction] : constants.directions) direction.normalize();
  material = with_law(*row, std::move(constants), std::move(material));
}

}  // namespace

const Catalog& catalog() {
  static const Catalog built_in = built_in_catalog();
  return built_in;
}

Strategy strategy_of(const char* name) { return catalog().find(&given(name, "strategy")); }

namespace {

Material described_material(const elastin_material& values) {
  if (values.youngs_modulus != 0 || values.poissons_ratio != 0 || values.thickness != 0 ||
      values.bending_rigidity != 0 || values.law)
    throw InputError("description: it says all of the material; leave the other values 0");
#ifdef ELASTIN_C_LAB
  return lab::make_material(values.description);
#else
  throw InputError("description: this library was built without scenes (ELASTIN_LAB)");
#endif
}

}  // namespace

Material material_of(const elastin_material* given) {
  const elastin_material values = checked_copy(given, "elastin_material");
  if (values.description) return described_material(values);
  Material material;
  const bool law = values.law != nullptr;  // E may follow from it
  material.youngs_modulus =
      within(values.youngs_modulus, law && values.youngs_modulus == 0 ? 0 : kLeast, kMost, "youngs_modulus");
  material.poissons_ratio = within(values.poissons_ratio, -0.99, 0.5, "poissons_ratio");
  material.thickness = within(values.thickness, 0, kMost, "thickness");
  material.bending_rigidity = within(values.bending_rigidity, 0, kMost, "bending_rigidity");
  if (law) set_law(values.law, material);
  return material;
}

SimulationOptions options_of(const elastin_options* given, std::unique_ptr<CallbackRunner>& runner) {
  SimulationOptions options;
#ifdef ELASTIN_C_LAB
  options.make_voronoi = mesh::voronoi_cells;
#endif
  if (!given) return options;
  const elastin_options values = checked_copy(given, "elastin_options");
  if (values.stepper) options.stepper.method = catalog().steppers.find(values.stepper);
  options.stepper.parameters =
      values_of(values.stepper_parameters, values.stepper_parameter_count, "stepper_parameters");
  if (values.safety != 0) options.safety = within(values.safety, 1e-6, 1, "safety");
  if (values.max_substeps != 0)
    options.max_substeps = static_cast<int>(within(values.max_substeps, 1, 1e9, "max_substeps"));
  options.parameters = values_of(values.parameters, values.parameter_count, "parameters");
  options.budget = within(values.budget, 0, 1e9, "budget");
  options.threads = static_cast<int>(within(values.threads, 0, kMostThreads, "threads"));
  if (values.run) {
    const int width = static_cast<int>(within(values.run_width, 1, kMostThreads, "run_width"));
    runner = std::make_unique<CallbackRunner>(width, values.run, values.run_context);
    options.runner = runner.get();
  }
  return options;
}

}  // namespace elastin::c

extern "C" elastin_status elastin_strategy_constants(const elastin_body* body, const char* strategy,
                                                     const elastin_material* material, const elastin_value* parameters,
                                                     size_t parameter_count, double* constants, size_t count) {
  using namespace elastin;
  return c::guarded([&] {
    MakeVoronoi make_voronoi;
#ifdef ELASTIN_C_LAB
    make_voronoi = mesh::voronoi_cells;
#endif
    const Body& given_body = c::given(body, "body").body;
    if (count != static_cast<std::size_t>(given_body.connections.size()))
      throw InputError("count is " + std::to_string(count) + "; the body has " +
                       std::to_string(given_body.connections.size()) + " connections");
    const VectorX found = spring_constants(c::strategy_of(strategy), given_body, c::material_of(material),
                                           c::values_of(parameters, parameter_count, "parameters"), make_voronoi);
    if (count > 0) std::copy_n(found.data(), count, &c::given(constants, "constants"));
  });
}
