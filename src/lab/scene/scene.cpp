#include "lab/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <new>
#include <stdexcept>

#include "core/base/named.h"
#include "core/base/stopwatch.h"
#include "core/forces/bending.h"
#include "core/simulation/warnings.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/model/share.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/parts.h"
#include "elastin/core/simulation/prepare.h"
#include "elastin/core/solve/engine.h"
#include "lab/run/common_measures.h"
#include "lab/run/section.h"
#include "lab/run/specimen.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

std::vector<StrategyChoice> read_strategies(std::optional<Reader> reader, const StrategyChoice& stiffness,
                                            const Catalog& catalog, const Specimen& specimen) {
  if (!reader) return {stiffness};
  if (reader->is_text() && reader->text() == "all") return all_strategies(catalog, specimen);
  if (reader->is_text())
    reader->fail("write a list of strategies, or all; one alone is strategies: [" + reader->text() + "]");
  std::vector<StrategyChoice> strategies;
  std::optional<std::size_t> all;  // where in the list it stands
  for (const Reader& item : reader->items()) {
    if (item.is_text() && item.text() == "all") {
      all = all.value_or(strategies.size());
      continue;
    }
    StrategyChoice choice = read_strategy(item, catalog);
    if (find_strategy(strategies, choice.label))
      item.fail("'" + choice.label + "' is in the list already; give this one a label of its own");
    strategies.push_back(std::move(choice));
  }
  if (all) {
    std::vector<StrategyChoice> others = all_strategies(catalog, specimen);
    std::erase_if(others, [&](const StrategyChoice& other) { return find_strategy(strategies, other.label); });
    strategies.insert(strategies.begin() + static_cast<std::ptrdiff_t>(*all), others.begin(), others.end());
  }
  if (strategies.empty()) reader->fail("names no strategy; write a list of them, or all");
  return strategies;
}

/// Where the strategy of `run` stands: `stiffness`, or the first of `strategies`.
Reader own_strategy(Reader& scene) {
  if (!scene.has("stiffness"))
    if (const auto strategies = scene.find("strategies"); strategies && strategies->is_list())
      if (const std::vector<Reader> items = strategies->items();
          !items.empty() && !(items.front().is_text() && items.front().text() == "all"))
        return items.front();
  return scene.at("stiffness", "needed, or a list of `strategies`");
}

/// The scene's own strategy. A law of solids that says nothing of its volume keeps it where it would lock otherwise.
StrategyChoice read_stiffness(Reader reader, const Catalog& catalog, Scene& scene) {
  StrategyChoice written = read_strategy(reader, catalog);
  const auto& stated = scene.specimen.material.law;
  if (stated && !catalog.material_laws.find(stated->law)->from_moduli &&
      written.strategy.kind == StrategyKind::cell_law && written.strategy.law != stated->law)
    scene.warnings.push_back("stiffness: '" + written.label + "' takes of the material's law " + stated->law +
                             " only its E and nu at rest; write stiffness: " + stated->law);
  if (reader.is_map() && reader.has("volume")) return written;
  StrategyChoice choice = without_locking(catalog, written, scene.specimen);
  if (choice.strategy.name == written.strategy.name) return choice;
  scene.notes.push_back("stiffness: " + choice.strategy.name +
                        ", since plain cells lock where nu is above 0.4; `volume: none` leaves the pressures out");
  if (reader.is_map() && reader.has("label")) choice.label = written.label;
  return choice;
}

/// {experiment: {kind: …}}: another experiment than the scene's own in which `calibrated:` rules are calibrated.
std::shared_ptr<const StaticExperiment> read_calibration(Reader reader, ExperimentContext context) {
  context.contact = nullptr;
  const Reader at = reader.at("experiment");
  const std::shared_ptr<const Experiment> experiment = read_experiment(at, context);
  reader.finish();
  const StaticExperiment* at_rest = experiment->at_rest();
  if (!at_rest || at_rest->identification() || calibrated_measure(*at_rest, context.material).empty())
    at.fail("a " + experiment->name() +
            " experiment measures on this body no modulus to calibrate to; take tension, shear or material");
  return {experiment, at_rest};
}

/// A strategy's volume term does not allow every Poisson's ratio that a material may have.
void check_volume_range(Reader material, const Specimen& specimen, const std::vector<StrategyChoice>& strategies) {
  std::vector<Material> materials = specimen.materials;
  if (materials.empty()) materials.push_back(specimen.material);
  const Reader at = material.has("poissons_ratio") ? material.at("poissons_ratio")
                    : material.has("bulk_modulus") ? material.at("bulk_modulus")
                                                   : material;
  for (const StrategyChoice& choice : strategies)
    for (const Material& values : materials)
      if (choice.strategy.volume_modulus) at.located([&] { return choice.strategy.volume_modulus(values); });
}

/// A state of rest of its own is what bodies are cut for.
void warn_of_pieces(const Body& body, const std::string& name, bool has_rest, std::vector<std::string>& warnings) {
  if (const std::string found = warning_of_pieces(body, name); !found.empty())
    warnings.push_back(found + "; `elastin check` names them");
  else if (std::string seams = has_rest ? "" : warning_of_seams(body, name); !seams.empty())
    warnings.push_back(std::move(seams));
}

/// Experiments that have planes of symmetry of their own show what the whole body shows; a support that holds a half in
/// such a plane knows no whole.
void refuse_halves(const Reader& supports, Reader experiment, const ExperimentCatalog& experiments) {
  if (const auto fixture = experiment.find("fixture")) experiment = *fixture;
  const std::vector<SceneKey> keys = keys_of(experiments.find(experiment.at("kind").text()));
  if (std::none_of(keys.begin(), keys.end(), [](const SceneKey& key) { return key.name == "symmetry"; })) return;
  for (Reader item : supports.items())
    if (const auto plane = item.find("symmetry"))
      plane->fail(
          "this experiment has planes of symmetry of its own, with which its force and modulus are those of the "
          "whole body: give them as `symmetry` of the experiment");
}

using BodyChange = std::function<void(Body&, const Material&)>;

/// A key of the scene itself.
struct TopKey {
  SceneKey row;
  bool of_problem = false;  ///< whether scenes in which it differs are different problems
};

const std::vector<TopKey>& top_keys() {
  static const std::vector<TopKey> keys{
      {{"title", "text", "", "", "the file's name", "heading of tables and pages"}},
      {{"extends", "file next to the scene", "", "", "none",
        "a scene whose keys count where this one has none; an empty value takes a key away, another `kind` the whole "
        "map"}},
      {{"values", "map of quantities", "", "", "none", "names for [formulas](#formulas): `spacing: = side / 9`"}},
      {{"model", "file next to the scene", "", "", "none",
        "[a model of FEBio](#febio-models), in place of all keys but `title`, `solver` and `expect`"}},
      {{"body", "map", "", "", "needed, or `bodies`", "[the body](#body)"}},
      {{"bodies", "list of maps", "", "", "none", "[several bodies](#bodies)"}},
      {{"ties", "list of maps", "", "", "none", "[joints between bodies](#bodies)"}},
      {{"material", "map", "", "", "needed", "[the material](#material)"}, true},
      {{"stiffness", "word, or map", "", "", "needed, or a list of `strategies`",
        "[the strategy](#stiffness) of `run`; without it the first of `strategies`"}},
      {{"strategies", "list, or `all`", "", "", "`stiffness`",
        "the strategies of `compare`; `all` in the list adds those not named before it, with `+volume` where "
        "the body's cells and Poisson's ratio allow it"}},
      {{"experiment", "map", "", "", "needed", "[the experiment](#experiment)"}, true},
      {{"calibrate", "map", "", "", "the scene's own",
        "`experiment`: the [experiment](#experiment) at rest in which `calibrated:` rules are calibrated, so that "
        "what "
        "the scene measures is a test of them"}},
      {{"supports", "list of maps", "", "", "none",
        "[planes of symmetry, rims and others](#supports) that stay; with experiments at rest, and a `fixture` in "
        "time"},
       true},
      {{"time", "map", "", "", "needed in time", "[duration, steps and frames](#time) of an experiment in time"}},
      {{"loads", "list of maps", "", "", "none", "[loads](#loads) besides the experiment's"}, true},
      {{"rest", "map", "", "", "the body as described",
        "[where the body is unstressed](#rest), if not as it is described: growth, swelling, heat, prestretch"},
       true},
      {{"initial", "map", "", "", "rest", "[where the search or the run begins](#initial-state)"}, true},
      {{"rotate", "rotation", "", "", "none", "turns the whole scene"}, true},
      {{"contact", "map", "", "", "none", "[contact](#contact)"}, true},
      {{"solver", "map", "", "", "Newton's method", "[the solver](#solver) of equilibria"}},
      {{"reference", "list of maps, `computed`, or `none`", "", "",
        "`computed` where nothing shows the material's values",
        "[values](#reference) that errors are computed against: from elsewhere, or the solid's own limit"}},
      {{"expect", "list of maps", "", "", "none", "[what must come out](#expectations); exit code 1 if one fails"}},
      {{"study", "map", "", "", "none", "[what `compare` varies](#study)"}},
      {{"uncertainty", "map of keys to quantities or intervals", "", "", "none",
        "[standard deviations](#uncertainty) of numbers of the scene, which give every measure its own"}},
      {{"identify", "map", "", "", "none", "[measured tests](#identification) that `identify` fits the material to"}},
      {{"steppers", "map", "", "", "none", "[steppers to compare in place of strategies](#steppers)"}},
      {{"engines", "map", "", "", "none", "[engines that `compare` runs too](#engines-1)"}}};
  return keys;
}

/// What makes the scene's problem, but for its body.
std::string problem_text(Reader& reader, const Scene& scene) {
  std::string text = scene.statics.linear ? "small" : "large";
  for (const TopKey& key : top_keys())
    if (const auto value = key.of_problem ? reader.find(key.row.name) : std::nullopt)
      text += "\n" + key.row.name + ": " + value->content();
  for (const char* key : {"body", "bodies"})
    if (scene.specimen.body.cell_stiffness.size() > 0 && reader.has(key))
      text += "\n" + std::string(key) + ": " + reader.at(key).content();
  return text;
}

/// Whether something in here picks molecules by a set. Notes no key as read.
bool names_set(const Reader& value) {
  if (value.is_list()) {
    const std::vector<Reader> items = value.items();
    return std::any_of(items.begin(), items.end(), names_set);
  }
  if (!value.is_map()) return false;
  const auto entries = value.entries();
  return std::any_of(entries.begin(), entries.end(),
                     [](const auto& entry) { return entry.first == "set" || names_set(entry.second); });
}

/// Whether an experiment, and that of its fixture, measures a body of which several processes have shares.
bool is_of_shares(Reader experiment, const ExperimentCatalog& experiments) {
  if (!experiment.is_map() || !experiment.has("kind")) return false;
  const std::string kind = experiment.at("kind").text();
  const auto& all = experiments.experiments();
  const bool own =
      std::any_of(all.begin(), all.end(), [&](const auto& info) { return info.name == kind && info.of_shares; });
  const auto fixture = own ? experiment.find("fixture") : std::nullopt;
  return own && (!fixture || is_of_shares(*fixture, experiments));
}

/// Why each of several processes needs the whole body; "" where shares of it do.
std::string needs_whole_body(Reader& reader, const Catalog& catalog, const ExperimentCatalog& experiments) {
  for (const char* key : {"bodies", "contact", "initial", "calibrate", "rest"})
    if (reader.has(key)) return "`" + std::string(key) + "` is read on the whole body";
  for (const auto& [key, value] : reader.entries())  // the body's file has sets, which one process reads alone
    if ((key == "supports" || key == "loads" || key == "experiment") && names_set(value))
      return "sets of molecules are read on the whole body";
  for (const char* key : {"fields", "bending"})
    if (reader.at("material").has(key)) return "`material." + std::string(key) + "` is read on the whole body";
  std::vector<std::string> able;
  for (const auto& load : scene_loads(catalog))
    if (load->of_shares) able.push_back(load->name);
  if (auto loads = reader.find("loads"))
    for (Reader& item : loads->items())
      if (!item.is_map() || std::none_of(able.begin(), able.end(), [&](const auto& name) { return item.has(name); }))
        return "loads other than " + joined(able) + " are read on the whole body";
  return is_of_shares(reader.at("experiment"), experiments) ? "" : "the experiment is measured on the whole body";
}

/// The same of its strategy, seen on a share.
std::string needs_whole_body(const Strategy& strategy, const Body& share, const Material& material) {
  if (lacks_voronoi(share, strategy, {material})) return "its Voronoi cells are those of the whole";
  if (strategy.joins_molecules) return "the rule's equations join all molecules";
  return "";
}

/// The scene's one body; of several processes that solve it together each has its share where that is possible.
Body read_one_body(Reader& reader, const Catalog& catalog, const ExperimentCatalog& experiments, Scene& scene) {
  const Material& material = scene.specimen.material;
  Remarks remarks{scene.warnings,  scene.notes,           nullptr, &scene.specimen.material.field,
                  &scene.specimen, &catalog.material_laws};
  for (const auto& [key, section] : reader.entries())  // without noting it: messages list keys as they are read
    if (const std::vector<std::string> keys = section.keys(); key == "experiment")
      remarks.section_is_given = std::find(keys.begin(), keys.end(), "cross_section") != keys.end();
  const auto make = [&] {
    Body body = read_body(reader.at("body"), material, remarks);
    if (!reader.has("contact")) warn_of_pieces(body, "the body", reader.has("rest"), scene.warnings);
    return body;
  };
  const auto processes = scene.statics.engine ? scene.statics.engine->processes() : nullptr;
  if (!processes) return make();
  std::string why = needs_whole_body(reader, catalog, experiments);
  const bool alone = why.empty() && makes_shares(reader.at("body"), processes->count());
  Body body = !why.empty() ? make()
              : alone      ? read_body(reader.at("body"), material, remarks, processes)
                           : share_out(make, processes, why);
  if (body.share) why = needs_whole_body(read_strategy(own_strategy(reader), catalog).strategy, body, material);
  if (!why.empty() && body.share) body = make();
  scene.whole_body = body.share ? "" : why;
  if (processes->count() == 1) return body;
  const std::string who = "each of " + std::to_string(processes->count()) + " processes has ";
  if (!body.share)
    scene.notes.push_back(who + "the whole body: " + why);
  else
    scene.notes.push_back(who + "its share of the body" + (alone ? ", which it made alone" : " from the first") +
                          ": this one " + counted(owned_molecules(body), "molecule") + " of its own and " +
                          std::to_string(body.size() - owned_molecules(body)) +
                          " of its neighbours; zero-energy modes are not counted");
  return body;
}

/// body: {…}, or bodies: [{…}, …] with ties: […]
void read_whole_body(Reader& reader, const Catalog& catalog, const ExperimentCatalog& experiments, Scene& scene,
                     const BodyChange& change) {
  Specimen& specimen = scene.specimen;
  const Remarks remarks{scene.warnings, scene.notes};
  auto ties = reader.find("ties");
  const auto fields = reader.at("material").find("fields");
  if (auto several = reader.find("bodies")) {
    if (fields) fields->fail("belongs to one body: give that a `material` with it");
    if (auto one = reader.find("body")) one->fail("there are `bodies` already; put it into that list, with a name");
    read_bodies(*several, ties, catalog.material_laws, specimen, remarks);
    for (const Part& part : specimen.body.parts)  // a rigid body needs no connections
      if (!part.rigid)
        warn_of_pieces(part_alone(specimen.body, part).body, "body '" + part.name + "'", reader.has("rest"),
                       scene.warnings);
    return;
  }
  if (ties) ties->fail("joins several `bodies`; the scene has one");
  if (!reader.has("body"))
    if (const auto identify = reader.find("identify"))
      identify->fail("the scene has no body: it is one for `elastin identify`");
  specimen.body = read_one_body(reader, catalog, experiments, scene);
  scene.bare_graph = (reader.at("body").has("molecules") || reader.at("body").given_body("given") ||
                      reader.at("body").given_body("given_shape")) &&
                     specimen.body.tetrahedra.empty() && specimen.body.triangles.empty();
  if (fields && !specimen.materials.empty())
    fields->fail("goes with labels whose materials have E, nu and density alone");
  if (fields) set_fields(*fields, catalog.material_laws, specimen.material, specimen.body);
  if (change) {
    change(specimen.body, specimen.material);
    MoleculeSets sets = reader.mesh_sets();
    add_between(specimen.body, sets);
    reader.set_mesh_sets(std::move(sets));
  }
  check_material(reader.at("material"), specimen.material, specimen.body);
  const auto bending = reader.at("material").find("bending");
  if (specimen.material.bending_rigidity > 0)
    (bending ? *bending : reader.at("material")).located([&] { prepare_bending(specimen.body, specimen.material); });
  constexpr double even = 1.1;
  const double excess =
      specimen.material.bending_rigidity > 0 ? bending_excess(specimen.body, specimen.material.poissons_ratio) : 1;
  if (excess > even)
    scene.warnings.push_back("the triangles lie so that the sheet is up to " + number(excess, 2) +
                             " times as stiff as it should be where it is bent or twisted, however fine they are; cut "
                             "squares by `pattern: one_way`");
}

void turn_fibres(Specimen& specimen, const Matrix3& rotation) {
  rotate(specimen.material, rotation);
  for (Material& material : specimen.materials) rotate(material, rotation);
}

/// Parts whose materials state laws of their own get them.
void set_laws(const Catalog& catalog, Scene& scene) {
  Specimen& specimen = scene.specimen;
  if (specimen.body.parts.empty()) return;
  specimen.laws = std::make_shared<const Catalog>(catalog);
  for (const Part& part : specimen.body.parts) {
    const Material& own = specimen.materials[part.material];
    if (part.rigid || !states_own_law(own, specimen.materials)) continue;
    scene.notes.push_back("body '" + part.name + "': laws of cells are " + own.law->law +
                          " there, whatever `stiffness` says");
    if (own.poissons_ratio > kLocking && part.tetrahedra.count > 0 && part.blocks.count == 0)
      scene.warnings.push_back("body '" + part.name + "': its tetrahedra have no volume term of " + own.law->law +
                               ", and may lock: nu = " + number(own.poissons_ratio, 4) +
                               "; use hexahedra, or cells of second order");
  }
}

/// Says what an engine that is not this process alone cannot take.
void refuse_of_engine(Reader& reader, const Scene& scene, bool timed, bool contact) {
  Reader solver = reader.at("solver");
  const Reader engine = solver.at("engine");
  const std::string name = "'" + engine.text() + "' ";
  if (is_stressed(scene.specimen)) engine.fail(name + "goes without `rest`; write engine: threads");
  if (contact) engine.fail(name + "goes without contact, which stays on one process; write engine: threads");
  if (!timed) return;
  if (!scene.specimen.body.share)
    engine.fail(name + "steps bodies of which each process has its share, and of this one each has the whole: " +
                (scene.whole_body.empty() ? "the engine has no processes" : scene.whole_body) +
                "; write engine: threads");
  if (const auto linear = solver.find("linear_solver"); linear && linear->text() == "multigrid")
    linear->fail("'multigrid' does not go with steps in time of engine: " + engine.text() +
                 ", whose inertia keeps iterations few; allowed: automatic, pcg");
}

/// A model of another program, with the keys of a scene that go with it.
/// @param reader of a scene that names the model, or of keys alone that the command line changes
std::unique_ptr<Scene> read_other_format(const SceneFormat& format, const SceneSource& model, const SceneSource& source,
                                         Reader reader, const Catalog& catalog, double most_molecules) {
  const Stopwatch watch;
  for (const std::string& key : reader.keys())
    if (key != "model" && key != "title" && key != "solver" && key != "expect")
      reader.at(key).fail(model.path() + " is a " + format.summary +
                          ": of a scene's keys it takes title, solver and expect; change the rest there");
  auto scene = format.read(model);
  if (scene->specimen.body.size() > most_molecules)
    throw InputError(SourceLocation{model.path()}, "the model has more molecules than are allowed");
  scene->source = source;
  scene->name = std::filesystem::path(source.path()).stem().string();
  if (const auto title = reader.find("title")) scene->title = title->text();
  if (scene->title.empty()) scene->title = scene->name;
  if (auto solver = reader.find("solver")) {
    for (const char* key : {"displacements", "engine", "method"})
      if (const auto own = solver->find(key)) own->fail(std::string("goes with no ") + format.summary);
    scene->statics = read_solver(*solver, catalog);
  }
  scene->strategies = {scene->stiffness};
  scene->measures = std::make_shared<const MeasureList>(measures_of(*scene->experiment));
  if (auto expect = reader.find("expect"))
    scene->expectations = read_expectations(*expect, scene->strategies, catalog, *scene->measures);
  reader.finish();
  scene->build_seconds = watch.seconds();
  return scene;
}

/// The file that `model` names.
std::unique_ptr<Scene> read_model(const Reader& model, const SceneSource& source, const Reader& reader,
                                  const Catalog& catalog, double most_molecules) {
  const std::string path = path_next_to(model);
  if (const SceneFormat* format = scene_format_of(path))
    return read_other_format(*format, source.other(path), source, reader, catalog, most_molecules);
  std::string endings;
  for (const auto& format : scene_formats()) endings += (endings.empty() ? "" : ", ") + format->ending;
  model.fail("'" + model.text() + "' is no model of another program; allowed: files that end with " + endings);
}

std::unique_ptr<Scene> read_scene(const SceneSource& source, const Catalog& catalog,
                                  const std::vector<std::string>& overrides, double most_molecules,
                                  const ExperimentCatalog& experiments, const BodyChange& change = {}) {
  const Stopwatch watch;
  Reader reader = open_scene(source, overrides, most_molecules);
  reader.set_owners([&](const std::string& key) { return owners_of(key, key_sections(catalog, experiments)); });
  read_preamble(reader);
  if (const auto model = reader.find("model")) return read_model(*model, source, reader, catalog, most_molecules);
  auto scene = std::make_unique<Scene>();
  scene->source = source;
  scene->name = std::filesystem::path(source.path()).stem().string();
  scene->title = reader.has("title") ? reader.at("title").text() : scene->name;
  scene->specimen.material = read_material(reader.at("material"), catalog.material_laws);
  if (auto solver = reader.find("solver")) scene->statics = read_solver(*solver, catalog);
  read_whole_body(reader, catalog, experiments, *scene, change);
  const auto rest = reader.find("rest");
  if (rest) set_rest(*rest, scene->specimen);
  const Matrix3 rotation = reader.has("rotate") ? reader.at("rotate").rotation() : Matrix3(Matrix3::Identity());
  if (reader.has("rotate")) rotate(scene->specimen.body, rotation);
  scene->rotation = rotation;
  turn_fibres(scene->specimen, rotation);
  set_laws(catalog, *scene);
  scene->specimen.law = stated_law(catalog, scene->specimen.material, scene->specimen.body);
  scene->stiffness = read_stiffness(own_strategy(reader), catalog, *scene);
  scene->strategies = read_strategies(reader.find("strategies"), scene->stiffness, catalog, scene->specimen);
  const Reader experiment = reader.at("experiment");
  ExperimentContext context{scene->specimen.body, scene->specimen.material, rotation, scene->statics, experiments};
  Findings found;
  context.findings = &found;
  std::optional<SceneContact> contact;
  if (auto value = reader.find("contact")) {
    contact = read_contact(*value, scene->specimen.body, scene->specimen.material, rotation, found);
    context.contact = &*contact;
  }
  std::unique_ptr<Experiment> made = read_experiment(experiment, context);
  scene->notes.insert(scene->notes.end(), found.notes.begin(), found.notes.end());
  scene->warnings.insert(scene->warnings.end(), found.warnings.begin(), found.warnings.end());
  context.findings = nullptr;  // calibration holds the same body
  if (const auto calibrate = reader.find("calibrate"))
    scene->specimen.calibration = read_calibration(*calibrate, context);
  const bool timed = made->in_time() != nullptr;
  if (rest) check_rest(*rest, timed);
  if (scene->statics.engine) refuse_of_engine(reader, *scene, timed, contact.has_value());
  if (const auto supports = reader.find("supports")) {
    auto* at_rest = dynamic_cast<StaticExperiment*>(made.get());
    if (auto* in_time = dynamic_cast<TimedExperiment*>(made.get())) at_rest = in_time->fixture();
    if (!at_rest)
      supports->fail("goes with experiments at rest and with a `fixture`; a " + made->name() +
                     " has none. `kind: motion` with `fixture: {kind: loads}` runs through time with these supports");
    refuse_halves(*supports, experiment, experiments);
    at_rest->set_further_supports(read_supports(*supports, scene->specimen.body, rotation));
  }
  scene->experiment = std::move(made);
  if (contact && !timed && scene->statics.linear)
    reader.at("solver")
        .at("displacements")
        .fail("one linear solve cannot find what touches; with `contact` displacements are large");
  if (contact) {
    check_motions(*contact, timed);
    reader.at("contact").located([&] { contact::make_contact(scene->specimen.body, *contact); });
    scene->specimen.contact = std::move(*contact);
  }
  const auto time = reader.find("time");
  if (time && !timed)
    time->fail("a " + scene->experiment->name() + " experiment is at rest and needs no time; those that do are " +
               timed_experiment_names(experiments));
  if (!time && timed)
    experiment.fail("a " + scene->experiment->name() + " experiment runs through time: key 'time' is missing, " +
                    "for example time: {duration: 1 s}");
  if (time) scene->time = read_time(*time, catalog.steppers);
  if (time && scene->time->stepper && (*scene->time->stepper)->is_explicit && scene->specimen.contact &&
      scene->specimen.contact->penetration > 0)
    reader.at("contact").at("penetration").fail(needs_implicit_steps());
  if (time && scene->specimen.body.share) {
    Reader keys = reader.at("time");
    if (scene->time->checkpoint)
      keys.at("checkpoint").fail("several processes that share a body write no restart files; leave it out");
    if (scene->time->budget > 0)
      keys.at("budget").fail(
          "the clocks of several processes that share a body would choose different steps; leave it out");
  }
  if (auto initial = reader.find("initial"))
    scene->specimen.start = read_initial(*initial, scene->specimen.body, rotation, timed);
  if (auto loads = reader.find("loads"))
    for (const Reader& item : loads->items()) {
      SceneLoad load = read_load(item, scene_loads(catalog), scene->specimen.body, scene->specimen.material, rotation);
      if (load.changes_in_time && !timed) item.fail("an experiment at rest has no time: in_time has no meaning here");
      if (!load.acts_at_rest && !timed)
        scene->warnings.push_back(item.path() +
                                  ": acts on moving bodies only; it changes nothing in a static experiment");
      if (!load.warning.empty()) scene->warnings.push_back(item.path() + ": " + load.warning);
      scene->specimen.loads.push_back(std::move(load.load));
    }
  if (scene->time) scene->time->follows = reader.time_functions();
  std::vector<StrategyChoice> known = scene->strategies;
  known.push_back(scene->stiffness);
  check_volume_range(reader.at("material"), scene->specimen, known);
  scene->measures = std::make_shared<const MeasureList>(measures_of(*scene->experiment));
  MeasureList measures = *scene->measures;  // what others have is known, too: it is not measured here
  if (reader.has("expect") || reader.has("reference")) measures.add(measures_of(experiments));
  if (auto expect = reader.find("expect")) {
    scene->expectations = read_expectations(*expect, known, catalog, measures);
    for (std::size_t i = 0; i < scene->expectations.size(); ++i)
      if (const std::string& wanted = scene->expectations[i].strategy; !wanted.empty() && !find_strategy(known, wanted))
        scene->warnings.push_back(expect->items()[i].path() + ": no run of this scene is with " + wanted +
                                  ", so that `run` and `compare` do not check it; add it to `strategies`");
  }
  if (auto references = reader.find("reference")) read_references(*references, catalog, measures, *scene);
  scene->problem = problem_text(reader, *scene);
  if (auto study = reader.find("study")) scene->study = read_study(*study, known);
  if (auto steppers = reader.find("steppers")) scene->steppers = read_stepper_study(*steppers, catalog.steppers);
  if (auto engines = reader.find("engines")) scene->engines = read_engine_study(*engines);
  if (const auto uncertainty = reader.find("uncertainty")) read_uncertainty(*uncertainty, overrides, *scene);
  if (const auto identify = reader.find("identify")) check_identify(*identify);
  reader.finish();
  scene->build_seconds = watch.seconds();
  return scene;
}

}  // namespace

const StrategyChoice* find_strategy(const std::vector<StrategyChoice>& choices, const std::string& label) {
  const auto found =
      std::find_if(choices.begin(), choices.end(), [&](const auto& choice) { return choice.label == label; });
  return found == choices.end() ? nullptr : &*found;
}

namespace {

/// Why the material's E, G and K at rest are no targets of an experiment: the body has others too, or the experiment
/// has no uniform strain, in which the law would show its own; or "".
std::string no_target(const Scene& scene) {
  constexpr double usual = 0.01;  // strain up to which a curve must be straight
  const StaticExperiment* experiment = scene.experiment->at_rest();
  const Material& material = scene.specimen.material;
  if (!experiment) return "";
  const std::vector<MainMeasure> measures = experiment->main_measures(material, {});
  const bool has_target =
      std::any_of(measures.begin(), measures.end(), [](const auto& one) { return std::isfinite(one.prescribed); });
  if (std::string why = no_one_modulus(scene.specimen); !why.empty())
    return has_target ? why + ", so the modulus is apparent; compare with the material's own law on cells, refined"
                      : "";
  if (material.active && experiment->axis())
    return "muscle is at work, so the material's E and nu are no targets; compare with its own law on cells, refined";
  const bool small = scene.statics.linear || experiment->of_small_strains(), along = experiment->axis().has_value();
  if (small ? along && !material.law : along || experiment->uniform({})) return "";
  if (!has_target) return "";
  const std::string why = no_isotropic_moduli(material, small ? 0 : usual);
  return why.empty() ? ""
                     : why +
                           ", so its E, G and nu at rest are no targets of this experiment; compare with its own law "
                           "on cells, refined";
}

}  // namespace

std::string no_reference(const Scene& scene) {
  if (is_stressed(scene.specimen))
    return "the body is stressed without its load, which no modulus shows; compare with a law of cells, refined";
  const std::string own = scene.experiment->no_reference();
  return own.empty() ? no_target(scene) : own;
}

StrategyChoice choose_strategy(const Scene& scene, const Catalog& catalog, const std::string& label) {
  const StrategyChoice* known = find_strategy(scene.strategies, label);
  if (scene.stiffness.label == label && (!known || known->values.empty())) known = &scene.stiffness;
  return known ? *known : choose_strategy(catalog, label);
}

namespace {

std::unique_ptr<Scene> read_scene_or_say(const SceneSource& source, const Catalog& catalog,
                                         const std::vector<std::string>& overrides, double most_molecules,
                                         const ExperimentCatalog& experiments, const BodyChange& change) {
  const auto too_large = [&] {
    return InputError(SourceLocation{source.path()}, "the scene does not fit into this machine's memory");
  };
  try {
    if (const SceneFormat* format = scene_format_of(source.path()))
      return read_other_format(*format, source, source,
                               open_scene(SceneSource::of_text(source.path(), "{}"), overrides, most_molecules),
                               catalog, most_molecules);
    return read_scene(source, catalog, overrides, most_molecules, experiments, change);
  } catch (const std::bad_alloc&) {
    throw too_large();
  } catch (const std::length_error&) {
    throw too_large();
  }
}

}  // namespace

std::unique_ptr<Scene> load_scene(const SceneSource& source, const Catalog& catalog,
                                  const std::vector<std::string>& overrides, double most_molecules,
                                  const ExperimentCatalog& experiments) {
  return read_scene_or_say(source, catalog, overrides, most_molecules, experiments, {});
}

std::unique_ptr<Scene> load_scene_on(const SceneSource& source, const Catalog& catalog,
                                     const std::vector<std::string>& overrides, const BodyChange& change) {
  return read_scene_or_say(source, catalog, overrides, kMostMolecules, built_in_experiments(), change);
}

std::vector<KeySection> scene_keys() {
  std::vector<SceneKey> rows;
  for (const TopKey& key : top_keys()) rows.push_back(key.row);
  return {{"", "Scene", "", std::move(rows)},
          {"rotation",
           "",
           "A *rotation*:",
           {{"axis", "direction", "", "", "needed", "axis of the rotation"},
            {"angle", "angle", "", "", "needed", "angle of the rotation, right-handed"}}}};
}

elastin::Table<SceneFormat>& scene_formats() {
  static elastin::Table<SceneFormat> formats("scene format");
  return formats;
}

const SceneFormat* scene_format_of(const std::string& path) {
  for (const auto& format : scene_formats())
    if (path.ends_with(format->ending)) return format.get();
  return nullptr;
}

}  // namespace elastin::lab
