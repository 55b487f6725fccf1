#include "elastin/core/simulation/simulation.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/shapes/surfaces.h"
#include "core/simulation/tissues.h"
#include "core/solve/stable_step.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/load_table.h"
#include "elastin/core/forces/loads.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/solve/sensitivity.h"
#include "support/refusal.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Contains;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kStep = 1e-3;  // s

void run(Simulation& tissue, int steps) {
  for (int step = 0; step < steps; ++step) {
    const StepResult result = tissue.step(kStep);
    INFO(result.cause);
    REQUIRE(result.outcome == Outcome::converged);
  }
}

double difference(const Positions& a, const Positions& b) { return (a - b).cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("simulation: a free body falls as its weight says, and its views stay where they are") {
  for (const StepperMethod& method : kSteppers) {
    Simulation tissue = simulation_of(tissue_cube(3), method);
    tissue.model().add(make_gravity(tissue.body(), {0, 0, -10}));
    const double* const views[] = {tissue.positions().data(), tissue.velocities().data(), tissue.forces().data(),
                                   tissue.tensions().data()};
    run(tissue, 100);
    CHECK(tissue.time() == Approx(0.1).epsilon(1e-12));
    CHECK(tissue.velocities()(2, 13) == Approx(-1).epsilon(1e-9));
    CHECK(tissue.forces()(2, 13) == Approx(-10 * tissue.body().mass[13]).epsilon(1e-9));
    CHECK(views[0] == tissue.positions().data());
    CHECK(views[1] == tissue.velocities().data());
    CHECK(views[2] == tissue.forces().data());
    CHECK(views[3] == tissue.tensions().data());
  }
}

TEST_CASE("simulation: a load gets other values and goes, in the middle of a run") {
  const LoadKind& gravity = *built_in_loads().find("gravity");
  const auto along = [](double x, double z) { return LoadValues{.vectors = {{"acceleration", Vector3(x, 0, z)}}}; };
  for (const StepperMethod& method : kSteppers) {
    CAPTURE(method->name);
    Simulation tissue = simulation_of(tissue_cube(3), method);
    const LoadId load = tissue.add_load(gravity, along(0, -10));
    const auto falls = [&](double x, double z) {
      run(tissue, 20);
      CHECK(tissue.velocities()(0, 13) == Approx(x).margin(1e-9));
      CHECK(tissue.velocities()(2, 13) == Approx(z).margin(1e-9));
    };
    falls(0, -0.2);
    tissue.set_load(load, along(5, 0));
    falls(0.1, -0.2);
    CHECK_THROWS_WITH(tissue.set_load(load, {.numbers = {{"acceleration", 1}}}), Contains("acceleration"));
    CHECK_THROWS_WITH(tissue.set_load(2, along(1, 0)), Contains("no load 2"));
    falls(0.2, -0.2);
    tissue.remove_load(load);
    falls(0.2, -0.2);
    CHECK_THROWS_WITH(tissue.remove_load(load), Contains("no load 1"));
    CHECK(tissue.add_load(gravity, along(0, 0)) == 2);
    const Vector3 middle = tissue.positions().rowwise().mean();
    REQUIRE(tissue.cut(CutSurface::plane(middle, {0, 1, 0.2})).changed);  // the model is made again
    falls(0.2, -0.2);
  }
}

TEST_CASE("simulation: a load that is set at every step leaves steps and bits as those of one that stays") {
  const LoadKind& drag = *built_in_loads().find("stokes_drag");
  const LoadValues water{.numbers = {{"viscosity", 1e-3}}};
  for (const bool early : {true, false}) {
    Simulation kept = simulation_of(tissue_cube(4)), set = simulation_of(tissue_cube(4));
    for (Simulation* one : {&kept, &set}) {
      one->add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", Vector3(0, 0, -10)}}});
      one->fix(0);
    }
    if (!early) run(kept, 1), run(set, 1);
    kept.add_load(drag, water);
    const LoadId load = set.add_load(drag, water);
    if (early) run(kept, 1), run(set, 1);
    int first = 0;
    for (int step = 0; step < 50; ++step) {
      set.set_load(load, water);
      const StepResult one = set.step(kStep), other = kept.step(kStep);
      if (step == 0) first = one.substeps;
      CHECK(one.substeps == first);
      CHECK(other.substeps <= one.substeps);
    }
    CHECK(difference(kept.positions(), set.positions()) <= (early ? 1e-9 : 0));
  }
}

namespace {

/// No force; counts the products with the stiffness that somebody asks for.
struct CountsProducts final : Load {
  explicit CountsProducts(int& count) : count_of(count) {}
  void add_forces(const State&, Positions&) const override {}
  double energy(const State&) const override { return 0; }
  bool changes() const override { return true; }
  bool feels_velocity() const override { return false; }
  void add_change(const State&, const Positions&, const Positions&, Positions&) const override { ++count_of; }
  int& count_of;
};

}  // namespace

TEST_CASE("simulation: the longest step takes few products with the stiffness, and a load that resists nothing none") {
  Simulation tissue = simulation_of(tissue_cube(9));
  int products = 0;
  tissue.model().add(std::make_unique<CountsProducts>(products));
  run(tissue, 1);
  CHECK(products > 0);
  CHECK(products < 150);
  const int before = products;
  const auto along = [](double z) { return LoadValues{.vectors = {{"acceleration", Vector3(0, 0, z)}}}; };
  const LoadId load = tissue.add_load(*built_in_loads().find("gravity"), along(-10));
  run(tissue, 1);
  tissue.set_load(load, along(5));
  run(tissue, 1);
  tissue.remove_load(load);
  run(tissue, 1);
  CHECK(products == before);
}

TEST_CASE("simulation: one spring under its weight; tension, reaction and settle are m g") {
  Body pair = listed_body({{0, 0, 0}, {0, 0, -0.1}}, {{0, 1}});
  pair.mass = VectorX::Constant(2, 0.2);
  pair.radius = VectorX::Constant(2, 0.01);
  Simulation hanging(std::move(pair), [](const Body& body) { return make_springs(body, VectorX::Constant(1, 50)); });
  hanging.model().add(make_gravity(hanging.body(), {0, 0, -10}));
  hanging.fix(0);
  REQUIRE(hanging.settle().outcome == Outcome::converged);
  CHECK(hanging.positions()(2, 1) == Approx(-0.1 - 0.2 * 10 / 50));
  CHECK(hanging.tensions()[0] == Approx(2));
  // The upper one's own weight hangs there too.
  CHECK((hanging.reaction(0) - Vector3(0, 0, 4)).norm() < 1e-9);
  CHECK(hanging.reaction(1).norm() == 0);
  run(hanging, 100);
  CHECK(hanging.positions()(2, 1) == Approx(-0.14));
}

TEST_CASE("simulation: what is moved goes there at one speed, and is pulled by what its reaction says") {
  for (const StepperMethod& method : kSteppers) {
    Simulation tissue = simulation_of(tissue_cube(3), method);
    for (int molecule = 0; molecule < 9; ++molecule) tissue.fix(molecule);
    for (int step = 1; step <= 20; ++step) {
      for (int molecule = 0; molecule < 9; ++molecule)
        tissue.move_to(molecule, tissue.body().rest.col(molecule) + Vector3(0, 0, -1e-5 * step));
      run(tissue, 1);
      REQUIRE(tissue.positions()(2, 4) == Approx(-1e-5 * step).margin(1e-15));
      REQUIRE(tissue.velocities()(2, 4) == Approx(-1e-2));
    }
    // Nothing else acts: what the supports do is what moves the rest.
    Vector3 held = Vector3::Zero();
    for (int molecule = 0; molecule < 9; ++molecule) held += tissue.reaction(molecule);
    const Vector3 rest = tissue.forces().rightCols(18).rowwise().sum();
    CHECK((held - rest).norm() < 1e-12);
    CHECK(rest.norm() > 1e-8);
    run(tissue, 1);  // nobody says where to: they stay
    CHECK(tissue.velocities().leftCols(9).norm() == 0);
    CHECK(tissue.positions()(2, 4) == Approx(-2e-4).margin(1e-15));
    tissue.release(4);
    CHECK(tissue.reaction(4).norm() == 0);
  }
}

TEST_CASE("simulation: what was caught stays where it is let go, and what was carried goes on as fast") {
  for (const StepperMethod& method : kSteppers)
    for (const int held : {1, 2, 9, 10})
      for (const double speed : {0., 1.}) {
        INFO(method->name << ", held for " << held << " steps, carried at " << speed << " m/s");
        Simulation tissue = simulation_of(tissue_cube(3), method);
        const int molecules = tissue.body().size();
        Positions velocities = Positions::Zero(3, molecules);
        velocities.row(0).setConstant(1 - speed);
        tissue.set_velocities(velocities);
        run(tissue, 2);
        for (int i = 0; i < molecules; ++i) tissue.fix(i);
        for (int step = 0; step < held; ++step) {
          for (int i = 0; i < molecules; ++i)
            tissue.move_to(i, tissue.positions().col(i) + Vector3(speed * kStep, 0, 0));
          run(tissue, 1);
        }
        for (int i = 0; i < molecules; ++i) tissue.release(i);
        run(tissue, 5);
        CHECK(tissue.velocities().row(0).maxCoeff() == Approx(speed).margin(1e-6));
        CHECK(tissue.velocities().row(0).minCoeff() == Approx(speed).margin(1e-6));
      }
}

TEST_CASE("simulation: a molecule with another support is taken over, moved and released") {
  Simulation tissue = simulation_of(tissue_cube(3));
  tissue.model().supports = {{0}, {1}, {2}};
  tissue.model().drive = [](double time, std::vector<Support>& supports) {
    for (Support& support : supports)
      if (support.molecule < 3) support.displacement.x() = 1e-2 * time, support.velocity.x() = 1e-2;
  };
  run(tissue, 10);
  CHECK(tissue.positions()(0, 0) == Approx(1e-4));
  tissue.fix(1);
  tissue.fix(5);
  tissue.move_to(2, tissue.positions().col(2) + Vector3(0, 1e-5, 0));
  run(tissue, 10);
  CHECK(tissue.positions()(0, 0) - tissue.body().rest(0, 0) == Approx(2e-4));
  CHECK(tissue.positions()(0, 1) - tissue.body().rest(0, 1) == Approx(1e-4));
  CHECK(tissue.positions()(1, 2) - tissue.body().rest(1, 2) == Approx(1e-5));
  CHECK(tissue.model().supports.size() == 4);
  tissue.release(1);
  tissue.release(5);
  REQUIRE(tissue.model().supports.size() == 3);  // others know theirs by number
  CHECK(tissue.model().supports[1].free == Matrix3::Identity());
  run(tissue, 1);
  CHECK(tissue.positions()(0, 0) - tissue.body().rest(0, 0) == Approx(2.1e-4));
}

TEST_CASE("simulation: a free direction of a support is free") {
  Simulation tissue = simulation_of(tissue_cube(3));
  tissue.model().add(make_gravity(tissue.body(), {0, 5, -10}));
  for (int molecule = 0; molecule < 27; ++molecule) tissue.fix(molecule, Vector3(0, 1, 0).asDiagonal());
  run(tissue, 50);
  CHECK(tissue.velocities().row(1).minCoeff() == Approx(0.25).epsilon(1e-9));
  CHECK(tissue.velocities().row(2).cwiseAbs().maxCoeff() == 0);
}

TEST_CASE("simulation: a grip pulls with its spring and its damper, in steps and at rest") {
  for (const StepperMethod& method : kSteppers) {
    INFO(method->name);
    SimulationOptions options;  // few iterations of xpbd have a rest of their own
    if (method->name == "xpbd") options.stepper.parameters = {{"iterations", 100}};
    Simulation tissue = simulation_of(tissue_cube(3), method, "lattice", options);
    for (int molecule = 0; molecule < 9; ++molecule) tissue.fix(molecule);
    const Vector3 position = tissue.body().rest.col(22) + Vector3(0, 0, 5e-4);
    const CouplingId coupling = tissue.couple(22, position, 20, 0.05);
    REQUIRE(tissue.settle().outcome == Outcome::converged);
    const Vector3 pull = tissue.coupling_force(coupling);
    CHECK((pull - 20 * (position - tissue.positions().col(22))).norm() < 1e-12);
    Vector3 held = Vector3::Zero();
    for (int molecule = 0; molecule < 9; ++molecule) held += tissue.reaction(molecule);
    CHECK((held + pull).norm() < 1e-6 * pull.norm());
    CHECK(pull.norm() > 1e-4);
    const Positions settled = tissue.positions();
    run(tissue, 50);
    CHECK(difference(tissue.positions(), settled) < 1e-8);
    tissue.move_coupling(coupling, position, {0, 0, 0.1});
    CHECK((tissue.coupling_force(coupling) - pull).z() == Approx(0.05 * 0.1).epsilon(1e-3));
    tissue.decouple(coupling);
    CHECK_THROWS_WITH(tissue.coupling_force(coupling), Contains("no coupling 1: it was taken off"));
    CHECK(tissue.couple(22, position, 20) != coupling);
  }
}

TEST_CASE("simulation: host forces, steps and grips give bitwise identical results after restore", "[slow]") {
  for (const StepperMethod& method : kSteppers) {
    for (const char* strategy : {"lattice", "lattice+volume"}) {
      if (!suits(method, strategy)) continue;
      const auto make = [&] {
        Simulation tissue = simulation_of(tissue_cube(4), method, strategy);
        tissue.model().add(make_mass_damping(tissue.body(), 3));
        return tissue;
      };
      Simulation tissue = make();
      for (int molecule = 0; molecule < 16; ++molecule) tissue.fix(molecule);
      tissue.host_forces()(0, 60) = 1e-3;
      tissue.couple(63, tissue.body().rest.col(63) + Vector3(0, 1e-4, 0), 5, 1e-3);
      run(tissue, 5);
      tissue.move_to(3, tissue.positions().col(3) + Vector3(0, 0, 1e-5));
      const SimulationState saved = tissue.save();
      const auto go_on = [](Simulation& one) {
        run(one, 1);
        one.move_to(5, one.positions().col(5) + Vector3(1e-5, 0, 0));
        run(one, 5);
        one.release(5);
        run(one, 5);
        return one.positions();
      };
      const Positions first = go_on(tissue);
      tissue.restore(saved);
      CHECK(go_on(tissue) == first);
      Simulation other = make();
      other.restore(saved);
      CHECK(go_on(other) == first);
    }
  }
}

TEST_CASE("simulation: observers see every n-th good step") {
  Simulation tissue = simulation_of(tissue_cube(3));
  int all = 0, some = 0;
  double last = 0;
  tissue.observe(1, [&](const Simulation& seen) { ++all, last = seen.time(); });
  tissue.observe(4, [&](const Simulation&) { ++some; });
  run(tissue, 9);
  tissue.step(-1);
  CHECK(all == 9);
  CHECK(some == 2);
  CHECK(last == tissue.time());
}

TEST_CASE("simulation: a step that cannot be leaves the state as it was and says why") {
  for (const StepperMethod& method : kSteppers) {
    Simulation tissue = simulation_of(tissue_block(), method, "neo_hookean");
    tissue.fix(0);
    run(tissue, 3);
    const auto refused = [&](double dt, const char* why) {
      const Positions before = tissue.positions();
      const double time = tissue.time();
      const StepResult result = tissue.step(dt);
      CHECK(result.outcome != Outcome::converged);
      CHECK_THAT(result.cause, Contains(why));
      CHECK(tissue.positions() == before);
      CHECK(tissue.time() == time);
      CHECK(tissue.positions().col(0) == tissue.body().rest.col(0));
    };
    for (const double dt : {0., -1e-3, kNaN, std::numeric_limits<double>::infinity()})
      refused(dt, "above 0 s and finite");
    if (method->is_explicit) refused(100, "1000 are allowed");
    tissue.host_forces()(1, 7) = kNaN;
    refused(kStep, "the host's force on molecule 7 is not finite");
    tissue.host_forces().setZero();
    const CouplingId coupling = tissue.couple(8, tissue.positions().col(8), 10);
    tissue.move_coupling(coupling, Vector3(kNaN, 0, 0));
    refused(kStep, "coupling 1 was moved to a position or at a velocity that is not finite");
    tissue.decouple(coupling);
    // Through the body's other side: some cell must be inverted.
    tissue.move_to(0, tissue.body().rest.rightCols(1) * 3);
    const StepResult result = tissue.step(kStep);
    CHECK(result.outcome == Outcome::inverted);
    CHECK_THAT(result.cause, Contains("cell"));
    tissue.move_to(0, tissue.body().rest.col(0));
    run(tissue, 3);
  }
}

TEST_CASE("simulation: wrong use is refused before anything changes") {
  Simulation tissue = simulation_of(tissue_cube(3));
  const Vector3 position(0, 0, 0);
  CHECK(refusal([&] { tissue.fix(27); }) == "no molecule 27: the body has molecules 0 to 26");
  CHECK_THAT(refusal([&] { tissue.fix(0, 2 * Matrix3::Identity()); }), Contains("projector"));
  CHECK_THAT(refusal([&] { tissue.release(-1); }), Contains("molecule -1"));
  CHECK(refusal([&] { tissue.move_to(3, position); }) == "move_to: molecule 3 is not fixed; fix it first");
  CHECK_THAT(refusal([&] { tissue.couple(99, position, 1); }), Contains("molecule 99"));
  CHECK_THAT(refusal([&] { tissue.couple(1, position, 0); }), Contains("stiffness of 0 N/m"));
  CHECK_THAT(refusal([&] { tissue.couple(1, position, 1, kNaN); }), Contains("damping of nan"));
  CHECK_THAT(refusal([&] { tissue.couple(1, Vector3(0, kNaN, 0), 1); }), Contains("(0, nan, 0) m is not finite"));
  CHECK_THAT(refusal([&] { tissue.observe(0, [](const Simulation&) {}); }), Contains("every 0 steps"));
  CHECK_THAT(refusal([&] { tissue.restore(simulation_of(tissue_cube(4)).save()); }), Contains("another body's: 64"));
  Body larger = tissue_cube(3);
  stretch(larger, Vector3::Constant(2));
  CHECK_THAT(refusal([&] { tissue.restore(simulation_of(larger).save()); }), Contains("lie elsewhere at rest"));
  SimulationState odd = tissue.save();
  odd.state.velocities(0, 0) = kNaN;
  CHECK_THAT(refusal([&] { tissue.restore(odd); }), Contains("velocities are not all finite"));
  const Catalog catalog = built_in_catalog();
  CHECK_THAT(refusal([&] { Simulation(tissue_block(), catalog.find("lattice"), kTissue); }),
             Contains("'lattice' cannot run on this body: "));
  CHECK_THAT(refusal([&] { Simulation(tissue_block(), catalog.find("volume"), kTissue); }),
             Contains("goes with a rule: lattice+volume"));
  CHECK_THAT(refusal([&] { Simulation(tissue_cube(3), catalog.find("lattice"), kTissue, {.safety = 0}); }),
             Contains("safety 0"));
  CHECK_THAT(refusal([&] { Simulation(Body{}, catalog.find("lattice"), kTissue); }), Contains("no molecules"));
  Body bare = cubic_lattice({2, 2, 2}, 1, {});
  CHECK_THAT(refusal([&] { Simulation(bare, catalog.find("standard"), kTissue); }), Contains("set_matter"));
  run(tissue, 1);
}

TEST_CASE("simulation: a moved-from simulation says so, and takes another") {
  Simulation tissue = simulation_of(tissue_cube(3));
  tissue.fix(0);
  const Positions* const seen = &tissue.positions();
  Simulation moved = std::move(tissue);
  CHECK(&moved.positions() == seen);
  moved.move_to(0, moved.body().rest.col(0) + Vector3(1e-6, 0, 0));
  run(moved, 2);
  CHECK_THAT(tissue.step(kStep).cause, Contains("moved-from"));  // NOLINT: what this is about
  tissue = simulation_of(tissue_cube(2));
  run(tissue, 1);
}

TEST_CASE("simulation: an explicit step goes in as many parts as its body and its grips require") {
  Simulation tissue = simulation_of(tissue_cube(3));
  Model model(tissue.body());
  const Catalog catalog = built_in_catalog();
  model.add(catalog.find("lattice").make(tissue.body(), kTissue, {}));
  const double longest = 0.8 * find_stable_step(model, state_at_rest(tissue.body())).step;
  CHECK(tissue.step(3.5 * longest).substeps == 4);
  CHECK(tissue.step(0.9 * longest).substeps == 1);
  // A grip much stiffer than the tissue: its own oscillation sets the step of Verlet's, 2/√(k/m) …
  Simulation verlet = simulation_of(tissue_cube(3), "velocity_verlet");
  verlet.couple(13, verlet.positions().col(13), 1e6);
  const double stiff = 0.8 * 2 / std::sqrt(1e6 / verlet.body().mass[13]);
  CHECK(verlet.step(10.5 * stiff).substeps == 11);
  run(verlet, 20);
  // … and none of a stepper that takes it at the end of the step: two of them, with dampers that alone would ask for
  // steps of 2 m/c = 1e-8 of this one.
  const Vector3 at = tissue.positions().col(13) + Vector3(1e-4, 0, 0);
  tissue.couple(13, at, 1e6, tissue.body().mass[13] * 2e8 / longest);
  const CouplingId other = tissue.couple(13, at, 1e3);
  for (int step = 0; step < 2000; ++step) {
    const StepResult result = tissue.step(0.99 * longest);
    REQUIRE(result.outcome == Outcome::converged);
    REQUIRE(result.substeps == 1);
  }
  // So stiff a damper creeps; nothing swings.
  CHECK((tissue.positions().col(13) - at).norm() < 1e-4);
  CHECK(tissue.velocities().cwiseAbs().maxCoeff() < 1e-4 / (100 * longest));
  CHECK((tissue.coupling_force(other) - 1e3 * (at - tissue.positions().col(13))).norm() < 1e-12);
}

TEST_CASE("simulation: what is added between steps shortens them by what it resists, without another search") {
  Simulation tissue = simulation_of(tissue_cube(3));
  Model model(tissue.body());
  const Catalog catalog = built_in_catalog();
  model.add(catalog.find("lattice").make(tissue.body(), kTissue, {}));
  const double longest = 0.8 * find_stable_step(model, state_at_rest(tissue.body())).step;
  CHECK(tissue.step(3.5 * longest).substeps == 4);
  tissue.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", Vector3(0, 0, -9.81)}}});
  CHECK(tissue.step(3.5 * longest).substeps == 4);
  // Ten times as much damping as the body's fastest vibration has stiffness.
  const double viscosity = 20 * 0.8 / longest * tissue.body().mass[0] / (6 * EIGEN_PI * tissue.body().radius[0]);
  tissue.add_load(*built_in_loads().find("stokes_drag"), {.numbers = {{"viscosity", viscosity}}});
  model.add(make_stokes_drag(tissue.body(), viscosity));
  const double damped = 0.8 * find_stable_step(model, state_at_rest(tissue.body())).step;
  CHECK(damped < 0.1 * longest);
  const int parts = tissue.step(3.5 * longest).substeps;
  CHECK(parts >= std::ceil(3.5 * longest / damped));
  CHECK(parts <= 1.1 * std::ceil(3.5 * longest / damped));
}

TEST_CASE("simulation: explicit steps see that the body stiffens, and go in shorter parts from there on") {
  // Slack below a strain of 3 %, ten times as stiff above it, as fibres are; drawn out by 8 % between its grips.
  Material fibrous = kTissue;
  fibrous.curve = StressStrain::toe(0.03, 1e4, 1e5);
  fibrous.youngs_modulus = fibrous.curve->modulus(0);
  for (const char* method : {"symplectic_euler", "velocity_verlet"}) {
    SimulationOptions options;
    options.stepper.method = method, options.safety = 0.95;
    Simulation tissue(tissue_cube(5), built_in_catalog().find("lattice"), fibrous, options);
    tissue.model().add(make_mass_damping(tissue.body(), 50));
    const Positions& rest = tissue.body().rest;
    const double height = rest.row(2).maxCoeff();
    std::vector<int> top;
    for (int molecule = 0; molecule < tissue.body().size(); ++molecule) {
      if (rest(2, molecule) > height - 1e-9) top.push_back(molecule);
      if (rest(2, molecule) < 1e-9 || rest(2, molecule) > height - 1e-9) tissue.fix(molecule);
    }
    const auto longest = [&](const Positions& positions) {
      Model model(tissue.body());
      model.add(built_in_catalog().find("lattice").make(tissue.body(), fibrous, {}));
      model.supports = tissue.model().supports;
      return find_stable_step(model, {positions, Positions::Zero(3, positions.cols())}).step;
    };
    const double dt = 0.9 * longest(rest);
    int first = 0, last = 0;
    for (int step = 0; tissue.time() < 0.8; ++step) {
      const double drawn = 1 + 0.08 * std::min(1., (tissue.time() + dt) / 0.2);
      for (const int molecule : top) tissue.move_to(molecule, rest.col(molecule).cwiseProduct(Vector3(1, 1, drawn)));
      const StepResult result = tissue.step(dt);
      INFO(method << ", step " << step << ": " << result.cause);
      REQUIRE(result.outcome == Outcome::converged);
      (step == 0 ? first : last) = result.substeps;
    }
    INFO(method);
    CHECK(first == 1);
    const double now = longest(tissue.positions());
    REQUIRE(now < dt / 2);  // whole steps would go wild
    CHECK(last >= dt / now);
    // What the steps were too long for for a moment has not grown: the body hangs between the grips.
    CHECK(tissue.velocities().cwiseAbs().maxCoeff() < 1e-3 * 0.08 * height / 0.2);
  }
}

TEST_CASE(
    "simulation: what explicit steps have seen of the body's frequency is never more than there is, and is saved") {
  const auto shaken = [] {
    SimulationOptions options;
    options.safety = 0.95;
    Simulation tissue = simulation_of(tissue_cube(5), "symplectic_euler", "lattice", options);
    tissue.couple(124, tissue.positions().col(124) + Vector3(5e-4, 0, 5e-4), 20);
    return tissue;
  };
  Simulation tissue = shaken(), other = shaken();
  Model model(tissue.body());
  model.add(built_in_catalog().find("lattice").make(tissue.body(), kTissue, {}));
  const StableStep rest = find_stable_step(model, state_at_rest(tissue.body()));
  for (int step = 0; step < 300; ++step) REQUIRE(tissue.step(0.94 * rest.step).substeps == 1);
  const SimulationState saved = tissue.save();
  CHECK(saved.seen.frequency > 0.3 * rest.frequency);
  CHECK(saved.seen.frequency < 1.005 * rest.frequency);  // it is a little strained
  other.restore(saved);
  for (int step = 0; step < 50; ++step) tissue.step(0.94 * rest.step), other.step(0.94 * rest.step);
  CHECK(tissue.save().seen.frequency == other.save().seen.frequency);
  CHECK(difference(tissue.positions(), other.positions()) == 0);
  // At rest there is nothing to see: rounding is no vibration.
  Simulation still = simulation_of(tissue_cube(5));
  for (int step = 0; step < 50; ++step) still.step(rest.step / 2);
  CHECK(still.save().seen.frequency <= rest.frequency);
}

TEST_CASE("simulation: a grip at the end of explicit steps tends to the motion of short steps with order 1") {
  const auto end_after = [](const char* method, int steps) {
    Simulation tissue = simulation_of(tissue_cube(3), method);
    for (int molecule = 0; molecule < 9; ++molecule) tissue.fix(molecule);
    tissue.couple(22, tissue.positions().col(22) + Vector3(2e-4, 0, 1e-4), 20, 2e-3);
    for (int step = 0; step < steps; ++step) REQUIRE(tissue.step(8e-3 / steps).outcome == Outcome::converged);
    return Positions(tissue.positions());
  };
  const Positions limit = end_after("velocity_verlet", 20000);
  const double coarse = difference(end_after("symplectic_euler", 500), limit),
               fine = difference(end_after("symplectic_euler", 1000), limit);
  CHECK(coarse > 0);
  CHECK(std::log2(coarse / fine) == Approx(1).margin(0.1));
}

namespace {

/// A load without a force that calls the host while the step is under way.
struct CallsHost final : Load {
  explicit CallsHost(std::function<void()> host) : call(std::move(host)) {}
  void add_forces(const State&, Positions&) const override { call(); }
  double energy(const State&) const override { return 0; }
  bool feels_velocity() const override { return false; }
  std::function<void()> call;
};

/// NaN on one molecule from some time on.
struct Breaks final : Load {
  void add_forces(const State& state, Positions& forces) const override {
    if (state.time > 1.5 * kStep) forces(1, 5) = kNaN;
  }
  double energy(const State&) const override { return 0; }
  bool feels_velocity() const override { return false; }
};

}  // namespace

TEST_CASE("simulation: forces of the host for another number of molecules are said, not read") {
  for (const StepperMethod& method : kSteppers) {
    CAPTURE(method->name);
    Simulation tissue = simulation_of(tissue_cube(3), method);
    tissue.host_forces().row(2).setConstant(1e-5);
    run(tissue, 1);
    const Positions before = tissue.positions();
    for (const int columns : {0, 5, 1000}) {
      tissue.host_forces().setZero(3, columns);
      const std::string said = "forces on " + std::to_string(columns) + " molecules and the body has 27";
      CHECK_THAT(tissue.step(kStep).cause, Contains(said));
      CHECK_THAT(refusal([&] { tissue.settle(); }), Contains(said));
      CHECK_THAT(refusal([&] { tissue.tear(0.5); }), Contains(said));
      CHECK_THAT(refusal([&] { tissue.set_positions(before); }), Contains(said));
      CHECK(tissue.forces().allFinite());
      CHECK(tissue.positions() == before);
    }
    tissue.host_forces().setZero(3, 27);
    run(tissue, 1);
  }
}

TEST_CASE("simulation: what a step calls can neither step nor change it, an observer can change it") {
  for (const StepperMethod& method : kSteppers) {
    CAPTURE(method->name);
    Simulation tissue = simulation_of(tissue_cube(3), method);
    const LoadKind& gravity = *built_in_loads().find("gravity");
    const LoadValues down{.vectors = {{"acceleration", Vector3(0, 0, -10)}}};
    const LoadId load = tissue.add_load(gravity, down);
    std::vector<std::string> said;
    bool calls = true;
    tissue.model().add(std::make_unique<CallsHost>([&] {
      if (!std::exchange(calls, false)) return;
      said = {refusal([&] { tissue.add_load(gravity, down); }),
              refusal([&] { tissue.set_load(load, down); }),
              refusal([&] { tissue.remove_load(load); }),
              refusal([&] { tissue.couple(1, Vector3::Zero(), 1); }),
              refusal([&] { tissue.fix(0); }),
              refusal([&] { tissue.release(0); }),
              refusal([&] { tissue.settle(); }),
              refusal([&] { tissue.restore(tissue.save()); }),
              refusal([&] {
                tissue.cut(CutSurface::plane({0, 0, 0}, {1, 0, 0}));
              }),
              tissue.step(kStep).cause};
      tissue.host_forces().row(0).setConstant(1e-5);  // from the next step on
    }));
    run(tissue, 1);
    REQUIRE(said.size() == 10);
    for (const std::string& one : said) CHECK_THAT(one, Contains("within a step"));
    CHECK(tissue.velocities().row(0).cwiseAbs().maxCoeff() < 1e-12);
    run(tissue, 1);
    CHECK(tissue.velocities().row(0).minCoeff() > 0);
    int seen = 0;
    tissue.observe(1, [&](const Simulation&) {
      said.push_back(tissue.step(kStep).cause);
      if (++seen > 1) return;
      for (int more = 0; more < 50; ++more) tissue.observe(1, [&](const Simulation&) { ++seen; });
      tissue.fix(0);
    });
    run(tissue, 2);
    CHECK(seen == 102);
    CHECK_THAT(said.back(), Contains("observers"));
  }
}

TEST_CASE("simulation: the cause of a step or an equilibrium that fails names what is not finite") {
  for (const StepperMethod& method : kSteppers) {
    CAPTURE(method->name);
    Simulation tissue = simulation_of(tissue_cube(3), method);
    tissue.add([](Model& model) { model.add(std::make_unique<Breaks>()); });
    StepResult result;
    for (int step = 0; step < 4 && result.outcome == Outcome::converged; ++step) result = tissue.step(kStep);
    CHECK(result.outcome == Outcome::diverged);
    CHECK_THAT(result.cause, Contains("load") && Contains("molecule 5"));
    CHECK(tissue.positions().allFinite());
  }
  Simulation tissue = simulation_of(tissue_cube(3));
  tissue.fix(0);
  tissue.host_forces()(0, 7) = kNaN;
  CHECK_THAT(tissue.settle().cause, Contains("the host's force on molecule 7 is not finite"));
  const Body body = tissue_cube(3);
  VectorX constants = VectorX::Constant(body.connections.size(), 1);
  constants[4] = kNaN;
  CHECK(refusal([&] { make_springs(body, constants); }) ==
        "connection 4 has a spring constant of nan N/m: it must be finite");
  CHECK_THAT(refusal([&] { make_curve_springs(body, constants, StressStrain::linear(1)); }),
             Contains("a section of nan"));
}

TEST_CASE("simulation: what a load throws is the cause of a step that has not been") {
  struct Throws : Load {
    explicit Throws(const bool& is_lost) : lost(is_lost) {}
    void add_forces(const State&, Positions&) const override {
      if (lost) throw std::runtime_error("the tracker is lost");
    }
    const bool& lost;
  };
  for (const StepperMethod& method : kSteppers) {
    CAPTURE(method->name);
    bool lost = false;
    Simulation tissue = simulation_of(tissue_cube(3), method);
    tissue.add([&](Model& model) { model.add(std::make_unique<Throws>(lost)); });
    CHECK(tissue.step(kStep).outcome == Outcome::converged);
    const Positions before = tissue.positions();
    lost = true;
    const StepResult result = tissue.step(kStep);
    CHECK(result.outcome == Outcome::diverged);
    CHECK_THAT(result.cause, Contains("the tracker is lost"));
    CHECK(tissue.positions() == before);
    lost = false;
    CHECK(tissue.step(kStep).outcome == Outcome::converged);
  }
}

TEST_CASE("simulation: a muscle whose activation is lost, at the step's start too, leaves the body where it was") {
  Material material = kTissue;
  double level = 0.1;
  material.active =
      ActiveFibre{.direction = Vector3::UnitZ(), .stress = 10, .activation = [&](double) { return level; }};
  for (const char* method : {"symplectic_euler", "newmark", "backward_euler"}) {
    CAPTURE(method);
    level = 0.1;
    SimulationOptions options;
    options.stepper.method = method;
    Simulation tissue(tissue_block(), built_in_catalog().find("neo_hookean"), material, options);
    CHECK(tissue.step(kStep).outcome == Outcome::converged);
    const Positions before = tissue.positions();
    level = kNaN;
    CHECK_THAT(tissue.step(kStep).cause, Contains("the activation of the muscle"));
    CHECK(tissue.positions() == before);
    level = 0.1;
    CHECK(tissue.step(kStep).outcome == Outcome::converged);
  }
}

TEST_CASE("simulation: settle leaves an equilibrium that is no minimum, unless it is told not to look") {
  // Two links in line, their joint held sideways by two springs of 100 N/m: straight up to 50 N, as in
  // relaxation_test.cpp.
  Body body = listed_body({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {1, 0, 1}, {0, 1, 1}}, {{0, 1}, {1, 2}, {1, 3}, {1, 4}});
  set_matter(body, 0.1, 1000, 0, 1);
  Matrix3 along = Matrix3::Zero();
  along(2, 2) = 1;
  const auto settled = [&](double force, const StaticOptions* options) {
    Simulation column(body, [](const Body& own) { return make_springs(own, Eigen::Vector4d(1e5, 1e5, 100, 100)); }, {});
    for (const int molecule : {0, 3, 4}) column.fix(molecule);
    column.fix(2, along);
    column.host_forces()(2, 2) = -force;
    const StaticResult result = options ? column.settle(*options) : column.settle();
    REQUIRE(result.outcome == Outcome::converged);
    CHECK_FALSE((result.left_saddle && result.unstable));
    return std::pair(result.left_saddle, column.positions().col(1).head<2>().norm());
  };
  CHECK(settled(45, nullptr).second < 1e-4);
  CHECK(settled(60, nullptr).first);
  CHECK(settled(60, nullptr).second > 0.01);
  const StaticOptions blind{};
  CHECK_FALSE(settled(60, &blind).first);
}

TEST_CASE("simulation: a skin of triangles and a solid core run by one law of cells") {
  const Body core = tissue_block();
  Body whole, skin = rectangular_sheet({6e-3, 6e-3}, {3, 3}, SheetPattern::alternating);
  set_matter(skin, 1e-3, 1000, 1e-3, 0);
  const Material material{.youngs_modulus = 1e4, .poissons_ratio = 0.3, .density = 1000, .thickness = 1e-3};
  Part part;
  part.name = "core", add_part(whole, core, part);
  part.name = "skin", add_part(whole, skin, part);
  const auto energy = [&](const Body& body, const char* law) {
    Simulation tissue(body, built_in_catalog().find(law), material);
    return tissue.model().elastic_energy(1.01 * tissue.body().rest);
  };
  const double both = energy(core, "neo_hookean") + energy(skin, "neo_hookean_membrane");
  for (const char* law : {"neo_hookean", "neo_hookean_membrane"}) CHECK(energy(whole, law) == Approx(both));
}

TEST_CASE("simulation: a muscle that nothing resists settles at any activation, rollers or none", "[muscle][slow]") {
  const Body body = tissue_block();
  int above = 0;  // molecule 0, at the other end of a fibre
  while ((body.rest.col(above) - body.rest.col(0) - Vector3(0, 0, 6e-3)).norm() > 1e-9) ++above;
  double level = 0;
  Material material = kTissue;
  material.active =
      ActiveFibre{.direction = Vector3::UnitZ(), .stress = 5e3, .activation = [&](double) { return level; }};
  enum { rollers, one_molecule, nothing };
  for (const auto held : {rollers, one_molecule, nothing})
    for (const double ratio : {0.25, 0.45, 0.49})
      for (int tenths = 1; tenths <= 10; ++tenths) {
        level = tenths / 10.;
        material.poissons_ratio = ratio;
        CAPTURE(held, ratio, level);
        Simulation tissue(body, built_in_catalog().find("neo_hookean"), material, {});
        if (held == one_molecule) tissue.fix(0);
        for (int molecule = 0; molecule < body.size() && held == rollers; ++molecule) {
          const Vector3 free = (body.rest.col(molecule).array() > 1e-9).cast<double>();
          if (free.minCoeff() == 0) tissue.fix(molecule, free.asDiagonal());
        }
        const StaticResult result = tissue.settle();
        INFO(result.cause);
        REQUIRE(result.outcome == Outcome::converged);
        CHECK(result.newton_iterations < 30);
        CHECK(result.residual < 1e-10);  // of the forces within the body
        CHECK((tissue.positions().col(above) - tissue.positions().col(0)).norm() < 6e-3 * (1 - 0.05 * level));
        CHECK_NOTHROW(tissue.sensitivity());
        if (held != rollers || ratio != 0.25 || tenths != 5) continue;
        const Positions found = tissue.positions();
        for (const StaticMethod by : {StaticMethod::explicit_steps, StaticMethod::implicit_steps}) {
          tissue.set_positions(body.rest);
          const StaticResult stepped = tissue.settle({.static_method = by});
          INFO(stepped.cause);
          CHECK(stepped.outcome == Outcome::converged);
          CHECK(stepped.residual < 1e-8);
          CHECK(difference(tissue.positions(), found) < 1e-9);
        }
      }
}

TEST_CASE("simulation: an equilibrium with a grip that was moving is that of its spring alone") {
  for (const StepperMethod& method : kSteppers) {
    CAPTURE(method->name);
    for (const double pull : {0., 1e-3}) {
      Simulation still = simulation_of(tissue_cube(3), method), moving = simulation_of(tissue_cube(3), method);
      for (Simulation* tissue : {&still, &moving}) {
        for (int molecule = 0; molecule < 9; ++molecule) tissue->fix(molecule);
        const CouplingId grip = tissue->couple(22, tissue->positions().col(22), 20, 0.05);
        const Vector3 position = tissue->positions().col(22) + Vector3(0, 0, pull);
        tissue->move_coupling(grip, position, {0, 0, tissue == &moving ? 0.1 : 0});
        const StaticResult result = tissue->settle();
        INFO(result.cause);
        REQUIRE(result.outcome == Outcome::converged);
        CHECK((tissue->coupling_force(grip) - 20 * (position - tissue->positions().col(22))).norm() < 1e-15);
      }
      CHECK(moving.positions() == still.positions());
      CHECK_NOTHROW(moving.sensitivity());
    }
  }
  Simulation lost = simulation_of(tissue_cube(3));  // what fails changes nothing, the grip's velocity neither
  const CouplingId grip = lost.couple(22, lost.positions().col(22), 20, 0.05);
  lost.move_coupling(grip, lost.positions().col(22), {0, 0, 0.1});
  lost.host_forces()(0, 7) = kNaN;
  CHECK(lost.settle().outcome != Outcome::converged);
  CHECK(lost.coupling_force(grip).z() == Approx(0.05 * 0.1));
}
