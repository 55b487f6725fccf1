// Rigid things that a host moves: where they are within a step, after it, and after one that fails.

#include <catch2/catch.hpp>

#include "core/simulation/tissues.h"
#include "elastin/core/base/error.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Contains;

namespace {

constexpr double kStep = 1e-3;  // s

Matrix3 about_z(double angle) { return Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix(); }

/// A load that does nothing but look where a tool is at the times at which it is asked.
class Look final : public Load {
 public:
  Look(std::function<Pose(double)> motion, std::vector<std::pair<double, Pose>>& seen)
      : motion_(std::move(motion)), seen_(seen) {}
  void add_forces(const State& state, Positions&) const override {
    seen_.emplace_back(state.time, motion_(state.time));
  }

 private:
  std::function<Pose(double)> motion_;
  std::vector<std::pair<double, Pose>>& seen_;
};

}  // namespace

TEST_CASE("a tool goes from pose to pose at constant speed and spin", "[tools]") {
  std::vector<std::pair<double, Pose>> seen;
  SimulationOptions options;
  options.stepper.method = "velocity_verlet";
  options.safety = 0.05;  // in several substeps
  Simulation tissue(tissue_cube(3), built_in_catalog().find("lattice"), kTissue, options);
  const ToolId tool = tissue.add_tool({.turn = about_z(0.3), .position = {1e-3, 0, 0}});
  tissue.add([&, motion = tissue.tool_motion(tool)](Model& model) { model.add(std::make_unique<Look>(motion, seen)); });
  tissue.host_forces()(0, 5) = 1e-4;
  REQUIRE(tissue.step(kStep).outcome == Outcome::converged);
  for (const auto& [time, pose] : seen) CHECK(pose.velocity.norm() == 0);  // it stays as long as nobody moves it
  CHECK(tissue.tool_pose(tool).position == Vector3(1e-3, 0, 0));

  seen.clear();
  const Pose next{.turn = about_z(0.5), .position = {1e-3, 2e-3, 0}};
  tissue.move_tool(tool, next.position, next.turn);
  const StepResult result = tissue.step(kStep);
  REQUIRE(result.outcome == Outcome::converged);
  REQUIRE(result.substeps > 2);
  REQUIRE(seen.size() > 2);
  for (const auto& [time, pose] : seen) {
    const double part = (time - kStep) / kStep;
    CHECK((pose.position - Vector3(1e-3, part * 2e-3, 0)).norm() < 1e-15);
    CHECK((pose.turn - about_z(0.3 + part * 0.2)).norm() < 1e-12);
    if (part > 1e-9 && part < 1 - 1e-9) {
      CHECK((pose.velocity - Vector3(0, 2, 0)).norm() < 1e-12);
      CHECK((pose.spin - Vector3(0, 0, 200)).norm() < 1e-9);
    }
  }
  CHECK(tissue.tool_pose(tool).position == next.position);
  CHECK(tissue.tool_pose(tool).turn == next.turn);
  CHECK(tissue.tool_pose(tool).velocity.norm() == 0);

  const SimulationState saved = tissue.save();
  tissue.move_tool(tool, {0, 0, 1});
  tissue.host_forces()(0, 3) = std::numeric_limits<double>::quiet_NaN();
  CHECK(tissue.step(kStep).outcome != Outcome::converged);
  CHECK(tissue.tool_pose(tool).position == next.position);  // the step was not taken
  tissue.restore(saved);
  REQUIRE(tissue.step(kStep).outcome == Outcome::converged);
  CHECK(tissue.tool_pose(tool).position == next.position);  // nor is it kept where it was to go
  tissue.move_tool(tool, {0, 0, 1e-3});
  REQUIRE(tissue.step(kStep).outcome == Outcome::converged);
  CHECK(tissue.tool_pose(tool).turn == next.turn);  // who says no turn turns nothing back
}

TEST_CASE("an invalid pose and an invalid tool are refused", "[tools]") {
  Simulation tissue = simulation_of(tissue_cube(3));
  CHECK_THROWS_WITH(tissue.add_tool({.turn = 2 * Matrix3::Identity()}), Contains("no rotation"));
  CHECK_THROWS_WITH(tissue.add_tool({.turn = -Matrix3::Identity()}), Contains("no rotation"));
  CHECK_THROWS_WITH(tissue.add_tool({.position = {0, INFINITY, 0}}), Contains("finite"));
  CHECK_THROWS_WITH(tissue.move_tool(1, Vector3::Zero()), Contains("no tool 1: there are 0"));
  CHECK_THROWS_WITH(tissue.tool_motion(-1), Contains("no tool -1"));
}
