#include "elastin/lab/experiment/experiment_catalog.h"

#include <algorithm>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/share.h"
#include "lab/experiment/keys.h"
#include "lab/run/common_measures.h"
#include "lab/run/config_names.h"

namespace elastin::lab {

// The experiments, each in a folder of its own. The order is that of lists and documents.
ExperimentInfo tension_row(), compression_row(), biaxial_row(), planar_row(), shear_row(), torsion_row(),
    hydrostatic_row(), bending_row(), inflation_row(), material_row(), bubble_row(), indentation_row(), press_row(),
    sliding_row(), loads_row(), motion_row(), release_row(), creep_row(), relaxation_row(), cyclic_row(), shake_row(),
    drop_row(), parachute_row(), vibration_row();

namespace {

constexpr ExperimentInfo (*kRows[])() = {tension_row, compression_row, biaxial_row,   planar_row,     shear_row,
                                         torsion_row, hydrostatic_row, bending_row,   inflation_row,  material_row,
                                         bubble_row,  indentation_row, press_row,     sliding_row,    loads_row,
                                         motion_row,  release_row,     creep_row,     relaxation_row, cyclic_row,
                                         shake_row,   drop_row,        parachute_row, vibration_row};

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

const ExperimentCatalog& built_in_experiments() {
  static const ExperimentCatalog all = [] {
    ExperimentCatalog catalog;
    for (const auto& row : kRows) catalog.add(row());
    return catalog;
  }();
  return all;
}

MeasureList measures_of(const ExperimentCatalog& catalog) {
  MeasureList all;
  for (const ExperimentInfo& info : catalog.experiments()) all.add(info.measures);
  all.add(common_measures());
  return all;
}

const MeasureList& built_in_measures() {
  static const MeasureList all = measures_of(built_in_experiments());
  return all;
}

const MeasureInfo& find_measure(const std::string& name) { return built_in_measures().at(name); }

std::unique_ptr<Experiment> read_experiment(Reader reader, const ExperimentContext& context) {
  reader.set_section("experiment");
  const Reader kind = reader.at("kind");
  const ExperimentInfo& info = *kind.located([&] { return &context.experiments.find(kind.text()); });
  reader.set_section("experiment." + info.name);
  return info.read ? info.read(reader, context) : make_from_parameters(reader, info, context);
}

std::unique_ptr<StaticExperiment> read_fixture(const Reader& reader, const ExperimentContext& context) {
  std::unique_ptr<Experiment> fixture = read_experiment(reader, context);
  auto* at_rest = dynamic_cast<StaticExperiment*>(fixture.get());
  if (!at_rest) reader.fail("must be an experiment at rest; " + fixture->name() + " runs through time itself");
  static_cast<void>(fixture.release());
  return std::unique_ptr<StaticExperiment>(at_rest);
}

std::string timed_experiment_names(const ExperimentCatalog& catalog) {
  std::vector<std::string> names;
  for (const ExperimentInfo& info : catalog.experiments())
    if (info.in_time) names.push_back(info.name);
  return listed(names);
}

void fix_in_planes(const Body& body, const std::vector<Vector3>& normals, FixedMolecules& fixed) {
  const double near = 1e-9 * largest_over(body, body.rest.cwiseAbs().maxCoeff());
  for (const Vector3& normal : normals) {
    const VectorX height = body.rest.transpose() * normal;
    if (least_over(body, height.minCoeff()) < -near && largest_over(body, height.maxCoeff()) > near)
      throw InputError("symmetry: the body lies on both sides of one of the planes");
    bool any = false;
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      if (std::abs(height[molecule]) > near) continue;
      any = true;
      Matrix3& free = fixed.try_emplace(molecule, Matrix3::Identity()).first->second;
      free = without_rounding(free - free * normal * normal.transpose());
    }
    if (!any_over(body, any))
      throw InputError("symmetry: no molecule lies in one of the planes, which go through the origin");
  }
}

}  // namespace elastin::lab
