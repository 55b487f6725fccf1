// Steppers side by side: what modulus a body has by each of them, and what is said of those that cannot step it.

#include "lab/study/study.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "elastin/core/base/error.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

constexpr const char* kCube = R"(title: A cube of springs
body: {lattice: {kind: cubic, molecules: [4, 4, 4], spacing: 1 cm, connections: [axis, face]}}
material: {youngs_modulus: 10 kPa, poissons_ratio: 0.25}
stiffness: lattice
experiment: {kind: tension, axis: z, force: 1 mN}
)";
constexpr const char* kBlock = R"(title: A rubber block
body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 3], size: [2 cm, 2 cm, 3 cm]}}
material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}
stiffness: neo_hookean
experiment: {kind: tension, axis: z, force: 0.2 N}
)";

StepperComparison compared(const std::string& scene, const std::string& steppers) {
  const TemporaryFolder folder;
  const auto loaded = load_scene(folder.write("scene.yaml", scene + steppers), built_in_catalog());
  REQUIRE(loaded->steppers);
  return measure_steppers(*loaded, *loaded->steppers);
}

const StepperRow& find(const StepperComparison& comparison, const std::string& stepper, int iterations) {
  for (const StepperRow& row : comparison.rows)
    if (row.stepper == stepper && row.iterations == iterations) return row;
  FAIL("no row of " << stepper << " with " << iterations);
  return comparison.rows.front();
}

}  // namespace

TEST_CASE("every stepper gives the body's modulus when its iterations are enough", "[steppers][slow]") {
  for (const char* scene : {kCube, kBlock}) {
    const StepperComparison comparison = compared(scene, "steppers: {iterations: [64, 128]}\n");
    INFO(comparison.title);
    // The cube's material says what springs of the lattice rule give; the block's equilibrium is Newton's own.
    if (scene == kCube) CHECK(comparison.equilibrium[0] == Approx(10e3).epsilon(1e-3));
    for (const auto& stepper : built_in_steppers()) {
      const bool iterates = !stepper->effort.empty() && stepper->effort != "newton_iterations";
      const StepperRow& row = find(comparison, stepper->name, iterates ? 128 : 0);
      INFO(row.stepper << ": " << row.cause);
      REQUIRE(row.suited);
      REQUIRE(row.outcome == Outcome::converged);
      CHECK(row.settled);
      CHECK(std::abs(row.rest_error) <= 0.01);
      CHECK(std::isfinite(row.time_error));
      if (stepper->order == 1 && !stepper->is_explicit) CHECK(row.energy < 0);  // backward Euler's steps lose it
      if (!iterates) continue;
      const StepperRow& half = find(comparison, stepper->name, 64);
      CHECK(std::abs(row.at_rest[0] / half.at_rest[0] - 1) <= 0.01);
      CHECK(row.iteration_error <= std::max(half.iteration_error, 1e-8));
      CHECK(row.iteration_error <= 0.01);
    }
  }
}

TEST_CASE("the error of the time step goes down with the order of the stepper", "[steppers][slow]") {
  for (const auto& [name, order] : {std::pair{"backward_euler", 1.}, std::pair{"newmark", 2.}}) {
    const StepperComparison comparison =
        compared(kCube, std::string("steppers: {methods: [{method: ") + name +
                            ", newton_iterations: 0}], steps: [0.5 ms, 0.25 ms, 0.125 ms]}\n");
    REQUIRE(comparison.rows.size() == 3);
    INFO(name);
    CHECK(std::log2(comparison.rows[1].time_error / comparison.rows[2].time_error) == Approx(order).margin(0.25));
  }
}

TEST_CASE("a stepper that has no form for the law is a row that says so", "[steppers]") {
  std::string scene = kBlock;
  scene.replace(scene.find("stiffness: neo_hookean"), 22, "stiffness: st_venant_kirchhoff");
  const StepperComparison comparison = compared(scene, "steppers: {methods: [xpbd, projective], iterations: [8]}\n");
  CHECK(!find(comparison, "xpbd", 8).suited);
  CHECK_THAT(find(comparison, "xpbd", 8).cause, Contains("neo_hookean"));
  CHECK(find(comparison, "projective", 8).suited);
  const auto json = nlohmann::json::parse(stepper_json({comparison}));
  CHECK(json["steppers"][0]["rows"][0]["outcome"] == "unsuited");
  CHECK_THAT(stepper_text(comparison, false), Contains("unsuited"));
  CHECK_THAT(stepper_page({comparison}, "elastin"), Contains("Error of the motion against time"));
}

TEST_CASE("slips in the keys of a comparison of steppers are named", "[steppers]") {
  CHECK_THROWS_WITH(compared(kCube, "steppers: {methods: [block_decent]}\n"), Contains("block_descent"));
  CHECK_THROWS_WITH(compared(kCube, "steppers: {iteration: [1]}\n"), Contains("iterations"));
  CHECK_THROWS_WITH(compared(kCube, "steppers: {iterations: [0]}\n"), Contains("1"));
  CHECK_THROWS_WITH(read_steppers("xpbd,proj", built_in_steppers()), Contains("proj"));
}
