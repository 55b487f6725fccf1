#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;

constexpr int kSide = 22;

/// One strategy on one body: its constants, or, where they are updated at every evaluation, one evaluation.
std::vector<Figures> time_rule(const Strategy& strategy, const Body& body, int repeats) {
  VectorX constants;
  std::function<void()> work = [&] { constants = strategy.constants(body, kMaterial, {}); };
  Model updated(body);
  Workspace workspace;
  if (!strategy.constants) {
    updated.add(strategy.make(body, kMaterial, {}));
    work = [&] { updated.edge_laws().front()->add_force_densities(body.rest, constants, workspace); };
    constants = VectorX::Zero(body.connections.size());
  }
  const Sample sample = interleaved({work}, repeats).front();
  Figures figures;
  figures.springs = body.connections.size();
  figures.minimum = sample.minimum;
  figures.median = sample.median;
  figures.each = sample.minimum / figures.springs;
  return {figures};
}

}  // namespace

std::vector<Row> run_rules(const Settings& settings) {
  const Body cube = make_cube(kSide);
  Body block = tetrahedral_block(BlockKind::kuhn, {kSide - 1, kSide - 1, kSide - 1}, Vector3::Constant(kCubeLength));
  bench::set_matter(block, kSide);
  std::vector<Row> rows;
  const Catalog catalog = built_in_catalog();
  for (const Strategy& strategy : catalog.strategies()) {
    if (strategy.kind != StrategyKind::spring_rule && strategy.kind != StrategyKind::updated_spring_rule) continue;
    Row row{"rules", strategy.name, kSide, 1, settings.repeats, {}, ""};
    const bool on_cube = strategy.unsuited(cube).empty();
    const std::string hindrance = on_cube ? "" : strategy.unsuited(block);
    if (!hindrance.empty()) {
      row.note = hindrance;
    } else {
      say("rules, " + strategy.name);
      row.figures = in_child([&] { return time_rule(strategy, on_cube ? cube : block, settings.repeats); }).front();
      row.note = !strategy.constants ? "one evaluation" : on_cube ? "" : "on tetrahedra (Kuhn)";
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace bench
