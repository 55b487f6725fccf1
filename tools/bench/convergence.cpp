#include <fmt/format.h>

#include <cmath>

#include "blocks.h"
#include "elastin/base/threads.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;

struct Grid {
  BlockKind kind;
  const char* name;
};
constexpr Grid kGrids[] = {{BlockKind::kuhn, "kuhn"}, {BlockKind::body_centred, "body_centred"}};

Figures solve(const BlockReference& reference, const Grid& grid, int level, int threads) {
  set_threads(threads);
  Figures figures;
  std::unique_ptr<BlockProblem> problem;
  figures.build = seconds_of([&] {
    problem =
        std::make_unique<BlockProblem>(*reference.block, grid.kind, level, reference.law, reference.poissons_ratio);
  });
  StaticResult result;
  double elongation = 0;
  figures.minimum =
      seconds_of([&] { elongation = problem->elongation(std::string(reference.law) == "linear", 1e-9, &result); });
  figures.cells = static_cast<double>(problem->body.tetrahedra.size());
  figures.newton = result.newton_iterations;
  figures.iterations = result.linear_iterations;
  figures.value = reference.elongation / elongation;  // moduli are as the inverse of elongations
  figures.error = std::abs(figures.value - 1);
  return figures;
}

}  // namespace

std::vector<Row> run_convergence(const Settings& settings) {
  std::vector<Row> rows;
  for (const BlockReference& reference : kBlockReferences)
    for (const Grid& grid : kGrids) {
      double coarser = kNone;
      const int finest = reference.block == &kBlock1 ? 16 : 24;  // 0.7 to 2 · 10⁵ cells
      for (const int level : {finest / 8, finest / 4, finest / 2, finest}) {
        const std::string name =
            fmt::format("{} {}, nu {}, {}", reference.block->name, reference.law, reference.poissons_ratio, grid.name);
        say(fmt::format("convergence, {}, {}", name, level));
        Figures figures =
            in_child([&] { return std::vector{solve(reference, grid, level, settings.threads.back())}; }).front();
        figures.order = std::log2(coarser / figures.error);
        coarser = figures.error;
        rows.push_back({"convergence", name, level, settings.threads.back(), 1, figures, ""});
      }
    }
  return rows;
}

}  // namespace bench
