// Two directions at once, strains in place of displacements, sheets, and natural frequencies under load.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/laws/homogeneous.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

Measures measured(const std::string& text) {
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.write("a.yaml", text), built_in_catalog());
  const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  return run.measures;
}

const std::string kBlock = "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [10 mm, 12 mm, 6 mm]}}\n";
const std::string kSheet = "body: {sheet: {size: [20 mm, 30 mm], squares: [4, 6]}}\n";

}  // namespace

TEST_CASE("a linear block under two strains has the stresses of plane stress", "[biaxial]") {
  // E = 5 kPa, ν = 0.3, ε = (2e-3, 1e-3): σ₁ = E (ε₁ + ν ε₂)/(1 − ν²)       [Timoshenko & Goodier 1970, section 6]
  const Measures block =
      measured(kBlock +
               "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
               "solver: {displacements: small}\nexperiment: {kind: biaxial, strain: [2e-3, 1e-3]}\n");
  CHECK(block.get("stress") == Approx(5000 * (2e-3 + 0.3e-3) / 0.91).epsilon(1e-9));
  CHECK(block.get("stress_across") == Approx(5000 * (1e-3 + 0.6e-3) / 0.91).epsilon(1e-9));
  CHECK(block.get("lateral_strain") == Approx(-0.3 / 0.7 * 3e-3).epsilon(1e-9));
  CHECK(block.get("effective_modulus") == Approx(5000).epsilon(1e-9));
  CHECK(block.get("poissons_ratio") == Approx(0.3).epsilon(1e-9));
  CHECK(block.get("force") == Approx(block.get("stress") * 72e-6).epsilon(1e-9));
  CHECK(block.get("isotropy_error") < 1e-8);
}

TEST_CASE("E under two strains does not depend on which of the directions is called the axis", "[biaxial]") {
  const auto pulled = [](const std::string& axes, const std::string& strains) {
    return measured(
        "body: {lattice: {kind: cubic, molecules: [4, 4, 4], spacing: [3 mm, 3 mm, 4 mm], connections: [axis, face]}}\n"
        "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.25}\nstiffness: standard\n"
        "solver: {displacements: small}\nexperiment: {kind: biaxial, " +
        axes + ", strain: [" + strains + "]}\n");
  };
  const Measures one = pulled("axis: x, across: z", "1e-5, 2e-5"), other = pulled("axis: z, across: x", "2e-5, 1e-5");
  CHECK(one.get("effective_modulus") == Approx(other.get("effective_modulus")).epsilon(1e-9));
  CHECK(one.get("stress") == Approx(other.get("stress_across")).epsilon(1e-9));
  // Lengths along z are no longer those along x, so its springs' stiffness is another: no isotropic material's.
  CHECK(one.get("isotropy_error") > 0.05);
  CHECK(one.get("isotropy_error") == Approx(other.get("isotropy_error")).epsilon(1e-9));
}

TEST_CASE("large biaxial and planar strains have the law's own stresses", "[biaxial]") {
  const std::string law =
      "material: {law: mooney_rivlin, c1: 1 kPa, c2: 0.2 kPa, bulk_modulus: 50 kPa}\n"
      "stiffness: mooney_rivlin\n";
  Material material;
  {
    const TemporaryFolder folder;
    material = load_scene(folder.write("a.yaml", kBlock + law + "experiment: {kind: vibration}\n"), built_in_catalog())
                   ->specimen.material;
  }
  const auto row = built_in_catalog().material_laws.find("mooney_rivlin");
  for (const auto& [kind, test] :
       {std::pair{"biaxial", HomogeneousTest::equibiaxial}, {"planar", HomogeneousTest::planar}}) {
    INFO(kind);
    const auto exact = homogeneous_state(*row, material, test, 0.3);
    REQUIRE(exact);
    const Measures block = measured(kBlock + law + "experiment: {kind: " + kind + ", strain: 30 %, load_steps: 3}\n");
    CHECK(block.get("stress") == Approx(exact->stress).epsilon(1e-7));
    CHECK(block.get("strain") == Approx(0.3));
  }
}

TEST_CASE("a sheet at constant width shows E and nu of its material", "[biaxial]") {
  const Measures sheet = measured(kSheet +
                                  "material: {youngs_modulus: 5 MPa, poissons_ratio: 0.4, thickness: 2 mm}\n"
                                  "stiffness: hencky_membrane\nsolver: {displacements: small}\n"
                                  "experiment: {kind: planar, axis: y, across: x, strain: 1e-4}\n"
                                  "rotate: {axis: [1, 1, 0], angle: 50 deg}\n");
  CHECK(sheet.get("poissons_ratio") == Approx(0.4).epsilon(1e-9));
  CHECK(sheet.get("effective_modulus") == Approx(5e6).epsilon(1e-9));
  CHECK(sheet.get("stress_across") == Approx(0.4 * sheet.get("stress")).epsilon(1e-9));
}

// Corners are held along both directions, and the flat sheet resists nothing across its plane.
TEST_CASE("a sheet of a law without an energy is the same wherever it lies", "[biaxial]") {
  const auto pulled = [](const std::string& law, const std::string& turn) {
    return measured(kSheet + "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.1, thickness: 0.5 mm}\nstiffness: " +
                    law + "\nexperiment: {kind: biaxial, strain: [0.06, 0.03]}\nrotate: " + turn + "\n");
  };
  for (const char* law : {"hencky_membrane", "two_parameter"}) {
    const Measures straight = pulled(law, "{axis: z, angle: 0 deg}");
    for (const char* turn : {"{axis: z, angle: 17 deg}", "{axis: [1, 2, -0.5], angle: 50 deg}"}) {
      INFO(law << " turned by " << turn);
      const Measures turned = pulled(law, turn);
      for (const char* measure : {"effective_modulus", "poissons_ratio", "stress_across"})
        CHECK(turned.get(measure) == Approx(straight.get(measure)).epsilon(1e-8));
    }
  }
}

TEST_CASE("a sheet that is stretched alike in both directions shows no Poisson's ratio", "[biaxial]") {
  for (const std::string strains : {"[1 %, 1 %]", "[3 %, 3 %]", "[5 %, 5 %]", "[5 %, -5 %]"}) {
    INFO(strains);
    const Measures sheet = measured(
        "body: {sheet: {size: [40 mm, 40 mm], squares: [4, 4], pattern: crossed}}\n"
        "material: {youngs_modulus: 1 MPa, poissons_ratio: 0.3, thickness: 0.2 mm}\nstiffness: neo_hookean_membrane\n"
        "experiment: {kind: biaxial, strain: " +
        strains + "}\n");
    CHECK(std::isnan(sheet.get("poissons_ratio")));
    CHECK(std::isfinite(sheet.get("stress")));
  }
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& body, const std::string& more) {
    const auto scene = load_scene(
        folder.write("a.yaml", body +
                                   "material: {youngs_modulus: 1 MPa, poissons_ratio: 0.3, thickness: 1 mm}\n"
                                   "stiffness: \"calibrated:uniform\"\n" +
                                   more),
        built_in_catalog());
    CHECK((no_reference(*scene) == "") == (body == kBlock || more.find("[1 %, 2 %]") != std::string::npos));
    return unsuited(scene->specimen, *scene->experiment, scene->stiffness);
  };
  const std::string equal = "experiment: {kind: biaxial, strain: 1 %}\n";
  CHECK_THAT(refused(kSheet, equal), Contains("no modulus to calibrate to: two strains of one size determine neither E "
                                              "nor nu of a sheet; write two that differ, or `calibrate:"));
  CHECK(refused(kSheet, equal + "calibrate: {experiment: {kind: tension, axis: x, strain: 1 %}}\n").empty());
  CHECK(refused(kSheet, "experiment: {kind: biaxial, strain: [1 %, 2 %]}\n").empty());
  CHECK(refused(kBlock, equal).empty());
}

TEST_CASE("invalid pairs of axes are refused", "[biaxial]") {
  const auto said = [](const std::string& experiment) {
    const TemporaryFolder folder;
    try {
      load_scene(
          folder.write("a.yaml", kBlock + "material: {youngs_modulus: 5 kPa}\nstiffness: neo_hookean\nexperiment: " +
                                     experiment + "\n"),
          built_in_catalog());
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(said("{kind: biaxial}"), Contains("experiment: key 'strain' is missing"));
  CHECK_THAT(said("{kind: biaxial, strain: 0}"), Contains("a load of zero"));
  CHECK_THAT(said("{kind: biaxial, strain: [1 %, 2 %, 3 %]}"), Contains("expected 2 values, found 3"));
  CHECK_THAT(said("{kind: planar, axis: y, strain: 1 %}"), Contains("must be perpendicular to the other axis"));
  CHECK_THAT(said("{kind: planar, strain: -100 %}"), Contains("is out of range"));
}

TEST_CASE("a strain is the displacement over the distance of the ends", "[tension]") {
  const std::string rest =
      "material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3}\nstiffness: neo_hookean\n"
      "experiment: {axis: y, load_steps: 2, loaded_grip: clamped, ";
  for (const auto& [kind, sign] : {std::pair{"tension", 1}, {"compression", -1}}) {
    const Measures strain = measured(kBlock + rest + "kind: " + kind + ", strain: 15 %}\n"),
                   length = measured(kBlock + rest + "kind: " + kind + ", displacement: 1.8 mm}\n");
    CHECK(strain.get("elongation") == Approx(sign * 1.8e-3).epsilon(1e-12));
    CHECK(strain.get("force") == Approx(length.get("force")).epsilon(1e-9));
  }
}

TEST_CASE("a sheet under tension shows the Poisson's ratio of its material", "[tension][slow]") {
  const std::string sheet = kSheet + "material: {youngs_modulus: 5 MPa, poissons_ratio: 0.4, thickness: 2 mm}\n";
  const std::string small = "experiment: {kind: tension, axis: y, strain: 1e-4}\nsolver: {displacements: small}\n";
  CHECK(measured(sheet + "stiffness: neo_hookean_membrane\n" + small).get("poissons_ratio") ==
        Approx(0.4).epsilon(1e-8));
  // Without stress across, E m J / (1 − ν) = E d / 2(1 + ν), m and d the mean and the difference of the logarithmic
  // strains, J = e^(2 m (1 − 2ν)/(1 − ν)): hencky_energy_membrane, wherever the sheet lies in space. Of
  // hencky_membrane, with true stress linear in logarithmic strain, −ν is the ratio of these strains.
  const auto pulled = [&](const std::string& law) {
    return measured(sheet + "stiffness: " + law + "\nexperiment: {kind: tension, axis: y, strain: 20 %, " +
                    "load_steps: 4}\nrotate: {axis: [1, 2, 3], angle: 50 deg}\n");
  };
  const double along = std::log(1.2), across = std::log1p(pulled("hencky_energy_membrane").get("lateral_strain"));
  CHECK(std::log1p(pulled("hencky_membrane").get("lateral_strain")) == Approx(-0.4 * along).epsilon(1e-7));
  const double mean = (along + across) / 2;
  CHECK(mean * std::exp(2 * mean * 0.2 / 0.6) / 0.6 == Approx((along - across) / 2.8).epsilon(1e-8));
}

TEST_CASE("a stretched string has the frequencies of its tension", "[vibration]") {
  // Two springs of 100 N/m from 10 to 11 mm on a bead: ω² = 2 T / (m L), T = 0.1 N across; 2 k / m along.
  const std::string string =
      "body: {molecules: [[0, 0, 0], [10 mm, 0, 0], [20 mm, 0, 0]], connections: {within: 11 mm},"
      " radius: 1 mm}\nmaterial: {youngs_modulus: 1 MPa, density: 1000 kg/m3}\n"
      "stiffness: {strategy: uniform, constant: 100 N/m}\nexperiment: {kind: vibration, count: 3, ";
  const std::string fixture =
      "fixture: {kind: tension, axis: x, strain: 10 %, fixed_grip: clamped, loaded_grip: clamped,"
      " cross_section: 1 mm2}}\n";
  const double mass = 1000 * 8e-9;  // a cube about each bead
  const Measures loaded = measured(string + "load: applied, " + fixture);
  for (const char* across : {"frequency_1", "frequency_2"})
    CHECK(loaded.get(across) == Approx(std::sqrt(2 * 0.1 / (mass * 0.011)) / (2 * M_PI)).epsilon(1e-6));
  CHECK(loaded.get("frequency_3") == Approx(std::sqrt(2 * 100 / mass) / (2 * M_PI)).epsilon(1e-6));
}

TEST_CASE("a body graded from both ends is its own mirror image", "[scene]") {
  const TemporaryFolder folder;
  const auto scene = load_scene(
      folder.write(
          "a.yaml",
          "body: {lattice: {kind: cubic, molecules: [9, 2, 2], spacing: 1 mm}, grade: {axis: x, ratio: 4, ends: "
          "both}}\nmaterial: {youngs_modulus: 5 kPa}\nstiffness: standard\nexperiment: {kind: vibration}\n"),
      built_in_catalog());
  const Body& body = scene->specimen.body;
  for (int i = 0; i < 9; ++i) CHECK(body.rest(0, i) + body.rest(0, 8 - i) == Approx(8e-3).epsilon(1e-12));
  const auto spacing = [&](int i) { return body.rest(0, i + 1) - body.rest(0, i); };
  // Four spacings in geometric progression over half the length: from first to last 4^(3/4).
  for (int i = 0; i < 3; ++i) CHECK(spacing(i + 1) / spacing(i) == Approx(std::pow(4, 0.25)).epsilon(1e-9));
}
