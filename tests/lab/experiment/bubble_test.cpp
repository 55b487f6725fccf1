#include "lab/experiment/bubble/bubble.h"

#include <catch2/catch.hpp>
#include <random>

#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "lab/report/records.h"
#include "support/experiments.h"
#include "support/membrane_ode.h"

using namespace elastin;
using namespace elastin::lab;
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

testing::MembraneLaw engineering_law(double E, double nu) {
  return [=](double along, double around) -> std::array<double, 2> {
    const double plane = E * kThickness / (1 - nu * nu);
    return {plane * (along - 1 + nu * (around - 1)), plane * (around - 1 + nu * (along - 1))};
  };
}
testing::MembraneLaw rubber_law(double mu) {
  return [=](double along, double around) -> std::array<double, 2> {
    return {mu * kThickness * (along - 1 / (std::pow(along, 3) * around * around)),
            mu * kThickness * (around - 1 / (std::pow(around, 3) * along * along))};
  };
}

struct Case {
  std::string strategy;
  double E, nu;
  testing::MembraneLaw law;
  std::array<double, 3> heights;  ///< of independent solutions [m]
};
const std::vector<double> kPressures{5000, 7300, 8940};
const std::vector<Case> kCases{
    {"neo_hookean_membrane", 1.8e6, 0.5, rubber_law(0.6e6), {0.01865939, 0.02383317, 0.02887066}},
    {"curve_membrane", 1.8e6, 0.45, engineering_law(1.8e6, 0.45), {0.01699837, 0.02000757, 0.02197219}}};

}  // namespace

TEST_CASE("the shooting solution meets heights computed elsewhere", "[bubble][slow]") {
  for (const Case& c : kCases)
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(solve_bubble(c.law, kRadius, kPressures[i], 200).height == Approx(c.heights[i]).epsilon(2e-6));
}

TEST_CASE("a bubble's height, pole stretch and pole stress converge to the shooting solution", "[bubble][slow]") {
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
  CHECK(std::isnan(run.measures.get("energy")));  // this law has none
  CHECK(blow_up(6, 1.8e6, 0.45, "curve_membrane", {8940}).measures.get("energy") > 0);
}

namespace {

/// Latex-like: a secant modulus that falls with the size of the strain, E(q) = 1.8 MPa (1 − 0.9 q + 0.6 q²).
double latex(double q) { return 1.8e6 * (1 - 0.9 * q + 0.6 * q * q); }
constexpr double kNu = 0.45;

/// Heights [m] of a bubble of that latex as the differential equation has them, times 1 + noise · (a number of standard
/// deviation about 1).
BubbleSetup measured_latex(double noise) {
  const testing::MembraneLaw law = [](double along, double around) -> std::array<double, 2> {
    const double x = along - 1, y = around - 1;
    const double q = std::sqrt(0.5 / (1 - kNu) * (x + y) * (x + y) + 0.5 / (1 + kNu) * (x - y) * (x - y));
    const double plane = latex(q) * kThickness / (1 - kNu * kNu);
    return {plane * (x + kNu * y), plane * (y + kNu * x)};
  };
  std::mt19937_64 generator(8);
  BubbleSetup setup;
  for (int i = 1; i <= 12; ++i) {
    double normal = -6;  // of twelve even numbers
    for (int k = 0; k < 12; ++k) normal += static_cast<double>(generator() >> 11) * 0x1p-53;
    setup.pressures.push_back(750 * i);
    setup.heights.push_back(solve_bubble(law, kRadius, 750 * i, 60).height * (1 + noise * normal));
  }
  setup.identify_degree = 2;
  setup.identify_up_to = 0.68;  // what the pole comes to at the last pressure
  return setup;
}

Run identify(const BubbleSetup& setup, int rings, const std::string& strategy = "curve_membrane") {
  const Specimen specimen = disc_specimen(rings, 1e6, kNu);  // E is no more than a start
  const auto bubble = make_bubble(specimen.body, setup, specimen.material);
  return solve(specimen, *bubble, strategy);
}

}  // namespace

TEST_CASE("E(strain) is found again from the heights that it makes, noise or none", "[bubble][identification][slow]") {
  const OneThread one;
  for (const auto& [noise, rings, tolerance] : {std::tuple{0., 10, 0.01}, {0.005, 6, 0.06}}) {
    const Run run = identify(measured_latex(noise), rings);
    REQUIRE(run.identified);
    INFO(noise << ": misfit " << run.identified->misfit << ", load curves " << run.identified->evaluations);
    CHECK(run.identified->polynomial.size() == 3);
    for (const double strain : {0.1, 0.35, 0.6}) {
      INFO(strain << ": " << run.identified->modulus(strain) << " for " << latex(strain));
      CHECK(run.identified->modulus(strain) == Approx(latex(strain)).epsilon(tolerance));
    }
    // Simulated again with the law found: what is left is the noise, and what the mesh is off.
    CHECK(run.identified->misfit < 1.2 * noise + 0.001);
    CHECK(run.identified->misfit > 0.6 * noise);
    CHECK(run.measures.get("identified_misfit") == run.identified->misfit);
    double squares = 0;
    for (const CurvePoint& point : run.curve) squares += std::pow(point.measures.get("height_misfit"), 2);
    CHECK(std::sqrt(squares / 12) == Approx(run.identified->misfit).epsilon(1e-4));
  }
}

TEST_CASE("what cannot be identified is said", "[bubble][identification]") {
  const Catalog catalog = built_in_catalog();
  BubbleSetup setup = measured_latex(0);
  const Specimen specimen = disc_specimen(4, 1e6, kNu);
  const auto bubble = make_bubble(specimen.body, setup, specimen.material);
  const Run stiff = run_strategy(specimen, *bubble, choose_strategy(catalog, "hencky_energy_membrane"), {});
  CHECK_FALSE(stiff.suited);
  CHECK_THAT(stiff.cause, Catch::Contains("does not follow a material's curve"));
  setup.pressures.resize(2), setup.heights.resize(2);
  const auto few = make_bubble(specimen.body, setup, specimen.material);
  const Run unsettled = run_strategy(specimen, *few, choose_strategy(catalog, "curve_membrane"), {});
  CHECK(unsettled.outcome == Outcome::limit_reached);
  CHECK_THAT(unsettled.cause, Catch::Contains("2 measured values do not settle 3 coefficients"));
}

TEST_CASE("the scenes of bubbles hold what they expect", "[bubble][scene][slow]") {
  const Catalog catalog = built_in_catalog();
  const OneThread one;
  int judged = 0;
  for (const std::string name : {"bubble-rubber", "bubble-engineering", "bubble-latex", "bubble-identify"}) {
    const auto scene = load_scene(std::string(ELASTIN_SOURCE_DIR) + "/scenes/membrane/" + name + ".yaml", catalog);
    const Record record = make_record(
        *scene, run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics}));
    for (const Verdict& verdict : record.verdicts) {
      INFO(name << " " << verdict.expectation.measure << ": " << verdict.measured << " for "
                << verdict.expectation.value);
      ++judged;
      CHECK(verdict.passed);
    }
  }
  CHECK(judged >= 12);
}

TEST_CASE("a bubble turns with its disc, and wants one that is flat and round", "[bubble]") {
  Specimen specimen = disc_specimen(5, 1.8e6, 0.4);
  const Matrix3 turn = Eigen::AngleAxisd(2.1, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  rotate(specimen.body, turn);
  const auto bubble = make_bubble(specimen.body, {{4000}, {}}, specimen.material);
  const double turned = solve(specimen, *bubble, "hencky_energy_membrane").measures.get("height");
  CHECK(turned ==
        Approx(blow_up(5, 1.8e6, 0.4, "hencky_energy_membrane", {4000}).measures.get("height")).epsilon(1e-8));

  Body bent = disc(1, 4), square = rectangular_sheet({1, 1}, {4, 4}, SheetPattern::alternating),
       closed = sphere(1, SphereMesh::icosahedron, 2);
  bent.rest(2, 0) += 0.1;
  CHECK_THROWS_WITH(make_bubble(bent, {{1}, {}}, specimen.material), Catch::Contains("flat"));
  CHECK_THROWS_WITH(make_bubble(square, {{1}, {}}, specimen.material), Catch::Contains("no circle"));
  CHECK_THROWS_WITH(make_bubble(closed, {{1}, {}}, specimen.material), Catch::Contains("rim"));
}
