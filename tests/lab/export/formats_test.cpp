// What is written for other programs: read back by our own readers it is the same body and the same equilibrium, and
// what a format cannot say is refused by name.

#include "lab/export/formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/solve/stable_step.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/export/problem.h"
#include "lab/export/process.h"
#include "lab/run/specimen.h"
#include "lab/study/study.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();
const std::string kLattice = "lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 5 mm, order: ";
const std::string kRubber =
    "{density: 1000 kg/m3, law: mooney_rivlin, c1: 1 kPa, c2: 0.2 kPa, bulk_modulus: 40 kPa, volumetric: ";
const std::string kPull = "{kind: tension, axis: z, strain: 20 %, fixed_grip: clamped, loaded_grip: clamped}";

struct Problem {
  std::string body = kLattice + "1}";
  std::string material = "{youngs_modulus: 5 kPa, poissons_ratio: 0.3}";
  std::string stiffness = "neo_hookean_log";
  std::string experiment = kPull;
  std::string solver = "{tolerance: 1e-13}";

  std::unique_ptr<Scene> load(const TemporaryFolder& folder) const {
    return load_scene(folder.write("scene.yaml", "title: a block\nbody: {" + body + "}\nmaterial: " + material +
                                                     "\nstiffness: " + stiffness + "\nexperiment: " + experiment +
                                                     "\nsolver: " + solver + "\n"),
                      kCatalog);
  }
};

Run run_of(Scene& scene) {
  prepare(scene.specimen, scene.stiffness.strategy);
  RunOptions options;
  options.statics = scene.statics;
  options.statics.tolerance = 1e-13;
  options.keep_snapshots = options.last_snapshot = true;
  Run run = run_strategy(scene.specimen, *scene.experiment, scene.stiffness, options);
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  return run;
}

/// Distances of the molecules from three of them: what no motion as a whole changes.
Eigen::MatrixXd distances(const Positions& positions) {
  Eigen::MatrixXd result(3, positions.cols());
  for (const int row : {0, 1, 2})
    result.row(row) = (positions.colwise() - Vector3(positions.col(row * (positions.cols() - 1) / 2))).colwise().norm();
  return result;
}

std::string exported(const Scene& scene, const char* format) {
  std::vector<std::string> notes;
  return export_formats().find(format)->text(scene, notes);
}

std::string refusal(const Problem& problem, const char* format) {
  const TemporaryFolder folder;
  try {
    exported(*problem.load(folder), format);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

int count(const std::string& text, const std::string& word) {
  int times = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++times;
  return times;
}

}  // namespace

TEST_CASE("A problem written for FEBio and read back has the same equilibrium", "[export][slow]") {
  const std::string rubber = kRubber + "quadratic}",
                    tetrahedra = "tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [5 mm, 5 mm, 10 mm], order: ";
  const std::vector<Problem> problems{
      {},
      {tetrahedra + "2}", "{youngs_modulus: 5 kPa, poissons_ratio: 0.2}", "st_venant_kirchhoff"},
      {kLattice + "2}", kRubber + "mixed}", "{strategy: mooney_rivlin, volume: none}"},
      {kLattice + "1}", rubber, "mooney_rivlin+volume",
       "{kind: tension, axis: z, force: 0.1 N, fixed_grip: clamped, load_steps: 2}"},
      {kLattice + "1}", rubber, "{strategy: mooney_rivlin, volume: none}",
       "{kind: tension, axis: z, force: 0.05 N}"},  // sliding grips
      {kLattice + "1}", "{youngs_modulus: 5 kPa, poissons_ratio: 0.3}", "neo_hookean_log",
       "{kind: torsion, axis: z, angle: 120 deg}"},
      {tetrahedra + "1}", "{youngs_modulus: 50 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}", "neo_hookean_log",
       "{kind: bending, axis: z, gravity: 9.81 m/s2, direction: x}"},
      {kLattice + "1}",
       "{law: ogden, terms: [[1 kPa, 3], [-0.5 kPa, -2]], convention: abaqus, "
       "bulk_modulus: "
       "50 kPa}",
       "ogden"},
      {kLattice + "1}", "{law: yeoh, terms: [1 kPa, 0.2 kPa], bulk_modulus: 50 kPa}", "yeoh"},
      {kLattice + "1}",
       "{law: transversely_isotropic, c1: 1 kPa, c4: 10, c5: 20 kPa, lambda_max: 1.1, direction: [1, 0, 2], "
       "bulk_modulus: 50 kPa}",
       "transversely_isotropic"},
      {kLattice + "1}", "{youngs_modulus: 5 kPa, poissons_ratio: 0.3}", "neo_hookean_log\nrest: {swelling: 1.1}",
       "{kind: tension, axis: z, displacement: 0 mm, fixed_grip: clamped, load_steps: 2}"},
      {tetrahedra + "1}", "{youngs_modulus: 5 kPa, poissons_ratio: 0.3}",
       "st_venant_kirchhoff\nrest: {regions: [{molecules: {box: {from: [-1 m, -1 m, -1 m], to: [1 m, 1 m, 5.1 mm]}}, "
       "growth: [1.1, 1, 0.9]}]}",
       "{kind: tension, axis: z, strain: 10 %}"}};
  for (const Problem& problem : problems) {
    INFO(problem.stiffness << " on " << problem.body << ", " << problem.experiment);
    const TemporaryFolder folder;
    const auto scene = problem.load(folder);
    const auto back = load_scene(folder.write("model.feb", exported(*scene, "febio")), kCatalog);
    const Run own = run_of(*scene), other = run_of(*back);
    REQUIRE(own.snapshots.back().positions.cols() == other.snapshots.back().positions.cols());
    const Eigen::MatrixXd before = distances(own.snapshots.back().positions),
                          after = distances(other.snapshots.back().positions);
    CHECK((before - after).cwiseAbs().maxCoeff() < 1e-9 * before.maxCoeff());
    const Positions& rest = scene->specimen.body.rest;
    CHECK((before - distances(rest)).cwiseAbs().maxCoeff() > 1e-3 * before.maxCoeff());  // it did move
  }
}

TEST_CASE("The command runs what was exported to FEBio", "[export]") {
  const TemporaryFolder folder;
  const auto scene = Problem{}.load(folder);
  Request request;
  request.scenes = {folder.write("model.feb", exported(*scene, "febio"))};
  request.quiet = true;
  CHECK(run_scenes(request, kCatalog));
}

TEST_CASE("A body written for Gmsh and for VTK and read back is the same", "[export]") {
  for (const char* body : {"tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [5 mm, 5 mm, 5 mm], order: 1}",
                           "tetrahedra: {kind: kuhn, cubes: [1, 1, 1], size: [5 mm, 5 mm, 5 mm], order: 2}",
                           "lattice: {kind: cubic, molecules: [3, 2, 2], spacing: 5 mm, order: 1}",
                           "lattice: {kind: cubic, molecules: [3, 2, 2], spacing: 5 mm, order: 2}"})
    for (const char* format : {"gmsh", "vtu"}) {
      INFO(body << " to " << format);
      const TemporaryFolder folder;
      const auto scene = Problem{body}.load(folder);
      const Body& own = scene->specimen.body;
      const std::string ending = export_formats().find(format)->ending;
      const mesh::Mesh back = mesh::load_mesh(folder.write("body" + ending, exported(*scene, format)));
      REQUIRE(back.points.cols() == own.size());
      CHECK((back.points - own.rest).cwiseAbs().maxCoeff() < 1e-17);
      CHECK(back.tetrahedra == own.tetrahedra);
      REQUIRE(back.blocks.size() == own.blocks.size());
      for (std::size_t block = 0; block < own.blocks.size(); ++block) {
        CHECK(back.blocks[block].kind == own.blocks[block].kind);
        CHECK(back.blocks[block].nodes == own.blocks[block].nodes);
      }
      if (std::string(format) == "gmsh") {
        CHECK(back.sets.at("held").size() == back.sets.at("loaded").size());
        for (const int molecule : back.sets.at("held")) CHECK(own.rest(2, molecule) == own.rest.row(2).minCoeff());
      }
    }
}

TEST_CASE("An input of CalculiX says what the scene says", "[export]") {
  const TemporaryFolder folder;
  const std::string text =
      exported(*Problem{kLattice + "1}", "{youngs_modulus: 5 kPa, poissons_ratio: 0.3}", "st_venant_kirchhoff",
                        "{kind: tension, axis: z, strain: 20 %, fixed_grip: clamped, load_steps: 2}"}
                    .load(folder),
               "calculix");
  CHECK_THAT(text, Contains("*ELEMENT, TYPE=C3D8, ELSET=CELLS1\n1,"));
  CHECK_THAT(text, Contains("*ELASTIC\n5.000000000000e+03,3.000000000000e-01\n"));
  CHECK(count(text, "*STEP, NLGEOM") == 2);
  // The lower end's 9 molecules in three directions, the upper end's 9 along z, in both steps.
  CHECK(count(text, ",3,3,1.500000000000e-03\n") == 9);
  CHECK(count(text, ",3,3,3.000000000000e-03\n") == 9);
  for (const char* axis : {",1,1,0.000000000000e+00\n", ",2,2,0.000000000000e+00\n", ",3,3,0.000000000000e+00\n"})
    CHECK(count(text, axis) == 2 * 9);
  CHECK(count(text, "*CLOAD") == 0);
}

TEST_CASE("What a format cannot say is refused by name", "[export]") {
  const std::string rubber = kRubber + "logarithmic}";
  CHECK_THAT(refusal({kLattice + "1}", "{youngs_modulus: 5 kPa}", "neo_hookean"}, "febio"),
             Contains("scene.yaml") && Contains("--set stiffness=neo_hookean_log"));
  CHECK_THAT(
      refusal({kLattice + "1}", "{youngs_modulus: 5 kPa}", "neo_hookean"}, "calculix"),
      Contains("no law 'neo_hookean' under large displacements") && Contains("--set stiffness=st_venant_kirchhoff"));
  CHECK_THAT(refusal({kLattice + "1}", rubber, "mooney_rivlin"}, "calculix"), Contains("volumetric: quadratic"));
  CHECK_THAT(refusal({kLattice + "2}"}, "calculix"), Contains("hexahedra of 27 nodes") || Contains("neo_hookean_log"));
  CHECK_THAT(refusal({kLattice + "2}", rubber, "mooney_rivlin+volume"}, "febio"), Contains("volume: none"));
  CHECK_THAT(refusal({kLattice + "1}", "{youngs_modulus: 5 kPa}", "standard"}, "febio"), Contains("springs"));
  CHECK_THAT(refusal({kLattice + "1}", "{youngs_modulus: 5 kPa}", "neo_hookean_log", kPull, "{displacements: small}"},
                     "febio"),
             Contains("large displacements alone"));
  const auto with_rest = [](const std::string& rest) {
    return Problem{.stiffness = "st_venant_kirchhoff\nrest: " + rest};
  };
  CHECK_THAT(refusal(with_rest("{growth: [1.1, 1, 1]}"), "calculix"), Contains("the same along all directions"));
  CHECK_THAT(refusal(with_rest("{swelling: 1 + z / 1 m}"), "febio"), Contains("differs within a cell"));
  CHECK_THAT(refusal(with_rest("{unloaded_from: loads}"), "febio"), Contains("`rest` that runs find"));
  CHECK_THAT(
      refusal({kLattice + "1}", rubber, "{strategy: mooney_rivlin, volume: none}\nrest: {swelling: 1.1}"}, "febio"),
      Contains("no `rest` of 'mooney_rivlin'"));
  CHECK_THROWS_WITH(export_formats().find("calculx"), Contains("calculix"));
}

TEST_CASE("A body that slides is held as a whole, and no further", "[export]") {
  const TemporaryFolder folder;
  const auto scene =
      Problem{kLattice + "1}", "{youngs_modulus: 5 kPa}", "neo_hookean_log", "{kind: tension, axis: z, force: 1 mN}"}
          .load(folder);
  StaticProblem problem = problem_of(*scene);
  CHECK(problem.notes.size() == 1);
  CHECK(problem.driven.size() == 9 + 3);  // the lower end along z; two ways and a turn
  CHECK(missing_supports(problem).empty());
  problem.driven.clear();
  CHECK(missing_supports(problem).size() == 6);
}

TEST_CASE("CalculiX, where it is installed, finds what the same cells find", "[export][calculix]") {
  try {
    check_calculix();
  } catch (const InputError& error) {
    WARN(error.what());
    return;
  }
  // Tetrahedra of 10 nodes with the same 4 points, small displacements; 7 digits are printed of each number.
  const TemporaryFolder folder;
  const auto scene = Problem{"tetrahedra: {kind: kuhn, cubes: [2, 2, 2], size: [10 mm, 10 mm, 10 mm], order: 2}",
                             "{youngs_modulus: 5 kPa, poissons_ratio: 0.3}", "neo_hookean",
                             "{kind: tension, axis: z, strain: 10 %, fixed_grip: clamped, loaded_grip: clamped}",
                             "{displacements: small}"}
                         .load(folder);
  const OtherRun other = run_calculix(*scene, kCatalog, {}, {});
  INFO(other.run.cause);
  REQUIRE(other.run.suited);
  REQUIRE(other.run.outcome == Outcome::converged);
  CHECK(other.run.measures.get("effective_modulus") ==
        Approx(run_of(*scene).measures.get("effective_modulus")).epsilon(1e-5));
  // A bar that swells between grips that stay, a half of it more than the other.
  const auto swelling = Problem{kLattice + "1}", "{youngs_modulus: 5 kPa, poissons_ratio: 0.3}",
                                "st_venant_kirchhoff\nrest: {swelling: 1.0001, regions: [{swelling: 1.0003, molecules: "
                                "{box: {from: [-1 m, -1 m, -1 m], to: [1 m, 1 m, 5.1 mm]}}}]}",
                                "{kind: tension, axis: z, displacement: 0 mm}"}
                            .load(folder);
  const OtherRun pushed = run_calculix(*swelling, kCatalog, {}, {});
  INFO(pushed.run.cause);
  REQUIRE(pushed.run.outcome == Outcome::converged);
  CHECK(pushed.run.measures.get("force") == Approx(run_of(*swelling).measures.get("force")).epsilon(1e-4));
  CHECK(pushed.run.measures.get("force") < -5e3 * 1e-4 * 1e-4);
}

TEST_CASE("CalculiX finds what the laws of several terms say", "[export][calculix][slow]") {
  if (std::system("command -v ccx > /dev/null") != 0) {
    WARN("ccx is not installed here");
    return;
  }
  // One strain all over, free sides: the cells' order does not count. A law that is soft against changes of volume, so
  // that a further volumetric term shows: by 3 % or more. CalculiX's own Ogden misses the closed form of two equal
  // stretches by 2e-5, with negative exponents by 2e-4.
  for (const auto& [law, material] :
       {std::pair{"yeoh", "{law: yeoh, terms: [6 kPa, -0.5 kPa, 0.4 kPa], "},
        {"ogden", "{law: ogden, terms: [[6 kPa, 2], [1 kPa, 3], [0.5 kPa, 4]], convention: abaqus, "},
        {"mooney_rivlin", "{law: mooney_rivlin, c1: 5 kPa, c2: 1 kPa, "}}) {
    INFO(law);
    const TemporaryFolder folder;
    const auto scene = Problem{kLattice + "1}", material + std::string("bulk_modulus: 20 kPa, volumetric: quadratic}"),
                               law, "{kind: tension, axis: z, strain: 2 %}"}
                           .load(folder);
    const OtherRun other = run_calculix(*scene, kCatalog, {}, {});
    INFO(other.run.cause);
    REQUIRE(other.run.outcome == Outcome::converged);
    const Run own = run_of(*scene);
    for (const char* measure : {"effective_modulus", "poissons_ratio"})
      CHECK(other.run.measures.get(measure) ==
            Approx(own.measures.get(measure)).epsilon(law == std::string_view("ogden") ? 1e-4 : 1e-5));
    CHECK_THAT(other.run.solver, Contains("hexahedra of 20 nodes"));
  }
}

TEST_CASE("Supports that slide askew to the axes are named where engines have none like that", "[export]") {
  const std::string turned = "lattice\nrotate: {axis: [1, 2, 3], angle: 41 deg}",
                    body = "lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 5 mm, connections: [axis, face]}";
  const auto body_of = [&](const std::string& stiffness, const std::string& experiment) {
    const TemporaryFolder folder;
    const auto scene =
        Problem{body, "{youngs_modulus: 5 kPa, poissons_ratio: 0.25}", stiffness, experiment}.load(folder);
    return exported_body(*scene, scene->stiffness);
  };
  const std::string sliding = "{kind: tension, axis: z, strain: 1 %, fixed_grip: clamped}";
  const ExportedBody askew = body_of(turned, sliding);
  CHECK(askew.askew == 9);
  CHECK(askew.supports.size() == 9);
  CHECK(std::count_if(askew.notes.begin(), askew.notes.end(), [](const std::string& note) {
          return note.find("9 supports that slide in directions askew") != std::string::npos;
        }) == 1);
  for (const ExportedBody& whole : {body_of("lattice", sliding), body_of(turned, kPull),
                                    body_of("lattice\nrotate: {axis: z, angle: 41 deg}", sliding)}) {
    CHECK(whole.askew == 0);
    CHECK(whole.supports.size() == 18);
  }
  // About x the plane of the grip keeps x free, and holds none of y and z alone.
  CHECK(body_of("lattice\nrotate: {axis: x, angle: 41 deg}", sliding).supports.size() == 9);
}

TEST_CASE("Springs with a history are exported with what they are after all time, which is said", "[export]") {
  const auto body_of = [&](const std::string& stiffness, const std::string& history) {
    const TemporaryFolder folder;
    const auto scene = Problem{"lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 5 mm, connections: [axis, face]}",
                               "{youngs_modulus: 5 kPa, poissons_ratio: 0.25, " + history + "}", stiffness}
                           .load(folder);
    return exported_body(*scene, scene->stiffness);
  };
  const std::string relaxing = "relaxation: {terms: [[0.3, 1 s]]}",
                    softening = "softening: {r: 1.5, m: 10 Pa, beta: 0.1}";
  struct Case {
    std::string stiffness, plain, history;
    double part;
  };
  for (const auto& [stiffness, plain, history, part] :
       {Case{"prony:lattice", "lattice", relaxing, 1},
        Case{"prony:lattice", "lattice", "relaxation: {moduli: instantaneous, terms: [[0.3, 1 s]]}", 0.7},
        Case{"mullins:lattice", "lattice", softening, 1},
        Case{"prony:mullins:patch", "patch", relaxing + ", " + softening, 1},
        Case{"prony:lattice+volume", "lattice", relaxing, 1}}) {
    INFO(stiffness << ", " << history);
    const ExportedBody own = body_of(stiffness, history), other = body_of(plain, history);
    REQUIRE(own.connections.size() > 100);
    REQUIRE(own.connections.size() == other.connections.size());
    for (std::size_t i = 0; i < own.connections.size(); ++i) {
      CHECK(own.connections[i].b == other.connections[i].b);
      CHECK(own.connections[i].rest_length == other.connections[i].rest_length);
      CHECK(own.connections[i].stiffness == Approx(part * other.connections[i].stiffness).epsilon(1e-9));
    }
    CHECK(std::count_if(own.notes.begin(), own.notes.end(), [](const std::string& note) {
            return note.find("relaxation and softening are not written: the constants are those") == 0;
          }) == 1);
    for (const char* format : {"json", "csv", "lammps", "mujoco", "sofa", "newton", "usd"})
      CHECK_THAT(engine_files(*export_formats().find(format), own).back().text, Contains("relaxation and softening"));
  }
}

TEST_CASE("Exported springs are those of the model that runs, sides of cells among them", "[export]") {
  const TemporaryFolder folder;
  for (const char* stiffness : {"van_gelder", "standard", "fitted:van_gelder", "van_gelder+volume"}) {
    CAPTURE(stiffness);
    const auto scene = Problem{"packing: {size: [10 mm, 10 mm, 10 mm], distance: 3 mm}, cells: delaunay",
                               "{youngs_modulus: 5 kPa, poissons_ratio: 0.25}", stiffness, "{kind: material}"}
                           .load(folder);
    const ExportedBody body = exported_body(*scene, scene->stiffness);
    Run run;
    prepare(scene->specimen, scene->stiffness.strategy);
    REQUIRE(make_model(scene->specimen, *scene->experiment, scene->stiffness, {scene->statics}, run));
    double sum = 0;
    for (const auto& one : body.connections) sum += one.stiffness;
    CHECK(sum == Approx(run.constants.sum()).epsilon(1e-12));
    CHECK(static_cast<Eigen::Index>(body.connections.size()) == (run.constants.array() != 0).count());
    const Connections& all = scene->specimen.body.connections;
    const bool by_cells = std::string(stiffness).find("van_gelder") != std::string::npos;
    REQUIRE(all.cell_sides > 0);
    CHECK((run.constants.tail(all.cell_sides).cwiseAbs().maxCoeff() > 0) == by_cells);
  }
}

TEST_CASE("The folder for an engine has the longest step that `check` has", "[export]") {
  const TemporaryFolder folder;
  const auto scene = Problem{"lattice: {kind: cubic, molecules: [4, 3, 5], spacing: 3 mm, connections: [axis, face]}",
                             "{youngs_modulus: 10 kPa, poissons_ratio: 0.25}", "standard", "{kind: motion}",
                             "{}\ninitial: {velocity: [1 mm/s, 0 m/s, 0 m/s]}\ntime: {duration: 0.5 s}"}
                         .load(folder);
  Run run;
  const auto held = make_model(scene->specimen, *scene->experiment, scene->stiffness, {}, run);
  REQUIRE(held);
  const double step = find_stable_step(*held->model, state_at_rest(scene->specimen.body)).step;
  CHECK_THAT(engine_files(*export_formats().find("json"), exported_body(*scene, scene->stiffness)).back().text,
             Contains(fmt::format("explicit integration is stable below {:.3g} s", step)));
}

TEST_CASE("cells of several bodies have the density of their own body and region", "[export]") {
  const TemporaryFolder folder;
  const auto exported = [&](const std::string& cells, const std::string& more) {
    const auto scene = load_scene(
        folder.write("two.yaml", "bodies:\n  - {name: a, " + cells +
                                     ", material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3, density: 2000 kg/m3}}\n"
                                     "  - {name: b, at: [0, 0, 30 mm], " +
                                     cells + more +
                                     "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}\n"
                                     "stiffness: neo_hookean_log\nexperiment: {kind: loads}\n"),
        kCatalog);
    return exported_body(*scene, scene->stiffness);
  };
  const std::string kuhn = "tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [10 mm, 10 mm, 20 mm]}";
  double mass = 0;
  const ExportedBody heavy = exported(kuhn, ", regions: [{from: [-1 m, -1 m, 10 mm], to: [1 m, 1 m, 1 m], mass: 4}]");
  for (const ExportedBody::Cell& cell : heavy.tetrahedra) {
    const double height = heavy.positions(2, cell.nodes).minCoeff();
    if (height < 25e-3) CHECK(cell.density == Approx(2000));
    if (height > 35e-3) CHECK(cell.density > 2000);
    const auto at = [&](int corner) { return Vector3(heavy.positions.col(cell.nodes[corner])); };
    mass += std::abs((at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0))) / 6 * cell.density;
  }
  CHECK(mass == Approx(heavy.masses.sum()).epsilon(1e-9));
  // The region has the molecules at 10 mm, where it begins: half of its body, and a quarter at its end.
  CHECK(heavy.masses.sum() == Approx(2e-6 * (2000 + 1000 * 3.25)));
  for (const std::string order : {"1}", "2}"})
    for (const ExportedBody::Cell& cell : exported(kuhn.substr(0, kuhn.size() - 1) + ", order: " + order, "").cells)
      CHECK((cell.density == 2000 || cell.density == 1000));
}

TEST_CASE("Regions are in what engines get of cells of every shape, their stiffness and their mass", "[export]") {
  const TemporaryFolder folder;
  const std::string region = "}, regions: [{from: [-1 m, -1 m, 5 mm], to: [1 m, 1 m, 1 m], stiffness: 3, mass: 2}",
                    sheet =
                        "sheet: {size: [15 mm, 10 mm], squares: [3, 2]}, regions: [{from: [5 mm, -1 m, -1 m], to: "
                        "[1 m, 1 m, 1 m], stiffness: 3, mass: 2}]";
  struct Case {
    std::string body, experiment, stiffness;
    double volume, stiff;  ///< [m³], of the whole body and of its region
  };
  for (const Case& c :
       {Case{kLattice + "1" + region + "]", kPull, "neo_hookean_log", 1.5e-6, 1e-6},
        Case{kLattice + "2" + region + "]", kPull, "neo_hookean_log", 1.5e-6, 1e-6},
        Case{"tetrahedra: {kind: kuhn, cubes: [2, 2, 3], size: [10 mm, 10 mm, 15 mm], order: 2" + region + "]", kPull,
             "neo_hookean_log", 1.5e-6, 1e-6},
        Case{"tetrahedra: {kind: kuhn, cubes: [2, 2, 3], size: [10 mm, 10 mm, 15 mm]" + region + "]", kPull,
             "neo_hookean_log", 1.5e-6, 1e-6},
        Case{sheet, "{kind: tension, axis: x, strain: 1 %}", "standard", 1.5e-7, 1e-7}}) {
    INFO(c.body);
    const auto scene =
        Problem{c.body, "{youngs_modulus: 5 kPa, poissons_ratio: 0.3, density: 1000 kg/m3, thickness: 1 mm}",
                c.stiffness, c.experiment}
            .load(folder);
    const ExportedBody body = exported_body(*scene, scene->stiffness);
    const bool solid = !body.tetrahedra.empty();
    CHECK(solid == (c.experiment == kPull));
    double volume = 0, stiff = 0, mass = 0;
    for (const ExportedBody::Cell& cell : solid ? body.tetrahedra : body.cells) {
      const auto at = [&](int corner) { return Vector3(body.positions.col(cell.nodes[corner])); };
      const Vector3 across = (at(1) - at(0)).cross(at(2) - at(0));
      const double own = solid ? std::abs(across.dot(at(3) - at(0))) / 6 : across.norm() / 2 * body.thickness;
      volume += own, mass += own * cell.density;
      if (cell.youngs_modulus != 5000) stiff += own;
      CHECK((cell.youngs_modulus == Approx(5000) || cell.youngs_modulus == Approx(15000)));
    }
    CHECK(volume == Approx(c.volume));
    CHECK(stiff == Approx(c.stiff));
    CHECK(mass > 1200 * c.volume);
    // Nodes that share a cell's mass otherwise than its tetrahedra do leave a few per cent.
    CHECK(mass == Approx(body.masses.sum()).epsilon(body.cells.size() == body.tetrahedra.size() ? 1e-9 : 0.05));
  }
  // A body of one density keeps it in every cell, to the last bit.
  for (const char* order : {"1}", "2}"}) {
    const auto scene =
        Problem{kLattice + order, "{youngs_modulus: 5 kPa, poissons_ratio: 0.3, density: 1100 kg/m3}"}.load(folder);
    for (const auto& cell : exported_body(*scene, scene->stiffness).tetrahedra) CHECK(cell.density == 1100);
  }
}

TEST_CASE("An engine that has one modulus for all cells refuses several; others get each", "[export]") {
  const TemporaryFolder folder;
  const auto scene =
      Problem{kLattice + "1}, regions: [{from: [-1 m, -1 m, 5 mm], to: [1 m, 1 m, 1 m], stiffness: 3}]"}.load(folder);
  ExportedBody body = exported_body(*scene, scene->stiffness);
  const auto files = [&](const char* format) { return engine_files(*export_formats().find(format), body); };
  CHECK_THROWS_WITH(files("rapier"), Contains("rapier has one E for all cells of a body, and these have several"));
  CHECK_NOTHROW(files("sofa"));
  // Of two flexes of one E and two nu each has a name of its own.
  for (auto& cell : body.tetrahedra) cell.youngs_modulus = 5000;
  body.tetrahedra.front().poissons_ratio = 0.1;
  for (const char* format : {"rapier", "sofa"})
    CHECK_THROWS_WITH(files(format), Contains("has one nu for all cells of a body, and these have several"));
  CHECK_THAT(files("mujoco").front().text, Contains("<flex name=\"cells1\"") && Contains("<flex name=\"cells2\""));
}

TEST_CASE("Damping that is not written is named", "[export]") {
  const TemporaryFolder folder;
  const std::string damping = "damping and drag are not written";
  const auto notes_of = [&](const std::string& load) {
    const auto scene = Problem{.body = "tetrahedra: {kind: kuhn, cubes: [2, 2, 3], size: [10 mm, 10 mm, 15 mm]}",
                               .stiffness = "neo_hookean_log\nloads: [" + load + "]"}
                           .load(folder);
    const ExportedBody body = exported_body(*scene, scene->stiffness);
    return std::count(body.notes.begin(), body.notes.end(), damping);
  };
  for (const char* load :
       {"{damping: 0.1 N s/m}", "{rayleigh: {mass: 1 1/s}}", "{cell_damping: {bulk: 1 Pa s, shear: 1 Pa s}}",
        "{stokes_drag: 1 Pa s}", "{quadratic_drag: {density: 1 kg/m3, drag_coefficient: 0.5}}"}) {
    INFO(load);
    CHECK(notes_of(load) == 1);
  }
  CHECK(notes_of("{gravity: [0, 0, -1 m/s2]}") == 0);
}

TEST_CASE("What a process prints comes through pipes, and fills no file and no memory", "[export][engines]") {
  const JobFolder folder("test");
  std::vector<std::string> objects;
  const std::string flood = "head -c 5000000 /dev/zero | tr '\\0' x; echo; ";
  const Ended ended = run_process(folder,
                                  flood + "echo ' {\"a\": 1}'; printf '{\"b\": \"%0100000d\"}' 2; { " + flood +
                                      "echo '  Error: of " + "the engine'; echo later; } >&2; exit 3",
                                  "", {}, 60, [&](std::string&& line) { objects.push_back(std::move(line)); });
  CHECK(ended.text == "status 3");
  CHECK_FALSE(ended.timed_out);
  CHECK(ended.complaint == "Error: of the engine");
  REQUIRE(objects.size() == 2);
  CHECK(objects[0] == "{\"a\": 1}");
  CHECK(objects[1] == "{\"b\": \"" + std::string(99999, '0') + "2\"}");  // longer than a pipe holds, without an end
  CHECK(std::filesystem::is_empty(folder.path()));
  // One that never stops to print is ended, and what it has left behind with it.
  const Ended endless = run_process(folder, "yes & yes '{}'", "", {}, 0.2);
  CHECK(endless.timed_out);
  CHECK(std::filesystem::is_empty(folder.path()));
  CHECK(run_process(folder, "echo only here; exit 1", "", {}, 60).complaint == "only here");
}

TEST_CASE("A scene may have any name in XML", "[export][engines]") {
  ExportedBody body;
  body.name = "a \"b\" <c> & --";
  body.positions = Positions::Identity(3, 2);
  body.connections = {{0, 1, std::sqrt(2.), 5}};
  body.forces = Positions::Zero(3, 2);
  body.masses = body.radii = VectorX::Ones(2);
  CHECK_THAT(engine_files(*export_formats().find("mujoco"), body).front().text,
             Contains("<mujoco model=\"a &quot;b&quot; &lt;c&gt; &amp; --\">"));
  CHECK_THAT(engine_files(*export_formats().find("sofa"), body).front().text, !Contains(body.name));
}

TEST_CASE("A folder for an engine says that it has no loads", "[export]") {
  const TemporaryFolder folder;
  const auto readme_of = [&](const char* format, const std::string& experiment) {
    const auto scene = Problem{"lattice: {kind: cubic, molecules: [3, 3, 4], spacing: 5 mm, connections: [axis, face]}",
                               "{youngs_modulus: 5 kPa, poissons_ratio: 0.25}", "lattice", experiment}
                           .load(folder);
    return engine_files(*export_formats().find(format), exported_body(*scene, scene->stiffness)).back().text;
  };
  const std::string force = "{kind: tension, axis: z, force: 1 mN, fixed_grip: clamped}";
  for (const char* format : {"csv", "mujoco", "bullet", "sofa", "usd"}) {
    INFO(format);
    CHECK_THAT(readme_of(format, force), Contains("Not in these files either: the forces of the experiment"));
    CHECK_THAT(readme_of(format, kPull), Contains("either: the prescribed displacements of the experiment"));
  }
  for (const char* format : {"json", "lammps", "jolt", "rapier", "newton"})
    CHECK_THAT(readme_of(format, force), !Contains("either"));
}

TEST_CASE("A comparison against CalculiX has its row, or says what to install", "[export][calculix]") {
  const TemporaryFolder folder;
  Problem{kLattice + "1}", "{youngs_modulus: 5 kPa, poissons_ratio: 0.3}", "neo_hookean", kPull,
          "{displacements: small}"}
      .load(folder);
  Request request;
  request.scenes = {folder.path("scene.yaml")};
  request.compare = request.quiet = true;
  request.against = kCalculix;
  request.reference = "none";
  request.json = folder.path("runs.json");
  const std::string path = std::getenv("PATH");
  if (std::system("command -v ccx > /dev/null") == 0) {
    CHECK(run_scenes(request, kCatalog));
    std::ifstream file(request.json);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    CHECK_THAT(text, Contains("\"calculix\"") && Contains("never recommended"));
  }
  setenv("PATH", folder.path("nothing").c_str(), 1);
  CHECK_THROWS_WITH(run_scenes(request, kCatalog), Contains("apt-get install calculix-ccx"));
  setenv("PATH", path.c_str(), 1);
}
