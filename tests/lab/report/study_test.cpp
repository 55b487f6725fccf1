#include "lab/report/comparison.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "elastin/core/base/error.h"
#include "lab/report/records.h"
#include "lab/report/table.h"
#include "lab/scene/parts.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

Record row(const std::string& strategy, const std::string& cubes, double spacing, double modulus, double seconds) {
  Record record;
  record.scene = record.title = "block";
  record.variant = {{"body.tetrahedra.cubes", cubes}};
  record.spacing = spacing;
  record.run.strategy = strategy;
  record.run.measures.set("effective_modulus", modulus);
  record.run.solve_seconds = seconds;
  record.main_measures = {{"effective_modulus"}};
  return record;
}

}  // namespace

TEST_CASE("a value is extrapolated with the order that it shows", "[study]") {
  // v = 3 + 0.5 h^1.7, spacings in no order; the exact limit is 3.
  const auto value = [](double h) { return 3 + 0.5 * std::pow(h, 1.7); };
  const Extrapolation found = extrapolate({{0.5, value(0.5)}, {1, value(1)}, {0.2, value(0.2)}});
  CHECK(found.order == Approx(1.7).epsilon(1e-9));
  CHECK(found.value == Approx(3).epsilon(1e-12));
  CHECK(found.uncertainty == Approx(1.25 * 0.5 * std::pow(0.2, 1.7)).epsilon(1e-9));
  // A coarse fourth row that does not follow: the two extrapolations differ, and that is less than the index.
  const Extrapolation four = extrapolate({{2, value(2) + 0.05}, {1, value(1)}, {0.5, value(0.5)}, {0.2, value(0.2)}});
  CHECK(four.value == Approx(found.value));
  CHECK(four.uncertainty > 1e-4);
  CHECK(four.uncertainty < found.uncertainty);
  CHECK_THROWS_WITH(extrapolate({{1, 2}, {0.5, 1}, {0.5, 1}}), Contains("three spacings or more; here are 2"));
  CHECK_THROWS_WITH(extrapolate({{1, 1}, {0.5, 2}, {0.25, 1}}), Contains("do not converge"));
}

TEST_CASE("a limit of few or unruly values knows how little it knows", "[study]") {
  // v = 3 + 0.5 h^1.4: the order is between those of a singular rim and of smooth strain, and so is the limit.
  const auto value = [](double h) { return 3 + 0.5 * std::pow(h, 1.4); };
  const Extrapolation two = limit_of({{1, value(1)}, {0.5, value(0.5)}});
  CHECK(std::isnan(two.order));
  CHECK(std::abs(two.value - 3) <= two.uncertainty);
  CHECK(two.uncertainty == Approx(value(1) - value(0.5)));
  const Extrapolation three = limit_of({{1, value(1)}, {0.5, value(0.5)}, {0.25, value(0.25)}});
  CHECK(three.value == Approx(3).epsilon(1e-12));
  CHECK(three.uncertainty == Approx(value(0.5) - value(0.25) - (value(0.25) - 3)));
  CHECK(three.uncertainty < extrapolate({{1, value(1)}, {0.5, value(0.5)}, {0.25, value(0.25)}}).uncertainty);
  // Four that agree to rounding are no more certain than a tenth of the last correction.
  const Extrapolation four = limit_of({{1, value(1)}, {0.5, value(0.5)}, {0.25, value(0.25)}, {0.125, value(0.125)}});
  CHECK(four.uncertainty == Approx(0.1 * (value(0.125) - 3)));
  const Extrapolation unruly = limit_of({{1, 3.2}, {0.5, 3.0}, {0.25, 3.1}});
  CHECK((unruly.value == 3.1 && std::isnan(unruly.order)));
  CHECK(unruly.uncertainty == Approx(0.3));
  const Extrapolation same = limit_of({{1, 3}, {0.5, 3 + 1e-9}});
  CHECK((same.value == Approx(3).epsilon(1e-8) && same.uncertainty < 1e-6));
  CHECK_THROWS_WITH(limit_of({{1, 3}}), Contains("two spacings"));
}

TEST_CASE("a singular edge that smooth strain hides is within the uncertainty", "[study]") {
  // v = 3 + h³ + b h: three values show an order near 3, and 0.1 h is still to come.
  for (const double b : {-0.3, -0.1, 0.03, 0.1, 0.3}) {
    std::vector<std::pair<double, double>> rows;
    for (double h = 1; h > 0.05; h /= 2) {
      rows.emplace_back(h, 3 + h * h * h + b * h);
      if (rows.size() < 2) continue;
      const Extrapolation found = limit_of(rows);
      INFO(b << ", " << rows.size() << " rows: " << found.value << " ± " << found.uncertainty);
      CHECK(std::abs(found.value - 3) <= found.uncertainty);
    }
  }
}

TEST_CASE("the time to an error is that of the fastest run that has no more", "[study]") {
  // A finer body that was solved faster counts, and a run that failed to come nearer does not hide it.
  const std::vector<std::pair<double, double>> curve{{10, 0.1}, {1000, 0.001}, {700, 0.0005}, {2000, 0.02}};
  CHECK(time_to(curve, 0.01) == 700);
  CHECK(time_to(curve, 0.0005) == 700);
  CHECK(time_to(curve, 0.2) == 10);
  CHECK(std::isnan(time_to(curve, 1e-4)));
  CHECK(std::isnan(time_to({}, 1)));
}

TEST_CASE("rows that differ in the body are one curve; a reference of their own holds for all", "[study]") {
  std::vector<Record> records;
  for (const double h : {1., 0.5, 0.25}) {
    const std::string cubes = "[" + std::to_string(static_cast<int>(4 / h)) + "]";
    records.push_back(row("neo_hookean", cubes, h, 100 + 8 * h * h, 0.01 / (h * h)));
    records.push_back(row("standard", cubes, h, 150, 0.01));
  }
  CHECK(refer_to_own(records, "neo_hookean").empty());
  REQUIRE(records[1].references.size() == 1);
  CHECK(records[1].references[0].value == Approx(100));
  CHECK_THAT(records[1].references[0].source, Contains("own: neo_hookean") && Contains("order 2.00"));
  CHECK(records[1].error("effective_modulus_to_reference") == Approx(0.5));
  const auto curves = curves_of(records);
  REQUIRE(curves.size() == 2);
  CHECK((curves[0].name == "neo_hookean" && curves[0].rows.size() == 3));
  const std::string text = study_text(records, false);
  CHECK_THAT(text, Contains("cubes") && Contains("to 1 %") && Contains("not reached"));
  CHECK(refer_to_own(records, "standard").find("cannot be extrapolated") != std::string::npos);
}

TEST_CASE("a measure that the experiment prescribes has no reference of its own, and nothing to say", "[study]") {
  std::vector<Record> records;
  for (const double h : {1., 0.5, 0.25}) {
    records.push_back(row("neo_hookean", std::to_string(h), h, 100, 0.01));
    records.push_back(row("standard", std::to_string(h), h, 100 * (1 + 1e-12), 0.01));
  }
  CHECK(refer_to_own(records, "neo_hookean").empty());
  for (const Record& record : records) CHECK(record.references.empty());
}

TEST_CASE("bodies of one problem alone are extrapolated together", "[study]") {
  std::vector<Record> records;
  for (const double h : {1., 0.5, 0.25})
    for (const double modulus : {100., 40.}) {  // of two materials, in turn
      records.push_back(row("neo_hookean", std::to_string(4 / h), h, modulus * (1 + 0.08 * h * h), 0.01));
      records.back().variant.emplace_back("material.youngs_modulus", std::to_string(modulus));
      records.back().extent = {1, 1, 2};
    }
  for (const double h : {1., 0.5, 0.25}) {  // and of the first material twice as long
    records.push_back(row("neo_hookean", "[long]" + std::to_string(4 / h), h, 300 + 8 * h, 0.01));
    records.back().variant.emplace_back("material.youngs_modulus", std::to_string(100.));
    records.back().extent = {1, 1, 4};
  }
  CHECK(refer_to_own(records, "neo_hookean").empty());
  for (const Record& record : records) {
    REQUIRE(record.references.size() == 1);
    CHECK(record.references[0].value == Approx(record.extent[2] == 4                                  ? 300
                                               : record.variant.back().second == std::to_string(100.) ? 100
                                                                                                      : 40));
    CHECK_THAT(record.references[0].source, Contains("over 3 spacings"));
  }
  // Two values at one fineness: what the study changes in the body is not its fineness alone.
  for (Record& record : records) record.extent.clear(), record.variant.resize(1), record.references.clear();
  CHECK_THAT(refer_to_own(records, "neo_hookean"),
             Contains("bodies of the same fineness differ in what the study changes"));
  for (const Record& record : records) CHECK(record.references.empty());
}

TEST_CASE("another program's time to an error stands next to Elastin's best", "[study]") {
  std::vector<Record> records;
  for (const double h : {1., 0.5, 0.25})  // errors of 8, 2, 0.5 % at 0.01, 0.04, 0.16 s: 1 % by the last one alone
    records.push_back(row("neo_hookean", "[" + std::to_string(h) + "]", h, 100 + 8 * h * h, 0.01 / (h * h)));
  for (Record& record : records) set_references(record, {{"effective_modulus", 100, "elsewhere", 0}});
  const std::vector<Peer> peers{{records[0].scene, "other", 0.8, 0.005}, {"another scene", "third", 1e-3, 1e-6}};
  const std::string text = time_to_table(records, rank_strategies(records), peers).text(false);
  CHECK_THAT(text,
             Contains("160.0 ms") && !Contains("≤") && Contains("800.0 ms") && Contains("× 5") && Contains("× 1 "));
  CHECK_THAT(text, !Contains("third"));
  CHECK_THAT(time_to_table(records, rank_strategies(records)).text(false), !Contains("best"));
}

TEST_CASE("axes of a study multiply, their keys go together", "[study]") {
  const StudyAxis size =
      read_axis("{body.lattice.molecules: [[3, 3, 3], [5, 5, 5]], body.lattice.spacing: [2 mm, 1 mm]}");
  const StudyAxis solver = read_axis("solver.linear_solver=[pcg, direct]");
  const auto all = combinations({size, solver});
  REQUIRE(all.size() == 4);
  CHECK(all[1] == std::vector<std::pair<std::string, std::string>>{{"body.lattice.molecules", "[3, 3, 3]"},
                                                                   {"body.lattice.spacing", "2 mm"},
                                                                   {"solver.linear_solver", "direct"}});
  CHECK(combinations({}).size() == 1);
  // A row is named by its values, so none of them may be replaced.
  const StudyAxis modulus = read_axis("material.youngs_modulus=[1, 2]"), material = read_axis("material=[{}]");
  CHECK_THROWS_WITH(combinations({modulus, solver, modulus}),
                    Contains("two of --vary and `study` change 'material.youngs_modulus'"));
  CHECK_THROWS_WITH(combinations({modulus, material}),
                    Contains("'material' would replace 'material.youngs_modulus'") && Contains("let it come first"));
  CHECK(combinations({material, modulus, read_axis("material.youngs=[1]")}).size() == 2);
  CHECK_THROWS_WITH(combinations({read_axis("{a: [1, 2], a: [3, 4]}")}), Contains("change 'a'"));
  CHECK_THROWS_WITH(combinations({read_axis("time.integrator=[newmark]"), read_axis("time.stepper=[xpbd]")}),
                    Contains("change 'time.stepper'"));
  CHECK_THROWS_WITH(combinations({modulus}, {"material.youngs_modulus=3"}),
                    Contains("--set material.youngs_modulus=3 changes nothing"));
  CHECK(combinations({modulus}, {"material={youngs_modulus: 1}", "material.youngs=2"}).size() == 2);
  // Nothing runs twice under two names.
  for (const std::string values : {"[5 mm, 5 mm]", "[5 mm, 7 mm, 0.005 m]", "[1.0, 1]", "[pcg, direct, pcg]",
                                   "[{E: 1 kPa, nu: 0.3}, {nu: 0.30, E: 1000 Pa}]", "[[1, 2], [1, 2.0]]"})
    CHECK_THROWS_WITH(read_axis("a=" + values), Contains("are the same") && Contains("leave one of them out"));
  CHECK_THROWS_WITH(read_axis("a=[5 mm, 7 mm, 0.005 m]"),
                    Contains("--vary a=[5 mm, 7 mm, 0.005 m]: a: values 1 and 3 are the same, 5 mm and 0.005 m; "));
  CHECK(read_axis("a=[5 mm, 5 m, 5 kPa, pcg]").values.size() == 4);
  CHECK(read_axis("{a: [1, 1], b: [2, 3]}").values.size() == 2);
  CHECK_THROWS_WITH(read_axis("{a: [1, 2], b: [1]}"), Contains("--vary") && Contains("equally many values: 1 here, 2"));
  CHECK_THROWS_WITH(read_axis("a=1 kPa, 2 kPa"),
                    "--vary a=1 kPa, 2 kPa: a: expected a list, found a single value; "
                    "write [1 kPa, 2 kPa]");
  CHECK_THROWS_WITH(read_axis("pcg"), Contains("write KEY.PATH=[value"));
}

TEST_CASE("a row comes back from its line of JSON", "[study]") {
  Record record = row("lattice", "[2]", 0.5, 5e3, 0.25);
  record.repeats = {{0.1, 0.3}, {0.05, 0.25}, {0.2, 0.4}};
  record.references = {{"effective_modulus", 5.1e3, "elsewhere", 1e-3}};
  record.errors = {{"effective_modulus", 0.01}};
  record.warnings = {"a \"warning\"\nof two lines"};
  record.run.outcome = Outcome::limit_reached;
  record.run.cause = "<why>";
  record.run.zero_energy_modes = 12;
  record.run.curve.resize(2);
  record.run.curve[1].load_factor = 1;
  record.run.curve[1].measures.set("stress", 7);
  Verdict verdict;
  verdict.strategy = "lattice";
  verdict.expectation = {"lattice", "effective_modulus", "", "", 5e3, 0.01, 0, "book", ""};
  verdict.passed = true;
  verdict.measured = 5e3;
  record.verdicts = {verdict};
  // What the table and the page of a resumed comparison show as well.
  record.run.warnings = {"mechanism: 12 zero-energy modes"};
  record.run.constants = VectorX::Constant(1, -3.5);
  record.neighbours = {5.5, 4};
  record.path = "a/b.yaml";
  record.apparent = true;
  record.no_reference = "the body is no prism";
  record.run.order = 7;
  record.run.measures.stiffness_matrix = Stiffness6::Random();
  record.run.identified = Identified{{1e3, -2e3, 5e2}, {1, 2, 3}, 0.8, 0.004, 52};
  record.run.curve[1].newton_iterations = 4;
  record.run.curve[1].linear_iterations = 40;
  record.run.curve[1].residual = 1e-11;
  record.run.time = TimeReport{};
  record.run.time->stepper = "newmark";
  record.run.time->reason = "cells";
  record.run.time->frequency = 3600;
  record.run.time->seconds = 2;
  record.run.time->resumed = true;
  record.run.curve[1].time = 0.5;
  record.run.curve[1].steps = 17;
  const std::string line = json_line(record);
  CHECK(line.find('\n') == std::string::npos);
  const Record back = record_of_json(line);
  CHECK(json_line(back) == line);
  CHECK(back.median_seconds() == Approx(0.4));
  CHECK(back.run.outcome == Outcome::limit_reached);
  CHECK(back.run.curve[1].measures.get("stress") == 7);
  CHECK(*back.run.measures.stiffness_matrix == *record.run.measures.stiffness_matrix);
  CHECK(back.run.identified->standard_errors == record.run.identified->standard_errors);
  CHECK(back.run.identified->modulus(0.5) == record.run.identified->modulus(0.5));
  CHECK(back.run.constants == record.run.constants);
  CHECK((back.run.time->frequency == 3600 && back.run.time->reason == "cells" && back.run.time->resumed));
  CHECK((back.run.curve[1].newton_iterations == 4 && back.run.curve[1].steps == 17));
  CHECK((back.apparent && back.no_reference == "the body is no prism" && back.run.order == 7));
  CHECK((back.neighbours.mean == 5.5 && back.neighbours.least == 4 && back.path == "a/b.yaml"));
  CHECK((back.verdicts[0].expectation.relative == 0.01 && back.verdicts[0].strategy == "lattice"));
  // Every word that is printed of it is the same, and so is the JSON for others.
  CHECK(run_text(back, false) == run_text(record, false));
  CHECK(comparison_text({back}, false) == comparison_text({record}, false));
  CHECK(json_text({back}) == json_text({record}));
  CHECK(json_text({record}).find("least_constant") == std::string::npos);
  CHECK_THROWS_WITH(record_of_json("{\"scene\": 3}"), Contains("not an Elastin run record"));
}
