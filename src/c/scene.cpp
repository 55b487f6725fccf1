#include "c/handles.h"

#ifdef ELASTIN_C_LAB
#include "core/base/named.h"
#include "elastin/lab/study/laboratory.h"
#ifdef ELASTIN_C_FEBIO
#include "elastin/febio/febio.h"
#endif

struct elastin_scene {
  elastin::lab::Laboratory laboratory;
};

struct elastin_result {
  elastin::lab::LaboratoryResult result;
};

using elastin::c::given;
using elastin::c::guarded;

namespace {

std::vector<std::string> strings(const char* const* texts, std::size_t count, const char* name) {
  std::vector<std::string> all;
  if (count > 0) given(texts, name);
  for (std::size_t i = 0; i < count; ++i) all.emplace_back(&given(texts[i], name));
  return all;
}

const elastin::lab::Measured& numbered(const elastin_result& result, std::size_t number) {
  const auto& all = result.result.measures;
  if (number >= all.size())
    throw elastin::InputError("measure " + std::to_string(number) + ": there are " + std::to_string(all.size()) +
                              ", from 0");
  return all[number];
}

const elastin::lab::Measured& named(const elastin_result& result, const std::string& name) {
  return elastin::named(result.result.measures, name, "'" + name + "' was not measured");
}

}  // namespace

extern "C" {

elastin_status elastin_scene_load(const char* path, const char* const* overrides, size_t override_count,
                                  elastin_scene** scene) {
  return guarded([&] {
    given(scene, "scene");
#ifdef ELASTIN_C_FEBIO
    elastin::febio::add_scene_format();
#endif
    elastin::lab::Laboratory laboratory(&given(path, "path"), strings(overrides, override_count, "overrides"));
    *scene = new elastin_scene{std::move(laboratory)};
  });
}

void elastin_scene_free(elastin_scene* scene) { delete scene; }

elastin_status elastin_scene_run(elastin_scene* scene, const char* strategy, elastin_result** result) {
  return guarded([&] {
    given(result, "result");
    elastin::lab::Laboratory& laboratory = given(scene, "scene").laboratory;
    auto made = std::make_unique<elastin_result>(elastin_result{laboratory.run(strategy ? strategy : "")});
    *result = made.release();
  });
}

elastin_status elastin_scene_simulate(elastin_scene* scene, const char* strategy, const elastin_options* options,
                                      elastin_simulation** simulation) {
  return guarded([&] {
    given(simulation, "simulation");
    elastin::lab::Laboratory& laboratory = given(scene, "scene").laboratory;
    std::unique_ptr<CallbackRunner> runner;
    elastin::SimulationOptions chosen = elastin::c::options_of(options, runner);
    elastin::Simulation made = laboratory.simulation(strategy ? strategy : "", std::move(chosen));
    *simulation = new elastin_simulation{std::move(runner), std::move(made)};
  });
}

void elastin_result_free(elastin_result* result) { delete result; }

elastin_status elastin_result_outcome(const elastin_result* result, elastin_outcome* outcome, const char** cause) {
  return guarded([&] {
    const elastin::lab::LaboratoryResult& from = given(result, "result").result;
    if (outcome) *outcome = from.suited ? static_cast<int>(from.outcome) : ELASTIN_UNSUITED;
    if (cause) *cause = from.cause.c_str();
  });
}

elastin_status elastin_result_count(const elastin_result* result, size_t* measures) {
  return guarded([&] { given(measures, "measures") = given(result, "result").result.measures.size(); });
}

elastin_status elastin_result_measure(const elastin_result* result, size_t number, const char** name, const char** unit,
                                      double* value) {
  return guarded([&] {
    const elastin::lab::Measured& measured = numbered(given(result, "result"), number);
    if (name) *name = measured.name.c_str();
    if (unit) *unit = measured.unit.c_str();
    if (value) *value = measured.value;
  });
}

elastin_status elastin_result_get(const elastin_result* result, const char* measure, double* value) {
  return guarded([&] { given(value, "value") = named(given(result, "result"), &given(measure, "measure")).value; });
}

elastin_status elastin_result_positions(const elastin_result* result, const double** values, size_t* count) {
  return guarded([&] { elastin::c::show(given(result, "result").result.positions, values, count); });
}

elastin_status elastin_result_tensions(const elastin_result* result, const double** values, size_t* count) {
  return guarded([&] { elastin::c::show(given(result, "result").result.tensions, values, count); });
}
}

#else

namespace {

elastin_status missing() {
  return elastin::c::failed(ELASTIN_MISSING, "this library was built without scenes (ELASTIN_LAB)");
}

}  // namespace

extern "C" {

elastin_status elastin_scene_load(const char*, const char* const*, size_t, elastin_scene**) { return missing(); }
void elastin_scene_free(elastin_scene*) {}
elastin_status elastin_scene_run(elastin_scene*, const char*, elastin_result**) { return missing(); }
elastin_status elastin_scene_simulate(elastin_scene*, const char*, const elastin_options*, elastin_simulation**) {
  return missing();
}
void elastin_result_free(elastin_result*) {}
elastin_status elastin_result_outcome(const elastin_result*, elastin_outcome*, const char**) { return missing(); }
elastin_status elastin_result_count(const elastin_result*, size_t*) { return missing(); }
elastin_status elastin_result_measure(const elastin_result*, size_t, const char**, const char**, double*) {
  return missing();
}
elastin_status elastin_result_get(const elastin_result*, const char*, double*) { return missing(); }
elastin_status elastin_result_positions(const elastin_result*, const double**, size_t*) { return missing(); }
elastin_status elastin_result_tensions(const elastin_result*, const double**, size_t*) { return missing(); }
}

#endif
