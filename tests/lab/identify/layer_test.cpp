// Indenters in layers: closed forms, series of others, and forces of bodies of cells.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/base/random.h"
#include "lab/identify/identify.h"
#include "lab/identify/layer.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("a thick layer is a half-space: Hertz's sphere, Sneddon's cone and punch", "[identify][layer]") {
  for (const double thickness : {kInfinite, 1e3}) {
    const auto force = [&](Indenter indenter, double size, double depth) {
      return IndentedLayer(indenter, size, thickness, LayerBottom::bonded, 0.4).force(depth);
    };
    CHECK(force(Indenter::sphere, 2e-3, 1e-5) == Approx(4. / 3 * std::sqrt(2e-3) * std::pow(1e-5, 1.5)).epsilon(1e-5));
    CHECK(force(Indenter::cone, 0.6, 1e-5) == Approx(2 / std::numbers::pi * std::tan(0.6) * 1e-10).epsilon(1e-5));
    CHECK(force(Indenter::flat, 2e-3, 1e-5) == Approx(2 * 2e-3 * 1e-5).epsilon(1e-5));
    CHECK(force(Indenter::flat, 2e-3, -1e-5) == 0);
  }
}

TEST_CASE("layers are as stiff as their series begin", "[identify][layer]") {
  const double radius = 1, thickness = 1;
  const auto stiffening = [&](LayerBottom bottom, double nu, double chi) {
    return IndentedLayer(Indenter::sphere, radius, thickness, bottom, nu).stiffening(chi * chi);
  };
  const double chi = 0.2;
  // Garcia & Garcia 2018, bonded, nu = 1/2.
  const double series = 1 + 1.133 * chi + 1.497 * chi * chi + 1.469 * std::pow(chi, 3) + 0.755 * std::pow(chi, 4);
  CHECK(stiffening(LayerBottom::bonded, 0.5, chi) == Approx(series).epsilon(3e-3));
  // To first order 2 a0 chi / pi, with a0 = 1.168 without friction [Vorovich & Ustinov 1959] and, bonded,
  // (1.2876 - 1.4678 nu + 1.3442 nu2) / (1 - nu) [Dimitriadis 2002].
  constexpr double small = 0.01;
  const auto first = [&](double a0) { return 1 + 2 * a0 * small / std::numbers::pi; };
  CHECK(stiffening(LayerBottom::free, 0.3, small) - 1 == Approx(first(1.168) - 1).epsilon(0.02));
  for (const double nu : {0.3, 0.45, 0.5})
    CHECK(stiffening(LayerBottom::bonded, nu, small) - 1 ==
          Approx(first((1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu)) - 1).epsilon(0.03));
}

TEST_CASE("an indenter that goes down, stays and is drawn back gives E and relaxation", "[identify][layer][slow]") {
  // Hertz's sphere on a solid with G = 1 + g exp(-t / tau): Lee and Radok's integral while the contact grows, and
  // Ting's while it shrinks, here by fine sums of their own.
  constexpr double radius = 5e-3, depth = 1e-4, ramp = 1, hold = 2, g = 1.5, tau = 0.8, modulus = 20e3 / (1 - 0.16);
  const auto relaxed = [](double t) { return 1 + g * std::exp(-t / tau); };
  const auto at = [](double t) { return depth * std::min({t / ramp, 1., (2 * ramp + hold - t) / ramp}); };
  constexpr int steps = 40000;
  const auto force = [&](double t) {
    double until = t;
    if (t > ramp + hold) {  // backward from t until the depths' integral is 0
      double sum = 0;
      for (int i = steps - 1; i >= 0 && until == t; --i) {
        const double a = t * i / steps, b = t * (i + 1) / steps;
        sum += relaxed(t - (a + b) / 2) * (at(b) - at(a));
        if (sum > 0) until = a;
      }
      if (until == t) return 0.;
    }
    double sum = 0;
    for (int i = 0; i < steps && t * (i + 1) / steps <= std::min(until, ramp); ++i) {
      const double a = t * i / steps, b = t * (i + 1) / steps;
      sum += relaxed(t - (a + b) / 2) * (std::pow(at(b), 1.5) - std::pow(at(a), 1.5));
    }
    return 4. / 3 * std::sqrt(radius) * modulus * sum;
  };
  std::string data = "time [s],force [N]\n";
  for (double t = 0.1; t < 4; t += 0.1) data += fmt::format("{:.6g},{:.9g}\n", t, force(t));
  const TemporaryFolder folder;
  folder.write("force.csv", data);
  const std::string scene =
      "material: {youngs_modulus: 12 kPa, poissons_ratio: 0.4, relaxation: {terms: [[1, 0.5 s]]}}\nidentify:\n  "
      "tests:\n"
      "    - {kind: indentation_relaxation, file: force.csv, indenter: {sphere: {radius: 5 mm}}, depth: 0.1 mm, ramp: "
      "1 "
      "s, hold: 2 s}\n";
  const Answer answer = identify(folder.write("scene.yaml", scene), kCatalog, {}).front();
  REQUIRE(answer.numbers.size() == 3);
  CHECK(answer.outcome == FitOutcome::converged);
  CHECK(answer.numbers[0].value == Approx(20e3).epsilon(3e-3));
  CHECK(answer.numbers[1].value == Approx(g).epsilon(3e-3));
  CHECK(answer.numbers[2].value == Approx(tau).epsilon(3e-3));
  CHECK(answer.tests[0].relative_rms < 3e-3);
  CHECK(force(3.9) == 0);                         // contact is lost before the indenter is back
  std::string pressing = "time [s],force [N]\n";  // of a load cell that counts pulling
  for (double t = 0.1; t < 4; t += 0.1) pressing += fmt::format("{:.6g},{:.9g}\n", t, -force(t));
  folder.write("force.csv", pressing);
  CHECK(identify(folder.write("scene.yaml", scene), kCatalog, {}).front().numbers[0].value ==
        Approx(answer.numbers[0].value));
}

TEST_CASE("a sphere on a layer gives E and the point of contact from forces of a body of cells", "[identify][layer]") {
  const std::string scene = std::string(ELASTIN_SOURCE_DIR) + "/scenes/identify/layer.yaml";
  const Answer answer = identify(scene, kCatalog, {}).front();
  REQUIRE(answer.outcome == FitOutcome::converged);
  CHECK(answer.numbers[0].value == Approx(100e3).epsilon(5e-3));
  CHECK(answer.numbers[1].name == "layer_contact_point");
  CHECK(std::abs(answer.numbers[1].value - 0.03e-3) < 0.25e-3 * 0.01);  // of the depth
  CHECK_THAT(answer.tests.front().data.notes.back(), Contains("times as stiff as a half-space"));
}

TEST_CASE("a contact point is found to a hundredth of the depth in noise of a fiftieth", "[identify][layer]") {
  const TemporaryFolder folder;
  std::mt19937_64 generator(3);
  const double modulus = 2e3, radius = 5e-6, touch = 0.12e-6, depth = 2e-6;
  const IndentedLayer half_space(Indenter::sphere, radius, kInfinite, LayerBottom::bonded, 0.5);
  const double scale = modulus / 0.75, largest = scale * half_space.force(depth);
  int within = 0;
  constexpr int repeats = 40;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    std::string data = "Indentation [nm],Force [nN]\n";
    for (int i = 0; i <= 400; ++i) {
      const double at = touch + depth * (i / 200. - 1);
      const double normal =
          std::sqrt(-2 * std::log1p(-unit_random(generator))) * std::cos(2 * std::numbers::pi * unit_random(generator));
      data += fmt::format("{:.9g},{:.9g}\n", 1e9 * at,
                          1e9 * (scale * half_space.force(at - touch) + largest / 50 * normal));
    }
    folder.write("bead.csv", data);
    const Answer answer = identify(folder.write("scene.yaml",
                                                "material: {youngs_modulus: 1 kPa, poissons_ratio: 0.5}\n"
                                                "identify:\n  starts: 1\n  tests:\n    - {name: bead, kind: "
                                                "indentation, file: bead.csv, indenter: {sphere: {radius: 5 um}}}\n"),
                                   kCatalog, {})
                              .front();
    REQUIRE(answer.outcome == FitOutcome::converged);
    CHECK(answer.numbers[0].value == Approx(modulus).epsilon(0.05));
    within += std::abs(answer.numbers[1].value - touch) < 0.01 * depth;
  }
  CHECK(within > repeats * 9 / 10);
}

TEST_CASE("exact curves of indenters give E without a warning, whatever signs the machine gives them",
          "[identify][layer]") {
  struct Shape {
    Indenter indenter;
    double size;
    std::string keys;
  };
  const TemporaryFolder folder;
  for (const auto& [indenter, size, keys] : {Shape{Indenter::sphere, 1e-3, "{sphere: {radius: 1 mm}}"},
                                             {Indenter::cone, 0.6, "{cone: {half_angle: 0.6 rad}}"},
                                             {Indenter::flat, 1e-3, "{flat: {radius: 1 mm}}"}}) {
    const IndentedLayer half_space(indenter, size, kInfinite, LayerBottom::bonded, 0.5);
    for (const double of_depth : {1., -1.})
      for (const double of_force : {1., -1.})
        for (const std::string signs : {"", ", signs: pressing", ", signs: pulling"})
          for (const bool named : {false, true}) {
            std::string data =
                named ? "Compressive extension (um),Compressive load (mN)\n" : "Extension (um),Load (mN)\n";
            for (int i = -10; i <= 40; ++i)  // touches at 0
              data += fmt::format("{},{:.12g}\n", of_depth * 2.5 * i,
                                  of_force * 1e3 * 10e3 / 0.75 * half_space.force(2.5e-6 * i));
            folder.write("bead.csv", data);
            const std::string scene =
                folder.write("scene.yaml",
                             "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.5}\nidentify:\n  starts: 1\n  tests: "
                             "[{kind: indentation, file: bead.csv, indenter: " +
                                 keys + signs + "}]\n");
            INFO(keys << signs << " " << of_depth << " " << of_force);
            if (signs.ends_with("pulling") && (of_depth < 0 || of_force < 0)) {
              if (of_depth * of_force < 0)
                CHECK_THROWS_WITH(identify(scene, kCatalog, {}), Contains("signs: pressing"));
              continue;  // they stand as they are
            }
            const Answer answer = identify(scene, kCatalog, {}).front();
            CHECK(answer.outcome == FitOutcome::converged);
            CHECK(answer.numbers.front().value == Approx(10e3).epsilon(1e-6));
            for (const std::string& warning : answer.warnings) FAIL_CHECK(warning);
          }
  }
}

TEST_CASE("a sphere that sticks is drawn off by Johnson, Kendall and Roberts's force", "[identify][layer]") {
  const double radius = 10e-6, modulus = 2e3, adhesion = 1e-4;  // E / (1 - nu2) and w
  const IndentedLayer half_space(Indenter::sphere, radius, kInfinite, LayerBottom::bonded, 0.5);
  const auto force = [&](double depth) { return modulus * half_space.force(depth, adhesion / modulus, true); };
  double least = 0;
  const double scale = std::cbrt(std::pow(adhesion / modulus, 2) * radius);
  for (int i = 0; i <= 4000; ++i) least = std::min(least, force(scale * (i / 1000. - 3)));
  CHECK(least == Approx(-1.5 * std::numbers::pi * adhesion * radius).epsilon(1e-4));
  CHECK(force(-10 * scale) == 0);
  // a²/R - sqrt(2 pi w a / E*) and 4 E* a³/(3 R) - sqrt(8 pi w E* a³) at a contact radius.
  const double a = 3e-6;
  CHECK(
      force(a * a / radius - std::sqrt(2 * std::numbers::pi * adhesion * a / modulus)) ==
      Approx(4 * modulus * a * a * a / (3 * radius) - std::sqrt(8 * std::numbers::pi * adhesion * modulus * a * a * a))
          .epsilon(1e-9));

  const TemporaryFolder folder;
  std::string data = "depth [um],force [nN]\n";
  for (int i = -200; i <= 200; ++i) {  // there and back
    const double depth = scale * ((200 - std::abs(i)) / 40. - 0.6);
    data += fmt::format("{:.9g},{:.9g}\n", 1e6 * (depth + 1e-6),
                        1e9 * modulus * half_space.force(depth, adhesion / modulus, i > 0));
  }
  folder.write("bead.csv", data);
  const Answer answer =
      identify(folder.write("scene.yaml",
                            "material: {youngs_modulus: 1 kPa, poissons_ratio: 0.5}\nidentify:\n  residuals: "
                            "absolute\n  tests:\n    - {name: bead, kind: indentation, file: bead.csv, indenter: "
                            "{sphere: {radius: 10 um}}, adhesion: 30 uN/m, branch: unloading}\n"),
               kCatalog, {})
          .front();
  INFO(answer.cause);
  REQUIRE(answer.numbers.size() == 3);
  CHECK(answer.numbers[0].value == Approx(modulus * 0.75).epsilon(1e-4));
  CHECK(answer.numbers[1].value == Approx(adhesion).epsilon(1e-4));
  CHECK(answer.numbers[2].value == Approx(1e-6).epsilon(1e-3));
}

TEST_CASE("an indentation without its indenter, or of none, is refused", "[identify][layer]") {
  const TemporaryFolder folder;
  folder.write("bead.csv", "depth [um],force [nN]\n0,0\n1,2\n2,5\n");
  const auto refused = [&](const std::string& keys, const std::string& message) {
    const std::string scene = folder.write(
        "scene.yaml",
        "material: {youngs_modulus: 1 kPa, poissons_ratio: 0.5}\nidentify:\n  tests:\n    - {kind: indentation, file: "
        "bead.csv" +
            keys + "}\n");
    CHECK_THROWS_WITH(identify(scene, kCatalog, {}), Contains(message));
  };
  refused("", "indenter");
  const std::string thin =
      folder.write("thin.yaml",
                   "material: {youngs_modulus: 1 kPa, poissons_ratio: 0.5}\nidentify:\n  tests:\n    - {kind: "
                   "indentation, file: bead.csv, indenter: {flat: {radius: 5 um}}, thickness: 50 nm}\n");
  CHECK_THAT(identify(thin, kCatalog, {}).front().cause, Contains("wider than 8 thicknesses of the layer"));
  refused(", indenter: {ball: {radius: 5 um}}", "write {sphere: {radius: 10 um}}");
  refused(", indenter: {sphere: {radius: -5 um}}", "radius");
  refused(", indenter: {sphere: {radius: 5 um, angle: 3}}", "angle");
  refused(", indenter: {sphere: {radius: 5 um}}, zero: found", "zero");
}
