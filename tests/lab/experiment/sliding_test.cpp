#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <set>

#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "lab/study/study.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

const Catalog kCatalog = built_in_catalog();
const std::string kContact = std::string(ELASTIN_SOURCE_DIR) + "/scenes/contact/";

Run run_of(const std::string& name, const std::vector<std::string>& overrides) {
  const auto scene = load_scene(kContact + name + ".yaml", kCatalog, overrides);
  RunOptions options;
  options.statics = scene->statics;
  options.time = scene->time;
  Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options);
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  return run;
}

}  // namespace

TEST_CASE("a block slips at the angle of friction, whatever the friction", "[sliding][slow]") {
  for (const double friction : {0.1, 0.6}) {
    const std::string mu = std::to_string(friction), from = std::to_string(std::atan(friction) - 0.004);
    const Run run = run_of("slip-threshold", {"contact.friction=" + mu, "experiment.threshold.from=" + from,
                                              "time.duration=1 s", "time.frames=100"});
    CHECK(run.measures.get("slip_friction") == Approx(friction).epsilon(1e-3));
    CHECK(run.measures.get("slip_angle") == Approx(std::atan(friction)).epsilon(1e-3));
  }
  const Run none = run_of("slip-threshold", {"time.duration=0.1 s", "time.frames=10"});
  CHECK_FALSE(std::isfinite(none.measures.get("slip_angle")));
  CHECK_THAT(none.remark, Catch::Contains("the body has not begun to slide within the duration"));
  // It slides from the start: there is no slope on which it stood.
  const Run late =
      run_of("slip-threshold", {"experiment.threshold.from=20 deg", "time.duration=0.5 s", "time.frames=50"});
  for (const char* name : {"slip_friction", "slip_angle"}) CHECK_FALSE(std::isfinite(late.measures.get(name)));
  CHECK_THAT(late.remark, Catch::Contains("slides from the start, for `from` is above it, at 20°"));
}

TEST_CASE("sliding turns with its scene and knows the scene's own floor", "[sliding][slow]") {
  const std::vector<std::string> brief{"time.duration=0.1 s", "time.frames=20"};
  const double own = run_of("incline-slides", brief).measures.get("slide_acceleration");
  CHECK(own == Approx(9.81 * (std::sin(M_PI / 9) - 0.3 * std::cos(M_PI / 9))).epsilon(1e-3));
  std::vector<std::string> turned = brief;
  turned.push_back("rotate={axis: [1, -2, 0.5], angle: 50 deg}");
  CHECK(run_of("incline-slides", turned).measures.get("slide_acceleration") == Approx(own).epsilon(1e-4));
  std::vector<std::string> named = brief;
  named.push_back("contact.obstacles=[{name: ice, plane: {point: [0, 0, -5 mm], normal: z}, friction: 0.1}]");
  named.push_back("experiment.floor=ice");
  CHECK(run_of("incline-slides", named).measures.get("slide_acceleration") ==
        Approx(9.81 * (std::sin(M_PI / 9) - 0.1 * std::cos(M_PI / 9))).epsilon(1e-3));
}

TEST_CASE("scenes of contact come out as they say", "[contact][scenes][slow]") {
  // Those that take long stand elsewhere, coarser; see indentation_test and press_test.
  const std::set<std::string> elsewhere{"indentation-sphere", "indentation-linear", "indentation-springs",
                                        "indentation-flat", "indentation-second-order"};
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kContact)) {
    if (entry.path().extension() != ".yaml" || elsewhere.count(entry.path().stem().string())) continue;
    ++count;
    for (const Case& a_case : verify_scene(entry.path().string(), kCatalog, {})) {
      INFO(entry.path() << ", " << a_case.own.run.strategy << ": " << a_case.own.run.cause << a_case.trouble);
      CHECK(passed(a_case));
    }
  }
  CHECK(count >= 10);
}

// A block of 1 x 1 x 2 cm, whose base is half as wide as it is high: on 26.6 degrees its weight passes over the edge.
TEST_CASE("a body that topples shows no friction", "[sliding][slow]") {
  const auto run = [](const std::string& experiment, const std::string& friction, const std::string& duration) {
    const TemporaryFolder folder;
    const auto scene = load_scene(
        folder.write("scene.yaml",
                     "body: {lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, connections: [axis, face]}}\n"
                     "material: {youngs_modulus: 500 kPa}\nstiffness: lattice\nexperiment: {kind: sliding, " +
                         experiment + "}\ncontact: {friction: " + friction + "}\ntime: {duration: " + duration + "}\n"),
        kCatalog);
    return run_strategy(scene->specimen, *scene->experiment, scene->stiffness,
                        {.statics = scene->statics, .time = scene->time});
  };
  for (const std::string experiment : {"incline: {angle: 30 deg}", "threshold: {from: 15 deg, rate: 1 1/s}"}) {
    INFO(experiment);
    const Run topples = run(experiment, "0.9", "0.4 s");
    REQUIRE(topples.outcome == Outcome::converged);
    for (const char* name : {"slip_angle", "slip_friction", "slide_acceleration"})
      CHECK_FALSE(std::isfinite(topples.measures.get(name)));
    CHECK(topples.measures.get("turn") > 0.1);
    CHECK_THAT(topples.remark, Catch::Contains("the body topples: it has turned by up to "));
  }
  CHECK_THAT(run("incline: {angle: 30 deg}", "0.9", "0.05 s").remark, Catch::Contains("the body topples"));
  const Run slides = run("incline: {angle: 30 deg}", "0.2", "0.1 s");
  CHECK(std::abs(slides.measures.get("turn")) < 0.02);
  CHECK(slides.measures.get("slide_acceleration") ==
        Approx(9.81 * (std::sin(M_PI / 6) - 0.2 * std::cos(M_PI / 6))).epsilon(0.02));
}
