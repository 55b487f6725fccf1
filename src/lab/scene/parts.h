#pragma once
#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/named.h"
#include "core/model/solid_cells.h"
#include "elastin/contact/contact.h"
#include "elastin/core/forces/time_function.h"
#include "elastin/core/model/body.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/experiment/inflation/inflation.h"
#include "lab/experiment/keys.h"
#include "lab/experiment/pick.h"
#include "lab/run/config_names.h"
#include "lab/run/material_numbers.h"
#include "lab/run/specimen.h"
#include "lab/run/time_options.h"

namespace elastin::lab {

/// Keys of the scene that change together, and the values that they take in turn.
struct StudyAxis {
  /// One a value: the keys with what they become, "body.lattice.molecules" = "[5, 5, 5]".
  std::vector<std::vector<std::pair<std::string, std::string>>> values;
};

/// What a comparison changes in addition to the strategy. One run for each combination of all axes.
struct Study {
  std::vector<StudyAxis> axes;
  int repeats = 1;           ///< of the whole comparison, one after the other
  std::vector<int> threads;  ///< numbers of threads; empty = the command's
  /// The strategy from whose own values under refinement the reference is extrapolated; empty = the scene's or the
  /// material's value counts.
  std::string own_reference;
  bool any() const { return !axes.empty() || repeats > 1 || !threads.empty(); }
};

/// A stepper with the parameters that a comparison of steppers leaves as they are.
struct StepperChoice {
  StepperMethod method;
  ParameterValues parameters = {};
};

/// What a comparison of steppers runs through: each stepper with each number of iterations and each time step.
struct StepperStudy {
  std::vector<StepperChoice> methods;
  std::vector<int> iterations{1, 4, 16, 64};
  std::vector<double> steps;  ///< [s]; empty = 1/25 and 1/100 of the loaded shape's period
};

/// Other programs that `compare` runs too, and how those that step in time run to rest.
struct EngineStudy {
  std::vector<Reader> names;
  double time_step = 1. / 60;     ///< [s]
  std::optional<int> iterations;  ///< of a step; none: the engine's own number
  double seconds = 120;           ///< after which an engine that has not answered is ended
  bool calibrate = false;         ///< multiply the constants until the engine shows the modulus that they have
};

/// "all", or names separated by commas. Throws InputError with the nearest name.
std::vector<StepperChoice> read_steppers(const std::string& names, const Table<StepperKind>& steppers);

/// One axis as a command line gives it: "KEY.PATH=[value, …]" or "{KEY.PATH: [value, …], KEY.PATH: …}".
StudyAxis read_axis(const std::string& text);

/// Each combination of the axes' values, the last axis fastest: the value of each key. One empty combination
/// without axes. Throws InputError where there are more than 100 000, and where a key replaces what another one before
/// it, or one of the overrides ("key.path=value"), has set.
std::vector<std::vector<std::pair<std::string, std::string>>> combinations(
    const std::vector<StudyAxis>& axes, const std::vector<std::string>& overrides = {});

struct Expectation;
struct Scene;

/// The parts of a scene, each from its own key. All throw InputError with position and key.
/// What it leaves out is that of `base`, if there is one.
Material read_material(Reader reader, const elastin::Table<MaterialLaw>& laws, const Material* base = nullptr);
/// What the `curve` or `secant_modulus` of a material is stated by; none without them.
std::optional<CurveNumbers> read_curve_numbers(Reader material);
/// What a material states in addition to its law, thickness, density and relaxation, as lines of a `material:` block
/// that takes its place in a scene of this folder: its file and name, fibres, softening.
std::string read_kept(Reader material, const std::string& folder);
/// Throws where a membrane has no thickness, or a solid is incompressible: above ν = 0.4999.
void check_material(Reader reader, const Material& material, const Body& body);
/// Of molecules, ascending, by the names that mesh files give them.
using MoleculeSets = std::map<std::string, std::vector<int>>;
/// Adds to each set the molecules of the body that lie between some of it alone: its cells are then those that they
/// were.
void add_between(const Body& body, MoleculeSets& sets);
/// Warnings and notes from reading a body, and, where somebody wants them, the sets of its mesh file.
struct Remarks {
  std::vector<std::string>&warnings, &notes;
  MoleculeSets* sets = nullptr;
  std::optional<MaterialField>* field = nullptr;  ///< of the material, which a body with materials of its own sets
  Specimen* specimen = nullptr;  ///< that gets the materials of parts and the image of a body, where it has them
  const elastin::Table<MaterialLaw>* laws = nullptr;  ///< of these materials
  bool section_is_given = false;                      ///< the experiment does not ask the body for its section
};
/// Masses and radii are set too. The body is as written: rotated later, with the experiment.
/// With processes: this one's share, where makes_shares says that it can be made alone.
Body read_body(Reader reader, const Material& material, Remarks remarks,
               const std::shared_ptr<const Processes>& processes = {});
/// Whether each of several processes can make its share of a body without the rest of it.
bool makes_shares(Reader body, int processes);
/// A list of bodies, each a part of one, and what ties them together; sets the specimen's body and materials. Its
/// material must be set.
void read_bodies(const Reader& list, std::optional<Reader> ties, const elastin::Table<MaterialLaw>& laws,
                 Specimen& specimen, Remarks remarks);
/// A mesh file that a scene names.
struct MeshFile {
  std::string path;
  double length_unit = 1;      ///< of its coordinates [m]
  std::optional<Reader> file;  ///< where it is named
  /// Points in metres. Throws InputError at the place that names the file.
  mesh::Mesh load() const;
};
Key<MeshFile> mesh_file_key(std::string text);
Key<MeshFile> length_unit_key();
/// A number in the range of a parameter, SI.
double read_parameter(const Reader& reader, const ParameterInfo& info);
/// A law's term: a number, or a list of them.
std::vector<double> read_term(const Reader& item, const std::vector<ParameterInfo>& columns);
/// The keys of all parameters that rows of a table have. A map has those of the row that it has chosen; `chosen` gets
/// it from the setup, or null.
template <class Setup, class Rows, class Chosen>
std::vector<Key<Setup>> parameter_keys(const Rows& rows, ParameterValues Setup::*values, Chosen chosen) {
  std::vector<SceneKey> known;
  for (const auto& row : rows)
    for (const ParameterInfo& info : row->parameters) {
      if (SceneKey* same = find_named(known, info.name)) {
        same->text.insert(same->text.find(": "), ", `" + row->name + "`");
        continue;
      }
      known.push_back(key_of(info));
      known.back().text = "of `" + row->name + "`: " + info.text;
    }
  std::vector<Key<Setup>> keys;
  for (SceneKey& own : known) {
    const auto find = [chosen, name = own.name](const Setup& setup) -> const ParameterInfo* {
      if (const auto* row = chosen(setup))
        for (const ParameterInfo& info : row->parameters)
          if (info.name == name) return &info;
      return nullptr;
    };
    keys.push_back(Key<Setup>(std::move(own), [find, values](const Reader& value, Setup& setup, const Frame&) {
                     const ParameterInfo& info = *find(setup);
                     (setup.*values)[info.name] = read_parameter(value, info);
                   }).when([find](const Setup& setup) { return find(setup) != nullptr; }));
  }
  return keys;
}
StrategyChoice read_strategy(Reader reader, const Catalog& catalog);
/// `strategies` are those of the scene: an expectation may name one by its label. `measures`: those that may be named.
std::vector<Expectation> read_expectations(const Reader& list, const std::vector<StrategyChoice>& strategies,
                                           const Catalog& catalog, const MeasureList& measures);
/// computed, none, {computed: {…}}, one stated value, or a list of stated values and `computed`.
void read_references(const Reader& reader, const Catalog& catalog, const MeasureList& measures, Scene& scene);
/// {vary: [{KEY.PATH: [value, …], …}, …], repeats: 5, threads: [1, 2], own_reference: STRATEGY}
Study read_study(const Reader& reader, const std::vector<StrategyChoice>& known);
/// Reads the section for its faults alone; see load_identify_task.
void check_identify(const Reader& reader);
/// Standard deviations of numbers that the scene, read with these overrides, states. Throws InputError.
void read_uncertainty(Reader reader, const std::vector<std::string>& overrides, Scene& scene);
StepperStudy read_stepper_study(const Reader& reader, const elastin::Table<StepperKind>& steppers);
EngineStudy read_engine_study(const Reader& reader);
/// Contact, and which obstacles' motions follow the load, and which the time.
struct SceneContact : contact::ContactOptions {
  std::vector<Reader> by_load, by_time;
};
SceneContact read_contact(const Reader& reader, const Body& body, const Material& material, const Matrix3& rotation,
                          Findings& findings);
/// Throws InputError on a motion that means nothing in this experiment.
void check_motions(const SceneContact& contact, bool timed);
/// The path of a file that a value names, relative to the folder of the scene or file in which the value stands.
std::string path_next_to(const Reader& reader);
StaticOptions read_solver(Reader reader, const Catalog& catalog);
/// Adds one load, or internal damping, to a model of the scene's body.
struct SceneLoad {
  SpecimenLoad load;
  bool acts_at_rest = true;      ///< false: drag and damping, which a static experiment does not feel
  bool changes_in_time = false;  ///< an experiment at rest must not have it
  std::string warning = {};      ///< of values that are hardly meant
};
/// What scenes name under `loads`: the catalog's, and those that stand on the ends of an experiment.
elastin::Table<LoadKind> scene_loads(const Catalog& catalog);
/// `rotation` turns its directions with the scene.
SceneLoad read_load(Reader reader, const elastin::Table<LoadKind>& loads, const Body& body, const Material& material,
                    const Matrix3& rotation);
TimeOptions read_time(const Reader& reader, const elastin::Table<StepperKind>& steppers);
/// {method: NAME, PARAMETER: VALUE, …}, or the name alone.
void read_stepper(const Reader& reader, const elastin::Table<StepperKind>& steppers, TimeOptions& options);
/// How the run begins: velocities and positions other than those at rest.
std::function<void(State&)> read_initial(const Reader& reader, const Body& body, const Matrix3& rotation, bool timed);
/// What stays where it is besides the experiment's own grips; at most one a molecule.
std::vector<Support> read_supports(const Reader& reader, const Body& body, const Matrix3& rotation);
/// `extends` and `values`, which were put in when the file was opened.
void read_preamble(Reader& reader);

/// Calls change(molecules, factor) with the factor of stiffness of each cell; a connection gets the mean of what it
/// would get as each of the cells around it, if requested of the cubes of a lattice as well, or in a body without cells
/// what its own ends say.
template <class Change>
void change_stiffness(Body& body, const Change& change, bool of_cubes = false) {
  const auto change_all = [&](int count, const auto& molecules, VectorX& factors) {
    if (factors.size() == 0) factors = VectorX::Ones(count);
    for (int i = 0; i < count; ++i) change(molecules(i), factors[i]);
  };
  const auto change_cells = [&](const auto& cells, VectorX& factors) {
    change_all(
        static_cast<int>(cells.size()), [&](int i) -> const auto& { return cells[i]; }, factors);
  };
  change_by_cells(body, body.connection_stiffness, std::cref(change), of_cubes);
  body.tetrahedra.empty() ? change_cells(body.triangles, body.cell_stiffness)
                          : change_cells(body.tetrahedra, body.cell_stiffness);
  for (CellBlock& block : body.blocks)
    change_all(
        block.size(), [&](int i) { return block.cell(i); }, block.stiffness);
}
/// `fields` of a material: makes the body as stiff and as heavy as they say at the middles of its cells and
/// connections, and at its molecules, and gives the material what else differs. The body is at rest where the
/// scene's places mean it.
void set_fields(const Reader& fields, const elastin::Table<MaterialLaw>& laws, Material& material, Body& body);
/// `rest`: makes the body unstressed as it says, whose places and fibres are those of the body before it is turned.
void set_rest(const Reader& rest, Specimen& specimen);
/// Throws InputError on what means nothing in this experiment.
void check_rest(const Reader& rest, bool timed);

/// The keys that these functions read, for the key reference.
std::vector<KeySection> scene_keys();
std::vector<KeySection> expectation_keys(const Catalog& catalog);
std::vector<KeySection> body_keys();
std::vector<KeySection> bodies_keys();
std::vector<KeySection> field_keys();
std::vector<KeySection> rest_keys();
/// Of the material's key `fields`.
std::vector<SceneKey> rows_of_fields();
std::vector<KeySection> material_keys(const Catalog& catalog);
std::vector<KeySection> strategy_keys(const Catalog& catalog);
std::vector<KeySection> solver_keys(const Catalog& catalog);
std::vector<KeySection> support_keys();
std::vector<KeySection> time_keys(const Catalog& catalog);
std::vector<KeySection> load_keys(const Catalog& catalog);
std::vector<KeySection> initial_keys();
std::vector<KeySection> contact_keys();
std::vector<KeySection> study_keys(const Catalog& catalog);

/// The order that a shape's cells are to have, which is chosen when all molecules are in their places.
struct CellOrder {
  std::optional<int> order;
  std::optional<Reader> order_place;
};
Key<CellOrder> order_key();

/// What the keys of the body get from the reading of its shape, in addition to the body.
struct ShapeContext {
  Reader& map;  ///< in which the shape is a key
  Remarks remarks;
  std::shared_ptr<const Processes> processes;
  const Material* material = nullptr;
  VectorX volumes = {};  ///< of the molecules [m³], as the material's density has it; empty: not known
  CellOrder order = {};
};

/// A shape that bodies of scenes may have.
struct Shape {
  std::string name;
  std::string text;     ///< behind its name in the key reference, above its keys
  std::string section;  ///< of the key reference
  std::vector<SceneKey> keys;
  std::function<Body(const Reader& value, ShapeContext&)> make;
};

/// A shape with the keys of a Setup. `make` gets the setup, and the context if it takes that.
template <class Setup, class Make>
Shape shape(const std::string& name, std::string text, Keys<Setup> keys, Make make) {
  std::vector<SceneKey> rows = keys.rows();
  return {name, std::move(text), "body." + name, std::move(rows),
          [keys = std::move(keys), make = std::move(make)](const Reader& value, ShapeContext& context) -> Body {
            const Setup setup = keys.read(value);
            if constexpr (std::derived_from<Setup, CellOrder>) context.order = setup;
            if constexpr (std::invocable<Make, const Setup&>)
              return make(setup);
            else
              return make(setup, context);
          }};
}

std::vector<Shape> surface_shapes();
Shape fill_shape();
Shape image_shape();

/// A key of which no body may have too many molecules.
template <class Setup, class Count>
Key<Setup> sized(Key<Setup> key, Count molecules) {
  return std::move(key).then(
      [molecules](const Reader& value, const Setup& setup) { value.check_size(molecules(setup)); });
}

/// A key of random bodies.
template <class Setup>
Key<Setup> seed_key(std::uint64_t Setup::*member) {
  return key::whole("seed", member, 0, "seed of the random numbers");
}

/// `connections.within`, where a body may have no connections of another kind.
template <class Setup>
Key<Setup> reach_key(std::optional<double> Setup::*member, std::string text, std::string otherwise) {
  return key::below(
      "connections",
      Keys<Setup>{
          key::quantity("within", member, dimension::length, std::move(text), kPositive).needed(std::move(otherwise))});
}

}  // namespace elastin::lab
