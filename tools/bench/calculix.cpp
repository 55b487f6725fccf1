#include <fmt/format.h>

#include <cmath>
#include <map>
#include <stdexcept>

#include "blocks.h"
#include "calculix_job.h"
#include "core/model/faces.h"
#include "elastin/core/parallel/threads.h"
#include "measure.h"
#include "support/temporary_folder.h"

namespace bench {
namespace {

using namespace elastin;
using namespace elastin::lab;

constexpr int kThreads = 2;
constexpr double kPoissonsRatio = 0.3;

/// What is asked of both programs: block T1 of Kuhn tetrahedra under a part of its load.
struct Task {
  const char* name;
  double part;
  double reference;      ///< elongation under the whole load [m]
  bool calculix_agrees;  ///< its neo-Hookean solid has the same answer, to well below the mesh's error
};
// CalculiX's solid is C10 (Ī₁ − 3) + (J − 1)²/D1 with C10 = μ/2, D1 = 2/K; ours ½ μ (F : F − 3) − μ ln J + ½ λ (J −
// 1)². They share E and ν; at a strain of 1e-5 their answers, and the linear one, differ by some 1e-5.
constexpr Task kTasks[] = {{"T1, 1/20000 of its load", 5e-5, 0.00314180381, true},
                           {"T1, whole load", 1, 0.0036002, false}};

BlockCase block_of(const Task& task) {
  return tension_block1("neo_hookean", kPoissonsRatio, task.reference * task.part, 0, task.part);
}

/// A mesh as CalculiX wants it: numbers from 1, corners first.
struct Mesh {
  std::string type;  // C3D4, C3D10
  std::vector<Vector3> positions;
  std::vector<std::vector<int>> cells;
  std::map<int, double> share;  // of the load by place on the loaded face, sum 1
  std::vector<int> held;
};

Mesh linear_mesh(const Body& body) {
  Mesh mesh{.type = "C3D4", .positions = {}, .cells = {}, .share = {}, .held = {}};
  for (int molecule = 0; molecule < body.size(); ++molecule) mesh.positions.push_back(body.rest.col(molecule));
  for (const auto& cell : body.tetrahedra) mesh.cells.emplace_back(cell.begin(), cell.end());
  const Face loaded = end_face(body, Vector3::UnitZ(), 0);
  for (std::size_t i = 0; i < loaded.molecules.size(); ++i)
    mesh.share[loaded.molecules[i]] = loaded.share[static_cast<Eigen::Index>(i)];
  mesh.held = end_face(body, -Vector3::UnitZ(), 0).molecules;
  return mesh;
}

/// The same body with a place in the middle of each connection: quadratic tetrahedra.
Mesh quadratic_mesh(const Body& body) {
  Mesh mesh = linear_mesh(body);
  mesh.type = "C3D10";
  std::map<std::pair<int, int>, int> middle;
  const double top = body.rest.row(2).maxCoeff(), bottom = body.rest.row(2).minCoeff();
  for (const auto& [a, b] : body.connections.ends) {
    const int number = static_cast<int>(mesh.positions.size());
    middle[{a, b}] = middle[{b, a}] = number;
    mesh.positions.push_back((body.rest.col(a) + body.rest.col(b)) / 2);
    if (mesh.positions.back().z() < bottom + 1e-9) mesh.held.push_back(number);
  }
  mesh.share.clear();
  double area = 0;
  for (auto& cell : mesh.cells) {
    static constexpr std::array<std::array<int, 2>, 6> sides{{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
    for (const auto& [i, j] : sides) cell.push_back(middle.at({cell[i], cell[j]}));
    std::vector<int> face;
    for (int corner = 0; corner < 4; ++corner)
      if (mesh.positions[cell[corner]].z() > top - 1e-9) face.push_back(cell[corner]);
    if (face.size() < 3) continue;
    // Uniform traction on six places: a third of the triangle's to each middle of a side.
    const Vector3 a = mesh.positions[face[0]], b = mesh.positions[face[1]], c = mesh.positions[face[2]];
    const double part = (b - a).cross(c - a).norm() / 2;
    area += part;
    for (int i = 0; i < 3; ++i) mesh.share[middle.at({face[i], face[(i + 1) % 3]})] += part / 3;
  }
  for (auto& [position, share] : mesh.share) share /= area;
  return mesh;
}

void write_input(const Mesh& mesh, const BlockCase& block, double part, const std::string& job) {
  const double mu = block.modulus / (2 * (1 + kPoissonsRatio)), bulk = block.modulus / (3 * (1 - 2 * kPoissonsRatio));
  std::vector<int> loaded;
  for (const auto& [position, share] : mesh.share) loaded.push_back(position);
  Deck deck{mesh.type, mesh.positions, mesh.cells, {{"HELD", mesh.held}, {"WATCHED", loaded}}, {}, {}};
  deck.rest = fmt::format("*MATERIAL, NAME=GEL\n*HYPERELASTIC, NEO HOOKE\n{:.15g},{:.15g}\n", mu / 2, 2 / bulk) +
              "*SOLID SECTION, ELSET=BODY, MATERIAL=GEL\n*BOUNDARY\nHELD,1,3\n*STEP, NLGEOM, INC=1000\n"
              "*STATIC, SOLVER=SPOOLES\n" +
              (part < 0.01 ? "1.,1.\n" : "0.25,1.\n") + "*CLOAD\n";
  for (const auto& [position, share] : mesh.share)
    deck.rest += fmt::format("{},3,{:.15g}\n", position + 1, part * share);
  deck.rest += "*NODE PRINT, NSET=WATCHED, FREQUENCY=1000\nU\n*END STEP\n";
  write_deck(deck, job);
}

/// Mean of the loaded face's displacements along z [m].
double read_elongation(const Mesh& mesh, const std::string& job) {
  double sum = 0, found = 0;
  for (const auto& [position, motion] : last_displacements(job)) {
    sum += mesh.share.at(position) * motion.z();
    found += mesh.share.at(position);
  }
  if (std::abs(found - 1) > 1e-6) throw std::runtime_error("CalculiX left no whole answer in " + job + ".dat");
  return sum;
}

/// One program on one mesh: a run as a whole process, and the elongation that it found.
struct Contender {
  std::string name;
  double cells;
  std::function<double()> run;
  double elongation = 0;
};

std::vector<Contender> contenders_of(const Task& task, int level, const TemporaryFolder& folder) {
  const auto elastin_run = [&task, level] {
    return in_child([&] {
             set_threads(kThreads);
             Figures figures;
             figures.value = block_of(task).run(BlockKind::kuhn, level, 1e-8).measures.get("elongation");
             return std::vector{figures};
           })
        .front()
        .value;
  };
  const auto calculix_run = [&task, &folder](Mesh mesh) {
    const std::string job = folder.path(mesh.type);
    write_input(mesh, block_of(task), task.part, job);
    return [mesh = std::move(mesh), job] {
      run_calculix_job(job, kThreads);
      return read_elongation(mesh, job);
    };
  };
  const BlockCase block = block_of(task);
  const Body fine = tetrahedral_block(BlockKind::kuhn, block.cubes(level), block.size);
  const Body coarse = tetrahedral_block(BlockKind::kuhn, block.cubes(level / 2), block.size);
  return {{"elastin", static_cast<double>(fine.tetrahedra.size()), elastin_run},
          {"CalculiX C3D4", static_cast<double>(fine.tetrahedra.size()), calculix_run(linear_mesh(fine))},
          {"CalculiX C3D10, as many places", static_cast<double>(coarse.tetrahedra.size()),
           calculix_run(quadratic_mesh(coarse))}};
}

}  // namespace

std::vector<Row> run_calculix(const Settings& settings) {
  if (!calculix_is_here()) return {{"calculix", "CalculiX", 0, kThreads, 0, {}, kCalculixMissing}};
  constexpr int level = 16;
  std::vector<Row> rows;
  for (const Task& task : kTasks) {
    const TemporaryFolder folder;
    std::vector<Contender> contenders = contenders_of(task, level, folder);
    const int repeats = std::min(settings.repeats, 3);  // CalculiX takes half a minute
    std::vector<std::function<void()>> works;
    for (Contender& contender : contenders)
      works.push_back([&] {
        say(fmt::format("calculix, {}, {}", task.name, contender.name));
        contender.elongation = contender.run();
      });
    const std::vector<Sample> samples = interleaved(works, repeats);
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      Figures figures;
      figures.cells = contenders[i].cells;
      figures.minimum = samples[i].minimum;
      figures.median = samples[i].median;
      figures.ratio = samples[1].median / samples[i].median;
      const bool comparable = i == 0 || task.calculix_agrees;
      const double value = task.reference * task.part / contenders[i].elongation;
      if (comparable) figures.value = value, figures.error = std::abs(value - 1);
      rows.push_back(
          {"calculix", fmt::format("{}: {}", task.name, contenders[i].name), level, kThreads, repeats, figures,
           comparable ? "" : fmt::format("another neo-Hookean solid: elongation {:.6g} m", contenders[i].elongation)});
    }
  }
  return rows;
}

}  // namespace bench
