#include <memory>

#include "core/shapes/orders.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "measure.h"
#include "plain_loop.h"
#include "support/law_constants.h"

namespace bench {
namespace {

using namespace elastin;

constexpr int kCubes = 26, kSquares = 224;  // 6 · 26³ = 105 456 tetrahedra, 2 · 224² = 100 352 triangles

Body make_block() {
  Body block = tetrahedral_block(BlockKind::kuhn, {kCubes, kCubes, kCubes}, Vector3::Constant(kCubeLength));
  bench::set_matter(block, kCubes + 1);
  return block;
}

Body make_sheet() {
  std::vector<Vector3> positions;
  for (int y = 0; y <= kSquares; ++y)
    for (int x = 0; x <= kSquares; ++x)
      positions.emplace_back(x * kCubeLength / kSquares, y * kCubeLength / kSquares, 0);
  Body sheet = listed_body(positions, {});
  for (int y = 0; y < kSquares; ++y)
    for (int x = 0; x < kSquares; ++x) {
      const int a = x + (kSquares + 1) * y, b = a + 1, c = a + kSquares + 1, d = c + 1;
      sheet.triangles.push_back({a, b, d});
      sheet.triangles.push_back({a, d, c});
    }
  sheet.connections = connections_of_cells(sheet.rest, sheet.triangles, {});
  elastin::set_matter(sheet, kCubeLength / kSquares / 2, kMaterial.density, 1e-3, 0);
  return sheet;
}

/// Some 20 000 molecules of the cube in cells of one shape.
Body make_block_of(const CellKind& kind) {
  const int side = kind.order == 2 ? 13 : 26;
  Body block;
  if (kind.corners == 4) {
    block = tetrahedral_block(BlockKind::kuhn, {side, side, side}, Vector3::Constant(kCubeLength));
  } else {
    block = cubic_lattice({side + 1, side + 1, side + 1}, kCubeLength / side, {true, false, false});
  }
  block = with_cells(block, kind);
  elastin::set_matter(block, kCubeLength / side / 4, kMaterial.density, 0, 0);
  return block;
}

Material membrane() {
  Material material = kMaterial;
  material.thickness = 1e-3;
  return material;
}

/// Stretched, sheared and bent a little, so that nothing is at rest.
Positions deformed(const Body& body) {
  Positions positions = body.rest;
  positions.row(1) *= 1.01;
  positions.row(0) += 0.02 * positions.row(1) + 0.01 * positions.row(1).cwiseAbs2();
  positions.row(2) += 0.01 * positions.row(0).cwiseAbs2();
  return positions;
}

constexpr int kPasses = 10;  // in a sample, so that it is long against the clock

/// One thread alone is timed by the processor, which other programs on it do not count for.
bool by_processor(const Settings& settings) { return settings.threads == std::vector{1}; }

enum class Pass { force, tangent, product };
constexpr const char* kPassNames[] = {"force", "tangent", "tangent times motion"};

/// One law's passes at each number of threads, in turn: figures by pass, then by threads.
std::vector<Figures> time_law(const Body& body, Model& model, const Settings& settings) {
  const Positions positions = deformed(body);
  const Positions motion = Positions::Random(3, body.size());
  const State state{positions, Positions::Zero(3, positions.cols())};
  const Tangent tangent(model, state);
  std::vector<std::function<void()>> works;
  Positions result(3, body.size());
  for (const Pass pass : {Pass::force, Pass::tangent, Pass::product})
    for (const int count : settings.threads)
      works.push_back([&, pass, count] {
        set_threads(count);
        for (int repeat = 0; repeat < kPasses; ++repeat) {
          if (pass == Pass::force) result = model.elastic_forces(positions);
          if (pass == Pass::tangent) Tangent(model, state);
          if (pass == Pass::product) tangent.apply(motion, result);
        }
      });
  std::vector<Figures> found;
  for (const Sample& sample : interleaved(works, settings.repeats, by_processor(settings))) {
    Figures figures;
    figures.springs = body.connections.size();
    figures.minimum = sample.minimum / kPasses;
    figures.median = sample.median / kPasses;
    figures.each = figures.minimum / figures.springs;
    const auto cells = static_cast<double>(count_cells(body));
    figures.molecules = body.size();
    if (cells > 0) figures.cells = cells, figures.each_cell = figures.minimum / cells;
    found.push_back(figures);
  }
  return found;
}

/// Springs as the command has them, without the block's cells, and the plain loop.
std::vector<Figures> time_springs(const Settings& settings) {
  Body block = make_block();
  const VectorX constants = built_in_catalog().find("standard").constants(block, kMaterial, {});
  block.tetrahedra.clear();
  Model model(block);
  model.add(make_springs(block, constants));
  return time_law(block, model, settings);
}

std::vector<Figures> time_plain_loop(const Settings& settings) {
  const Body block = make_block();
  const VectorX constants = built_in_catalog().find("standard").constants(block, kMaterial, {});
  const Positions positions = deformed(block);
  const Springs springs{block.connections, constants};
  std::vector<std::unique_ptr<Team>> teams;
  std::vector<std::vector<Positions>> forces;
  std::vector<std::function<void()>> works;
  for (const int count : settings.threads) {
    teams.push_back(std::make_unique<Team>(count));
    forces.emplace_back(count);
  }
  for (std::size_t i = 0; i < teams.size(); ++i)
    works.push_back([&, i] {
      for (int repeat = 0; repeat < kPasses; ++repeat) plain_forces(*teams[i], springs, positions, forces[i]);
    });
  std::vector<Figures> found;
  for (const Sample& sample : interleaved(works, settings.repeats, by_processor(settings))) {
    found.emplace_back();
    found.back().springs = block.connections.size();
    found.back().minimum = sample.minimum / kPasses;
    found.back().median = sample.median / kPasses;
    found.back().each = found.back().minimum / found.back().springs;
  }
  return found;
}

void add_rows(const std::string& name, const std::vector<Figures>& found, const Settings& settings, const char* note,
              std::vector<Row>& rows) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t threads = settings.threads.size();
    rows.push_back({"laws", name + ", " + kPassNames[i / threads], 0, settings.threads[i % threads], settings.repeats,
                    found[i], note + std::string(by_processor(settings) ? ", processor time" : "")});
  }
}

}  // namespace

std::vector<Row> run_laws(const Settings& settings) {
  std::vector<Row> rows;
  say("laws, springs");
  add_rows("plain loop", in_child([&] { return time_plain_loop(settings); }), settings, "edges of tetrahedra", rows);
  add_rows("springs", in_child([&] { return time_springs(settings); }), settings, "edges of tetrahedra", rows);
  const Body block = make_block(), sheet = make_sheet();
  const Catalog catalog = built_in_catalog();
  for (const Strategy& strategy : catalog.strategies()) {
    if (strategy.kind != StrategyKind::cell_law) continue;
    const bool solid = strategy.unsuited(block).empty();
    Material material = solid ? kMaterial : membrane();
    if (const auto constants = testing::law_constants(); constants.contains(strategy.law))
      material = with_law(*catalog.material_laws.find(strategy.law), constants.at(strategy.law), material);
    if (!strategy.unsuited_material(material).empty()) continue;
    say("laws, " + strategy.name);
    const auto found = in_child([&] {
      const Body& body = solid ? block : sheet;
      Model model(body);
      model.add(strategy.make(body, material, {}));
      return time_law(body, model, settings);
    });
    add_rows(strategy.name, found, settings, solid ? "tetrahedra" : "triangles", rows);
  }
  for (const char* name : {"prony:neo_hookean", "mullins:neo_hookean"}) {
    say(std::string("laws, ") + name);
    Material material = kMaterial;
    material.relaxation = Relaxation{{{0.5, 1}, {0.3, 10}}};
    material.softening = Softening{1.5, 1000, 0.1};
    for (const bool second_order : {false, true}) {
      const auto found = in_child([&] {
        const Body body = second_order ? make_block_of(cell_kind("tetrahedron10")) : make_block();
        Model model(body);
        model.add(catalog.find(name).make(body, material, {}));
        State state = state_at_rest(body);
        model.declare_history(state);
        state.positions = deformed(body);
        model.commit_step(state);
        model.begin_step(state, 0.1);
        return time_law(body, model, settings);
      });
      add_rows(std::string(name) + (second_order ? ", tetrahedron10" : ""), found, settings,
               second_order ? "tetrahedron10" : "tetrahedra", rows);
    }
  }
  for (const CellKind& kind : cell_kinds()) {
    if (kind.dimensions != 3 || kind.name == "tetrahedron4" || kind.name == "prism6") continue;
    say("laws, " + std::string(kind.name));
    for (const char* name : {"neo_hookean", "neo_hookean+volume"}) {
      const auto found = in_child([&] {
        const Body body = make_block_of(kind);
        Model model(body);
        model.add(catalog.find(name).make(body, kMaterial, {}));
        return time_law(body, model, settings);
      });
      add_rows(std::string(name) + ", " + std::string(kind.name), found, settings, std::string(kind.plural).c_str(),
               rows);
    }
  }
  return rows;
}

}  // namespace bench
