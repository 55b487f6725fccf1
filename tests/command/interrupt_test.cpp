// The command stopped in the middle of a run in time, and going on from there.

#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "support/temporary_folder.h"

using Catch::Matchers::Contains;

namespace {

/// Would take for ever; `frames` makes it end.
std::string scene_of(int frames) {
  return "title: An oscillator\n"
         "body: {molecules: [[0 m, 0 m, 0 m], [10 cm, 0 m, 0 m]], connections: [[0, 1]]}\n"
         "material: {youngs_modulus: 10 kPa, density: 1000 kg/m3}\n"
         "stiffness: {strategy: uniform, constant: 100 N/m}\n"
         "experiment: {kind: release, fixture: {kind: tension, axis: x, force: 0.1 N, cross_section: 1 cm2}}\n"
         "time: {duration: " +
         std::to_string(frames) + " s, frames: " + std::to_string(frames) + ", step: 0.1 ms, checkpoint: 2}\n";
}

int shell(const std::string& line) {
  const int status = std::system(line.c_str());
  REQUIRE(WIFEXITED(status));
  return WEXITSTATUS(status);
}

nlohmann::json first_run(const std::string& path) { return nlohmann::json::parse(text_of_file(path))["runs"][0]; }

}  // namespace

TEST_CASE("an interrupted command leaves whole files and goes on from its restart file", "[command][time][slow]") {
  const TemporaryFolder folder;
  const std::string scene = folder.write("oscillator.yaml", scene_of(100000)), out = folder.path("out"),
                    restart = out + "/oscillator-uniform.restart",
                    command = "'" ELASTIN_COMMAND "' run '" + scene + "' ";
  // Interrupted as soon as there is a first restart file.
  const int code = shell("cd '" + folder.path("") + "' && { " + command + "--quiet --out '" + out +
                         "' & p=$!; while [ ! -e '" + restart + "' ]; do sleep 0.02; done; kill -INT $p; wait $p; }");
  CHECK(code == 1);
  const auto run = first_run(out + "/runs.json");
  CHECK(run["outcome"] == "interrupted");
  CHECK_THAT(run["cause"].get<std::string>(), Contains("of 100000, at t = "));
  const auto rows = run["curve"].size();
  CHECK(rows >= 3);
  CHECK_THAT(text_of_file(out + "/oscillator-uniform-curve.csv"), Contains("time [s]"));
  CHECK_THAT(text_of_file(out + "/oscillator-uniform.pvd"), Contains("timestep=\"1\""));

  const std::string frames = std::to_string(rows + 1);
  CHECK(shell(command + "--quiet --set time.duration=" + frames + " --set time.frames=" + frames + " --restart '" +
              restart + "' --out '" + out + "' --json '" + folder.path("rest.json") + "'") == 0);
  CHECK(shell(command + "--quiet --set time.duration=" + frames + " --set time.frames=" + frames + " --json '" +
              folder.path("whole.json") + "'") == 0);
  const auto rest = first_run(folder.path("rest.json")), whole = first_run(folder.path("whole.json"));
  CHECK(rest["curve"].size() == rows + 2);
  CHECK(rest["curve"] == whole["curve"]);
  CHECK(rest["measures"] == whole["measures"]);

  const std::string shown = text_of_file(out + "/oscillator-uniform.pvd");  // the frames of both runs
  for (std::size_t frame = 0; frame <= rows; ++frame)
    CHECK_THAT(shown, Contains("timestep=\"" + std::to_string(frame) + "\""));

  const std::string said = folder.path("said");
  CHECK(shell(command + "--restart nowhere 2> '" + said + "'") == 2);
  CHECK_THAT(text_of_file(said), Contains("--restart: nowhere: cannot be read"));
  CHECK(shell(command + "--restart '" + restart + "' --set time.duration=3 2> '" + said + "'") == 2);
  CHECK_THAT(text_of_file(said), Contains("this is the restart file of another run"));
}

TEST_CASE("what has no steps stops within a second, too", "[command][slow]") {
  const TemporaryFolder folder;
  const std::string material =
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}\nstiffness: patch\n";
  folder.write("packing.yaml", "body: {packing: {size: [100 mm, 100 mm, 100 mm], distance: 0.8 mm}}\n" + material +
                                   "experiment: {kind: tension, axis: z, strain: 0.01}\n");
  folder.write("factorisation.yaml",
               "body: {tetrahedra: {kind: kuhn, cubes: [40, 40, 40], size: [1 m, 1 m, 1 m]}}\n" + material +
                   "solver: {linear_solver: direct}\nexperiment: {kind: tension, axis: z, strain: 0.01}\n");
  for (const char* phase : {"packing", "factorisation"}) {
    CAPTURE(phase);
    const std::string line =
        std::string("cd '") + folder.path("") + "' && { '" ELASTIN_COMMAND "' run " + phase +
        ".yaml 2> said & p=$!; sleep 1.5; kill -INT $p; s=$(date +%s%N); wait $p; e=$(date +%s%N); "
        "[ $((e - s)) -lt 3000000000 ]; }";  // a second, and what a busy machine takes
    CHECK(shell(line) == 0);
    CHECK_THAT(text_of_file(folder.path("said")), Contains("stopped in the middle"));
  }
}

TEST_CASE("CalculiX works in a folder of its own, and is ended with the comparison", "[command][calculix]") {
  const TemporaryFolder folder;
  folder.write("bar.yaml",
               "body: {tetrahedra: {kind: kuhn, cubes: [2, 1, 1], size: [2 mm, 1 mm, 1 mm]}}\n"
               "material: {youngs_modulus: 10 kPa}\nstiffness: neo_hookean\nstrategies: [neo_hookean]\n"
               "experiment: {kind: tension, axis: x, strain: 0.1 %}\nreference: none\n");
  std::filesystem::create_directory(folder.path("tmp"));
  std::filesystem::create_directory(folder.path("bin"));
  folder.write("bin/ccx", "#!/bin/sh\nstat -c %a . > ../../mode; pwd > ../../where; exec sleep 60\n");
  const auto begin = std::chrono::steady_clock::now();
  CHECK(shell("cd '" + folder.path("") +
              "' && chmod +x bin/ccx && { TMPDIR=$PWD/tmp PATH=$PWD/bin:$PATH '" ELASTIN_COMMAND
              "' compare bar.yaml --against calculix --out o --quiet & p=$!; "
              "while [ ! -s where ]; do sleep 0.02; done; kill -INT $p; wait $p; }") == 1);
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(30));
  CHECK(text_of_file(folder.path("mode")) == "700\n");
  const std::string where = text_of_file(folder.path("where"));
  CHECK_THAT(where, Contains("/tmp/elastin-calculix-"));
  CHECK(std::filesystem::is_empty(folder.path("tmp")));
  CHECK(shell("cd '" + folder.path("") +
              "' && TMPDIR=/no/such PATH=$PWD/bin:$PATH '" ELASTIN_COMMAND
              "' compare bar.yaml --against calculix --quiet 2> said") == 2);
  CHECK_THAT(text_of_file(folder.path("said")), Contains("/no/such (TMPDIR)") && !Contains("standard output"));
}

TEST_CASE("a comparison that is stopped between two runs has not succeeded", "[command][slow]") {
  const TemporaryFolder folder;
  folder.write("bar.yaml",
               "body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 1 mm, connections: [axis, face]}}\n"
               "material: {youngs_modulus: 10 kPa}\nstiffness: lattice\nstrategies: [lattice, standard]\n"
               "experiment: {kind: tension, axis: x, strain: 0.1 %}\nreference: none\n");
  const std::string rows = "'" + folder.path("o/runs.jsonl") + "'";
  CHECK(shell("cd '" + folder.path("") +
              "' && { '" ELASTIN_COMMAND "' compare bar.yaml --repeats 1000 --out o --quiet & "
              "p=$!; until [ -s " +
              rows + " ]; do sleep 0.01; done; kill -INT $p; wait $p; }") == 1);
}

TEST_CASE("a verification that is interrupted prints its results so far", "[command][slow]") {
  const TemporaryFolder folder;
  folder.write("bar.yaml",
               "body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 1 mm, connections: [axis, face]}}\n"
               "material: {youngs_modulus: 10 kPa}\nstiffness: lattice\n"
               "experiment: {kind: tension, axis: x, strain: 0.1 %}\nreference: none\n"
               "expect: [{measure: effective_modulus, value: 10 kPa, tolerance: 1 %, source: the material}]\n");
  folder.write("oscillator.yaml", scene_of(100000));
  CHECK(shell("cd '" + folder.path("") +
              "' && { '" ELASTIN_COMMAND "' verify bar.yaml oscillator.yaml --out o > table 2> said & p=$!; "
              "while kill -0 $p && ! grep -qs effective_modulus o/runs.json; do sleep 0.02; done; kill -TERM $p; wait "
              "$p; }") == 1);
  CHECK_THAT(text_of_file(folder.path("table")), Contains("passed") && Contains("1 of 1 passed"));
  CHECK_THAT(text_of_file(folder.path("said")), Contains("stopped: 1 of 2 scenes are verified"));
}
