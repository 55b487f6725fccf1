#include "lab/study/study.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "elastin/core/simulation/catalog.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

Plot plot_of(const LawConstants& constants, double stretch) {
  const Catalog catalog = built_in_catalog();
  const auto law = catalog.material_laws.find(constants.law);
  return material_plot("rubber", *law, with_law(*law, constants), stretch);
}

}  // namespace

TEST_CASE("the curves of a material: four tests, in the legend once each", "[plot]") {
  const Plot plot = plot_of({.law = "mooney_rivlin", .numbers = {{"c1", 1500}, {"c2", 400}}}, 2);
  std::set<std::string> names;
  for (const PlotSeries& series : plot.series) {
    CHECK(series.kind == PlotSeries::Kind::line);  // stable everywhere
    if (!series.name.empty()) CHECK(names.insert(series.name).second);
    for (const PlotPoint& point : series.points)
      if (point.text == "uniaxial") {
        const double l = 1 + point.x;  // closed form [Treloar 1975]
        CHECK(point.y == Approx(2 * (l - 1 / (l * l)) * (1500 + 400 / l)).epsilon(1e-8).margin(1e-9));
      }
  }
  CHECK(names == std::set<std::string>{"uniaxial", "planar", "equibiaxial", "shear"});
  CHECK(plot.series.front().points.back().x == Approx(1));
  CHECK(plot.title == "rubber");
}

TEST_CASE("where a material is unstable its curve is dashed", "[plot]") {
  const Plot plot = plot_of({.law = "yeoh", .terms = {{1000}, {-150}}}, 2.5);
  int dashed = 0;
  for (const PlotSeries& series : plot.series)
    if (series.kind == PlotSeries::Kind::dashed) {
      ++dashed;
      CHECK(std::abs(series.points.front().x) > 0.2);
    }
  CHECK(dashed >= 3);
  CHECK(plot.title.find("unstable (Drucker)") != std::string::npos);
}

TEST_CASE("the curves of a material with fibres go along them", "[plot]") {
  const LawConstants x{.law = "transversely_isotropic",
                       .numbers = {{"c1", 1e3}, {"c4", 20}, {"c5", 1e5}, {"lambda_max", 1.1}},
                       .directions = {{"direction", Vector3::UnitX()}}};
  LawConstants askew = x;
  askew.directions["direction"] = Vector3(1, 2, 2) / 3;
  const Plot one = plot_of(x, 1.3), other = plot_of(askew, 1.3);
  REQUIRE(one.series.size() == other.series.size());
  CHECK(one.series[0].points.back().y > 1e4);  // 2 kPa of the matrix
  CHECK(one.series[0].points.back().y == Approx(other.series[0].points.back().y).epsilon(1e-9));
}
