// What every strategy of the catalog must keep, on every body that it can run on.

#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "core/simulation/fibres.h"
#include "core/solve/stable_step.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/model/rest.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/stepper.h"
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

/// Unstressed lengths that differ over the body and with the direction.
std::shared_ptr<const Rest> growth() {
  return std::make_shared<const Rest>(Rest{[](const Vector3& place, const Vector3&) {
    Matrix3 F;
    F << 1.1 + 2 * place.x(), 0.05, 0, 0, 0.95, 0.03 + place.y(), 0.02, 0, 1.05;
    return F;
  }});
}

/// Calls test(strategy, body, model, number of the material) for each strategy, material and body that go together.
template <class Test>
void for_each_pair(Test test, const std::shared_ptr<const Rest>& unstressed = nullptr) {
  std::vector<std::pair<std::string, Body>> bodies{
      {"lattice", jittered_lattice()}, {"block", jittered_block()}, {"sheet", sheet(kMaterial.thickness)}};
  for (auto& [name, body] : bodies) body.voronoi = voronoi_cells(body);
  for (const CellKind& kind : cell_kinds())
    if (kind.dimensions == 3) bodies.emplace_back(kind.name, cell_box(kind, {2, 1, 2}, {0.02, 0.01, 0.02}, 0.06, true));
  bodies.emplace_back("triangle6", quadratic_sheet(kMaterial.thickness));
  for (auto& [name, body] : bodies) body.unstressed = unstressed;
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
  const auto check = [](const Strategy&, const Body& body, Model& model, std::size_t) {
    if (!model.has_energy()) return;
    const Positions positions = deformed(body, 2e-4);
    const Positions forces = model.elastic_forces(positions), motion = random_motion(body, 21);
    const double predicted = -forces.cwiseProduct(motion).sum(), h = 1e-7;
    // Fourth-order differences: their error is far below the rounding of the energy.
    const auto energy = [&](double step) { return model.elastic_energy(positions + step * motion); };
    const double measured = (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h);
    CHECK(measured == Approx(predicted).epsilon(1e-6));
  };
  for_each_pair(check);
  for_each_pair(check, growth());
}

TEST_CASE("every strategy: the tangent is the difference of forces", "[conformance]") {
  const auto check = [](const Strategy&, const Body& body, Model& model, std::size_t) {
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
  };
  for_each_pair(check);
  for_each_pair(check, growth());
}

TEST_CASE("every strategy: no total force, no total torque, none at rest, and it turns with the body",
          "[conformance]") {
  const Matrix3 turn = Eigen::AngleAxisd(1.1, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  const auto check = [&](const Strategy&, const Body& body, Model& model, std::size_t) {
    const Positions positions = deformed(body, 2e-4), forces = model.elastic_forces(positions);
    const double size = forces.colwise().norm().sum();
    REQUIRE(size > 0);
    CHECK(forces.rowwise().sum().norm() <= 1e-13 * size);
    Vector3 torque = Vector3::Zero();
    for (int i = 0; i < body.size(); ++i) torque += Vector3(positions.col(i)).cross(Vector3(forces.col(i)));
    CHECK(torque.norm() <= 1e-13 * size * positions.cwiseAbs().maxCoeff() * 3);
    if (!body.unstressed) CHECK(model.elastic_forces(body.rest).norm() <= 1e-10 * size);
    Positions moved = turn * positions;
    moved.colwise() += Vector3(0.1, -0.2, 0.05);
    CHECK((model.elastic_forces(moved) - turn * forces).norm() <= 1e-9 * size);
  };
  for_each_pair(check);
  for_each_pair(check, growth());
}

TEST_CASE("every strategy: the body that is unstressed by F_g is free of stress at F_g X, and stiff as before",
          "[conformance][rest]") {
  Matrix3 growth, stretch;
  growth << 1.2, 0.1, 0, -0.05, 0.9, 0.04, 0.03, 0, 1.1;
  stretch << 1.08, 0.05, 0, -0.02, 0.95, 0.04, 0.03, 0, 1.04;
  const auto check = [&](const Strategy& strategy, const Body& body, Model& model, std::size_t material) {
    Body plain_body = body;
    plain_body.unstressed.reset();
    Model plain(plain_body);
    REQUIRE(add_strategy(plain, strategy, materials()[material]));
    const double size = plain.elastic_forces(stretch * body.rest).norm();
    CHECK(model.elastic_forces(growth * body.rest).norm() <= 1e-10 * size);
    CHECK(model.elastic_energy(growth * body.rest) <= 1e-18 * size);
    // W = det F_g · W of the stretch from there, where all points of the body are alike.
    if (strategy.kind == StrategyKind::cell_law && strategy.dimensions == 3 && model.has_energy())
      CHECK(model.elastic_energy(stretch * growth * body.rest) ==
            Approx(growth.determinant() * plain.elastic_energy(stretch * body.rest)).epsilon(1e-9));
    // Of half of it the lengths are half as much longer; of none the body is the plain one.
    model.set_rest(0.5);
    CHECK(model.elastic_forces((Matrix3::Identity() + growth) / 2 * body.rest).norm() <= 1e-10 * size);
    model.set_rest(0);
    CHECK((model.elastic_forces(stretch * body.rest) - plain.elastic_forces(stretch * body.rest)).norm() <=
          1e-11 * size);
  };
  for_each_pair(check, std::make_shared<const Rest>(Rest{[growth](const Vector3&, const Vector3&) { return growth; }}));
}

TEST_CASE("bodies that relax, soften or are turned keep their unstressed lengths", "[conformance][rest]") {
  Matrix3 growth;
  growth << 1.2, 0.1, 0, -0.05, 0.9, 0.04, 0.03, 0, 1.1;
  const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  Material material = kMaterial;
  material.relaxation = Relaxation{{{0.4, 0.1}}};
  material.softening = Softening{1.5, 1, 0.1};
  const Catalog catalog = built_in_catalog();
  for (const Body& plain : {jittered_lattice(), jittered_block(),
                            cell_box(cell_kind("hexahedron20"), {2, 1, 1}, {0.02, 0.01, 0.01}, 0.06, true)})
    for (const char* name : {"prony:standard", "mullins:standard", "prony:neo_hookean", "mullins:neo_hookean",
                             "prony:standard+volume", "prony:neo_hookean+volume"}) {
      const Strategy strategy = catalog.find(name);
      if (!strategy.unsuited(plain).empty()) continue;
      if (!plain.blocks.empty() && !plain.tetrahedra.empty() && std::string(name).find("standard") != std::string::npos)
        continue;
      Body body = plain;
      body.unstressed = std::make_shared<const Rest>(Rest{[&](const Vector3&, const Vector3&) { return growth; }});
      rotate(body, turn);
      INFO(name << " on " << body.size() << " molecules");
      Model model(body);
      model.add(strategy.make(body, material, {}));
      const double size = model.elastic_forces(body.rest).norm();
      CHECK(size > 0);
      State state = state_at_rest(body);
      model.declare_history(state);
      state.positions = turn * growth * plain.rest;
      model.begin_step(state, 1);
      CHECK(model.elastic_forces(state.positions).norm() <= 1e-10 * size);
      state.time = 1;
      model.commit_step(state);
      CHECK(model.stored_energy(state.positions) <= 1e-12 * size);
      CHECK(model.elastic_forces(body.rest).norm() > 0.1 * size);
    }
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

TEST_CASE("every strategy and stepper: steps allocate no memory after the first ones",
          "[conformance][steppers][slow]") {
  if (allocations() == 0) return;  // they cannot be counted here
  std::set<std::string> done;      // each strategy on one body, one of them on all
  std::map<std::string, int> steps;
  for_each_pair([&](const Strategy& strategy, const Body& body, Model& model, std::size_t) {
    if (strategy.kind == StrategyKind::updated_spring_rule) return;  // sets its springs again in every pass
    if (!done.insert(strategy.name).second && strategy.name != "neo_hookean") return;
    model.add(make_gravity(body, {0, 0, -9.81}));
    model.add(make_mass_damping(body, 10));
    model.supports.push_back({0});
    for (const auto& row : built_in_steppers()) {
      const StepperKind& method = *row;
      if (!unsuited_for(method, model).empty()) continue;
      State state = state_at_rest(body);
      state.velocities = 0.01 * random_motion(body, 33);
      const double dt = method.is_explicit ? 0.2 * bounded_stable_step(model, state).step : 2e-4;
      const auto stepper = make_stepper({method.name});
      const int parts = stepper->advance(model, state, dt).substeps;
      bool went = true;
      for (int step = 0; step < 2; ++step) went &= stepper->advance(model, state, dt).substeps == parts;
      const long before = allocations();
      for (int step = 0; step < 4; ++step) {
        const StepResult result = stepper->advance(model, state, dt);
        went &= result.outcome == Outcome::converged && result.substeps == parts;
      }
      const long after = allocations();
      INFO(method.name);
      CHECK(went);
      CHECK(after == before);
      ++steps[method.name];
    }
  });
  for (const auto& method : built_in_steppers()) CHECK(steps[method->name] > 2);
}
