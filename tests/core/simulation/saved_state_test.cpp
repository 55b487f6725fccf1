// What a simulation keeps from step to step, written down and read back.

#include "elastin/core/simulation/saved_state.h"

#include <catch2/catch.hpp>

#include "core/simulation/tissues.h"
#include "elastin/core/forces/load_table.h"
#include "support/own_rows.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Contains;

namespace {

constexpr double kStep = 1e-3;  // s

/// A cube that the ratchet pulls ever harder.
Simulation ratcheted(const StepperMethod& method) {
  Simulation tissue = simulation_of(tissue_cube(3), method);
  tissue.add_load(own::ratchet_row(),
                  {.vectors = {{"growth", Vector3(0, 0, 1e-6)}}, .molecules = {{"molecules", {26}}}});
  tissue.fix(0);
  return tissue;
}

void step(Simulation& tissue, int count) {
  for (int i = 0; i < count; ++i) REQUIRE(tissue.step(kStep).outcome == Outcome::converged);
}

std::string refusal(const std::vector<char>& bytes) {
  try {
    simulation_state_of(bytes.data(), bytes.size());
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("the history of a load is committed with each step, and goes through a saved state", "[saved-state]") {
  for (const StepperMethod& method : kSteppers) {
    INFO(method->name);
    Simulation whole = ratcheted(method), other = ratcheted(method);
    step(whole, 5);
    const std::vector<char> bytes = bytes_of(whole.save());
    const SimulationState read = simulation_state_of(bytes.data(), bytes.size());
    REQUIRE(read.state.find_history("ratchet"));
    CHECK(read.state.find_history("ratchet")->values[0] >= 5);  // explicit steps go in substeps
    CHECK(bytes_of(read) == bytes);
    step(whole, 5);
    other.restore(read);
    step(other, 5);
    CHECK((other.positions().array() == whole.positions().array()).all());
    CHECK(bytes_of(other.save()) == bytes_of(whole.save()));
    CHECK(whole.positions()(2, 26) > tissue_cube(3).rest(2, 26));
  }
}

TEST_CASE("a step that fails commits no history", "[saved-state]") {
  Simulation tissue = ratcheted("backward_euler");
  step(tissue, 3);
  const std::vector<char> before = bytes_of(tissue.save());
  CHECK(tissue.step(-1).outcome != Outcome::converged);
  tissue.host_forces()(0, 3) = std::numeric_limits<double>::quiet_NaN();
  CHECK(tissue.step(kStep).outcome != Outcome::converged);
  CHECK(tissue.save().state.find_history("ratchet")->values[0] == 3);
  tissue.host_forces().setZero();
  step(tissue, 1);
  CHECK(tissue.save().state.find_history("ratchet")->values[0] == 4);
}

TEST_CASE("a saved state with any bit changed is refused", "[saved-state]") {
  Simulation tissue = ratcheted("backward_euler");
  step(tissue, 2);
  const std::vector<char> bytes = bytes_of(tissue.save());
  REQUIRE(refusal(bytes).empty());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::vector<char> bad = bytes;
    bad[at] = static_cast<char>(bad[at] ^ (1 << at % 8));
    INFO(at);
    CHECK_FALSE(refusal(bad).empty());
  }
  std::vector<char> longer = bytes, shorter = bytes;
  longer.push_back(0);
  shorter.pop_back();
  CHECK_THAT(refusal(longer), Contains("followed by 1 bytes"));
  CHECK_THAT(refusal(shorter), Contains("cut off"));
}

TEST_CASE("a state of a model with another history is refused", "[saved-state]") {
  Simulation tissue = ratcheted("velocity_verlet"), plain = simulation_of(tissue_cube(3), "velocity_verlet");
  step(tissue, 1);
  CHECK_THROWS_WITH(plain.restore(tissue.save()), Contains("has a history that this model does not have"));
  plain.restore(simulation_of(tissue_cube(3)).save());
  Model twice(tissue.body());
  add_load(twice, own::ratchet_row(), {.vectors = {{"growth", Vector3(0, 0, 1)}}, .molecules = {{"molecules", {1}}}});
  CHECK_THROWS_WITH(add_load(twice, own::ratchet_row(),
                             {.vectors = {{"growth", Vector3(0, 0, 1)}}, .molecules = {{"molecules", {1}}}}),
                    Contains("under the name 'ratchet'"));
}

TEST_CASE("steps go on bitwise identically in another simulation, whatever went before there", "[saved-state]") {
  Material material = kTissue;
  material.relaxation = Relaxation{{{0.6, 3e-3}, {0.3, 0.1}}, false, 0};
  material.softening = Softening{1.5, 1, 0.1};
  const LoadValues water{.numbers = {{"viscosity", 10}}};
  for (const StepperMethod& method : kSteppers)
    for (const char* name : {"lattice", "prony:lattice", "mullins:lattice"}) {
      const Strategy strategy = built_in_catalog().find(name);
      Body body = tissue_cube(3);
      Model model(body);
      model.add(strategy.make(body, material, {}));
      if (!unsuited_for(*method, model).empty()) continue;
      INFO(method->name << " of " << name);
      SimulationOptions options;
      options.stepper.method = method;
      if (method->name == "projective") options.stepper.parameters = {{"solves", 3}};
      // Loads that come before the first step or after some, of which explicit steps know bounds alone.
      for (const int before : {0, 4}) {
        Simulation whole(body, strategy, material, options), other(body, strategy, material, options);
        whole.fix(0);
        whole.host_forces().row(2).setConstant(-1e-4);
        step(whole, before);
        for (Simulation* each : {&whole, &other}) each->add_load(*built_in_loads().find("stokes_drag"), water);
        step(whole, 3);
        whole.couple(26, body.rest.col(26) + Vector3(0, 0, 1e-4), 5);
        step(whole, 4);
        other.restore(whole.save());
        step(whole, 5);
        step(other, 5);
        CHECK((other.positions().array() == whole.positions().array()).all());
        CHECK(bytes_of(other.save()) == bytes_of(whole.save()));
      }
    }
}

TEST_CASE("a state that comes from slower vibrations does not make explicit steps too long", "[saved-state]") {
  Material stiff = kTissue;
  stiff.youngs_modulus *= 100;
  Simulation soft = simulation_of(tissue_cube(3));
  Simulation hard(tissue_cube(3), built_in_catalog().find("lattice"), stiff, {});
  step(soft, 1);
  const int substeps = hard.step(kStep).substeps;
  hard.restore(soft.save());
  CHECK(hard.step(kStep).substeps == substeps);
  hard.restore(simulation_of(tissue_cube(3)).save());
  CHECK(hard.step(kStep).substeps == substeps);
}
