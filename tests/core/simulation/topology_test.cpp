// Simulations that are cut and torn while they move.

#include <catch2/catch.hpp>

#include "core/shapes/surfaces.h"
#include "core/simulation/tissues.h"
#include "core/solve/stable_step.h"
#include "elastin/core/base/error.h"
#include "elastin/core/shapes/arrays.h"
#include "elastin/core/simulation/saved_state.h"
#include "support/refusal.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Contains;

namespace {

constexpr double kStep = 1e-3;  // s

void step(Simulation& tissue, int count) {
  for (int i = 0; i < count; ++i) {
    const StepResult result = tissue.step(kStep);
    INFO(result.cause);
    REQUIRE(result.outcome == Outcome::converged);
  }
}

/// A block or lattice that hangs from one side under gravity.
Simulation hanging(const std::string& strategy, const StepperMethod& method = "backward_euler") {
  const bool cells = strategy.starts_with("neo");
  SimulationOptions options;
  options.stepper.method = method;
  Simulation tissue(cells ? tissue_block() : tissue_cube(4), built_in_catalog().find(strategy), kTissue, options);
  tissue.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", Vector3(0, 0, -9.81)}}});
  for (int molecule = 0; molecule < tissue.body().size(); ++molecule)
    if (tissue.body().rest(0, molecule) == 0) tissue.fix(molecule);
  return tissue;
}

const CutSurface kMiddle = CutSurface::plane({3e-3, 3e-3, 3e-3}, {0, 1, 0.2});

Vector3 momentum(const Simulation& tissue) { return tissue.velocities() * tissue.body().mass; }

}  // namespace

TEST_CASE("a body that is cut while it moves keeps momentum, energy and stiffness", "[topology]") {
  for (const std::string strategy : {"neo_hookean", "lattice", "calibrated:standard"}) {
    INFO(strategy);
    Simulation tissue = hanging(strategy);
    step(tissue, 20);
    const double energy = tissue.model().elastic_energy(tissue.positions());
    const Vector3 before = momentum(tissue);
    const double mass = tissue.body().mass.sum();
    const TopologyReport report = tissue.cut(kMiddle);
    REQUIRE(report.changed);
    CHECK(report.split_molecules > 0);
    CHECK(inspect(tissue.body()).pieces == 2);
    CHECK(tissue.body().mass.sum() == Approx(mass).epsilon(1e-14));
    CHECK((momentum(tissue) - before).norm() < 1e-14 * before.norm());
    CHECK(tissue.model().elastic_energy(tissue.positions()) == Approx(energy).epsilon(1e-12));
    CHECK(tissue.origin().size() == static_cast<std::size_t>(tissue.body().size()));
    step(tissue, 20);
    // What was one molecule goes two ways.
    const int split = static_cast<int>(report.molecule_from.size()) - 1;
    CHECK((tissue.positions().col(split) - tissue.positions().col(report.molecule_from.back())).norm() > 0);
  }
}

TEST_CASE("a cut body goes on as one that was made so", "[topology]") {
  for (const StepperMethod method : {"backward_euler", "symplectic_euler", "block_descent", "projective"}) {
    INFO(method->name);
    const double dt =
        method->is_explicit ? 2e-5 : kStep;  // in one part, whatever the longest stable step is said to be
    Simulation tissue = hanging("neo_hookean", method);
    step(tissue, 10);
    const Positions there = tissue.positions();
    tissue.cut(kMiddle);
    SimulationOptions options;
    options.stepper.method = method;
    const Body made = cut(tissue_block(), there, kMiddle).body;
    Simulation other(made, built_in_catalog().find("neo_hookean"), kTissue, options);
    other.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", Vector3(0, 0, -9.81)}}});
    SimulationState state = tissue.save();
    state.topology = nullptr;
    other.restore(state);
    for (int i = 0; i < 10; ++i) {
      const StepResult one = tissue.step(dt), two = other.step(dt);
      REQUIRE((one.outcome == Outcome::converged && two.outcome == Outcome::converged));
      REQUIRE((one.substeps == 1 && two.substeps == 1));
    }
    CHECK(tissue.positions() == other.positions());
  }
}

TEST_CASE("explicit steps after a cut go by a bound that is never too long", "[topology]") {
  for (const bool damped : {false, true}) {
    Simulation tissue = hanging("neo_hookean", "symplectic_euler");
    tissue.cut(kMiddle);
    if (damped) tissue.add_load(*built_in_loads().find("rayleigh"), {.numbers = {{"mass", 30}, {"stiffness", 2e-4}}});
    const State rest = state_at_rest(tissue.body());
    tissue.model().supports.clear();
    const StableStep exact = find_stable_step(tissue.model(), rest), bound = bounded_stable_step(tissue.model(), rest);
    CHECK(bound.step <= exact.step * (1 + 1e-4));
    CHECK(bound.step > 0.3 * exact.step);
    CHECK(bound.frequency >= exact.frequency * (1 - 1e-4));
    CHECK(bound.damping_rate >= exact.damping_rate * (1 - 1e-4));
  }
}

TEST_CASE("states are saved and restored across a cut, bitwise", "[topology]") {
  const auto begin = [] { return hanging("lattice", "backward_euler"); };
  Simulation tissue = begin();
  const CouplingId tool = tissue.couple(63, tissue.positions().col(63), 5, 0.01);
  tissue.host_forces()(0, 40) = 1e-4;
  step(tissue, 5);
  const std::vector<char> whole = bytes_of(tissue.save());
  const SimulationState in_memory = tissue.save();
  tissue.cut(kMiddle);
  tissue.move_coupling(tool, tissue.positions().col(63) + Vector3(0, 0, 1e-3));
  step(tissue, 5);
  const std::vector<char> parted = bytes_of(tissue.save());
  const SimulationState parted_in_memory = tissue.save();
  step(tissue, 5);
  const std::vector<char> reached = bytes_of(tissue.save());

  Simulation fresh = begin();  // that was never cut
  fresh.restore(simulation_state_of(parted.data(), parted.size()));
  CHECK(fresh.body().size() == tissue.body().size());
  step(fresh, 5);
  CHECK(bytes_of(fresh.save()) == reached);

  for (const bool from_memory : {false, true}) {  // back before the cut, and once more
    tissue.restore(from_memory ? in_memory : simulation_state_of(whole.data(), whole.size()));
    CHECK(tissue.body().size() == 64);
    CHECK(bytes_of(tissue.save()) == whole);
    tissue.cut(kMiddle);
    tissue.move_coupling(tool, tissue.positions().col(63) + Vector3(0, 0, 1e-3));
    step(tissue, 5);
    CHECK(bytes_of(tissue.save()) == parted);
    tissue.restore(parted_in_memory);
    step(tissue, 5);
    CHECK(bytes_of(tissue.save()) == reached);
  }
}

TEST_CASE("supports, host forces and observers follow a cut", "[topology]") {
  Simulation tissue = hanging("neo_hookean");
  const CutSurface through = CutSurface::plane({0, 2e-3, 0}, {0, 1, 0});  // through fixed molecules, between layers
  const int split = 4;                                                    // at (0, 2 mm, 0)
  REQUIRE(tissue.body().rest.col(split) == Vector3(0, 2e-3, 0));
  tissue.host_forces().col(split) = Vector3(1, 2, 3);
  int seen = 0;
  tissue.observe(1, [&](const Simulation&) { ++seen; });
  const TopologyReport report = tissue.cut(through);
  double share = 0;
  int images = 0;
  for (int molecule = 0; molecule < tissue.body().size(); ++molecule) {
    if (report.molecule_from[molecule] != split) continue;
    ++images;
    share += tissue.host_forces()(2, molecule);
    tissue.move_to(molecule, Vector3(0, 2e-3, 1e-4));  // throws where it is not held
  }
  CHECK(images == 2);
  CHECK(share == Approx(3).epsilon(1e-14));
  step(tissue, 2);
  CHECK(seen == 2);
  CHECK(tissue.positions()(2, split) == 1e-4);
  const TopologyReport again = tissue.cut(through);
  CHECK_FALSE(again.changed);
}

TEST_CASE("loads on named molecules follow cuts, removals and their undoing", "[topology]") {
  Simulation tissue(tissue_block(), built_in_catalog().find("neo_hookean"), kTissue, {});
  const Body whole = tissue.body();
  const double high = whole.rest.row(2).maxCoeff(), middle = whole.rest.row(1).maxCoeff() / 2;
  std::vector<int> top;
  int corner = -1, last = -1;
  for (int molecule = 0; molecule < whole.size(); ++molecule) {
    if (whole.rest(2, molecule) == high) top.push_back(molecule), last = molecule;
    if (whole.rest.col(molecule).norm() == 0) corner = molecule;
  }
  REQUIRE(corner == 0);
  const auto total = [&] { return Vector3(tissue.forces().rowwise().sum()); };
  const LoadId traction = tissue.add_load(*built_in_loads().find("traction"),
                                          {.vectors = {{"traction", Vector3(0, 0, 50)}}, .molecules = {{"on", top}}});
  tissue.add_load(*built_in_loads().find("pressure"), {.numbers = {{"pressure", 100}}, .molecules = {{"on", top}}});
  tissue.add_load(*built_in_loads().find("point"),
                  {.vectors = {{"force", Vector3(1e-3, 0, 0)}}, .molecules = {{"molecules", {last}}}});
  const Vector3 before = total();
  const SimulationState saved = tissue.save();
  const TopologyReport cut = tissue.cut(CutSurface::plane({0, middle, 0}, {0, 1, 0}));
  REQUIRE(cut.split_molecules > 0);
  CHECK((total() - before).norm() < 1e-12 * before.norm());

  std::vector<int> cells;  // all that have the corner, and then all that have a molecule of the top
  for (std::size_t cell = 0; cell < tissue.body().tetrahedra.size(); ++cell)
    if (std::ranges::count(tissue.body().tetrahedra[cell], corner)) cells.push_back(static_cast<int>(cell));
  tissue.remove({}, cells);
  REQUIRE(tissue.origin()[0] != corner);
  CHECK((total() - before).norm() < 1e-12 * before.norm());
  int pulled = -1;
  for (int molecule = 0; molecule < tissue.body().size(); ++molecule)
    if (std::abs(tissue.forces()(0, molecule)) > 0.5e-3) pulled = molecule;
  REQUIRE(pulled >= 0);
  CHECK(tissue.origin()[pulled] == last);

  cells.clear();
  for (std::size_t cell = 0; cell < tissue.body().tetrahedra.size(); ++cell)
    if (std::ranges::any_of(tissue.body().tetrahedra[cell],
                            [&](int molecule) { return whole.rest(2, tissue.origin()[molecule]) == high; }))
      cells.push_back(static_cast<int>(cell));
  tissue.remove({}, cells);
  CHECK(total().norm() < 1e-12 * before.norm());
  tissue.restore(saved);
  CHECK(total() == before);
  CHECK_NOTHROW(tissue.remove_load(traction));
}

TEST_CASE("a block torn by its own weight falls apart, and keeps its mass", "[topology]") {
  Simulation tissue = hanging("neo_hookean");
  const double mass = tissue.body().mass.sum();
  tissue.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", Vector3(800, 0, 0)}}});
  int torn = 0;
  for (int i = 0; i < 60; ++i) {
    step(tissue, 1);
    torn += tissue.tear(0.1).split_molecules;
  }
  CHECK(torn > 0);
  CHECK(tissue.body().mass.sum() == Approx(mass).epsilon(1e-13));
}

TEST_CASE("what cannot follow a cut refuses it, and nothing changes", "[topology]") {
  Simulation tissue = hanging("lattice");
  tissue.model().add(make_mass_damping(tissue.body(), 3));
  step(tissue, 2);
  const Positions before = tissue.positions();
  CHECK_THROWS_WITH(tissue.cut(kMiddle), Contains("added to model() directly"));
  CHECK(tissue.positions() == before);
  step(tissue, 1);

  Material relaxing = kTissue;
  relaxing.relaxation = Relaxation{.terms = {{0.5, 0.1}}};
  Simulation prony(tissue_cube(4), built_in_catalog().find("prony:lattice"), relaxing);
  CHECK_THROWS_WITH(prony.cut(kMiddle), Contains("the history 'law0' cannot follow"));
  CHECK_FALSE(prony.cut(CutSurface::plane({1, 0, 0}, {1, 0, 0})).changed);

  Body sheet = rectangular_sheet({0.02, 0.015}, {4, 3}, SheetPattern::one_way);
  set_matter(sheet, 1000, 1e-3);
  Material bends{.youngs_modulus = 1e5, .poissons_ratio = 0.3};
  bends.thickness = 1e-3, bends.bending_rigidity = 1e-5;
  Simulation plate(sheet, built_in_catalog().find("neo_hookean_membrane"), bends);
  CHECK_THROWS_WITH(plate.cut(CutSurface::plane({0.01, 0, 0}, {1, 0, 0})), Contains("with bending stiffness"));

  Simulation loaded = hanging("lattice");
  step(loaded, 3);
  CHECK_THROWS_WITH(loaded.remove({100000}, {}), Contains("no connection 100000"));
}

TEST_CASE("loads are added between steps", "[topology]") {
  Simulation tissue = simulation_of(tissue_cube(3), "symplectic_euler");
  step(tissue, 3);
  CHECK(tissue.velocities().norm() == 0);
  tissue.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", Vector3(0, 0, -10)}}});
  step(tissue, 4);
  CHECK(tissue.velocities()(2, 5) == Approx(-10 * 4 * kStep).epsilon(1e-12));
  CHECK_THROWS_WITH(tissue.add([](Model&) { throw InputError("not today"); }), Contains("not today"));
}

TEST_CASE("a state after a cut is refused by a body of another shape or other springs", "[topology]") {
  const auto lattice = [](double size, double modulus) {
    Body body = tissue_cube(4);
    stretch(body, Vector3::Constant(size));
    Material material = kTissue;
    material.youngs_modulus = modulus;
    return Simulation(std::move(body), built_in_catalog().find("lattice"), material, {});
  };
  Simulation tissue = lattice(1, 5e3);
  const SimulationState whole = tissue.save();
  REQUIRE(tissue.cut(kMiddle).changed);
  const std::vector<char> bytes = bytes_of(tissue.save());
  const SimulationState saved = simulation_state_of(bytes.data(), bytes.size());
  for (const bool is_cut : {false, true}) {
    Simulation stiffer = lattice(1, 1e4), larger = lattice(1.5, 5e3), own = lattice(1, 5e3);
    for (Simulation* other : {&stiffer, &larger, &own})
      if (is_cut) other->cut(CutSurface::plane({3.1e-3, 3e-3, 3e-3}, {1, 0.1, 0.2}));
    const int before = larger.body().size();
    CHECK_THAT(refusal([&] { stiffer.restore(saved); }), Contains("springs had constants with a sum of"));
    CHECK_THAT(refusal([&] { larger.restore(saved); }), Contains("lie elsewhere at rest"));
    CHECK_THAT(refusal([&] { larger.restore(whole); }), Contains("lie elsewhere at rest"));
    CHECK(larger.body().size() == before);
    own.restore(saved);
    CHECK(own.body().size() == tissue.body().size());
    own.restore(whole);
    CHECK(own.body().size() == 64);
  }
}
