// What every strategy of the catalog must keep, on every body that it can run on.

#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "elastin/core/base/error.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/simulation/fibres.h"
#include "elastin/core/solve/integrator.h"
#include "elastin/core/solve/stable_step.h"
#include "elastin/mesh/voronoi.h"
#include "support/allocations.h"
#include "support/bodies.h"
#include "support/law_constants.h"

using namespace elastin;
using namespace elastin::mesh;
using namespace elastin::testing;

namespace {

/// Plain; with a stress-strain curve; with fibres that follow a curve of their own; and one with the constants of each
/// material law. All moduli times `factor`.
std::vector<Material> materials(double factor = 1) {
  const Material plain{.youngs_modulus = factor * 2e4, .poissons_ratio = 0.3, .density = 1000, .thickness = 0.001};
  Material curved = plain, reinforced = plain;
  curved.curve = StressStrain::through(
      {{-0.1, -factor * 5e3}, {-0.03, -factor * 900}, {0, 0}, {0.02, factor * 500}, {0.1, factor * 4e3}});
  curved.youngs_modulus = curved.curve->modulus(0);
  reinforced.fibre = Fibre{Vector3(1, 2, 2) / 3, StressStrain::toe(0.03, factor * 1e4, factor * 3e5)};
  std::vector<Material> all{plain, curved, reinforced};
  static const Catalog catalog = built_in_catalog();
  for (const auto& [name, constants] : law_constants(factor))
    all.push_back(with_law(*catalog.material_laws.find(name), constants, plain));
  return all;
}
const Material kMaterial = materials()[0];

/// Adds the strategy and the fibres; returns whether the body suits both.
bool add_strategy(Model& model, const Strategy& strategy, const Material& material) {
  if (!strategy.unsuited(model.body()).empty()) return false;
  if (!material_unsuited(strategy, model.body(), material).empty()) return false;
  model.add(strategy.make(model.body(), material, {}));
  model.add(make_fibres(strategy, model.body(), material));
  return true;
}

/// Calls test(strategy, body, model, number of the material) for each strategy, material and body that go together.
template <class Test>
void for_each_pair(Test test) {
  std::vector<std::pair<std::string, Body>> bodies{
      {"lattice", jittered_lattice()}, {"block", jittered_block()}, {"sheet", sheet(kMaterial.thickness)}};
  for (auto& [name, body] : bodies) body.voronoi = voronoi_cells(body);
  for (const CellKind& kind : cell_kinds())
    if (kind.dimensions == 3) bodies.emplace_back(kind.name, cell_box(kind, {2, 1, 2}, {0.02, 0.01, 0.02}, 0.06, true));
  bodies.emplace_back("triangle6", quadratic_sheet(kMaterial.thickness));
  const std::vector<Material> all = materials();
  std::vector<Strategy> strategies = built_in_catalog().strategies();
  const std::size_t plain = strategies.size();
  for (std::size_t i = 0; i < plain; ++i)
    if (strategies[i].make_without_volume || strategies[i].kind == StrategyKind::spring_rule ||
        strategies[i].kind == StrategyKind::updated_spring_rule)
      strategies.push_back(with_volume(strategies[i]));
  for (const Strategy& strategy : strategies) {
    if (strategy.kind == StrategyKind::wrapper) continue;
    int bodies_used = 0;
    for (const auto& [name, body] : bodies)
      for (std::size_t material = 0; material < all.size(); ++material) {
        if (material > 2 && strategy.law != all[material].law->law) continue;           // E and nu as of the first
        if (!body.blocks.empty() && strategy.kind != StrategyKind::cell_law) continue;  // springs see simplices alone
        Model model(body);
        if (!add_strategy(model, strategy, all[material])) continue;
        ++bodies_used;
        INFO(strategy.name << " on " << name << ", material " << material);
        test(strategy, body, model, material);
      }
    INFO(strategy.name);
    CHECK(bodies_used > 0);  // a strategy that no body here suits is not tested at all
  }
}

}  // namespace

TEST_CASE("every strategy: forces are minus the gradient of the energy", "[conformance]") {
  for_each_pair([](const Strategy&, const Body& body, Model& model, std::size_t) {
    if (!model.has_energy()) return;
    const Positions positions = deformed(body, 2e-4);
    const Positions forces = model.elastic_forces(positions), motion = random_motion(body, 21);
    const double predicted = -forces.cwiseProduct(motion).sum(), h = 1e-7;
    // Fourth-order differences: their error is far below the rounding of the energy.
    const auto energy = [&](double step) { return model.elastic_energy(positions + step * motion); };
    const double measured = (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h);
    CHECK(measured == Approx(predicted).epsilon(1e-6));
  });
}

TEST_CASE("every strategy: the tangent is the difference of forces", "[conformance]") {
  for_each_pair([](const Strategy&, const Body& body, Model& model, std::size_t) {
    const Positions positions = deformed(body, 2e-4), motion = random_motion(body, 22);
    const State at{positions, Positions::Zero(3, positions.cols())};
    const Tangent tangent(model, at);
    Positions predicted(3, body.size());
    tangent.apply(motion, predicted);
    const double h = 1e-8;
    const Positions measured =
        -(model.elastic_forces(positions + h * motion) - model.elastic_forces(positions - h * motion)) / (2 * h);
    if (model.has_full_tangent()) CHECK((predicted - measured).norm() <= 1e-5 * measured.norm());
    // The parts of the blocks add up to the same operator, and the diagonal to its own.
    Positions assembled = Positions::Zero(3, body.size());
    tangent.visit_blocks([&](int a, int b, const Matrix3& part) { assembled.col(a) += part * motion.col(b); });
    CHECK((assembled - predicted).norm() <= 1e-11 * predicted.norm());
    const Matrix3 block = tangent.diagonal(3);
    Positions unit = Positions::Zero(3, body.size()), column(3, body.size());
    unit(1, 3) = 1;
    tangent.apply(unit, column);
    CHECK((column.col(3) - block.col(1)).head<2>().norm() <= 1e-11 * block.norm());  // the upper triangle
    if (model.has_energy()) CHECK((column.col(3) - block.col(1)).norm() <= 1e-11 * block.norm());
    if (model.has_energy()) {
      const Positions other = random_motion(body, 23);
      Positions image(3, body.size());
      tangent.apply(other, image);
      CHECK(predicted.cwiseProduct(other).sum() == Approx(image.cwiseProduct(motion).sum()).epsilon(1e-9));
    }
  });
}

TEST_CASE("every strategy: no total force, no total torque, none at rest, and it turns with the body",
          "[conformance]") {
  const Matrix3 turn = Eigen::AngleAxisd(1.1, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  for_each_pair([&](const Strategy&, const Body& body, Model& model, std::size_t) {
    const Positions positions = deformed(body, 2e-4), forces = model.elastic_forces(positions);
    const double size = forces.colwise().norm().sum();
    REQUIRE(size > 0);
    CHECK(forces.rowwise().sum().norm() <= 1e-13 * size);
    Vector3 torque = Vector3::Zero();
    for (int i = 0; i < body.size(); ++i) torque += Vector3(positions.col(i)).cross(Vector3(forces.col(i)));
    CHECK(torque.norm() <= 1e-13 * size * positions.cwiseAbs().maxCoeff() * 3);
    CHECK(model.elastic_forces(body.rest).norm() <= 1e-10 * size);
    Positions moved = turn * positions;
    moved.colwise() += Vector3(0.1, -0.2, 0.05);
    CHECK((model.elastic_forces(moved) - turn * forces).norm() <= 1e-9 * size);
  });
}

TEST_CASE("every strategy: stiffness scales with E and not with the order of molecules", "[conformance]") {
  for_each_pair([](const Strategy& strategy, const Body& body, Model& model, std::size_t material) {
    if (strategy.name.starts_with("uniform")) return;  // its constant is given, not made from E
    const Positions positions = deformed(body, 2e-4), forces = model.elastic_forces(positions);
    Model stiffer(body);
    REQUIRE(add_strategy(stiffer, strategy, materials(2)[material]));
    CHECK((stiffer.elastic_forces(positions) - 2 * forces).norm() <= 1e-13 * forces.norm());

    // The same body with its molecules numbered backwards.
    const int last = body.size() - 1;
    Body reversed = body;
    reversed.rest = body.rest.rowwise().reverse();
    reversed.radius = body.radius.reverse();
    for (auto& [a, b] : reversed.connections.ends) a = last - a, b = last - b;
    for (auto& cell : reversed.tetrahedra)
      for (int& molecule : cell) molecule = last - molecule;
    for (auto& cell : reversed.triangles)
      for (int& molecule : cell) molecule = last - molecule;
    for (auto& cell : reversed.cubes)
      for (int& molecule : cell) molecule = last - molecule;
    for (CellBlock& block : reversed.blocks)
      for (int& molecule : block.nodes) molecule = last - molecule;
    if (body.blocks.empty()) reversed.voronoi = voronoi_cells(reversed);
    Model other(reversed);
    REQUIRE(add_strategy(other, strategy, materials()[material]));
    const Positions back = other.elastic_forces(positions.rowwise().reverse()).rowwise().reverse();
    const bool fitted =
        strategy.name.starts_with("patch") || (material == 2 && strategy.kind != StrategyKind::cell_law);
    const double tolerance = fitted ? 1e-6 : 1e-12;  // the least squares are iterated to 1e-7
    CHECK((back - forces).norm() <= tolerance * forces.norm());
  });
}

TEST_CASE("the catalog names what it has and what is wrong", "[catalog]") {
  Catalog catalog = built_in_catalog();
  CHECK_THROWS_WITH(catalog.find("standrad"), Catch::Contains("did you mean 'standard'"));
  CHECK_THROWS_WITH(catalog.add(catalog.find("standard")), Catch::Contains("already"));
  const Body body = jittered_lattice();
  CHECK_THROWS_WITH(catalog.find("divided").make(body, kMaterial, {{"divisor", -1}}), Catch::Contains("out of range"));
  CHECK_THROWS_WITH(catalog.find("divided").make(body, kMaterial, {{"divisr", 1}}),
                    Catch::Contains("did you mean 'divisor'"));
  CHECK_THROWS_WITH(catalog.find("standard").make(body, kMaterial, {{"x", 1}}), Catch::Contains("takes no parameters"));
}

namespace {
/// A host's own rule: one struct, one line.
struct Twice {
  static constexpr std::string_view name = "twice", summary = "2 E", source = "test";
  VectorX constants(const Body& body, const Material& material) const {
    return VectorX::Constant(body.connections.size(), 2 * material.youngs_modulus);
  }
};
}  // namespace

TEST_CASE("a program adds its own rule in one line", "[catalog]") {
  Catalog catalog = built_in_catalog();
  catalog.add<Twice>();
  const Body body = jittered_lattice();
  CHECK(catalog.find("twice").constants(body, kMaterial, {})[0] == 4e4);
  CHECK(catalog.find("twice").kind == StrategyKind::spring_rule);
}

TEST_CASE("every strategy and stepper: steps ask for no memory after the first ones", "[conformance][steppers][slow]") {
  if (allocations() == 0) return;  // they cannot be counted here
  std::set<std::string> done;      // each strategy on one body, one of them on all
  std::map<std::string, int> steps;
  for_each_pair([&](const Strategy& strategy, const Body& body, Model& model, std::size_t) {
    if (strategy.kind == StrategyKind::updated_spring_rule) return;  // sets its springs anew in every pass
    if (!done.insert(strategy.name).second && strategy.name != "neo_hookean") return;
    model.add(make_gravity(body, {0, 0, -9.81}));
    model.add(make_mass_damping(body, 10));
    model.supports.push_back({0});
    for (const auto& row : built_in_steppers()) {
      const Stepper& scheme = *row;
      if (!unsuited_for(scheme, model).empty()) continue;
      State state = state_at_rest(body);
      state.velocities = 0.01 * random_motion(body, 33);
      const double dt = scheme.is_explicit ? 0.2 * bounded_stable_step(model, state).step : 2e-4;
      const auto integrator = make_integrator({scheme.name});
      const int parts = integrator->advance(model, state, dt).substeps;
      bool went = true;
      for (int step = 0; step < 2; ++step) went &= integrator->advance(model, state, dt).substeps == parts;
      const long before = allocations();
      for (int step = 0; step < 4; ++step) {
        const StepResult result = integrator->advance(model, state, dt);
        went &= result.outcome == Outcome::converged && result.substeps == parts;
      }
      const long after = allocations();
      INFO(scheme.name);
      CHECK(went);
      CHECK(after == before);
      ++steps[scheme.name];
    }
  });
  for (const auto& scheme : built_in_steppers()) CHECK(steps[scheme->name] > 2);
}
