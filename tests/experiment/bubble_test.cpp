#include "experiment/bubble.h"

#include <catch2/catch.hpp>

#include "elastin/base/error.h"
#include "elastin/model/surfaces.h"
#include "experiments.h"
#include "membrane_ode.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

constexpr double kRadius = 0.0375, kThickness = 0.00035;

Specimen disc_specimen(int rings, double E, double nu) {
  Specimen specimen;
  specimen.material = {.youngs_modulus = E, .poissons_ratio = nu, .thickness = kThickness};
  specimen.body = disc(kRadius, rings);
  set_matter(specimen.body, kRadius / rings / 2, 1000, kThickness, 0);
  return specimen;
}

Run blow_up(int rings, double E, double nu, const std::string& strategy, const std::vector<double>& pressures) {
  const Specimen specimen = disc_specimen(rings, E, nu);
  const auto bubble = make_bubble(specimen.body, {pressures, {}}, specimen.material);
  return solve(specimen, *bubble, strategy);
}

MembraneLaw engineering_law(double E, double nu) {
  return [=](double along, double around) -> std::array<double, 2> {
    const double plane = E * kThickness / (1 - nu * nu);
    return {plane * (along - 1 + nu * (around - 1)), plane * (around - 1 + nu * (along - 1))};
  };
}
MembraneLaw rubber_law(double mu) {
  return [=](double along, double around) -> std::array<double, 2> {
    return {mu * kThickness * (along - 1 / (std::pow(along, 3) * around * around)),
            mu * kThickness * (around - 1 / (std::pow(around, 3) * along * along))};
  };
}

struct Case {
  std::string strategy;
  double E, nu;
  MembraneLaw law;
  std::array<double, 3> heights;  ///< of independent solutions [m]
};
const std::vector<double> kPressures{5000, 7300, 8940};
const std::vector<Case> kCases{
    {"neo_hookean_membrane", 1.8e6, 0.5, rubber_law(0.6e6), {0.01865939, 0.02383317, 0.02887066}},
    {"curve_membrane", 1.8e6, 0.45, engineering_law(1.8e6, 0.45), {0.01699837, 0.02000757, 0.02197219}}};

}  // namespace

TEST_CASE("the shooting solution meets heights computed elsewhere", "[bubble]") {
  for (const Case& c : kCases)
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(solve_bubble(c.law, kRadius, kPressures[i], 200).height == Approx(c.heights[i]).epsilon(2e-6));
}

TEST_CASE("a bubble's height, pole stretch and pole stress converge to the shooting solution", "[bubble]") {
  const OneThread one;
  for (const Case& c : kCases) {
    std::array<Run, 3> runs;
    for (std::size_t i = 0; i < 3; ++i)
      runs[i] = blow_up(8 << i, c.E, c.nu, c.strategy, kPressures);  // 8, 16, 32 rings
    for (std::size_t step = 0; step < 3; ++step) {
      INFO(c.strategy << " at " << kPressures[step] << " Pa");
      const auto at = [&](const char* name) {
        Refinement values;
        for (std::size_t i = 0; i < 3; ++i) values[i] = runs[i].curve[step].measures.get(name);
        return values;
      };
      const BubbleSolution exact = solve_bubble(c.law, kRadius, kPressures[step], 200);
      const Refinement height = at("height");
      CHECK(height[2] == Approx(exact.height).epsilon(1e-3));
      CHECK(order_of(height) > 1.6);
      CHECK(order_of(height) < 2.4);
      CHECK(limit_of(height) == Approx(exact.height).epsilon(1e-4));
      CHECK(at("pole_stretch")[2] == Approx(exact.stretch).epsilon(1e-3));
      CHECK(at("pole_stress")[2] == Approx(exact.tension / kThickness).epsilon(1e-3));
      // Balance at the pole: the true tension N/λ is p R/2, R the radius of curvature.
      CHECK(at("pole_radius")[2] == Approx(2 * exact.tension / exact.stretch / kPressures[step]).epsilon(1e-3));
    }
  }
}

TEST_CASE("a bubble's measures as a spherical cap", "[bubble][TP]") {
  const Run run = blow_up(6, 1.8e6, 0.45, "two_parameter", {8940});
  const double h = run.measures.get("height"), a = kRadius, R = (a * a + h * h) / (2 * h);
  CHECK(run.measures.get("cap_radius") == Approx(R));
  const double stretch = R / a * std::asin(a / R);  // the cap is less than a half sphere
  CHECK(run.measures.get("stretch") == Approx(stretch));
  CHECK(run.measures.get("strain") == Approx(stretch - 1));
  CHECK(run.measures.get("stress") == Approx(8940 * R / (2 * kThickness / (stretch * stretch))));
  CHECK(run.measures.get("pressure") == 8940);
  CHECK(run.measures.get("reaction_balance") < 1e-8);
}

TEST_CASE("a bubble turns with its disc, and wants one that is flat and round", "[bubble]") {
  Specimen specimen = disc_specimen(5, 1.8e6, 0.4);
  const Matrix3 turn = Eigen::AngleAxisd(2.1, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  rotate(specimen.body, turn);
  const auto bubble = make_bubble(specimen.body, {{4000}, {}}, specimen.material);
  const double turned = solve(specimen, *bubble, "hencky_membrane").measures.get("height");
  CHECK(turned == Approx(blow_up(5, 1.8e6, 0.4, "hencky_membrane", {4000}).measures.get("height")).epsilon(1e-8));

  Body bent = disc(1, 4), square = rectangular_sheet({1, 1}, {4, 4}, SheetPattern::alternating),
       closed = sphere(1, SphereMesh::icosahedron, 2);
  bent.rest(2, 0) += 0.1;
  CHECK_THROWS_WITH(make_bubble(bent, {{1}, {}}, specimen.material), Catch::Contains("flat"));
  CHECK_THROWS_WITH(make_bubble(square, {{1}, {}}, specimen.material), Catch::Contains("no circle"));
  CHECK_THROWS_WITH(make_bubble(closed, {{1}, {}}, specimen.material), Catch::Contains("rim"));
}
