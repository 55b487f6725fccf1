#include "lab/report/comparison.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>
#include <vector>

using namespace elastin;
using namespace elastin::lab;

namespace {

Record run_of(const std::string& strategy, std::vector<std::pair<std::string, std::string>> variant = {}) {
  Record record;
  record.scene = record.title = "block";
  record.run.strategy = strategy;
  record.variant = std::move(variant);
  record.main_measures = {{"effective_modulus"}};
  return record;
}

std::shared_ptr<const MeasureList> measures_of_scene(const std::string& name) {
  return load_scene(ELASTIN_SOURCE_DIR "/scenes/dynamics/" + name + ".yaml", built_in_catalog())->measures;
}

}  // namespace

TEST_CASE("strategies of one family have shades of one hue, and none looks like another", "[figures]") {
  std::vector<Record> records;
  for (const char* stem : {"standard", "divided", "angles", "statistical", "lloyd", "lattice", "patch", "neo_hookean"})
    for (const char* kind : {"", "calibrated:"})
      for (const char* volume : {"", "+volume"}) records.push_back(run_of(std::string(kind) + stem + volume));
  const auto colours = strategy_colours(records);
  CHECK(colours.size() == 32);
  std::set<std::string> seen;
  for (const auto& [name, colour] : colours) seen.insert(plot_colour(colour));
  CHECK(seen.size() == 32);
  const int hue = colours.at("lattice");
  CHECK(colours.at("calibrated:lattice") == hue + kPlotHues);
  CHECK(colours.at("lattice+volume") == hue + 2 * kPlotHues);
}

TEST_CASE("a study draws its measure and signed error over the parameter in SI units", "[figures]") {
  std::vector<Record> records;
  for (const char* strategy : {"standard", "lattice"})
    for (const auto& [text, modulus] : {std::pair{"2 kPa", 2100.}, {"0.001 MPa", 950.}, {"4 kPa", 4000.}}) {
      Record record = run_of(strategy, {{"material.youngs_modulus", text}});
      record.run.measures.set("effective_modulus", modulus);
      record.errors = {{"effective_modulus", modulus < 1000 ? -0.05 : 0.05}};
      records.push_back(record);
    }
  Ranking ranking;
  ranking.measures = {"effective_modulus"};
  const auto plots = parameter_plots(records, ranking, strategy_colours(records));
  REQUIRE(plots.size() == 2);
  for (const Plot& plot : plots) {
    CHECK(plot.x.unit == "Pa");
    REQUIRE(plot.series.size() == 2);
    REQUIRE(plot.series[0].points.size() == 3);
    for (int i = 0; i < 3; ++i) CHECK(plot.series[0].points[i].x == Approx(1000 * (1 << i)));
  }
  CHECK(plots[0].series[0].points[0].y == 950);
  CHECK(plots[1].series[0].points[0].y == -0.05);
  CHECK(plots[1].y.unit == "%");
  std::set<int> own;
  for (const Plot plot = response_plot(records, strategy_colours(records)); const PlotSeries& series : plot.series)
    own.insert(series.colour);
  CHECK(own.size() == response_plot(records, strategy_colours(records)).series.size());
}

TEST_CASE("lists under a key count as the body's molecules", "[figures]") {
  std::vector<Record> records;
  for (const int n : {3, 5, 9}) {
    Record record = run_of("lattice", {{"body.lattice.molecules", "[" + std::to_string(n) + ", 3, 3]"},
                                       {"body.lattice.spacing", std::to_string(9. / n) + " mm"}});
    record.molecules = 9 * n;
    record.run.measures.set("effective_modulus", 1000. / n);
    records.push_back(record);
  }
  const auto plots = parameter_plots(records, {}, strategy_colours(records));
  REQUIRE(plots.size() == 1);  // the spacing changes with the molecules: it is no parameter of its own
  CHECK(plots[0].x.title == "molecules");
  REQUIRE(plots[0].series.size() == 1);
  CHECK(plots[0].series[0].points[1].x == 45);
}

TEST_CASE("cyclic loading shows the loop of stress and strain", "[figures]") {
  Record record = run_of("prony:lattice");
  record.measures = measures_of_scene("cyclic");
  record.run.time.emplace();
  for (int i = 0; i <= 40; ++i) {
    CurvePoint point;
    point.time = 0.05 * i;
    point.measures.set("elongation", 1e-3 * std::sin(point.time));
    point.measures.set("strain", 0.1 * std::sin(point.time));
    point.measures.set("stress", 100 * std::sin(point.time + 0.3));
    record.run.curve.push_back(point);
  }
  const Plot plot = response_plot({record}, strategy_colours({record}));
  REQUIRE(plot.series.size() == 1);
  REQUIRE(plot.series[0].points.size() == 41);
  CHECK(plot.x.title == "strain");
  CHECK(plot.series[0].points[10].x == Approx(0.1 * std::sin(0.5)));
  CHECK(plot.series[0].points[10].y == Approx(100 * std::sin(0.8)));
  CHECK(plot.y.title == "nominal stress");
  const auto colours = strategy_colours({record});
  CHECK(response_plot({record}, colours, 1).series.empty());  // no force yet
  for (CurvePoint& point : record.run.curve) point.measures.set("force", 2 * point.measures.get("stress"));
  const Plot force = response_plot({record}, colours, 1);
  CHECK(force.x.title == "elongation");
  CHECK(force.y.title == "force");
  CHECK(response_plot({record}, colours, 2).series.empty());
}

TEST_CASE("relaxation shows the force, over the logarithm of time where it spans decades", "[figures]") {
  const auto plot_of = [](double factor) {
    Record record = run_of("prony:lattice");
    record.measures = measures_of_scene("relaxation");
    record.run.time.emplace();
    for (double time = 1; record.run.curve.size() < 20; time = factor > 1 ? factor * time : time + 1) {
      CurvePoint point;
      point.time = record.run.curve.empty() ? 0 : time;
      point.measures.set("elongation", 1e-3);
      point.measures.set("force", 1 / (1 + point.time));
      record.run.curve.push_back(point);
    }
    return response_plot({record}, strategy_colours({record}));
  };
  for (const double factor : {1., 2.}) {
    const Plot plot = plot_of(factor);
    REQUIRE(plot.series.size() == 1);
    CHECK(plot.series[0].points[4].y == Approx(1 / (1 + plot.series[0].points[4].x)));
    CHECK(plot.x.logarithmic == (factor > 1));
  }
}
