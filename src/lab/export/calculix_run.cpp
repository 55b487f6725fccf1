#include "lab/export/formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include "core/laws/solids/mooney_rivlin.h"
#include "core/laws/solids/neo_hookean_log.h"
#include "core/laws/solids/ogden.h"
#include "core/laws/solids/st_venant_kirchhoff.h"
#include "core/laws/solids/yeoh.h"
#include "core/shapes/orders.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/laws/material_law.h"
#include "elastin/core/parallel/threads.h"
#include "lab/export/engine_run.h"
#include "lab/export/process.h"

namespace elastin::lab {
namespace {

// It reads 20 characters of a number at most, so that 13 digits are written.

/// CalculiX' elements of the shapes of cells; nodes have the same order.
const std::map<std::string_view, const char*> kElements{{"tetrahedron4", "C3D4"},
                                                        {"tetrahedron10", "C3D10"},
                                                        {"prism6", "C3D6"},
                                                        {"hexahedron8", "C3D8"},
                                                        {"hexahedron20", "C3D20"}};
/// Of Yeoh's and Ogden's laws.
constexpr int kMostTerms = 3;
/// D of a volumetric term without weight, over that of the first term.
constexpr double kWeightless = 1e20;

class CalculixDeck : Deck {
 public:
  CalculixDeck(StaticProblem& problem, const CalculixOptions& options)
      : Deck("CalculiX", problem), problem_(problem), options_(options) {}

  std::string text() {
    write("** {}: {}\n** Lengths in m, forces in N, stresses in Pa.\n", problem_.scene->name, problem_.scene->title);
    write_mesh();
    for (std::size_t i = 0; i < problem_.materials.size(); ++i) write_material(i);
    for (std::size_t i = 0; i < problem_.cells.size(); ++i)
      write("*SOLID SECTION, ELSET=CELLS{}, MATERIAL=M{}\n", i + 1, problem_.cells[i].material + 1);
    if (!problem_.growths.empty()) write("*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL,0.\n");
    for (std::size_t step = 0; step < problem_.steps.size(); ++step) write_step(step);
    return std::move(out_);
  }

 private:
  void write_mesh() {
    const Positions& rest = problem_.body().rest;
    write("*NODE, NSET=ALL\n");
    for (Eigen::Index i = 0; i < rest.cols(); ++i)
      write("{},{:.12e},{:.12e},{:.12e}\n", i + 1, rest(0, i), rest(1, i), rest(2, i));
    int number = 0;
    for (std::size_t i = 0; i < problem_.cells.size(); ++i) {
      const ExportedCells& cells = problem_.cells[i];
      const auto element = kElements.find(cells.kind->name);
      if (element == kElements.end())
        refuse("it has no " + std::string(cells.kind->plural) +
               (cells.kind->name == "hexahedron27" ? "; write `order: 1`" : ""));
      write("*ELEMENT, TYPE={}, ELSET=CELLS{}\n", element->second, i + 1);
      for (std::size_t node = 0; node < cells.nodes.size(); ++node) {
        const auto place = node % static_cast<std::size_t>(cells.kind->nodes);
        if (place == 0) write("{}", ++number);
        write("{}{}", place % 15 == 14 ? ",\n" : ",", cells.nodes[node] + 1);  // 16 numbers a line
        if (place + 1 == static_cast<std::size_t>(cells.kind->nodes)) write("\n");
      }
    }
    std::set<int> held;
    for (const DrivenComponent& driven : problem_.driven) held.insert(driven.molecule);
    write("*NSET, NSET=HELD\n");
    for (const int molecule : held) write("{},\n", molecule + 1);
  }

  // ------------------------------------------------------------------------------------------ materials, by their laws

  using Write = void (CalculixDeck::*)(const Material& material);
  struct Law {
    std::string_view name;
    bool of_moduli;  ///< under small displacements *ELASTIC says all of it
    Write write;     ///< under large displacements; null: CalculiX has none
    Write nearest = nullptr;
  };
  static const std::vector<Law>& laws() {
    static const std::vector<Law> all{
        {NeoHookean::name, true, nullptr, &CalculixDeck::write_neo_hooke},
        {NeoHookeanLog::name, true, nullptr, &CalculixDeck::write_neo_hooke},
        {StVenantKirchhoff::name, true, &CalculixDeck::write_elastic},
        {MooneyRivlin::name, false, &CalculixDeck::write_mooney_rivlin},
        {Yeoh::name, false, &CalculixDeck::write_yeoh},
        {Ogden::name, false, &CalculixDeck::write_ogden},
    };
    return all;
  }

  void write_material(std::size_t number) {
    const Material& material = problem_.materials[number];
    const auto law =
        std::find_if(laws().begin(), laws().end(), [&](const Law& one) { return one.name == problem_.law; });
    Write write_law = nullptr;
    if (law != laws().end())
      write_law = problem_.small && law->of_moduli      ? &CalculixDeck::write_elastic
                  : !law->write && options_.nearest_law ? law->nearest
                                                        : law->write;
    if (!write_law) {
      std::string known;
      for (const Law& one : laws())
        if (one.write) known += (known.empty() ? "" : ", ") + std::string(one.name);
      refuse("it has no law '" + problem_.law + "' under large displacements; allowed: " + known +
             (law == laws().end() ? "" : ", or `displacements: small`: --set stiffness=st_venant_kirchhoff"));
    }
    if (problem_.whole_cell && number == 0)
      problem_.notes.emplace_back(
          "CalculiX has no cells with pressures of their own: near nu = 1/2 its cells may lock");
    write("*MATERIAL, NAME=M{}\n", number + 1);
    (this->*write_law)(material);
    write("*DENSITY\n{:.12e}\n", material.density);
    if (problem_.growths.empty()) return;
    const Matrix3& growth = problem_.growths[number];
    if ((growth - growth(0, 0) * Matrix3::Identity()).norm() > 1e-12)
      refuse("of a `rest` it takes what is the same along all directions, as heat; this one is not");
    write("*EXPANSION, ZERO=0.\n{:.12e}\n", growth(0, 0) - 1);
    if (number == 0)
      problem_.notes.emplace_back(
          "CalculiX takes the rest as heat: bodies that are free become as large as here, the stress of others is "
          "the same for factors near 1");
  }

  void write_elastic(const Material& material) {
    write("*ELASTIC\n{:.12e},{:.12e}\n", material.youngs_modulus, material.poissons_ratio);
  }

  void write_neo_hooke(const Material& material) {
    const auto [lambda, mu] = lame<3>(material);
    write("*HYPERELASTIC, NEO HOOKE\n{:.12e},{:.12e}\n", mu / 2, 2 / (lambda + 2 * mu / 3));
    problem_.notes.push_back("CalculiX has no " + problem_.law +
                             ": its own neo-Hookean law stands here, another one beyond small strain");
  }

  /// 2/κ of κ/2 (J − 1)², the one volumetric term that CalculiX has.
  double volume_of(const Material& material) const {
    const Volumetric volume = ConstantsOf(material, problem_.law).volume();
    if (volume.form != Volumetric::Form::quadratic)
      refuse("its laws of rubber have the volume term κ/2 (J − 1)² alone: write `volumetric: quadratic`");
    return 2 / volume.modulus;
  }
  /// Of a law of several terms: the further ones, D₂ … (J − 1)⁴ …, weigh nothing. A D of 0 is not "none" for CalculiX:
  /// it puts a value of its own there.
  void write_terms(std::vector<double> constants, const Material& material, int terms) {
    const double first = volume_of(material);
    for (int i = 0; i < terms; ++i) constants.push_back(i == 0 ? first : kWeightless * first);
    for (std::size_t i = 0; i < constants.size(); ++i)  // 8 a line
      write("{:.12e}{}", constants[i], i + 1 == constants.size() || i % 8 == 7 ? "\n" : ",");
  }
  void check_terms(int terms) const {
    if (terms > kMostTerms)
      refuse(fmt::format("its {} has at most {} terms, this one has {}", problem_.law, kMostTerms, terms));
  }
  void write_mooney_rivlin(const Material& material) {
    const auto [c1, c2] = MooneyRivlin{}.density(material);
    write("*HYPERELASTIC, MOONEY-RIVLIN\n{:.12e},{:.12e},{:.12e}\n", c1, c2, volume_of(material));
  }
  void write_yeoh(const Material& material) {
    const Yeoh::Density density = Yeoh{}.density(material);
    check_terms(density.terms);
    write("*HYPERELASTIC, YEOH\n");
    std::vector<double> constants;
    for (int i = 0; i < kMostTerms; ++i) constants.push_back(i < density.terms ? density.c[i] : 0);
    write_terms(std::move(constants), material, kMostTerms);
  }
  void write_ogden(const Material& material) {
    const auto terms = Ogden::terms(material);
    check_terms(terms.count);
    write("*HYPERELASTIC, OGDEN, N={}\n", terms.count);
    std::vector<double> constants;
    for (int i = 0; i < terms.count; ++i)
      constants.insert(constants.end(), {terms.c(i) / 2, terms.m(i)});  // c/α² = 2 μ/α²
    write_terms(std::move(constants), material, terms.count);
  }

  void write_step(std::size_t step) {
    const char* whole_step = "1.,1.\n";
    if (problem_.small)
      write("*STEP\n*STATIC\n");
    else
      write("*STEP, NLGEOM, INC=10000\n*CONTROLS, PARAMETERS=FIELD\n1.e-7,1.e-5\n*STATIC\n{}", whole_step);
    write("*BOUNDARY\n");
    for (const DrivenComponent& driven : problem_.driven)
      write("{},{},{},{:.12e}\n", driven.molecule + 1, driven.axis + 1, driven.axis + 1, driven.displacements[step]);
    if (!problem_.growths.empty()) write("*TEMPERATURE\nALL,{:.12e}\n", problem_.rest_parts[step]);
    const Positions& forces = problem_.forces[step];
    if (!forces.isZero(0)) write("*CLOAD, OP=NEW\n");
    for (Eigen::Index molecule = 0; molecule < forces.cols(); ++molecule)
      for (int axis = 0; axis < 3; ++axis)
        if (forces(axis, molecule) != 0) write("{},{},{:.12e}\n", molecule + 1, axis + 1, forces(axis, molecule));
    constexpr const char* kAtEnd = "FREQUENCY=100000";
    write("*NODE PRINT, NSET=ALL, {}\nU\n*NODE PRINT, NSET=HELD, {}\nRF\n", kAtEnd, kAtEnd);
    if (options_.result_files) write("*NODE FILE, {}\nU\n*EL FILE, {}\nS,E\n", kAtEnd, kAtEnd);
    write("*END STEP\n");
  }

  StaticProblem& problem_;
  const CalculixOptions& options_;
};

}  // namespace

std::string calculix_deck(StaticProblem& problem, const CalculixOptions& options) {
  return CalculixDeck(problem, options).text();
}

std::string calculix_text(const Scene& scene, std::vector<std::string>& notes) {
  StaticProblem problem = problem_of(scene);
  std::string text = calculix_deck(problem, {});
  notes = std::move(problem.notes);
  return text;
}

namespace {

/// The body with its cells of second order, as far as CalculiX and `with_cells` have them.
Body second_order(const Body& body) {
  if (!has_blocks(body, 3)) return with_cells(body, cell_kind(body.cubes.empty() ? "tetrahedron10" : "hexahedron20"));
  const CellKind& kind = *body.blocks.front().kind;
  const bool alike =
      std::all_of(body.blocks.begin(), body.blocks.end(), [&](const CellBlock& block) { return block.kind == &kind; });
  if (!alike || !body.parts.empty()) return body;
  if (kind.name == "hexahedron8") return with_cells(body, cell_kind("hexahedron20"));
  if (kind.name == "tetrahedron4") return with_cells(body, cell_kind("tetrahedron10"));
  return body;
}

/// Which cells stayed of first order, or "".
std::string first_order_note(const StaticProblem& problem) {
  for (const ExportedCells& cells : problem.cells)
    if (cells.kind->order == 1)
      return "CalculiX solves on the scene's own " + std::string(cells.kind->plural) +
             ", which are of first order: they are stiffer than cells of second order";
  return "";
}

/// What CalculiX has printed at the end of the last step.
struct Printed {
  Positions displacements, forces;  ///< [m], [N]; forces on the held molecules, loads included
  bool complete = false;
};

Printed read_printed(const std::string& path, int molecules) {
  Printed result{Positions::Zero(3, molecules), Positions::Zero(3, molecules)};
  std::ifstream file(path);
  Positions* target = nullptr;
  int read = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.find("displacements") != std::string::npos) target = &result.displacements, read = 0;
    if (line.find("forces") != std::string::npos) target = &result.forces;
    std::istringstream numbers(line);
    int number = 0;
    Vector3 values;
    if (!(target && numbers >> number >> values[0] >> values[1] >> values[2])) continue;
    if (number < 1 || number > molecules || !values.allFinite()) return result;
    target->col(number - 1) = values;
    if (target == &result.displacements) ++read;
  }
  result.complete = read == molecules;
  return result;
}

void solve(const Scene& scene, const std::function<bool()>& stop, Run& run) {
  const auto begin = std::chrono::steady_clock::now();
  if (!scene.specimen.loads.empty())
    throw InputError("loads in addition to the experiment's are not measured separately");
  StaticProblem problem = problem_of(scene);
  const std::string deck = calculix_deck(problem, {true, false});
  const JobFolder folder(kCalculix);
  std::ofstream(folder.file("job.inp")) << deck;
  run.warnings = problem.notes;
  if (std::string note = first_order_note(problem); !note.empty()) run.warnings.push_back(std::move(note));
  run.build_seconds = seconds_since(begin);
  const Ended ended = run_process(folder, R"(cd "$0" && OMP_NUM_THREADS=$1 exec ccx -i job)", std::to_string(threads()),
                                  stop, std::numeric_limits<double>::infinity());
  run.solve_seconds = ended.seconds;
  const Printed printed = read_printed(folder.file("job.dat"), scene.specimen.body.size());
  if (!ended.well || !printed.complete) {
    run.outcome = ended.stopped ? Outcome::interrupted : Outcome::diverged;
    run.cause = "CalculiX: " + (ended.stopped                        ? "interrupted"
                                : ended.text.rfind("signal", 0) == 0 ? "ended by " + ended.text
                                                                     : ended.complaint);
    return;
  }
  measure_other(scene, problem.steps.back(), {printed.displacements, printed.forces - problem.forces.back()}, run);
}

}  // namespace

void check_calculix() {
  if (const std::string why = missing(*engines().find(kCalculix)); !why.empty())
    throw InputError("--against calculix: " + why + ", or leave it out");
}

OtherRun run_calculix(const Scene& scene, const Catalog& catalog, const std::vector<std::string>& overrides,
                      const std::function<bool()>& stop) {
  OtherRun result;
  Run& run = result.run;
  try {
    result.scene = load_scene_on(scene.source, catalog, overrides, [](Body& body, const Material&) {
      if (has_blocks(body, 3) || !body.tetrahedra.empty() || !body.cubes.empty()) body = second_order(body);
    });
    Scene& own = *result.scene;
    own.specimen.references = scene.specimen.references;
    const Material& material = own.specimen.material;
    const std::string& stated = scene.stiffness.strategy.name;
    own.stiffness = choose_strategy(catalog, material.law                      ? material.law->law
                                             : stated == "st_venant_kirchhoff" ? stated
                                                                               : "neo_hookean");
    run.solver =
        "ccx on " +
        std::string(own.specimen.body.blocks.empty() ? "cells" : own.specimen.body.blocks.front().kind->plural);
    solve(own, stop, run);
  } catch (const InputError& error) {
    run.suited = false;
    run.cause = error.what();
  }
  run.strategy = kCalculix;
  run.warnings.emplace_back("computed by CalculiX: shown with the others, never recommended");
  return result;
}

}  // namespace elastin::lab
