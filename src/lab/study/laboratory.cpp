#include "elastin/lab/study/laboratory.h"

#include <limits>
#include <utility>

#include "config/scene_tree.h"
#include "core/solve/steppers.h"
#include "lab/export/engine_run.h"
#include "lab/export/formats.h"
#include "lab/report/comparison.h"
#include "lab/report/page.h"
#include "lab/report/records.h"
#include "lab/report/viewer.h"
#include "lab/run/contact_measures.h"
#include "lab/run/load_path.h"
#include "lab/scene/parts.h"
#include "lab/study/reference.h"
#include "lab/study/study.h"

namespace elastin::lab {
namespace {

/// "" is the scene's own.
StrategyChoice choose(const Scene& scene, const Catalog& catalog, const std::string& label) {
  return label.empty() ? scene.stiffness : choose_strategy(scene, catalog, label);
}

Measured measured(const MeasureList& known, const std::string& name, double value) {
  const MeasureInfo* info = known.find(name);
  return {name, (info ? *info : find_measure(name)).unit_text(), value};
}

std::vector<Measured> measured(const MeasureList& known, const Measures& measures) {
  std::vector<Measured> list;
  for (const auto& [name, value] : measures.all()) list.push_back(measured(known, name, value));
  return list;
}

void set_last_state(const Body& body, const Snapshot& last, LaboratoryResult& result) {
  result.positions = last.positions;
  result.tensions.resize(body.connections.size());
  for (int connection = 0; connection < body.connections.size(); ++connection) {
    const auto& [a, b] = body.connections.ends[connection];
    result.tensions[connection] =
        last.force_densities[connection] * (last.positions.col(b) - last.positions.col(a)).norm();
  }
}

LaboratoryResult result_of(const std::shared_ptr<const Scene>& of, Run made) {
  const Scene& scene = *of;
  LaboratoryResult result;
  result.record = std::make_shared<const Record>(make_record(scene, std::move(made)));
  result.scene = of;
  const Record& record = *result.record;
  const Run& run = record.run;
  result.strategy = run.strategy;
  result.outcome = run.outcome;
  result.suited = run.suited;
  result.cause = run.cause;
  result.good = record.good() && (run.suited || record.stopped_as_expected());
  result.measures = measured(*scene.measures, run.measures);
  result.gradients = run.gradients;
  result.spreads = record.spreads;
  for (const MainMeasure& measure : record.main_measures) result.main.emplace_back(measure.name);
  for (const auto& [name, error] : record.errors) result.errors.push_back({name, "", error});
  for (const CurvePoint& point : run.curve)
    result.curve.push_back({run.time ? point.time : point.load_factor, measured(*scene.measures, point.measures)});
  result.stiffness = run.measures.stiffness_matrix;
  if (!run.snapshots.empty()) set_last_state(scene.specimen.body, run.snapshots.back(), result);
  for (const Snapshot& kept : run.snapshots) result.states.push_back({kept.at, kept.positions});
  result.warnings = record.warnings;
  result.notes = record.notes;
  result.solver = run.solver;
  result.newton_iterations = run.newton_iterations;
  result.linear_iterations = run.linear_iterations;
  result.build_seconds = run.build_seconds;
  result.solve_seconds = run.solve_seconds;
  return result;
}

/// What a simulation of a scene refers to, for as long as it lives.
struct Owned {
  std::shared_ptr<const Scene> scene;        ///< its body, on which the experiment was made
  std::shared_ptr<const Specimen> specimen;  ///< its material may have been identified for the simulation
};

/// Puts the experiment's whole load on the model of a scene at rest, or brings that of a scene in time to time 0. What
/// drives the model from then on keeps its rig.
void load_in_full(const Scene& scene, const std::shared_ptr<Rig>& rig, Model& model, State& state) {
  if (TimedRig* timed = rig->in_time()) {
    const StaticResult started = timed->start(state, scene.statics);
    if (started.outcome != Outcome::converged) throw InputError(started.cause + " (before time 0)");
  } else if (StaticRig& own = *rig->at_rest(); own.seeks_load()) {  // which has its load when it has found it
    Run run;
    RunOptions options;
    options.statics = scene.statics;
    solve_load_curve(model, *scene.experiment->at_rest(), own, scene.specimen.material, options, run,
                     scene.specimen.start);
    if (run.outcome != Outcome::converged)
      throw InputError(run.cause + " (while the load that the experiment prescribes was sought)");
  } else {
    set_load(model, own, 1);
  }
  if (scene.specimen.start) scene.specimen.start(state);
  if (model.drive)
    model.drive = [rig, drive = model.drive](double time, std::vector<Support>& supports) { drive(time, supports); };
  if (model.drive) model.drive(0, model.supports);
  if (scene.specimen.start) move_with_supports(model.supports, state.velocities);  // what is held takes no velocity
  model.commit_step(state);
}

}  // namespace

struct Laboratory::Impl {
  Catalog catalog;
  std::vector<std::string> overrides;
  ExperimentCatalog experiments;
  std::shared_ptr<Scene> scene;  // simulations keep it
};

namespace {

std::vector<Record> records_of(const LaboratoryResults& results) {
  std::vector<Record> records;
  for (const LaboratoryResult* result : results) {
    if (!result->record) throw InputError("a result that was unpacked has lost what a page shows: run it again");
    records.push_back(*result->record);
  }
  return records;
}

/// Lines of what is to be turned, and behind them the records.
std::pair<std::vector<std::string>, std::vector<Record>> views_of(const LaboratoryResults& results) {
  std::pair<std::vector<std::string>, std::vector<Record>> views{{}, records_of(results)};
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (views.first.empty()) views.first.push_back(body_view(*results[i]->scene, views.second[i]));
    if (std::string states = states_view(*results[i]->scene, views.second[i]); !states.empty())
      views.first.push_back(std::move(states));
  }
  return views;
}

std::string view_of(const Body& body, Snapshot state) {
  Scene scene;
  scene.specimen.body = body;
  Record record;
  record.scene = record.title = "body";
  record.molecules = body.size();
  record.run.strategy = "now";
  state.obstacles.clear();
  record.run.snapshots.push_back(std::move(state));
  return viewer_text({body_view(scene, record), states_view(scene, record)}, {record});
}

}  // namespace

Advice advice_of(const LaboratoryResults& results) {
  const std::vector<Record> records = records_of(results);
  const Ranking ranking = rank_strategies(records);
  return {ranking.recommends() ? ranking.best->run.strategy : "", advice_text(ranking, false)};
}

std::string page_of(const LaboratoryResults& results) {
  auto [views, records] = views_of(results);
  return page_text({std::move(records), std::move(views), {}, "", ""});
}

std::string view_of(const LaboratoryResults& results) {
  const auto [views, records] = views_of(results);
  return viewer_text(views, records);
}

std::string view_of(const Simulation& simulation) {
  return view_of(simulation.body(), snapshot_of(simulation.model(), simulation.state(), simulation.time(), 0));
}

std::string view_of(const Body& body) {
  Snapshot rest;
  rest.positions = body.rest;
  return view_of(body, std::move(rest));
}

double LaboratoryResult::get(const std::string& name) const {
  for (const Measured& one : measures)
    if (one.name == name) return one.value;
  return std::numeric_limits<double>::quiet_NaN();
}

Laboratory::Laboratory(const SceneSource& scene, const std::vector<std::string>& overrides, Catalog catalog,
                       const ExperimentCatalog& experiments)
    : impl_(new Impl{std::move(catalog), overrides, experiments, nullptr}) {
  config::check_overrides(overrides);
  impl_->scene = load_scene(scene, impl_->catalog, overrides, kMostMolecules, experiments);
}
Laboratory::~Laboratory() = default;
Laboratory::Laboratory(Laboratory&&) noexcept = default;
Laboratory& Laboratory::operator=(Laboratory&&) noexcept = default;

const std::string& Laboratory::name() const { return impl_->scene->name; }
const std::string& Laboratory::title() const { return impl_->scene->title; }
const Body& Laboratory::body() const { return impl_->scene->specimen.body; }
const Material& Laboratory::material() const { return impl_->scene->specimen.material; }
std::string Laboratory::strategy() const { return impl_->scene->stiffness.label; }
const std::vector<std::string>& Laboratory::warnings() const { return impl_->scene->warnings; }

std::vector<std::string> Laboratory::strategies() const {
  std::vector<std::string> labels;
  for (const StrategyChoice& choice : impl_->scene->strategies) labels.push_back(choice.label);
  return labels;
}

std::vector<Stated> Laboratory::references() const {
  std::vector<Stated> list;
  for (const auto* references : {&impl_->scene->references, &impl_->scene->specimen.references})
    for (const Reference& reference : *references)
      list.push_back({"", measured(*impl_->scene->measures, reference.measure, reference.value), reference.source});
  return list;
}

std::vector<Stated> Laboratory::expectations() const {
  std::vector<Stated> list;
  for (const Expectation& expectation : impl_->scene->expectations)
    if (!expectation.measure.empty())
      list.push_back({expectation.strategy, measured(*impl_->scene->measures, expectation.measure, expectation.value),
                      expectation.source});
  return list;
}

void Laboratory::compute_reference(const std::string& option, const RunWatch& watch) {
  Scene& scene = *impl_->scene;
  if (!wants_computed_references(scene, option)) return;
  ReferenceStore store;
  ComputedReferences found =
      compute_references(scene, impl_->catalog, impl_->overrides, store, watch.progress, watch.stop);
  scene.specimen.references = std::move(found.references);
  scene.no_computed_reference = std::move(found.trouble);
  if (!scene.no_computed_reference.empty())
    scene.warnings.push_back("no reference was computed: " + scene.no_computed_reference);
}

LaboratoryResult Laboratory::run(const std::string& strategy, const RunWatch& watch) {
  Scene& scene = *impl_->scene;
  const StrategyChoice choice = choose(scene, impl_->catalog, strategy);
  prepare(scene.specimen, choice.strategy);
  RunOptions options;
  options.statics = scene.statics;
  options.time = scene.time;
  options.keep_snapshots = true;
  options.last_snapshot = !watch.keep_states;
  options.progress = watch.progress;
  options.stop = watch.stop;
  options.derivatives =
      derivatives_by(watch.derivatives_by, scene, choice, impl_->catalog, impl_->overrides, impl_->experiments);
  Run run = run_strategy(scene.specimen, *scene.experiment, choice, options);
  check_deviations(scene, options, run);
  LaboratoryResult result = result_of(impl_->scene, std::move(run));
  if (!watch.keep_states) result.states.clear();
  return result;
}

std::string Laboratory::exported(const std::string& strategy) {
  return json_of_body(exported_body(*impl_->scene, choose(*impl_->scene, impl_->catalog, strategy)));
}

std::vector<std::pair<std::string, std::string>> Laboratory::exported(const std::string& format,
                                                                      const std::string& strategy,
                                                                      std::vector<std::string>& notes) {
  const auto row = export_formats().find(format);
  Scene& scene = *impl_->scene;
  const StrategyChoice choice = choose(scene, impl_->catalog, strategy);
  std::vector<std::pair<std::string, std::string>> files;
  if (row->files) {
    const ExportedBody body = exported_body(scene, choice);
    for (auto& [name, text] : engine_files(*row, body)) files.emplace_back(std::move(name), std::move(text));
    notes.insert(notes.end(), body.notes.begin(), body.notes.end());
  } else {
    const StrategyChoice own = std::exchange(scene.stiffness, choice);
    try {
      files.emplace_back("", row->text(scene, notes));
    } catch (...) {
      scene.stiffness = own;
      throw;
    }
    scene.stiffness = own;
  }
  return files;
}

LaboratoryResult Laboratory::measure(const std::function<std::string(const std::string& request)>& solve) {
  Engine engine{{"engine", "", ""}, "", "", ""};
  engine.ask = solve;
  return result_of(impl_->scene, run_engine(engine, *impl_->scene, impl_->catalog, impl_->overrides, {}).run);
}

Simulation Laboratory::simulation(const std::string& strategy, SimulationOptions options) {
  const std::shared_ptr<Scene> scene = impl_->scene;
  StrategyChoice choice = choose(*scene, impl_->catalog, strategy);
  if (!options.parameters.empty()) choice.values = std::exchange(options.parameters, {});
  prepare(scene->specimen, choice.strategy);
  Run run;
  RunOptions of_run;
  of_run.statics = scene->statics;
  const Experiment& experiment = *scene->experiment;
  const std::string why = scene->specimen.given == GivenShape::at_rest ? unsuited(scene->specimen, experiment, choice)
                                                                       : "its `rest` is to be found first, by run()";
  if (!why.empty()) throw InputError("strategy '" + choice.label + "' cannot run here: " + why);
  const auto specimen = std::make_shared<Specimen>(scene->specimen);
  if (const auto wanted = identification_of(experiment);
      wanted && !identify_material(*wanted, *specimen, *experiment.at_rest(), choice, of_run, run))
    throw InputError(run.cause);
  const auto here = std::make_shared<bool>(true);  // what it refers to is there
  const auto make = [&, here](const Body&) {
    if (!*here)
      throw InputError("a simulation of a scene has the strategy of the scene's body: it cannot have another");
    auto terms = make_elasticity(*specimen, experiment, choice, of_run, run);
    if (!terms) throw InputError(run.cause);
    terms->owners.push_back(std::make_shared<Owned>(Owned{scene, specimen}));
    return std::move(*terms);
  };
  Simulation simulation(specimen->body, make, std::move(options));
  const std::shared_ptr<Rig> rig = add_surroundings(simulation.model(), *specimen, experiment, choice);
  SimulationState begin = simulation.save();
  load_in_full(*scene, rig, simulation.model(), begin.state);
  begin.supports = simulation.model().supports;
  simulation.restore(begin);
  *here = false;
  return simulation;
}

namespace {

Material material_of(Reader reader, const Catalog& catalog = built_in_catalog()) {
  if (reader.has("fields")) reader.at("fields").fail("are those of a body: write the material into the scene, as keys");
  return read_material(reader, catalog.material_laws);
}

Body body_of(const Reader& reader, const Material& material, std::vector<std::string>& warnings,
             std::vector<std::string>& notes) {
  Body body = read_body(reader, material, {warnings, notes});
  check_material(reader, material, body);
  return body;
}

}  // namespace

Material make_material(const std::string& yaml) {
  return material_of(open_scene(SceneSource::of_text("material", yaml), {}, kMostMolecules));
}

Material make_material(const HeldScene& held, const Catalog& catalog) {
  return material_of(open_scene(held, {}, kMostMolecules), catalog);
}

Body make_body(const std::string& yaml, const Material& material, std::vector<std::string>& warnings,
               std::vector<std::string>& notes) {
  return body_of(open_scene(SceneSource::of_text("body", yaml), {}, kMostMolecules), material, warnings, notes);
}

Body make_body(const HeldScene& held, const Material& material, std::vector<std::string>& warnings,
               std::vector<std::string>& notes) {
  return body_of(open_scene(held, {}, kMostMolecules), material, warnings, notes);
}

}  // namespace elastin::lab
