#include "core/simulation/volume_fit.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/base/error.h"
#include "lab/experiment/tension/tension.h"
#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;

namespace {

const Catalog kCatalog = built_in_catalog();

Specimen specimen_of(Body body, double nu) {
  Specimen specimen;
  specimen.body = std::move(body);
  specimen.material = {.youngs_modulus = 1e4, .poissons_ratio = nu};
  return specimen;
}

Run pull(Specimen specimen, const std::string& strategy) {
  TensionSetup setup;
  setup.displacement = 1e-6;
  const auto experiment = make_tension(specimen.body, setup);
  Run run = run_strategy(specimen, *experiment, choose_strategy(kCatalog, strategy), {.statics = {.linear = true}});
  INFO(strategy << ": " << run.cause);
  REQUIRE(run.suited);
  REQUIRE(run.outcome == Outcome::converged);
  return run;
}

}  // namespace

TEST_CASE("lattice+volume: any Poisson's ratio comes back from a cubic lattice", "[volume]") {
  for (const double nu : {0., 0.25, 0.3, 0.45, 0.49, 0.499}) {
    const Run run = pull(specimen_of(cubic_lattice({5, 4, 6}, 0.01, {true, true, false}), nu), "lattice+volume");
    INFO("nu " << nu);
    CHECK(run.measures.get("effective_modulus") == Approx(1e4).epsilon(1e-7));
    CHECK(run.measures.get("poissons_ratio") == Approx(nu).margin(1e-7));
  }
}

TEST_CASE("calibrated with a volume term fits E and Poisson's ratio on irregular bodies", "[volume]") {
  for (const double nu : {0., 0.3, 0.45, 0.49, 0.499}) {
    for (const auto& [body, rule] :
         {std::pair{jittered_lattice(), "standard"}, {jittered_lattice(), "patch"}, {jittered_block(), "van_gelder"}}) {
      const Run run = pull(specimen_of(body, nu), "calibrated:" + std::string(rule) + "+volume");
      INFO(rule << ", nu " << nu << ": " << run.measures.get("poissons_ratio"));
      CHECK(run.measures.get("effective_modulus") == Approx(1e4).epsilon(1e-3));
      CHECK(run.measures.get("poissons_ratio") == Approx(nu).margin(0.002));
    }
  }
}

TEST_CASE("any Poisson's ratio on a random packing, by springs and the volumes of Delaunay tetrahedra",
          "[volume][slow]") {
  for (const std::string nu : {"0", "0.25", "0.3", "0.45", "0.49", "0.499"}) {
    const auto scene = load_scene(
        std::string(ELASTIN_SOURCE_DIR) + "/scenes/material/any-nu-packing.yaml", kCatalog,
        {"body.packing.size=[15 mm, 15 mm, 15 mm]", "material.poissons_ratio=" + nu, "solver={displacements: small}"});
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO("nu " << nu << ": " << run.measures.get("poissons_ratio") << " " << run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    CHECK(run.measures.get("effective_modulus") == Approx(1e4).epsilon(1e-3));
    CHECK(run.measures.get("poissons_ratio") == Approx(std::stod(nu)).margin(0.01));
  }
}

TEST_CASE("a nearly incompressible clamped block tends to independent hexahedra", "[volume][reference][slow]") {
  // Block T1, nu = 0.499: mixed Q2/P1 hexahedra, 4 to 12 a side, graded, extrapolated: 1.2179 E within 1e-4; the same
  // program gives 1.04069 at nu = 0.25, where the reference is 1.040698.
  std::array<double, 2> plain{}, averaged{};
  for (const std::size_t i : {0u, 1u}) {
    const int n = 3 << i;
    Specimen specimen =
        specimen_of(tetrahedral_block(BlockKind::body_centred, {2 * n, 2 * n, n}, {.03, .03, .015}), .499);
    TensionSetup setup;
    setup.force = 1e-4;
    setup.fixed_grip = Grip::clamped;
    const auto experiment = make_tension(specimen.body, setup);
    const auto error = [&](const std::string& strategy) {
      const Run run = run_strategy(specimen, *experiment, choose_strategy(kCatalog, strategy),
                                   {.statics = {.linear = true, .tolerance = 1e-7}});
      return run.measures.get("effective_modulus") / 1e4 / 1.2179 - 1;
    };
    plain[i] = error("neo_hookean");
    averaged[i] = error("neo_hookean+volume");
  }
  INFO("plain " << plain[0] << " " << plain[1] << ", averaged " << averaged[0] << " " << averaged[1]);
  CHECK(averaged[1] < 0.035);
  CHECK(std::log2(averaged[0] / averaged[1]) > 1);  // the clamped edge is singular
  CHECK(plain[1] > 5 * averaged[1]);
}

TEST_CASE("the fit takes two solves of an isotropic body, and few where strain is not affine", "[volume]") {
  // Springs of shear modulus g and bulk modulus k; the volume term counts by `part`.
  const double g = 3e3, k = 4e3;
  for (const double nu : {0., 0.25, 0.45, 0.499})
    for (const double part : {1., 0.7}) {
      int solves = 0;
      const auto fit = fit_volume({.youngs_modulus = 1e4, .poissons_ratio = nu}, [&](double kappa) {
        ++solves;
        const double K = k + part * kappa / (1 + (1 - part) * kappa / (kappa + 1e4));
        return std::optional(std::pair{9 * K * g / (3 * K + g), (3 * K - 2 * g) / (2 * (3 * K + g))});
      });
      INFO("nu " << nu << ", part " << part << ": " << solves << " solves");
      REQUIRE(fit);
      CHECK(fit->met);
      CHECK(fit->poissons_ratio == Approx(nu).margin(std::min(0.001, (0.5 - nu) / 10)));
      CHECK(fit->spring_factor * g == Approx(1e4 / (2 * (1 + fit->poissons_ratio))).epsilon(1e-12));
      CHECK(solves <= (part == 1 ? 2 : 5));
    }
  // A body that measures 0.48 at most, however stiff its volume: the term stays within reason.
  const auto fit = fit_volume({.youngs_modulus = 1e4, .poissons_ratio = 0.499}, [](double kappa) {
    return std::optional(std::pair{1e4, 0.48 - 2e3 / (kappa + 1e4)});
  });
  REQUIRE(fit);
  CHECK_FALSE(fit->met);
  CHECK(fit->poissons_ratio == Approx(0.48).margin(0.001));
  CHECK(fit->volume_modulus < 1e8);
  CHECK_FALSE(fit_volume({.youngs_modulus = 1}, [](double) { return std::optional<std::pair<double, double>>(); }));
  CHECK_FALSE(fit_volume({.youngs_modulus = 1}, [](double) { return std::optional(std::pair{1., std::nan("")}); }));
}

TEST_CASE("the fit reaches what a negative volume term reaches while the body is stable", "[volume]") {
  struct Case {
    const char* rule;
    std::array<double, 3> spacing;
    CubicPattern pattern;
    bool reached;
  };
  const CubicPattern all{true, true, true};
  // Of the last the stable terms end at 0.53: compared with a scan of them.
  for (const auto& [rule, spacing, pattern, reached] : {Case{"angles", {3e-3, 3e-3, 3e-3}, all, true},
                                                        {"standard", {3e-3, 4e-3, 5e-3}, all, true},
                                                        {"statistical", {3e-3, 4e-3, 5e-3}, all, true},
                                                        {"angles", {3e-3, 4e-3, 5e-3}, all, false}}) {
    Body body = cubic_lattice({4, 4, 5}, 1, pattern);
    body.rest = Vector3(spacing[0], spacing[1], spacing[2]).asDiagonal() * body.rest;
    set_present_lengths(body);
    set_matter(body, 1e-3, 1000, 0, 36 * spacing[0] * spacing[1] * spacing[2]);
    const Run run = pull(specimen_of(std::move(body), 0.25), std::string("calibrated:") + rule + "+volume");
    INFO(rule << ": " << run.measures.get("poissons_ratio"));
    CHECK_FALSE(run.unstable);
    const bool said = std::any_of(run.warnings.begin(), run.warnings.end(), [](const std::string& warning) {
      return warning.find("calibration reaches no nearer Poisson's ratio") == 0;
    });
    CHECK(said == !reached);
    CHECK(run.measures.get("poissons_ratio") == (reached ? Approx(0.25).margin(0.001) : Approx(0.535).margin(0.01)));
  }
}

TEST_CASE("a Poisson's ratio near 1/2 is met as nearly as what is left to it", "[volume]") {
  Body body = tetrahedral_block(BlockKind::body_centred, {2, 2, 3}, {.01, .01, .015});
  set_matter(body, 1e-3, 1000, 0, 0);
  for (const double nu : {0.498, 0.4999}) {
    const Run run = pull(specimen_of(body, nu), "calibrated:statistical+volume");
    CHECK(run.measures.get("poissons_ratio") == Approx(nu).margin((0.5 - nu) / 5));
  }
}

TEST_CASE("a volume term is named in short or refused with a reason", "[volume]") {
  const StrategyChoice choice = choose_strategy(kCatalog, "calibrated:standard+volume");
  CHECK(choice.label == "calibrated:standard+volume");
  CHECK(choice.name.calibrated);
  CHECK(choice.strategy.name == "standard+volume");
  CHECK_THROWS_WITH(choose_strategy(kCatalog, "standrad+volume"), Catch::Contains("did you mean 'standard'"));
  CHECK_THROWS_WITH(choose_strategy(kCatalog, "st_venant_kirchhoff+volume"), Catch::Contains("neo_hookean"));
  CHECK_THROWS_WITH(choose_strategy(kCatalog, "volume"), Catch::Contains("lattice+volume"));
  CHECK_THROWS_WITH(choose_strategy(kCatalog, "standard+volume+volume"), Catch::Contains("repeated"));
  for (const double nu : {-0.1, 0.49995}) {
    const Specimen specimen = specimen_of(jittered_lattice(), nu);
    CHECK_THROWS_WITH(choose_strategy(kCatalog, "lattice+volume").strategy.make(specimen.body, specimen.material, {}),
                      Catch::Contains("0 to 0.4999"));
  }
  const Body packing = random_packing({0.02, 0.02, 0.02}, 0.003, 0.005, 2);
  CHECK_THAT(choice.strategy.unsuited(packing), Catch::Contains("delaunay"));
}
