#include "lab/study/journal.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "elastin/core/base/error.h"
#include "support/shell.h"
#include "support/small_cube.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using elastin::testing::kCube;

TEST_CASE("a line that was cut off is no line", "[journal]") {
  const TemporaryFolder folder;
  const std::string path = folder.write("rows", "one\ntwo\nthr");
  CHECK(lines_of(path) == std::vector<std::string>{"one", "two"});
  LineFile(path, true).add("three");
  CHECK(text_of_file(path) == "one\ntwo\nthree\n");
  LineFile(path, false).add("four");
  CHECK(text_of_file(path) == "four\n");
  CHECK_THROWS_WITH(LineFile("/dev/null/rows", false), Contains("/dev/null/rows: cannot make its folder"));
}

TEST_CASE("a key changes with every part and where one ends", "[journal]") {
  std::set<std::string> keys;
  for (const std::vector<std::string>& parts :
       std::vector<std::vector<std::string>>{{}, {""}, {"ab", "c"}, {"a", "bc"}, {"abc"}, {"abc", ""}})
    keys.insert(key_of(parts));
  CHECK(keys.size() == 6);
}

TEST_CASE("a study that is killed goes on with --resume and loses no finished row", "[journal][command][slow]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  const std::string study =
      "$elastin compare cube.yaml --quiet --vary material.poissons_ratio=[0.1,0.2,0.25] "
      "--vary solver.tolerance=[1e-8,1e-9,1e-10,1e-11] --repeats 10 ";
  // Killed as soon as five rows are on disk; 360 are to come.
  shell(folder, study +
                    "--out o & until [ \"$(cat o/runs.jsonl 2>/dev/null | wc -l)\" -ge 5 ]; do sleep 0.01; done; "
                    "kill -9 $!; wait $!");
  const std::vector<std::string> before = lines_of(folder.path("o/runs.jsonl"));
  REQUIRE(before.size() >= 5);
  REQUIRE(before.size() < 360);
  REQUIRE(shell(folder, study + "--resume o") == 0);
  const std::vector<std::string> after = lines_of(folder.path("o/runs.jsonl"));
  REQUIRE(after.size() == 360);
  CHECK(std::vector<std::string>(after.begin(), after.begin() + static_cast<long>(before.size())) == before);
  CHECK(std::set<std::string>(after.begin(), after.end()).size() == 360);
  CHECK(lines_of(folder.path("o/runs.csv")).size() == 1 + 36);
  CHECK(std::filesystem::exists(folder.path("o/report.html")));
  // Nothing is left to do.
  REQUIRE(shell(folder, study + "--resume o") == 0);
  CHECK(lines_of(folder.path("o/runs.jsonl")).size() == 360);
}

TEST_CASE("the option --resume refuses a folder whose runs come from elsewhere, and leaves it as it is",
          "[journal][command][slow]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  folder.write("other.yaml", kCube);
  const std::string compare = "$elastin compare --quiet --resume o ";
  REQUIRE(shell(folder, compare + "cube.yaml --set material.youngs_modulus=6000") == 0);
  const std::string runs = text_of_file(folder.path("o/runs.jsonl")), csv = text_of_file(folder.path("o/runs.csv")),
                    curve = text_of_file(folder.path("o/cube-lattice-curve.csv"));
  const auto refused = [&](const std::string& arguments, const std::string& message) {
    INFO(arguments);
    CHECK(shell(folder, compare + arguments) == 2);
    CHECK_THAT(text_of_file(folder.path("err")), Contains("elastin: --resume: o contains runs of " + message));
    CHECK(text_of_file(folder.path("o/runs.jsonl")) == runs);
    CHECK(text_of_file(folder.path("o/runs.csv")) == csv);
    CHECK(text_of_file(folder.path("o/cube-lattice-curve.csv")) == curve);
  };
  refused("other.yaml --set material.youngs_modulus=6000", "the scene 'cube'; this command is about 'other'");
  refused("cube.yaml", "the scene 'cube' with --set material.youngs_modulus=6000; this command has no --set");
  refused("cube.yaml --set material.youngs_modulus=7000",
          "the scene 'cube' with --set material.youngs_modulus=6000; this command has --set "
          "material.youngs_modulus=7000");
  folder.write("cube.yaml", kCube + "# another line\n");
  refused("cube.yaml --set material.youngs_modulus=6000",
          "another version of the scene 'cube': its file has changed since");
  // More scenes and more strategies of the same are welcome.
  folder.write("cube.yaml", kCube);
  CHECK(shell(folder,
              compare + "cube.yaml other.yaml --set material.youngs_modulus=6000 --strategies lattice,divided") == 0);
  CHECK(lines_of(folder.path("o/runs.jsonl")).size() == 3 + 1 + 2);
}

TEST_CASE("two commands at once do not write to one folder", "[journal][command]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  const std::string study = "$elastin compare cube.yaml --quiet --resume o";
  REQUIRE(shell(folder, study) == 0);
  const std::string runs = text_of_file(folder.path("o/runs.jsonl"));
  CHECK(shell(folder, "flock o/runs.jsonl " + study) == 2);
  CHECK_THAT(text_of_file(folder.path("err")), Contains("o/runs.jsonl: another command writes to it"));
  CHECK(text_of_file(folder.path("o/runs.jsonl")) == runs);
}

TEST_CASE("a mesh that has changed since makes other rows", "[journal][command]") {
  const TemporaryFolder folder;
  const std::string mesh =  // a cube of six tetrahedra
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 0 0 1\n6 1 0 1\n"
      "7 0 1 1\n8 1 1 1\n$EndNodes\n$Elements\n6\n1 4 2 1 1 1 2 4 8\n2 4 2 1 1 1 6 2 8\n3 4 2 1 1 1 4 3 8\n"
      "4 4 2 1 1 1 3 7 8\n5 4 2 1 1 1 5 6 8\n6 4 2 1 1 1 7 5 8\n$EndElements\n";
  folder.write("cube.msh", mesh);
  folder.write("cube.yaml",
               "body: {mesh: {file: cube.msh, length_unit: mm}}\nmaterial: {youngs_modulus: 5 kPa}\n"
               "stiffness: neo_hookean\nexperiment: {kind: tension, axis: z, force: 1 uN}\n");
  const std::string study = "$elastin compare cube.yaml --strategies neo_hookean --quiet --resume o";
  REQUIRE(shell(folder, study) == 0);
  folder.write("cube.msh", mesh + "\n");
  CHECK(shell(folder, study) == 2);
  CHECK_THAT(text_of_file(folder.path("err")), Contains("its file has changed since, or one that it names"));
}

TEST_CASE("a full disk is named, and the rows before it stay", "[journal][command][slow]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  const std::string study = "$elastin compare cube.yaml --quiet --repeats 100 ";
  // No file may grow beyond 64 kB: writing fails as on a full disk.
  CHECK(shell(folder, "trap \"\" XFSZ; ulimit -f 64; " + study + "--out o") == 2);
  CHECK_THAT(text_of_file(folder.path("err")), Contains("o/runs.jsonl: cannot write: File too large"));
  const std::size_t before = lines_of(folder.path("o/runs.jsonl")).size();
  CHECK(before > 10);
  CHECK(text_of_file(folder.path("o/runs.jsonl")).back() == '\n');
  REQUIRE(shell(folder, study + "--resume o") == 0);
  CHECK(lines_of(folder.path("o/runs.jsonl")).size() == 300);
}

TEST_CASE("a row of a study that fails says why and does not end it", "[journal][command]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  const std::string study = "$elastin compare cube.yaml --vary \"{body.lattice.molecules: ", loads = "{loads: ",
                    point = "[{point: {molecules: [", on = "], force: [0, 0, 1 nN]}}]";
  // Each value can be read with some of the others: what does not go together is a row.
  CHECK(shell(folder, study + "[[3, 3, 3], [4, 4, 4]]}\" --vary \"" + loads + "[" + point + "26" + on + ", " + point +
                          "63" + on + "]}\"") == 1);
  const std::string out = text_of_file(folder.path("out"));
  CHECK_THAT(out, Contains("'63' is not a whole number") && Contains("[4, 4, 4]"));
  // One that cannot be read with any is a slip, said at once.
  CHECK(shell(folder, study + "[[3, 3, 3], [0, 3, 3], [4, 4, 4]]}\"") == 2);
  CHECK_THAT(text_of_file(folder.path("err")),
             Contains("--vary: body.lattice.molecules[0]: ") && Contains("is not a whole number of at least"));
  CHECK(shell(folder, "$elastin compare cube.yaml --vary body.lattice.molecule=[[3,3,3]]") == 2);
  CHECK_THAT(text_of_file(folder.path("err")), Contains("unknown key") && Contains("did you mean"));
}

TEST_CASE("a study refuses to vary what says which runs there are", "[journal][command]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  for (const std::string axis :
       {"stiffness=[standard, lattice]", "strategies=[[standard], [lattice]]", "study.repeats=[1, 2]"}) {
    INFO(axis);
    CHECK(shell(folder, "$elastin compare cube.yaml --vary \"" + axis + "\"") == 2);
    CHECK_THAT(text_of_file(folder.path("err")), Contains("a study does not vary"));
  }
}

TEST_CASE("a row in which one digit has changed is refused, and one without a checksum too", "[journal][command]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  REQUIRE(shell(folder, "$elastin compare cube.yaml --quiet --out o") == 0);
  const std::string rows = text_of_file(folder.path("o/runs.jsonl"));
  std::size_t flipped = 0;
  for (std::size_t at = rows.find('\n') + 1; at < rows.size(); at += 1 + rows.size() / 300) {
    if (rows[at] == '\n') continue;
    std::string changed = rows;
    changed[at] = rows[at] == '7' ? '3' : '7';
    folder.write("o/runs.jsonl", changed);
    CHECK_THROWS_WITH(journal_of(folder.path("o")), Contains("o/runs.jsonl:") && Contains("hecksum"));
    ++flipped;
  }
  CHECK(flipped > 100);
  const std::size_t sum = rows.rfind(",\"sum\"");
  folder.write("o/runs.jsonl", rows.substr(0, sum) + "}\n");
  CHECK(shell(folder, "$elastin compare cube.yaml --quiet --resume o") == 2);
  CHECK_THAT(text_of_file(folder.path("err")), Contains("it has no checksum: an older version wrote it"));
}

TEST_CASE("a disk that is full with states has the row's numbers", "[journal][command]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  // A folder where the states of the first row would stand.
  std::filesystem::create_directories(folder.path("o/cube-lattice-000.vtu"));
  CHECK(shell(folder, "$elastin compare cube.yaml --quiet --strategies lattice --out o") == 2);
  CHECK_THAT(text_of_file(folder.path("err")), Contains("cube-lattice-000.vtu"));
  CHECK(lines_of(folder.path("o/runs.jsonl")).size() == 1);
  CHECK(shell(folder, "$elastin compare cube.yaml --strategies lattice --resume o") == 0);
  CHECK_THAT(text_of_file(folder.path("out")), Contains("cube, lattice: its numbers are here, but not its states"));
}
