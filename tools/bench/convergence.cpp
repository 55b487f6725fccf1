#include <fmt/format.h>

#include <cmath>

#include "blocks.h"
#include "elastin/core/parallel/threads.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;

struct Grid {
  BlockKind kind;
  const char* name;
  int cells;  ///< of a cube
};
constexpr Grid kGrids[] = {{BlockKind::kuhn, "kuhn", 6}, {BlockKind::body_centred, "body_centred", 12}};

int cells_of(const BlockCase& one, const Grid& grid, int level) {
  const auto [x, y, z] = one.cubes(level);
  return grid.cells * x * y * z;
}

Figures solve(const BlockCase& one, const Grid& grid, int level, int threads) {
  set_threads(threads);
  const lab::Run run = one.run(grid.kind, level, 1e-9);
  Figures figures;
  figures.cells = static_cast<double>(cells_of(one, grid, level));
  figures.build = run.build_seconds;
  figures.minimum = figures.median = run.solve_seconds;
  figures.newton = run.newton_iterations;
  figures.iterations = run.linear_iterations;
  figures.value = run.measures.get(one.measure) / one.reference;
  figures.error = std::abs(figures.value - 1);
  return figures;
}

}  // namespace

std::vector<Row> run_convergence(const Settings& settings) {
  std::vector<Row> rows;
  const int threads = settings.threads.back();
  for (const BlockCase& one : block_cases())
    for (const Grid& grid : kGrids) {
      double coarser = kNone;
      for (const int level : {one.finest / 8, one.finest / 4, one.finest / 2, one.finest}) {
        const std::string name = fmt::format("{} {}, nu {}, {}", one.name, one.law, one.poissons_ratio, grid.name);
        say(fmt::format("convergence, {}, {}", name, level));
        Figures figures = in_child([&] { return std::vector{solve(one, grid, level, threads)}; }).front();
        figures.order = std::log2(coarser / figures.error);
        coarser = figures.error;
        const bool exact = figures.error < 3 * one.error;
        rows.push_back({"convergence", name, level, threads, 1, figures, exact ? "as exact as the reference" : ""});
      }
    }
  return rows;
}

}  // namespace bench
