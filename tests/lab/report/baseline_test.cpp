#include "lab/report/comparison.h"

#include <catch2/catch.hpp>
#include <string>

#include "elastin/core/base/error.h"
#include "lab/study/journal.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

Record run_of(const std::string& strategy, double modulus, double seconds) {
  Record record;
  record.scene = record.title = "block";
  record.run.strategy = strategy;
  record.run.measures.set("effective_modulus", modulus);
  record.run.solve_seconds = seconds;
  record.main_measures = {{"effective_modulus"}};
  return record;
}

}  // namespace

TEST_CASE("what changed since an earlier run is stated run by run", "[baseline]") {
  const TemporaryFolder folder;
  {
    Journal journal(folder.path(""), false, {});
    journal.add("1", {"block", "", {}}, run_of("lattice", 5000, 0.2));
    journal.add("2", {"block", "", {}}, run_of("patch", 800, 0.1));
  }
  const auto earlier = load_baseline(folder.path(""));
  REQUIRE(earlier.size() == 2);
  const std::string text =
      change_table({run_of("lattice", 5500, 0.1), run_of("patch", 800, 0.1), run_of("lloyd", 1, 1)}, earlier)
          .text(false);
  CHECK_THAT(text, Contains("5.0000 kPa") && Contains("5.5000 kPa") && Contains("+10.00 %") && Contains("0.50"));
  CHECK_THAT(text, Contains("none") && !Contains("lloyd"));
  CHECK(change_table({run_of("lloyd", 1, 1)}, earlier).empty());
}

TEST_CASE("a baseline without runs says what was looked for", "[baseline]") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(load_baseline(folder.path("none")), Contains("--baseline") && Contains("none/runs.jsonl"));
  folder.write("runs.jsonl", "{}\n");
  CHECK_THROWS_WITH(load_baseline(folder.path("")), Contains("runs.jsonl:1"));
}
