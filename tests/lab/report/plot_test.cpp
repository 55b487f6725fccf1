#include "lab/report/plot.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <pugixml.hpp>
#include <string>

#include "elastin/core/base/error.h"
#include "lab/format/csv.h"
#include "lab/report/comparison.h"
#include "lab/study/study.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

/// Places of the marks of a plot, in px.
std::vector<std::pair<double, double>> marks_of(const std::string& svg) {
  pugi::xml_document document;
  REQUIRE(document.load_string(svg.c_str()));
  std::vector<std::pair<double, double>> marks;
  for (const auto& found : document.select_nodes("//g[@class='mark']/circle"))
    marks.emplace_back(found.node().attribute("cx").as_double(), found.node().attribute("cy").as_double());
  return marks;
}

Plot logarithmic(std::vector<PlotPoint> points) {
  Plot plot;
  plot.title = "<&\"'>";
  plot.x = {"time", "s", true};
  plot.y = {"error", "%", true};
  plot.series = {{"a<b", 0, PlotSeries::Kind::marked_line, std::move(points)}};
  return plot;
}

}  // namespace

TEST_CASE("equal ratios are equal distances on logarithmic axes", "[plot]") {
  const Plot plot = logarithmic({{1e-3, 1e-1, "p"}, {1e-2, 1e-2, "q"}, {1, 1e-4, "r"}});
  for (const bool alone : {false, true}) {
    const auto marks = marks_of(svg_text(plot, 600, alone));
    REQUIRE(marks.size() == 3);
    CHECK(marks[2].first - marks[1].first == Approx(2 * (marks[1].first - marks[0].first)).margin(0.3));
    CHECK(marks[2].second - marks[1].second == Approx(2 * (marks[1].second - marks[0].second)).margin(0.3));
    CHECK(marks[0].second < marks[2].second);  // larger errors lie higher
  }
  CHECK_THAT(svg_text(plot, 600, true), Contains(">1 ms<") && Contains(">0.01 %<") && Contains("a&lt;b"));
}

TEST_CASE("long labels of ticks stay on the paper", "[plot]") {
  Plot plot = logarithmic({{1e-3, 1e-7, "p"}, {1e-2, 1, "q"}});  // from 0.00001 %
  plot.x = {"strain", "%", false};
  plot.series[0].points = {{0, 1e-7, "p"}, {2.4e-5, 1, "q"}};  // to 0.0025 %
  constexpr double width = 360, letter = 6.5;                  // px: digits of sans-serif at 12 px
  pugi::xml_document document;
  const std::string svg = svg_text(plot, width, false);
  REQUIRE(document.load_string(svg.c_str()));
  CHECK_THAT(svg, Contains(">0.00001 %<") && Contains(">0.0025 %<"));
  for (const auto& found : document.select_nodes("//svg/text")) {
    const std::string text = found.node().text().get(), anchor = found.node().attribute("text-anchor").value();
    const double x = found.node().attribute("x").as_double(), size = letter * static_cast<double>(text.size());
    CAPTURE(text, x, anchor);
    CHECK(x - (anchor == "end" ? size : anchor == "middle" ? size / 2 : 0) >= 0);
    CHECK(x + (anchor == "end" ? 0 : anchor == "middle" ? size / 2 : size) <= width);
  }
}

TEST_CASE("a target is dashed on top of a curve that follows it, and in the legend", "[plot]") {
  Plot plot;
  plot.x = {"strain", "%"};
  plot.y = {"stress", "Pa"};
  const std::vector<PlotPoint> points{{0, 0, ""}, {0.1, 1000, ""}};
  plot.series = {{"neo_hookean", 0, PlotSeries::Kind::marked_line, points},
                 {"target", -1, PlotSeries::Kind::dashed, points}};
  pugi::xml_document document;
  REQUIRE(document.load_string(svg_text(plot, 600, false).c_str()));
  const auto series = document.select_nodes("//g[@class='series']/path");
  REQUIRE(series.size() == 2);
  const pugi::xml_node line = series[1].node();  // drawn last
  CHECK(std::string(line.attribute("d").value()) == series[0].node().attribute("d").value());
  CHECK(line.attribute("stroke-dasharray"));
  CHECK(std::string(line.attribute("stroke").value()) == "var(--ink)");
  const pugi::xml_node key = document.select_node("//g[@class='key'][@data-series='target']/path").node();
  CHECK(std::string(key.attribute("stroke-dasharray").value()) == line.attribute("stroke-dasharray").value());
}

TEST_CASE("what cannot be drawn is left out", "[plot]") {
  const Plot plot =
      logarithmic({{1, 0.1, "p"}, {0, 0.1, "zero"}, {1, NAN, "nan"}, {INFINITY, 1, "inf"}, {-1, 1, "minus"}});
  const std::string svg = svg_text(plot, 400, false);
  CHECK(marks_of(svg).size() == 1);
  CHECK_THAT(svg, !Contains("nan") && !Contains("inf"));
  CHECK(marks_of(svg_text(logarithmic({}), 400, true)).empty());  // well-formed without any point
}

TEST_CASE("columns of a CSV file become a plot, and other programs' rows peers", "[plot]") {
  const TemporaryFolder folder;
  const std::string good =
      folder.write("good.csv", "case,method,minimum_s,error\nx,\"a, b\",0.1,0.5\nx,c,,0.2\nx,c,0.3,1e-3\n");
  CHECK(marks_of(svg_text(csv_plot(good, "minimum_s", "error"), 700, true)).size() == 2);
  const auto peers = load_peers(good);
  REQUIRE(peers.size() == 2);
  CHECK((peers[0].name == "a, b" && peers[0].error == 0.5 && peers[1].seconds == 0.3));
  CHECK_THROWS_WITH(csv_plot(good, "minimum", "error"),
                    Contains("good.csv:1: no column 'minimum'; did you mean 'minimum_s'?"));
  CHECK_THROWS_WITH(load_csv(folder.write("short.csv", "a,b\n1\n")),
                    Contains("short.csv:2:1: 1 fields; the head has 2"));
  CHECK_THROWS_WITH(load_peers(folder.write("word.csv", "method,minimum_s,error\nx,soon,1\n")),
                    Contains("word.csv:2:3: minimum_s: 'soon' is no number"));
  CHECK_THROWS_WITH(
      load_peers(folder.write("late.csv", "# by me\nmethod,minimum_s,error\n\"a, \"\"b\n\"\"c\",1,2\nx,1,0.1,\n")),
      Contains("late.csv:5:5: 4 fields; the head has 3"));
  CHECK_THROWS_WITH(load_peers(folder.write("quoted.csv", "method,minimum_s,error\n\"a, \"\"b\n\"\"c\",1,O.2\n")),
                    Contains("quoted.csv:3:8: error: 'O.2' is no number"));
  CHECK_THROWS_WITH(load_peers(folder.write("head.csv", "method,minimum,error\nx,1,0.1\n")),
                    Contains("head.csv:1:1: no column 'minimum_s'; did you mean 'minimum'?"));
  CHECK_THROWS_WITH(load_csv(folder.path("none.csv")), Contains("none.csv: cannot be read"));
}

TEST_CASE("a curve at rest begins without the load, and has a gap where a number is missing", "[plot]") {
  const TemporaryFolder folder;
  const auto line_of = [](const Plot& plot) {
    const std::string svg = svg_text(plot, 700, true);
    const std::size_t begin = svg.find(" d=\"", svg.find("class=\"line\"")) + 4;
    return svg.substr(begin, svg.find('"', begin) - begin);
  };
  const std::string one = folder.write("one-curve.csv", "load_factor,strain,stress [Pa]\n1,0.1,50\n");
  const Plot plot = csv_plot(one, "", "");
  REQUIRE(plot.series.size() == 1);
  REQUIRE(plot.series[0].points.size() == 2);
  CHECK((plot.series[0].points[0].x == 0 && plot.series[0].points[0].y == 0));
  CHECK(csv_plot(one, "stress", "strain").series[0].points.size() == 1);  // of other columns nothing is known
  const std::string history = folder.write("history.csv", "time [s],strain,stress [Pa]\n1,0.1,50\n");
  CHECK(csv_plot(history, "strain", "stress").series[0].points.size() == 1);
  const Plot gap = csv_plot(folder.write("gap.csv", "a,b\n1,1\n2,2\n3,\n4,4\n5,5\n"), "a", "b");
  const std::string line = line_of(gap);
  CHECK((std::count(line.begin(), line.end(), 'M') == 2 && std::count(line.begin(), line.end(), 'L') == 2));
}

TEST_CASE("long titles and names stay in the picture", "[plot]") {
  std::vector<std::pair<std::string, Plot>> plots;
  for (const char* name : {"a", "b", "c", "d", "e", "f"}) {
    Plot plot;
    plot.title = std::string("cube-27-face-angles+volume-") + name + "-curve.csv";
    plot.series = {{"", 0, PlotSeries::Kind::marked_line, {{0, 0, ""}, {1, 1, ""}}}};
    plots.emplace_back("out/é" + std::string(200, 'x') + name + "-curve.csv", std::move(plot));
  }
  pugi::xml_document document;
  const std::string svg = svg_text(overlaid(plots), 760, true);
  REQUIRE(document.load_string(svg.c_str()));
  int lines = 0, keys = 0;
  for (const auto& node : document.select_nodes("//text[@class='head']")) {
    CHECK(std::string(node.node().text().get()).size() * 9.1 < 760);
    ++lines;
  }
  for (const auto& node : document.select_nodes("//g[@class='key']/text")) {
    const std::string name = node.node().text().get();
    CHECK(node.node().attribute("x").as_double() + 7.3 * static_cast<double>(name.size() - 2) < 760);
    CHECK((name.starts_with("…x") && name.ends_with("-curve.csv")));
    ++keys;
  }
  CHECK((lines > 2 && keys == 6));
}
