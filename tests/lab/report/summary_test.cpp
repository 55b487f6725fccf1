#include "lab/report/comparison.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/shapes/shapes.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

Record record(const std::string& scene, const std::string& strategy, double modulus_error, double ratio_error,
              double seconds) {
  Record one;
  one.scene = scene;
  one.path = scene + ".yaml";
  one.molecules = 27;
  one.neighbours = {18, 17};
  one.run.strategy = strategy;
  one.run.solve_seconds = seconds;
  if (std::isfinite(modulus_error)) one.errors.emplace_back("effective_modulus", modulus_error);
  if (std::isfinite(ratio_error)) {
    one.errors.emplace_back("poissons_ratio", ratio_error);
    one.run.measures.set("poissons_ratio", 0.25 + ratio_error);
  }
  return one;
}

const StrategySummary& row_of(const Summary& summary, const std::string& strategy) {
  for (const StrategySummary& row : summary.strategies)
    if (row.strategy == strategy) return row;
  throw std::runtime_error("no row of " + strategy);
}

/// Three bodies; every figure below can be read off by looking at them.
std::vector<Record> three_bodies() {
  std::vector<Record> all{record("a", "standard", 1.0, 0.05, 2),
                          record("a", "exact", -0.001, 0.002, 3),
                          record("a", "law", 0, 0, 8),
                          record("b", "standard", -0.5, -0.1, 1),
                          record("b", "exact", 0.004, -0.02, 2),
                          record("b", "law", 0, 0, 8),
                          record("c", "standard", 2.0, std::nan(""), 4),
                          record("c", "exact", std::nan(""), std::nan(""), 0),
                          record("c", "law", 0, 0, 8)};
  for (Record& one : all) {
    one.run.uses_cells = one.run.strategy == "law";
    if (!one.run.uses_cells) one.run.constants = VectorX::Ones(3);
  }
  all[3].run.zero_energy_modes = 2;
  all[5].run.suited = false;  // no cells on body b
  all[5].errors.clear();
  all[7].run.outcome = Outcome::diverged;
  all[7].run.cause = "no step helps";
  return all;
}

}  // namespace

TEST_CASE("the summary counts, and takes medians and worst sizes of errors", "[summary]") {
  const std::vector<Record> all = three_bodies();
  const Summary summary = summarise(all);
  REQUIRE(summary.strategies.size() == 3);
  const StrategySummary& standard = row_of(summary, "standard");
  CHECK(standard.bodies == 3);
  CHECK(standard.failed + standard.unsuited == 0);
  CHECK(standard.mechanisms == 1);
  CHECK(standard.modulus.median == 1.0);
  CHECK(standard.modulus.worst == 2.0);
  CHECK(standard.modulus.worst_scene == "c");
  CHECK(standard.ratio.median == Approx(0.075));  // of the two that show one
  CHECK(standard.ratio.worst_scene == "b");
  CHECK(standard.solve == 1);
  const StrategySummary& exact = row_of(summary, "exact");
  CHECK(exact.failed == 1);
  CHECK(exact.modulus.worst == 0.004);
  CHECK(exact.solve == Approx(1.75));  // of 3/2 and 2/1; a failed run took no time
  const StrategySummary& law = row_of(summary, "law");
  CHECK(law.unsuited == 1);
  CHECK(law.uses_cells);
  CHECK_FALSE(exact.uses_cells);
}

TEST_CASE("the best strategy without cells is nearest to the goals for E and for Poisson's ratio together",
          "[summary]") {
  std::vector<Record> all = three_bodies();
  Summary summary = summarise(all);
  REQUIRE(summary.bodies.size() == 3);
  CHECK(summary.bodies[0].best == &all[1]);
  CHECK(summary.bodies[0].best_springs == &all[1]);
  CHECK(summary.bodies[1].best_springs == &all[4]);
  CHECK(summary.bodies[1].best == &all[4]);  // 0.4 % and 0.02, against 50 % and 0.1
  CHECK(summary.bodies[2].best == &all[6]);  // the only one that ran
  CHECK(row_of(summary, "exact").best_on == 2);
  CHECK(row_of(summary, "law").best_on == 0);
  all[1].run.zero_energy_modes = 1;
  CHECK(summarise(all).bodies[0].best == &all[0]);  // a mechanism is not to be taken
  // Equal to a thousandth of the goal: the simpler one, however slow.
  all.push_back(record("a", "simpler", 0.999999, 0.05, 100));
  for (Record& one : all) one.run.order = 1 - (one.run.strategy == "simpler");
  summary = summarise(all);
  CHECK(summary.bodies[0].best == &all.back());
  // A specimen that does not show the material ranks nothing.
  for (Record& one : all)
    if (one.scene == "a") one.no_reference = "the grips clamp";
  summary = summarise(all);
  CHECK((!summary.bodies[0].best && !summary.bodies[0].best_springs && !summary.bodies[0].judged));
  CHECK(row_of(summary, "standard").modulus.worst_scene == "c");
  CHECK_THAT(summary_text(all, false), Contains("no reference") && Contains("of the 2 bodies"));
  // Neither does one on which nothing was run that could be ranked, or what has no modulus, as a vibration has none.
  std::vector<Record> others{record("a", "law", 0, 0, 8), record("b", "standard", std::nan(""), std::nan(""), 1),
                             record("c", "standard", 1, 0, 1)};
  others[0].run.uses_cells = true;
  others[2].run.constants = VectorX::Ones(3);
  summary = summarise(others);
  CHECK((summary.bodies[0].judged && !summary.bodies[0].without_cells && !summary.bodies[1].judged));
  CHECK_THAT(summary_text(others, false), Contains("none was run") && !Contains("none that is stable"));
  // Unless what it should show was computed: then that counts, not what the material has elsewhere.
  for (Record& one : all)
    if (one.scene == "a") {
      one.references = {{.measure = "effective_modulus", .value = 12e3, .source = "computed"},
                        {.measure = "poissons_ratio", .value = 0.5, .source = "computed"}};
      const bool exact = one.run.strategy == "exact";
      one.run.zero_energy_modes = 0;
      one.errors.emplace_back("effective_modulus_to_reference", exact ? -0.25 : 0.002);
      one.errors.emplace_back("poissons_ratio_to_reference", exact ? 0.1 : 0.01);  // 0.05 and 0.005 off
    }
  summary = summarise(all);
  CHECK((summary.bodies[0].judged && summary.bodies[0].best->run.strategy == "simpler"));
  CHECK(row_of(summary, "exact").modulus.worst == Approx(0.25));
  CHECK(row_of(summary, "exact").ratio.worst == Approx(0.05));
  CHECK_THAT(summary_text(all, false), Contains("of the 3 bodies"));
}

TEST_CASE("the summary in words: rows, goals, what failed", "[summary]") {
  std::vector<Record> all = three_bodies();
  all[1].verdicts.push_back({{}, "exact", 1, 0.5, false, true});
  all[1].verdicts.back().expectation.measure = "effective_modulus";
  const std::string text = summary_text(all, false);
  CHECK_THAT(text, Contains("Summary  3 bodies") && Contains("law *") && Contains("2 of 3"));
  // b has 0.02, more than 0.01; c has no near one; a is within both.
  CHECK_THAT(text, !Contains("calibrated within"));
  CHECK_THAT(
      text,
      Contains(
          "within 1 % of E and 0.01 of nu, of the 3 bodies with 12 neighbours or more: 1 without cells, 1 by any"));
  CHECK_THAT(text, Contains("c, exact: diverged: no step helps\n") &&
                       Contains("a, exact: effective_modulus +50.00 % from expected\n") &&
                       Contains("0 of 1 expectations hold"));
  CHECK(summary_text({}, false).empty());
  for (Record& one : all)
    if (one.run.strategy == "exact") one.run.strategy = "calibrated:exact";
  CHECK_THAT(summary_text(all, false),
             Contains("calibrated within 0.1 % of E: 1 of 2 runs; calibrated:exact on b: +0.400 %\n"));
  for (Record& one : all) one.run.suited &= one.run.strategy != "law";
  CHECK_THAT(summary_text(all, false), Contains("suited to none of these bodies: law\n") && !Contains("law *"));
}

TEST_CASE("neighbours are counted away from the surface", "[summary]") {
  // Cubic lattices: 6 along the axes, 12 face diagonals, 8 space diagonals; a corner of the lattice has 3.
  const Neighbours axis = neighbours_inside(cubic_lattice({5, 5, 5}, 1, {true, false, false}));
  CHECK(axis.mean == 6);
  CHECK(axis.least == 6);
  CHECK(neighbours_inside(cubic_lattice({7, 7, 7}, 1, {true, true, true})).mean == 26);
  CHECK(neighbours_inside(cubic_lattice({2, 2, 2}, 1, {true, false, false})).mean == 3);  // nothing is inside
  Body isolated = cubic_lattice({2, 2, 2}, 1, {true, false, false});
  isolated.connections = {};
  CHECK(neighbours_inside(isolated).mean == 0);
}
