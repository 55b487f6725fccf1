#include "lab/live/parcel.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "lab/live/live.h"

namespace elastin::lab {
namespace {

void add_strategy(const Scene& scene, const StrategyChoice& choice, Parcel& parcel) {
  const auto same = [&](const Parcel::Strategy& known) { return known.label == choice.label; };
  if (std::any_of(parcel.strategies.begin(), parcel.strategies.end(), same)) return;
  Specimen specimen = scene.specimen;
  prepare(specimen, choice.strategy);
  if (!unsuited(specimen, *scene.experiment, choice).empty()) return;
  parcel.strategies.push_back({choice.label, choice.name.text(), choice.values});
  if (specimen.body.voronoi && !parcel.body.voronoi) parcel.body.voronoi = specimen.body.voronoi;
  for (std::size_t i = 0; i < parcel.body.parts.size(); ++i)
    if (const auto& own = specimen.body.parts[i].voronoi; own && !parcel.body.parts[i].voronoi)
      parcel.body.parts[i].voronoi = own;
}

/// The scene's own strategy first, of a calibrated one the rule alone, then those that it compares, then every other
/// one that suits, none calibrated: the scene's experiment would do that, and a page has no experiment.
void add_strategies(const Scene& scene, const Catalog& catalog, Parcel& parcel) {
  StrategyChoice own = scene.stiffness;
  if (std::exchange(own.name.calibrated, false)) {
    const ParameterValues values = std::move(own.values);
    own = choose_strategy(catalog, own.name);
    own.values = values;
  }
  std::vector<StrategyChoice> choices{std::move(own)};
  choices.insert(choices.end(), scene.strategies.begin(), scene.strategies.end());
  const std::vector<StrategyChoice> all = all_strategies(catalog, scene.specimen);
  choices.insert(choices.end(), all.begin(), all.end());
  for (const StrategyChoice& choice : choices)
    if (!choice.name.calibrated) add_strategy(scene, choice, parcel);
  if (parcel.strategies.empty())
    throw InputError(scene.source.path() +
                     ": no strategy suits this body but calibrated ones, which a page cannot make");
}

/// The test of a scene that has none: along the longest side of the body, by as little as 1e-4.
TensionSetup usual_tension(const Scene& scene) {
  const Positions& rest = scene.specimen.body.rest;
  const Vector3 size = rest.rowwise().maxCoeff() - rest.rowwise().minCoeff();
  TensionSetup setup;
  Eigen::Index longest = 2;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (size[axis] > size[longest] * (1 + 1e-9)) longest = axis;
  setup.axis = Vector3::Unit(longest);
  setup.displacement = 1e-4 * size[longest];
  setup.thickness = scene.specimen.material.thickness;
  return setup;
}

/// What holds the body once the load of its experiment is gone. Under a hand the end of a tension test is clamped: its
/// grips may slide, and the body would be pulled away.
void add_supports(const std::vector<Support>& supports, const TensionSetup* tension, Parcel& parcel) {
  for (Support support : supports) {
    if (support.free.isIdentity()) continue;
    if (tension && std::abs(tension->axis.dot(support.free * tension->axis)) < 1e-9) support.free.setZero();
    support.displacement.setZero();
    support.velocity.setZero();
    parcel.supports.push_back(support);
  }
}

/// What the bodies of a page have not.
void note_left_out(const Scene& scene, Parcel& parcel) {
  const auto note = [&](std::string text) { parcel.left_out.push_back(std::move(text)); };
  if (scene.specimen.contact) note("contact and its obstacles");
  if (const std::size_t kept = parcel.loads.size(), all = scene.specimen.loads.size(); kept < all)
    note(counted(static_cast<std::ptrdiff_t>(all - kept), "load") + " in time or on a part of the surface");
  for (const Parcel::NamedLoad& load : parcel.loads)
    if (load.name == "rayleigh" && load.values.has("stiffness")) note("the damping by stiffness of `rayleigh`");
  if (scene.specimen.start) note("the initial state");
  const bool own = scene.stiffness.name.calibrated;
  std::string names = own ? scene.stiffness.label : "";
  std::ptrdiff_t count = own;
  for (const StrategyChoice& choice : scene.strategies)
    if (choice.name.calibrated && (!own || choice.label != scene.stiffness.label))
      names += (count++ > 0 ? ", " : "") + choice.label;
  constexpr std::ptrdiff_t most = 4;  // that are named
  if (count == 0) return;
  note("calibration, of " + (count > most ? counted(count, "strategy", "strategies") : names) +
       (own ? ": the page begins with " + parcel.strategies.front().label + " as it is" : ""));
}

/// What a load that is not yet there adds in full [N], if that is the same wherever the body is; otherwise nothing: a
/// tool that touches and a pressure that turns with the surface are no dead load.
Positions dead_load(StaticRig& rig, Model& model, const State& rest) {
  State larger = rest;
  larger.positions *= 1.01;
  const auto added = [&](const State& state) -> Positions {
    rig.set_load(1);
    const Positions loaded = model.load_forces(state);
    rig.set_load(0);
    return loaded - model.load_forces(state);
  };
  const Positions here = added(rest), there = added(larger);
  return (there - here).norm() <= 1e-9 * here.norm() ? here : Positions(3, 0);
}

/// The load of what an experiment in time is held and loaded by, and how much of it acts as the body begins.
void add_fixture_load(const Scene& scene, const Specimen& specimen, Model& model, const State& start, Parcel& parcel) {
  const StaticExperiment* fixture = scene.experiment->calibration();
  if (!fixture) return;
  Run run;
  const auto held = make_model(specimen, *fixture, scene.stiffness, {scene.statics}, run);
  if (!held) return;
  parcel.own_load = dead_load(*held->rig->at_rest(), *held->model, start);
  if (parcel.own_load.isZero(0)) return;
  const Positions acting = model.load_forces(start) - held->model->load_forces(start);
  parcel.own_load_share = acting.cwiseProduct(parcel.own_load).sum() / parcel.own_load.squaredNorm();
}

/// The experiment's own load, its supports, and where the body begins.
void add_experiment(const Scene& scene, const TensionSetup* tension, Parcel& parcel) {
  Specimen specimen = scene.specimen;
  prepare(specimen, scene.stiffness.strategy);
  Run run;
  const auto held = make_model(specimen, *scene.experiment, scene.stiffness, {scene.statics}, run);
  if (!held) throw InputError(scene.source.path() + ": " + run.cause);
  Model& model = *held->model;
  State state = state_at_rest(specimen.body);
  model.declare_history(state);
  if (TimedRig* timed = held->rig->in_time()) {
    const StaticResult started = timed->start(state, scene.statics);
    if (started.outcome != Outcome::converged)
      throw InputError(scene.source.path() + ": the body cannot be brought to its start: " + started.cause);
    add_fixture_load(scene, specimen, model, state, parcel);
    if (!scene.experiment->calibration())
      parcel.left_out.push_back("what acts in its experiment `" + scene.experiment->name() + "`");
    else if (model.drive)
      parcel.left_out.emplace_back("what moves its supports, or changes its load, in time");
  } else if (StaticRig* rig = held->rig->at_rest()) {
    const bool of_scene = scene.experiment->name() == "loads";  // which are in the parcel already
    if (!tension && !of_scene) parcel.own_load = dead_load(*rig, model, state);
    parcel.own_load_share = 1;
    rig->release(state);
  }
  if (parcel.own_load.isZero(0) || !parcel.own_load.allFinite()) parcel.own_load.resize(3, 0);
  parcel.positions = state.positions;
  add_supports(model.supports, tension, parcel);
}

}  // namespace

Parcel make_parcel(const Scene& scene, const Catalog& catalog) {
  const Specimen& specimen = scene.specimen;
  if (specimen.body.connections.size() > kMostLiveConnections)
    throw InputError(scene.source.path() + ": the body has " + std::to_string(specimen.body.connections.size()) +
                     " connections; a page takes at most " + std::to_string(kMostLiveConnections) +
                     ": make it coarser, with --set for example");
  if (specimen.body.size() < 2)
    throw InputError(scene.source.path() + ": the body is one molecule, of which a page shows nothing");
  if (specimen.given != GivenShape::at_rest)
    throw InputError(scene.source.path() + ": a page cannot find a rest; `elastin run --out` shows the body");
  std::vector<Material> materials = specimen.materials;
  materials.push_back(specimen.material);
  for (const Material& material : materials)
    if (const std::string why = beyond_numbers(material); !why.empty())
      throw InputError(scene.source.path() + ": " + why +
                       ", which a page cannot take; `elastin run --out` shows the body");
  Parcel parcel;
  parcel.body = specimen.body;
  if (const Rest* rest = specimen.body.unstressed.get())
    parcel.rest =
        sampled_rest(specimen.body, specimen.body.rest, rest->part && scene.experiment->at_rest() ? rest->part(1) : 1);
  parcel.material = specimen.material;
  parcel.materials = specimen.materials;
  parcel.linear = scene.statics.linear;
  parcel.tolerance = scene.statics.tolerance;
  for (const SpecimenLoad& load : specimen.loads)
    if (load.row) parcel.loads.push_back({load.row->first, load.row->second});
  add_strategies(scene, catalog, parcel);
  const TensionSetup* tension = tension_setup(*scene.experiment);
  parcel.tension = tension ? *tension : usual_tension(scene);
  parcel.own_test = tension != nullptr;
  if (tension)
    parcel.further_supports = scene.experiment->at_rest()->further_supports();
  else
    try {
      make_tension(parcel.body, parcel.tension);
    } catch (const InputError& error) {
      parcel.no_test = error.what();
    }
  note_left_out(scene, parcel);
  add_experiment(scene, tension, parcel);
  return parcel;
}

}  // namespace elastin::lab
