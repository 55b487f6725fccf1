#include <fmt/format.h>
#include <sys/resource.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>

#include "lab/scene/scene.h"
#include "measure.h"
#include "support/temporary_folder.h"

namespace bench {
namespace {

using namespace elastin;
using namespace elastin::lab;

/// An input of CalculiX. Places and cells count from 0 here.
struct Deck {
  std::string type;  ///< C3D8I, C3D20R
  std::vector<Vector3> positions;
  std::vector<std::vector<int>> cells;
  std::map<std::string, std::vector<int>> node_sets, cell_sets;
  std::string rest;  ///< material, supports, steps; the body is the set BODY, "WATCHED" is printed
};

/// Whether ccx can be started.
bool calculix_is_here() { return std::system("command -v ccx > /dev/null 2>&1") == 0; }

/// Writes JOB.inp.
void write_deck(const Deck& deck, const std::string& job) {
  std::ofstream file(job + ".inp");
  file << "*NODE, NSET=ALL\n";
  for (std::size_t i = 0; i < deck.positions.size(); ++i)
    file << fmt::format("{},{:.15g},{:.15g},{:.15g}\n", i + 1, deck.positions[i].x(), deck.positions[i].y(),
                        deck.positions[i].z());
  file << "*ELEMENT, TYPE=" << deck.type << ", ELSET=BODY\n";
  for (std::size_t i = 0; i < deck.cells.size(); ++i) {
    file << i + 1;
    for (std::size_t corner = 0; corner < deck.cells[i].size(); ++corner)
      file << (corner % 15 == 14 ? ",\n" : ",") << deck.cells[i][corner] + 1;  // 16 numbers a line
    file << '\n';
  }
  const auto write_sets = [&](const char* keyword, const auto& sets) {
    for (const auto& [name, numbers] : sets) {
      file << keyword << '=' << name << '\n';
      for (const int number : numbers) file << number + 1 << ",\n";
    }
  };
  write_sets("*NSET, NSET", deck.node_sets);
  write_sets("*ELSET, ELSET", deck.cell_sets);
  file << deck.rest;
  if (!file.flush()) throw std::runtime_error("cannot write " + job + ".inp");
}

void run_calculix_job(const std::string& job, int threads) {
  const std::string line = fmt::format("cd '{}' && OMP_NUM_THREADS={} ccx -i '{}' > '{}.log' 2>&1",
                                       std::filesystem::path(job).parent_path().string(), threads, job, job);
  if (std::system(line.c_str()) != 0) throw std::runtime_error("ccx failed: " + line);
}

/// The last displacements [m] that it has printed.
std::map<int, Vector3> last_displacements(const std::string& job) {
  std::ifstream file(job + ".dat");
  std::map<int, Vector3> found;
  for (std::string line; std::getline(file, line);) {
    if (line.find("displacements") != std::string::npos) found.clear();
    std::istringstream numbers(line);
    int number = 0;
    double x, y, z;
    if (numbers >> number >> x >> y >> z) found[number - 1] = {x, y, z};
  }
  if (found.empty()) throw std::runtime_error("CalculiX left no answer in " + job + ".dat");
  return found;
}

/// A block of hexahedra as CalculiX wants it, `counts` along x, y, z; quadratic ones have a place in the middle of each
/// side.
Deck hexahedra(const std::array<int, 3>& counts, const Vector3& size, bool quadratic) {
  Deck deck;
  deck.type = quadratic ? "C3D20R" : "C3D8I";
  const int step = quadratic ? 2 : 1;
  std::map<std::array<int, 3>, int> numbers;  // by half (quadratic) or whole steps
  const auto number = [&](const std::array<int, 3>& at) {
    const auto [position, is_new] = numbers.try_emplace(at, static_cast<int>(deck.positions.size()));
    if (is_new)
      deck.positions.emplace_back(size.x() * at[0] / (step * counts[0]), size.y() * at[1] / (step * counts[1]),
                                  size.z() * at[2] / (step * counts[2]));
    return position->second;
  };
  static constexpr std::array<std::array<int, 3>, 20> corners{
      {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}, {1, 0, 0}, {2, 1, 0},
       {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2}, {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}}};
  for (int z = 0; z < counts[2]; ++z)
    for (int y = 0; y < counts[1]; ++y)
      for (int x = 0; x < counts[0]; ++x) {
        if (z + 1 == counts[2]) deck.cell_sets["TOP"].push_back(static_cast<int>(deck.cells.size()));
        auto& cell = deck.cells.emplace_back();
        for (int c = 0; c < (quadratic ? 20 : 8); ++c)
          cell.push_back(number({step * x + corners[c][0] * step / 2, step * y + corners[c][1] * step / 2,
                                 step * z + corners[c][2] * step / 2}));
      }
  return deck;
}

/// What is solved: a scene of scenes/study, and how CalculiX is told the same.
struct Task {
  const char* scene;
  Vector3 size;
  int hold;  ///< the face that is held lies across this axis, at the origin
  std::string (*rest)();
  /// The scene's measure from the motion of what is watched.
  double (*measure)(const Deck& deck, const std::map<int, Vector3>& motion);
  bool (*watched)(const Vector3& position);
  std::array<int, 3> (*counts)(int level);
  std::vector<int> quadratic, linear;  ///< levels, from the coarsest on
  const char* law;                     ///< Elastin's, on hexahedra of 27 and of 8 molecules
  std::vector<int> elastin_quadratic, elastin_linear;
};

constexpr double kBlock = 0.03, kHeight = 0.015, kForce = 45e-6;  // m, N
constexpr double kLength = 1, kSide = 0.2;

/// The mean over a face: of quadratic ones the middles of the sides count a third of each square, the corners −1/12.
double mean_over_top(const Deck& deck, const std::map<int, Vector3>& motion) {
  double sum = 0, area = 0;
  for (const int cell : deck.cell_sets.at("TOP")) {
    const auto& nodes = deck.cells[cell];
    const bool quadratic = nodes.size() == 20;
    for (const int corner : {4, 5, 6, 7}) sum += (quadratic ? -1. / 12 : 1. / 4) * motion.at(nodes[corner]).z();
    for (const int middle : {12, 13, 14, 15})
      if (quadratic) sum += motion.at(nodes[middle]).z() / 3;
    area += 1;
  }
  return sum / area;
}

const Task kTasks[] = {
    {"clamped-block",
     {kBlock, kBlock, kHeight},
     2,
     [] {
       return fmt::format(
           "*MATERIAL, NAME=GEL\n*ELASTIC\n5000.,0.25\n*SOLID SECTION, ELSET=BODY, MATERIAL=GEL\n"
           "*BOUNDARY\nHELD,1,3\n*STEP\n*STATIC, SOLVER=SPOOLES\n*DLOAD\nTOP,P2,{:.15g}\n",
           -kForce / (kBlock * kBlock));
     },
     [](const Deck& deck, const std::map<int, Vector3>& motion) {
       return kForce * kHeight / (kBlock * kBlock * mean_over_top(deck, motion));
     },
     [](const Vector3& position) { return position.z() > (1 - 1e-9) * kHeight; },
     [](int level) {
       return std::array{2 * level, 2 * level, level};
     },
     {1, 2, 3, 4, 5, 6, 8, 12},
     {1, 2, 3, 4, 6, 8, 12, 16},
     "neo_hookean",
     {1, 2, 3, 4, 5, 6, 8},
     {1, 2, 3, 4, 6, 8, 12, 16}},
    {"cantilever-green",
     {kLength, kSide, kSide},
     0,
     [] {
       return std::string(
           "*MATERIAL, NAME=GEL\n*ELASTIC\n1e6,0.3\n*DENSITY\n1000.\n*SOLID SECTION, ELSET=BODY, MATERIAL=GEL\n"
           "*BOUNDARY\nHELD,1,3\n*STEP, NLGEOM, INC=1000\n*STATIC, SOLVER=SPOOLES\n0.25,1.\n"
           "*DLOAD\nBODY,GRAV,9.81,0.,0.,-1.\n");
     },
     [](const Deck&, const std::map<int, Vector3>& motion) { return -motion.begin()->second.z(); },
     [](const Vector3& position) { return (position - Vector3(kLength, kSide / 2, kSide / 2)).norm() < 1e-6; },
     [](int level) {
       return std::array{5 * level, level, level};
     },
     {2, 4, 6, 8, 10},
     {2, 4, 6, 8, 12},
     "st_venant_kirchhoff",
     {1, 2, 3, 4, 6, 8},
     {2, 4, 6, 8, 12, 16}}};

Deck deck_of(const Task& task, int level, bool quadratic) {
  Deck deck = hexahedra(task.counts(level), task.size, quadratic);
  for (std::size_t position = 0; position < deck.positions.size(); ++position) {
    if (deck.positions[position][task.hold] < 1e-9) deck.node_sets["HELD"].push_back(static_cast<int>(position));
    if (task.watched(deck.positions[position])) deck.node_sets["WATCHED"].push_back(static_cast<int>(position));
  }
  deck.rest = task.rest() + "*NODE PRINT, NSET=WATCHED, FREQUENCY=1000\nU\n*END STEP\n";
  return deck;
}

/// The command on the same scene with cells of its own, as CalculiX is run: a process that reads the scene, makes the
/// body, solves, and writes what it measures to `job`.json.
void run_elastin(const Task& task, int level, int order, int threads, const std::string& job) {
  const auto counts = task.counts(level);
  const std::string line = fmt::format(
      "'{}' run '{}/scenes/study/{}.yaml' --quiet --threads {} --json '{}.json' --set stiffness={} "
      "--set 'body={{lattice: {{kind: cubic, molecules: [{}, {}, {}], spacing: {:.15g} m, order: {}}}}}' > '{}.log' "
      "2>&1",
      ELASTIN_COMMAND, ELASTIN_SOURCE_DIR, task.scene, threads, job, task.law, counts[0] + 1, counts[1] + 1,
      counts[2] + 1, task.size[0] / counts[0], order, job);
  if (std::system(line.c_str()) != 0) throw std::runtime_error("elastin failed: " + line);
}

/// The first number of this name in what the command wrote.
double number_in(const std::string& text, const std::string& name) {
  const std::string key = '"' + name + "\": ";
  const auto at = text.find(key);
  if (at == std::string::npos) throw std::runtime_error("elastin wrote no " + name);
  return std::stod(text.substr(at + key.size(), 30));
}

Figures figures_of(const std::string& job, const std::string& measure) {
  const std::string text = text_of_file(job + ".json");
  Figures figures;
  figures.value = number_in(text, measure);
  figures.molecules = number_in(text, "molecules");
  figures.cells = number_in(text, "cells");
  return figures;
}

/// What takes longer runs once [s].
constexpr double kSlow = 10;

/// Processor time of the processes that `work` waits for [s], on all threads: what else the machine does has little
/// part in it.
double processor_seconds_of(const std::function<void()>& work) {
  const auto used = [] {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    const auto seconds = [](const timeval& time) {
      return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
  };
  const double before = used();
  work();
  return used() - before;
}

/// The scene's reference.
Reference reference_of(const Task& task) {
  const Catalog catalog = built_in_catalog();
  return load_scene(fmt::format("{}/scenes/study/{}.yaml", ELASTIN_SOURCE_DIR, task.scene), catalog)->references.at(0);
}

}  // namespace

std::vector<Row> run_accuracy(const Settings& settings) {
  const int threads = settings.threads.back(), repeats = std::min(settings.repeats, 3);
  if (!calculix_is_here())
    return {{"accuracy", "CalculiX", 0, threads, 0, {}, "skipped: ccx is not here; apt-get install calculix-ccx"}};
  std::vector<Row> rows;
  for (const Task& task : kTasks) {
    const Reference reference = reference_of(task);
    for (const int order : {2, 1})
      for (const int level : order == 2 ? task.elastin_quadratic : task.elastin_linear) {
        const std::string name = order == 2 ? "hexahedron27" : "hexahedron8";
        say(fmt::format("accuracy, {}, elastin {}, {}", task.scene, name, level));
        const TemporaryFolder folder;
        const std::string job = folder.path("job");
        std::vector<double> seconds;
        do seconds.push_back(processor_seconds_of([&] { run_elastin(task, level, order, threads, job); }));
        while (static_cast<int>(seconds.size()) < repeats && seconds.back() < kSlow);
        Figures figures = figures_of(job, reference.measure);
        const double measured = figures.value;
        figures.minimum = summary(seconds).minimum;
        figures.median = summary(seconds).median;
        figures.value = measured / reference.value;
        figures.error = std::abs(figures.value - 1);
        rows.push_back({"accuracy", fmt::format("elastin {}, {}", task.law, name), level, threads,
                        static_cast<int>(seconds.size()), figures,
                        fmt::format("{} {:.9g}", reference.measure, measured), task.scene});
      }
    for (const bool quadratic : {true, false})
      for (const int level : quadratic ? task.quadratic : task.linear) {
        const TemporaryFolder folder;
        const Deck deck = deck_of(task, level, quadratic);
        say(fmt::format("accuracy, {}, {}, {}", task.scene, deck.type, level));
        const std::string job = folder.path("job");
        write_deck(deck, job);
        std::vector<double> seconds;
        do seconds.push_back(processor_seconds_of([&] { run_calculix_job(job, threads); }));
        while (static_cast<int>(seconds.size()) < repeats && seconds.back() < kSlow);
        Figures figures;
        figures.minimum = summary(seconds).minimum;
        figures.median = summary(seconds).median;
        figures.cells = static_cast<double>(deck.cells.size());
        const double measured = task.measure(deck, last_displacements(job));
        figures.value = measured / reference.value;
        figures.error = std::abs(figures.value - 1);
        rows.push_back({"accuracy", "CalculiX " + deck.type, level, threads, static_cast<int>(seconds.size()), figures,
                        fmt::format("{} {:.9g}", reference.measure, measured), task.scene});
      }
  }
  return rows;
}

}  // namespace bench
