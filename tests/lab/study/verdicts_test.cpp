#include "lab/study/study.h"

#include <catch2/catch.hpp>
#include <cctype>
#include <filesystem>
#include <set>

#include "elastin/core/parallel/threads.h"
#include "lab/report/files.h"
#include "lab/report/records.h"
#include "lab/run/specimen.h"
#include "support/temporary_folder.h"
#include "support/vtu_arrays.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();
const std::string kHard = std::string(ELASTIN_SOURCE_DIR) + "/scenes/hard/";

/// Whether a text holds nan or inf as a word of its own, as numbers that are not finite are printed.
bool has_non_finite(const std::string& text) {
  std::string word;
  for (const char c : text + " ") {
    if (std::isalpha(static_cast<unsigned char>(c))) {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      continue;
    }
    if (word == "nan" || word == "inf" || word == "infinity") return true;
    word.clear();
  }
  return false;
}

/// All that the command writes of one run.
void check_files(const Scene& scene, const Record& record) {
  CHECK_FALSE(has_non_finite(json_text({record})));
  CHECK_FALSE(has_non_finite(csv_text({record})));
  CHECK_FALSE(has_non_finite(curve_csv_text(record)));
  for (const Snapshot& shot : record.run.snapshots)
    if (&shot == &record.run.snapshots.back() || record.run.outcome != Outcome::converged)
      CHECK(finite_arrays(vtu_text(scene.specimen.body, shot, record.run.constants)));
}

/// Too slow for the sanitizers.
const std::set<std::string> kLong{"buckling", "pushed-in-time",        "slender",   "step-implicit-long", "twist-720",
                                  "nu-0.499", "undamped-100000-steps", "free-fall", "mass-ratio"};

bool sanitized() {
#ifdef __SANITIZE_ADDRESS__
  return true;
#else
  return false;
#endif
}

Run run_on(int threads, const std::string& scene_name, const std::vector<std::string>& overrides) {
  set_threads(threads);
  const auto scene = load_scene(kHard + scene_name + ".yaml", kCatalog, overrides);
  REQUIRE(scene->specimen.body.connections.size() > 50000);  // where several threads begin
  RunOptions options;
  options.statics = scene->statics;
  options.time = scene->time;
  options.keep_snapshots = true;
  Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, options);
  set_threads(0);
  return run;
}

}  // namespace

TEST_CASE("every hard case comes out as its scene says, and nothing that is not finite is written", "[hard][slow]") {
  CHECK(has_non_finite("1 -nan 2"));
  CHECK(has_non_finite("a,inf"));
  CHECK_FALSE(has_non_finite("infinite nanny"));
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kHard)) {
    if (entry.path().extension() != ".yaml") continue;
    ++count;
    if (sanitized() && kLong.count(entry.path().stem().string())) continue;
    VerifyOptions options;
    options.keep_snapshots = true;
    options.finished = check_files;
    for (const Case& a_case : verify_scene(entry.path().string(), kCatalog, options)) {
      INFO(entry.path() << ", " << a_case.own.run.strategy << ": " << a_case.own.run.cause << a_case.trouble);
      CHECK(passed(a_case));
    }
  }
  CHECK(count >= 40);
}

TEST_CASE("a case in time has a verdict for every stepper, one at rest for none", "[hard]") {
  VerifyOptions options;
  options.steppers = true;
  const Case in_time = verify_scene(kHard + "inverted-in-time.yaml", kCatalog, options).front();
  REQUIRE(in_time.others.size() ==
          static_cast<std::size_t>(std::distance(kCatalog.steppers.begin(), kCatalog.steppers.end())));
  for (const auto& [stepper, verdict] : in_time.others) {
    INFO(stepper);
    CHECK(verdict == "stopped: inverted");
  }
  const Case at_rest = verify_scene(kHard + "zero-length.yaml", kCatalog, options).front();
  for (const auto& [stepper, verdict] : at_rest.others) CHECK(verdict == "–");
}

TEST_CASE("hard cases are bitwise identical on any number of threads", "[hard][threads][slow]") {
  const std::string lattice = "body.lattice.molecules=[18, 18, 20]";
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases{
      {"impact", {lattice, "time.duration=1 ms", "time.frames=4"}},
      {"step-implicit-long", {lattice, "time.duration=16 ms", "time.frames=2"}},
      {"scene-rotated", {"body.tetrahedra.cubes=[20, 20, 19]", "experiment.displacement=0.3 mm"}}};
  for (const auto& [scene, overrides] : cases) {
    INFO(scene);
    const Run one = run_on(1, scene, overrides);
    INFO(one.cause);
    REQUIRE(one.outcome == Outcome::converged);
    for (const int threads : sanitized() ? std::vector{2} : std::vector{2, 3, 5}) {
      INFO(threads << " threads");
      const Run other = run_on(threads, scene, overrides);
      CHECK(other.measures.all() == one.measures.all());
      CHECK(other.snapshots.back().positions == one.snapshots.back().positions);
    }
  }
}

TEST_CASE("verdicts: an expected stop passes, an unexpected answer or stop fails, no expectation is neither",
          "[hard]") {
  const TemporaryFolder folder;
  const auto verdict_of = [&](const std::string& strategy, const std::string& expect) {
    const std::string path = folder.write("bar.yaml",
                                          "title: A bar\nbody:\n  molecules: [[0 m, 0 m, 0 m], [0 m, 0 m, 1 m]]\n  "
                                          "connections: [[0, 1]]\n  radius: 1 cm\n"
                                          "material: {youngs_modulus: 10 kPa}\nstiffness: " +
                                              strategy +
                                              "\nexperiment: {kind: tension, force: 1 uN, cross_section: 4 cm2}\n"
                                              "expect: [" +
                                              expect + "]\n");
    const std::vector<Case> cases = verify_scene(path, kCatalog, {});
    REQUIRE(cases.size() == 1);
    return verdicts_text(cases, false, false);
  };
  const std::string right = "{measure: effective_modulus, value: 10 kPa, tolerance: 1e-6, source: me}";
  CHECK_THAT(verdict_of("standard", right), Contains("passed  ") && Contains("1 of 1 passed\n"));
  CHECK_THAT(verdict_of("standard", "{measure: effective_modulus, value: 11 kPa, tolerance: 1e-6, source: me}"),
             Contains("failed") && Contains("E -9.09 %") && Contains("0 of 1"));
  const std::string stop = "{outcome: unsuited, cause: needs tetrahedra, source: me}";
  CHECK_THAT(verdict_of("neo_hookean", stop), Contains("passed: unsuited") && Contains("1 of 1"));
  CHECK_THAT(verdict_of("neo_hookean", "{outcome: unsuited, cause: needs triangles, source: me}"), Contains("failed"));
  CHECK_THAT(verdict_of("neo_hookean", "{outcome: inverted, cause: needs tetrahedra, source: me}"), Contains("failed"));
  CHECK_THAT(verdict_of("standard", stop), Contains("failed") && Contains("converged, expected unsuited"));
  CHECK_THAT(verdict_of("standard", "{measure: storage_modulus, value: 9 kPa, tolerance: 1 %, source: me}"),
             Contains("failed") && Contains("storage_modulus not measured"));
  CHECK_THROWS_WITH(verdict_of("standard", "{measure: poissons_ratio, value: 0, tolerance: 1 %, source: me}"),
                    Contains("bar.yaml:9:10") && Contains("of 0 it allows nothing: give `absolute`"));
  CHECK_THAT(verdict_of("neo_hookean", right), Contains("failed"));
  CHECK_THAT(verdict_of("standard", ""), Contains("no expectation") && Contains("0 of 1 passed, 1 not judged\n"));
  CHECK_THAT(verdict_of("neo_hookean", ""), Contains("failed") && Contains("needs tetrahedra"));
  CHECK_THAT(verdict_of("standard", "{measure: effective_modulus, value: 1 kPa, not_reproduced: why not, source: me}"),
             Contains("not reproduced") && Contains("why not") && Contains("1 not judged"));
}

TEST_CASE("a measure that a scene names itself has a verdict under its name", "[hard]") {
  const std::string scene = std::string(ELASTIN_SOURCE_DIR) + "/scenes/tissue/artery-ring.yaml";
  CHECK_THAT(verdicts_text(verify_scene(scene, kCatalog, {}), false, false),
             Contains("lumen displacement") && Contains("1 of 1 passed"));
}

TEST_CASE("what a muscle does is no energy from nothing", "[hard]") {
  const std::string scene = std::string(ELASTIN_SOURCE_DIR) + "/scenes/tissue/muscle.yaml";
  CHECK_THAT(verdicts_text(verify_scene(scene, kCatalog, {}), false, false), Contains("1 of 1 passed"));
}
