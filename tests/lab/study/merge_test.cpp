#include "lab/study/study.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <set>

#include "elastin/core/base/error.h"
#include "lab/report/records.h"
#include "lab/study/journal.h"
#include "lab/study/plan.h"
#include "support/shell.h"
#include "support/small_cube.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using elastin::testing::kCube;

namespace {

/// One end clamped, so that its reference is computed.
const std::string kClamped = R"(title: A clamped block
body:
  tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [1 cm, 1 cm, 1 cm]}
material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3}
stiffness: neo_hookean
strategies: [standard, neo_hookean, "calibrated:standard"]
experiment: {kind: tension, axis: z, force: 1 mN, fixed_grip: clamped}
reference: {computed: {uncertainty: 2 %, most_cells: 1000}}
)";

/// What a page shows, without the machine and the command.
std::string page_of(const TemporaryFolder& folder, const std::string& name) {
  const std::string page = text_of_file(folder.path(name + "/report.html"));
  const std::size_t footer = page.find("<footer>");
  REQUIRE(footer != std::string::npos);
  return page.substr(0, footer) + page.substr(page.find("</footer>"));
}

/// The same rows in the same order, but for times.
void check_same_runs(const TemporaryFolder& folder, const std::string& one, const std::string& other) {
  const std::vector<JournalEntry> first = journal_of(folder.path(one)), second = journal_of(folder.path(other));
  REQUIRE(first.size() == second.size());
  for (std::size_t row = 0; row < first.size(); ++row) {
    INFO("row " << row);
    CHECK(first[row].key == second[row].key);
    CHECK(disagreement(first[row].record, second[row].record) == "");
  }
}

}  // namespace

TEST_CASE("shards have the same number of rows, and no shard all of one strategy or size", "[merge]") {
  constexpr std::size_t rows = 960;
  for (const int shards : {1, 2, 3, 4, 7, 16}) {
    const std::vector<int> shard = deal_rows(rows, shards);
    REQUIRE(shard.size() == rows);
    CHECK(shard == deal_rows(rows, shards));
    const double share = static_cast<double>(rows) / shards;
    for (const std::size_t period : {1, 2, 3, 4, 8, 16})  // strategies, or values of a key, that come again and again
      for (std::size_t phase = 0; phase < period; ++phase) {
        std::map<int, int> counts;
        for (std::size_t row = phase; row < rows; row += period) ++counts[shard[row]];
        INFO(shards << " shards, every " << period << "th row from " << phase);
        REQUIRE(counts.begin()->first >= 1);
        REQUIRE(counts.rbegin()->first <= shards);
        for (const auto& [number, count] : counts) {
          if (period == 1) CHECK(std::abs(count - share) < 1);
          // Of a random choice: within five standard deviations.
          const double mean = share / static_cast<double>(period);
          CHECK(std::abs(count - mean) < 5 * std::sqrt(mean) + 1);
        }
      }
  }
  CHECK(deal_rows(0, 4).empty());
}

TEST_CASE("a shard is a number and how many there are", "[merge]") {
  CHECK(read_shard("3/16").number == 3);
  CHECK(read_shard("3/16").of == 16);
  CHECK(read_shard("1/1").of == 1);
  for (const char* text : {"", "3", "3/", "/16", "0/4", "5/4", "-1/4", "1/4x", "1.5/4", "1/0", "1/99999999999"})
    CHECK_THROWS_WITH(read_shard(text), Contains("--shard: '" + std::string(text) + "' is not N/M"));
}

TEST_CASE("a study in shards, one of them killed and continued, is that of one run", "[merge][command][slow]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  const std::string study =
      "$elastin compare cube.yaml --quiet --vary material.poissons_ratio=[0.1,0.25] "
      "--vary solver.tolerance=[1e-8,1e-9,1e-10] --repeats 6 ";
  REQUIRE(shell(folder, study + "--out serial") == 0);
  REQUIRE(shell(folder, study + "--shard 1/3 --resume s/1") == 0);
  REQUIRE(shell(folder, study + "--shard 3/3 --resume s/3") == 0);
  // Killed in the middle of a line, of 36 runs: no file may grow beyond 32 kB.
  REQUIRE(shell(folder, "ulimit -f 32; ulimit -c 0; " + study + "--shard 2/3 --resume s/2") == 128 + SIGXFSZ);
  CHECK(text_of_file(folder.path("s/2/runs.jsonl")).back() != '\n');
  const std::size_t there = lines_of(folder.path("s/2/runs.jsonl")).size();
  REQUIRE(there >= 5);
  REQUIRE(there < 36);
  CHECK(shell(folder, "$elastin merge s/* --out part") == 1);
  CHECK_THAT(text_of_file(folder.path("err")),
             Contains(std::to_string(36 - there) + " of 108 runs are missing:") && Contains("of shard 2/3: cube, "));
  CHECK(lines_of(folder.path("part/runs.jsonl")).size() == 72 + there);
  REQUIRE(shell(folder, study + "--shard 2/3 --resume s/2") == 0);
  REQUIRE(shell(folder, "$elastin merge s/* --out merged") == 0);
  CHECK(text_of_file(folder.path("err")).empty());
  check_same_runs(folder, "merged", "serial");
  CHECK(lines_of(folder.path("merged/runs.csv")).size() == 1 + 18);
  // The page of the same times by the one command is the same page.
  REQUIRE(shell(folder, "cp -r merged again && " + study + "--resume again") == 0);
  CHECK(page_of(folder, "again") == page_of(folder, "merged"));
  for (const char* file : {"runs.csv", "runs.json", "runs.jsonl", "cube-error.svg"}) {
    INFO(file);
    CHECK(text_of_file(folder.path(std::string("again/") + file)) ==
          text_of_file(folder.path(std::string("merged/") + file)));
  }
  // What a merged folder lacks is computed there.
  REQUIRE(shell(folder, study + "--resume part") == 0);
  CHECK(lines_of(folder.path("part/runs.jsonl")).size() == 108);
  // Parts may be cut in other ways, and overlap.
  CHECK(shell(folder, "$elastin merge part s/1 s/3 --quiet") == 0);
}

TEST_CASE("merged scenes have their references, states and bodies", "[merge][command][slow]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  folder.write("clamped.yaml", kClamped);
  const std::string study = "$elastin compare cube.yaml clamped.yaml --quiet ";
  REQUIRE(shell(folder, study + "--out serial") == 0);
  for (const char* shard : {"1", "2", "3", "4"})
    REQUIRE(shell(folder, study + "--out s/" + shard + " --shard " + shard + "/4") == 0);
  REQUIRE(shell(folder, "$elastin merge s/* --out merged") == 0);
  check_same_runs(folder, "merged", "serial");
  const auto files = [&](const std::string& name) {
    std::set<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path(name)))
      found.insert(entry.path().filename().string());
    return found;
  };
  CHECK(files("merged") == files("serial"));
  for (const std::string& file : files("serial"))
    if (file.ends_with(".vtu") || file.ends_with("-curve.csv")) {
      INFO(file);
      CHECK(text_of_file(folder.path("merged/" + file)) == text_of_file(folder.path("serial/" + file)));
    }
  CHECK(lines_of(folder.path("merged/views.jsonl")) == lines_of(folder.path("serial/views.jsonl")));
  // One computed reference in all, though each shard has computed it: the next command has nothing left to compute.
  const std::string json = text_of_file(folder.path("merged/runs.json"));
  const std::size_t references = json.find("\n \"references\"");
  REQUIRE(references != std::string::npos);
  const std::string list = json.substr(references);
  CHECK_THAT(list, Contains("\"scene\": \"clamped\""));
  CHECK(list.find("effective_modulus") == list.rfind("effective_modulus"));
  REQUIRE(shell(folder, "cp -r merged again && " + study + "--resume again") == 0);
  CHECK(page_of(folder, "again") == page_of(folder, "merged"));
}

TEST_CASE("rows that were computed twice with different numbers are named", "[merge][command]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  const std::string study = "$elastin compare cube.yaml --quiet ";
  REQUIRE(shell(folder, study + "--out one") == 0);
  REQUIRE(shell(folder, study + "--out two") == 0);
  CHECK(shell(folder, "$elastin merge one two") == 0);  // other times are no contradiction
  const std::vector<std::string> lines = lines_of(folder.path("two/runs.jsonl"));
  REQUIRE(lines.size() == 3);
  const std::string key = "\"elongation\":";
  std::string changed = lines[1];
  const std::size_t at = changed.find(key) + key.size();
  changed.replace(at, changed.find_first_of(",}", at) - at, "0.25");
  changed = with_sum(changed.substr(0, changed.rfind(",\"sum\"")) + "}");
  folder.write("two/runs.jsonl", lines[0] + "\n" + changed + "\n" + lines[2] + "\n");
  CHECK(shell(folder, "$elastin merge one two --json merged.json --quiet") == 1);
  CHECK_THAT(
      text_of_file(folder.path("err")),
      Contains("cube, lattice: one and two have different numbers, measures/elongation: ") && Contains(" and 0.25\n"));
  CHECK_THAT(text_of_file(folder.path("merged.json")), !Contains("0.25,"));  // the first folder's count
}

TEST_CASE("folders that do not belong together are not merged", "[merge][command][slow]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  folder.write("other.yaml", kCube);
  const std::string compare = "$elastin compare --quiet --out ";
  REQUIRE(shell(folder, compare + "a cube.yaml --shard 1/2") == 0);
  REQUIRE(shell(folder, compare + "other other.yaml") == 0);
  REQUIRE(shell(folder, compare + "set cube.yaml --set material.youngs_modulus=6000") == 0);
  REQUIRE(shell(folder, compare + "strategies cube.yaml --strategies lattice") == 0);
  folder.write("cube.yaml", kCube + "# another line\n");
  REQUIRE(shell(folder, compare + "version cube.yaml") == 0);
  const auto refused = [&](const std::string& folders, const std::string& message) {
    INFO(folders);
    CHECK(shell(folder, "$elastin merge --out out " + folders) == 2);
    CHECK_THAT(text_of_file(folder.path("err")), Contains("elastin: " + message));
    CHECK_FALSE(std::filesystem::exists(folder.path("out/runs.jsonl")));
  };
  refused("a other", "other cannot be merged with a: it contains runs of the scene 'other'; the other is about 'cube'");
  refused("a set",
          "set cannot be merged with a: it contains runs of the scene 'cube' with --set material.youngs_modulus=6000; "
          "the other has no --set");
  refused("a strategies", "strategies cannot be merged with a: it is of another study of the same scenes");
  refused("a version", "version cannot be merged with a: it contains runs of another version of the scene 'cube'");
  refused("a none", "none/study.json: cannot be read; a folder that `elastin compare --shard N/M --out` wrote has it");
  folder.write("a/study.json", "{\"record_version\": 1}\n");
  refused("a", "a/study.json: is not the plan of a study");
  CHECK(shell(folder, "$elastin merge other version --out version") == 2);
  CHECK_THAT(text_of_file(folder.path("err")), Contains("version is one of the folders that are merged"));
}

TEST_CASE("the option --shard says what it needs", "[merge][command]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  const auto refused = [&](const std::string& options, const std::string& message) {
    INFO(options);
    CHECK(shell(folder, "$elastin compare cube.yaml " + options) == 2);
    CHECK_THAT(text_of_file(folder.path("err")), Contains(message));
  };
  refused("--shard 1/2", "--shard needs a folder of its own");
  refused("--shard 3/2 --out o", "'3/2' is not N/M");
  refused("--shard 1/2 --out o --baseline b", "give --peers and --baseline to `merge`");
  refused("--shard 1/2 --out o --steppers all", "--shard: is of a comparison of strategies");
  // There may be more shards than rows.
  CHECK(shell(folder, "$elastin compare cube.yaml --shard 9/9 --out o") == 0);
  CHECK_THAT(text_of_file(folder.path("out")), Contains("shard 9/9: 0 of 0 runs in o/"));
}
