#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

#include "elastin/c/elastin.h"
#include "elastin/core/shapes/shapes.h"
#include "measure.h"
#include "support/temporary_folder.h"

namespace bench {
namespace {

using namespace elastin;
namespace files = std::filesystem;

constexpr double kDensity = 1000, kModulus = 1e5;

/// What is stepped on both sides, by the C API here and by the same functions in the module there.
struct Case {
  const char *kind, *strategy, *each;
};
constexpr std::array<Case, 2> kCases{
    {{"lattice", "lattice", "springs of a lattice"}, {"tetrahedra", "neo_hookean", "neo-Hookean tetrahedra"}}};

struct Answer {
  double seconds = kNone, place = kNone;  ///< what the steps took, and the first molecule's x after them
};

void need(elastin_status status) {
  if (status != ELASTIN_OK) throw std::runtime_error(elastin_message());
}

Answer native(elastin_body* body, const Case& one, double dt, int steps) {
  const elastin_material material{sizeof material, kModulus, 0.25, 0, 0, nullptr, nullptr};
  elastin_simulation* made = nullptr;
  need(elastin_simulate(body, one.strategy, &material, nullptr, &made));
  const std::unique_ptr<elastin_simulation, decltype(&elastin_simulation_free)> tissue(made, elastin_simulation_free);
  double* forces = nullptr;
  std::size_t count = 0;
  need(elastin_host_forces(made, &forces, &count));
  for (std::size_t i = 0; i < count; i += 3) forces[i] = 1e-2 * static_cast<double>(i) / static_cast<double>(count);
  need(elastin_step(made, dt, nullptr));
  Answer answer;
  answer.seconds = seconds_of([&] {
    for (int step = 0; step < steps; ++step) need(elastin_step(made, dt, nullptr));
  });
  const double* positions = nullptr;
  need(elastin_positions(made, &positions, &count));
  answer.place = positions[0];
  return answer;
}

/// The same by node.
Answer in_node(const files::path& npm, const files::path& cells, const Case& one, int side, double dt, int steps) {
  const std::string line = fmt::format("node '{}/tools/bench/web.js' '{}' '{}' {} {} {} {} {}", ELASTIN_SOURCE_DIR,
                                       npm.string(), cells.string(), one.kind, one.strategy, side, dt, steps);
  FILE* output = popen(line.c_str(), "r");
  Answer answer;
  const int read = output ? std::fscanf(output, "%lf %lf", &answer.seconds, &answer.place) : 0;
  if (!output || pclose(output) != 0 || read != 2) throw std::runtime_error("failed: " + line);
  return answer;
}

/// The block's positions and cells as JSON, which node reads.
void write_cells(const Body& block, const files::path& path) {
  std::ofstream file(path);
  file << fmt::format("{{\"positions\": [{}], \"tetrahedra\": [",
                      fmt::join(block.rest.data(), block.rest.data() + block.rest.size(), ","));
  for (std::size_t cell = 0; cell < block.tetrahedra.size(); ++cell)
    file << (cell ? "," : "") << fmt::format("{}", fmt::join(block.tetrahedra[cell], ","));
  if (!(file << "]}").flush()) throw std::runtime_error("cannot write " + path.string());
}

elastin_body* make_body(const Case& one, int side, const Body& block) {
  elastin_body* body = nullptr;
  if (std::string(one.kind) == "lattice") {
    const std::array<int, 3> counts{side, side, side};
    const std::array<double, 3> spacing{0.01, 0.01, 0.01};
    need(elastin_lattice(counts.data(), spacing.data(), ELASTIN_AXIS | ELASTIN_FACE, kDensity, &body));
    return body;
  }
  elastin_arrays arrays{};
  arrays.size = sizeof arrays;
  arrays.positions = block.rest.data(), arrays.molecule_count = static_cast<std::size_t>(block.size());
  arrays.tetrahedra = block.tetrahedra.front().data(), arrays.tetrahedron_count = block.tetrahedra.size();
  arrays.density = kDensity;
  need(elastin_body_from_arrays(&arrays, &body));
  return body;
}

}  // namespace

std::vector<Row> run_web(const Settings& settings) {
  const files::path npm = files::read_symlink("/proc/self/exe").parent_path().parent_path() / "web/npm";
  const TemporaryFolder folder;
  const files::path cells = folder.path("cells.json");
  std::string missing;
  if (!files::exists(npm / "elastin.wasm")) missing = "left out: tools/setup --web builds the module";
  if (missing.empty() && std::system("node --version > /dev/null 2>&1") != 0) missing = "left out: there is no node";
  std::vector<Row> rows;
  for (const int side : settings.sides) {
    const Body block =
        tetrahedral_block(BlockKind::kuhn, {side - 1, side - 1, side - 1}, Vector3::Constant(0.01 * (side - 1)));
    write_cells(block, cells);
    for (const Case& one : kCases) {
      say(fmt::format("web, {}, side {}", one.kind, side));
      const std::unique_ptr<elastin_body, decltype(&elastin_body_free)> body(make_body(one, side, block),
                                                                             elastin_body_free);
      elastin_counts counts{sizeof counts, 0, 0, 0, 0};
      need(elastin_body_counts(body.get(), &counts));
      const bool springs = counts.tetrahedra == 0;
      const double each = static_cast<double>(springs ? counts.connections : counts.tetrahedra);
      const double dt = 0.1 * 0.01 / std::sqrt(kModulus / kDensity);  // far below the stable step
      const int steps = std::max(20, static_cast<int>((springs ? 4e7 : 1e7) / each));
      std::array<std::vector<double>, 2> seconds;
      for (int repeat = 0; repeat < settings.repeats; ++repeat) {
        const Answer here = native(body.get(), one, dt, steps);
        seconds[0].push_back(here.seconds / steps);
        if (!missing.empty()) continue;
        const Answer there = in_node(npm, cells, one, side, dt, steps);
        seconds[1].push_back(there.seconds / steps);
        if (here.place != there.place) throw std::runtime_error("WebAssembly does not give the native bits");
      }
      for (std::size_t where = 0; where < 2; ++where) {
        Figures figures;
        figures.molecules = static_cast<double>(counts.molecules);
        (springs ? figures.springs : figures.cells) = each;
        if (!seconds[where].empty()) {
          const Sample sample = summary(seconds[where]);
          figures.minimum = sample.minimum, figures.median = sample.median;
          (springs ? figures.each : figures.each_cell) = sample.minimum / each;
          figures.ratio = summary(seconds[0]).minimum / sample.minimum;
        }
        const std::string note = where ? missing.empty() ? "the native bits" : missing : "";
        rows.push_back({"web", fmt::format("{}, {}", one.each, where ? "WebAssembly in node" : "native"), side, 1,
                        settings.repeats, figures, note});
      }
    }
  }
  return rows;
}

}  // namespace bench
