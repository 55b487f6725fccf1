// What experiments hold of bodies whose ends are not plane, and what they say of it.

#include "lab/run/ends.h"

#include <catch2/catch.hpp>
#include <random>

#include "core/shapes/orders.h"
#include "lab/experiment/bending/bending.h"
#include "lab/experiment/shear/shear.h"
#include "lab/experiment/tension/tension.h"
#include "lab/experiment/torsion/torsion.h"
#include "lab/scene/scene.h"
#include "support/experiments.h"
#include "support/refusal.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

/// A bar of 20 × 5 × 5 mm of tetrahedra or hexahedra, of order 1 or 2.
Specimen bar(int corners, int order) {
  Specimen specimen;
  specimen.material = {.youngs_modulus = 1e4, .poissons_ratio = 0.3};
  if (corners == 4) {
    specimen.body = tetrahedral_block(BlockKind::kuhn, {8, 2, 2}, {0.02, 0.005, 0.005});
  } else {
    specimen.body = cubic_lattice({9, 3, 3}, 0.0025, {true, false, false});
    specimen.body = with_order(specimen.body, 1);
  }
  specimen.body = order == 2 ? with_order(specimen.body, 2) : specimen.body;
  set_matter(specimen.body, 0.001, 1000, 0, 0);
  return specimen;
}

/// Its ends uneven by up to `amount`, the whole turned about an axis across it.
Specimen worn(Specimen specimen, double amount, double degrees, unsigned seed) {
  Body& body = specimen.body;
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> moved(-amount, amount);
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if (const double x = body.rest(0, molecule); x < 1e-9 || x > 0.02 - 1e-9)
      body.rest(0, molecule) += moved(generator);
  body.rest = Eigen::AngleAxisd(degrees * M_PI / 180, Vector3(0, 0.6, 0.8)).toRotationMatrix() * body.rest;
  set_present_lengths(body);
  return specimen;
}

double measured(const Specimen& specimen, const StaticExperiment& experiment, const char* measure) {
  return solve(specimen, experiment, "neo_hookean").measures.get(measure);
}

TensionSetup pull(Grip grip) {
  TensionSetup setup;
  setup.axis = Vector3::UnitX();
  setup.strain = 1e-3;
  setup.fixed_grip = setup.loaded_grip = grip;
  return setup;
}

}  // namespace

TEST_CASE("a bar with rough or tilted ends shows its modulus", "[ends][tension][slow]") {
  unsigned seed = 0;
  for (const int corners : {4, 8})
    for (const int order : {1, 2}) {
      const Specimen straight = bar(corners, order);
      const auto clamped = make_tension(straight.body, pull(Grip::clamped));
      CHECK((clamped->findings().notes.empty() && clamped->findings().warnings.empty()));
      const double expected = measured(straight, *clamped, "effective_modulus");
      for (const double degrees : {0., 2., 4.}) {
        const Specimen specimen = worn(straight, 2e-5, degrees, ++seed);
        // Between smooth plates the stress is even: E itself.
        if (degrees == 0)
          CHECK(measured(specimen, *make_tension(specimen.body, pull(Grip::sliding)), "effective_modulus") ==
                Approx(1e4).epsilon(0.002));
        const auto experiment = make_tension(specimen.body, pull(Grip::clamped));
        CHECK(measured(specimen, *experiment, "effective_modulus") == Approx(expected).epsilon(0.012));
        REQUIRE(experiment->findings().notes.size() == 2);
        CHECK_THAT(experiment->findings().notes[0], Contains("molecules on 2") && Contains("of a section of 2"));
        CHECK(experiment->findings().warnings.size() == (degrees > 0 ? 2 : 0));
        if (degrees > 0) CHECK_THAT(experiment->findings().warnings[0], Contains("axis: longest"));
        // Along its own axis there is no tilt to warn of.
        TensionSetup own = pull(Grip::clamped);
        own.axis = longest_axis(specimen.body);
        const auto along = make_tension(specimen.body, own);
        CHECK(along->findings().warnings.empty());
        CHECK(measured(specimen, *along, "effective_modulus") == Approx(expected).epsilon(0.003));
      }
    }
}

TEST_CASE("meshes of bars with rough ends and in a scanner's frame show the modulus of the straight one",
          "[ends][brought]") {
  // 20 x 5 x 5 mm, clamped, 0.1 %: 10.28 kPa for E = 10 kPa on the same cells.
  const auto modulus = [](const std::string& mesh, const std::string& axis) {
    const auto scene = load_scene(
        SceneSource::of_text("a.yaml", std::string("body: {mesh: {file: ") + ELASTIN_TEST_DATA + "/mesh/data/brought/" +
                                           mesh +
                                           ", length_unit: mm}}\nmaterial: {youngs_modulus: 10 kPa, "
                                           "poissons_ratio: 0.3}\nstiffness: neo_hookean\nexperiment: {kind: "
                                           "tension, axis: " +
                                           axis + ", strain: 0.1 %, fixed_grip: clamped, loaded_grip: clamped}\n"),
        built_in_catalog());
    return solve(scene->specimen, *scene->experiment, "neo_hookean").measures.get("effective_modulus");
  };
  CHECK(modulus("bar_rough_ends.msh", "x") == Approx(10280).epsilon(0.003));
  CHECK(modulus("bar_turned_2_degrees.msh", "longest") == Approx(10280).epsilon(0.003));
  CHECK(modulus("bar_turned_2_degrees.msh", "x") == Approx(10280).epsilon(0.005));
}

TEST_CASE("bending, torsion and shear of a bar with rough ends are those of the bar", "[ends]") {
  const Specimen straight = bar(4, 2), specimen = worn(straight, 2e-5, 0, 7);
  BendingSetup bending;
  bending.force = 1e-5;
  TorsionSetup torsion;
  torsion.axis = Vector3::UnitX();
  torsion.angle = 0.01;
  ShearSetup shear;
  shear.axis = Vector3::UnitX();
  shear.direction = Vector3::UnitZ();
  shear.strain = 1e-3;
  CHECK(measured(specimen, *make_bending(specimen.body, bending, specimen.material), "tip_deflection") ==
        Approx(measured(straight, *make_bending(straight.body, bending, straight.material), "tip_deflection"))
            .epsilon(0.01));
  CHECK(measured(specimen, *make_torsion(specimen.body, torsion), "torque") ==
        Approx(measured(straight, *make_torsion(straight.body, torsion), "torque")).epsilon(0.01));
  CHECK(measured(specimen, *make_shear(specimen.body, shear, Matrix3::Identity()), "force") ==
        Approx(measured(straight, *make_shear(straight.body, shear, Matrix3::Identity()), "force")).epsilon(0.01));
}

TEST_CASE("a grip that holds too little is refused with the depth that does", "[ends]") {
  // A bar whose end is a spike.
  Specimen specimen = bar(4, 1);
  for (int molecule = 0; molecule < specimen.body.size(); ++molecule)
    if (const Vector3 at = specimen.body.rest.col(molecule); at.x() > 0.02 - 1e-9)
      specimen.body.rest(0, molecule) += 0.004 * (1 - at.tail<2>().norm() / 0.008);
  TensionSetup setup = pull(Grip::clamped);
  setup.grip_depth = 1e-5;
  const std::string message = refusal([&] { make_tension(specimen.body, setup); });
  CHECK_THAT(message, Contains("the loaded end holds 1 molecule on 0 mm2 of a section of ") &&
                          Contains("write grip_depth: ") && Contains("`loaded: {set: NAME}`"));
  setup.grip_depth = 1e-3 * std::stod(message.substr(message.find("grip_depth: ") + 12));
  CHECK(refusal([&] { make_tension(specimen.body, setup); }).empty());
}

TEST_CASE("the longest axis is the bar's own; a cube has none", "[ends]") {
  const Vector3 own = Eigen::AngleAxisd(0.4, Vector3(0, 0.6, 0.8)).toRotationMatrix() * Vector3::UnitX();
  CHECK((longest_axis(worn(bar(8, 1), 0, 0.4 * 180 / M_PI, 1).body) - own).norm() < 1e-9);
  CHECK_THAT(refusal([] {
               longest_axis(tetrahedral_block(BlockKind::kuhn, {2, 2, 2}, {1, 1, 1}));
             }),
             Contains("as far along another axis"));
}

TEST_CASE("a scene picks what is held, and takes the longest axis", "[ends][scene]") {
  const auto load = [](const std::string& experiment) {
    return load_scene(SceneSource::of_text("a.yaml",
                                           "title: t\n"
                                           "body: {tetrahedra: {kind: kuhn, cubes: [8, 2, 2], size: [20 mm, "
                                           "5 mm, 5 mm]}}\n"
                                           "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\n"
                                           "rotate: {axis: z, angle: 30 deg}\n"
                                           "stiffness: neo_hookean\nexperiment: {" +
                                               experiment + "}\n"),
                      built_in_catalog());
  };
  const std::string ends =
      ", fixed: {plane: {point: [0, 0, 0], normal: x}}, loaded: {box: {from: [20 mm, 0, 0], to: [20 mm, 5 mm, 5 mm]}}";
  std::vector<double> moduli;
  for (const std::string& text :
       {"kind: tension, axis: x, strain: 0.1 %" + ends, std::string("kind: tension, axis: x, strain: 0.1 %"),
        std::string("kind: tension, axis: longest, strain: 0.1 %")}) {
    const auto scene = load(text);
    moduli.push_back(measured(scene->specimen, *scene->experiment->at_rest(), "effective_modulus"));
    CHECK(scene->warnings.empty());
  }
  for (const double modulus : moduli) {
    CHECK(modulus == Approx(1e4).epsilon(1e-3));  // a secant at 0.1 %
    CHECK(modulus == Approx(moduli[0]).epsilon(1e-9));
  }
  // Each experiment with ends takes them.
  for (const std::string& text :
       {"kind: bending, axis: x, direction: z, force: 1 uN" + ends, "kind: torsion, axis: x, angle: 1 deg" + ends,
        "kind: shear, axis: x, direction: z, strain: 1 %" + ends,
        std::string("kind: bending, axis: longest, direction: [0.1, 0, 1], force: 1 uN")})
    CHECK(load(text)->warnings.empty());
  CHECK_THAT(load("kind: tension, axis: x, strain: 1 %, fixed: {nearest: [0, 0, 0]}")->warnings.at(0),
             Contains("the fixed end holds 1 molecule on 0 mm2"));
  CHECK_THAT(refusal([&] { load("kind: tension, axis: x, strain: 1 %, fixed: {side: x}"); }),
             Contains("a.yaml:6") && Contains("in common"));
  // Along its diagonal a block has an edge in place of an end.
  CHECK_THAT(refusal([&] { load("kind: tension, axis: [0.8, 1, 0], strain: 1 %"); }),
             Contains("a.yaml:6") && Contains("no two ends across this axis") && Contains("grip_depth: "));
  CHECK_THAT(refusal([&] { load("kind: bending, axis: longest, direction: x, force: 1 uN"); }),
             Contains("lies along the body's longest axis"));
}

TEST_CASE("ends that are picked or have a depth say that a bar lies askew, too", "[ends]") {
  const auto warnings = [](double degrees, const auto& change) {
    const Specimen straight = bar(8, 1), turned = worn(straight, 0, degrees, 1);
    TensionSetup setup = pull(Grip::sliding);
    setup.fixed.emplace(), setup.loaded.emplace();
    for (int molecule = 0; molecule < straight.body.size(); ++molecule) {
      const double x = straight.body.rest(0, molecule);
      if (x < 1e-9) setup.fixed->push_back(molecule);
      if (x > 0.02 - 1e-9) setup.loaded->push_back(molecule);
    }
    change(setup);
    return Ends(turned.body, setup.axis, setup).findings.warnings;
  };
  const auto picked = [](TensionSetup&) {};
  const auto of_depth = [](TensionSetup& setup) { setup.fixed.reset(), setup.loaded.reset(), setup.grip_depth = 4e-3; };
  for (const auto& found : {warnings(10, picked), warnings(20, of_depth)}) {
    REQUIRE(found.size() == 1);
    CHECK_THAT(found[0], Contains("° from the axis") && Contains("write axis: longest"));
  }
  CHECK_THAT(warnings(10, picked).at(0), Contains("tilted by 10°"));
  CHECK(warnings(1, picked).empty());
  CHECK(warnings(0, of_depth).empty());
  CHECK(warnings(10, [](TensionSetup& setup) { setup.longest = true; }).empty());
}

TEST_CASE("what lies inside or beyond the grips counts for no section and no Poisson's ratio", "[ends][tension]") {
  // A bar with shoulders of 5 mm: nine times the section.
  Specimen specimen = bar(8, 1);
  for (int molecule = 0; molecule < specimen.body.size(); ++molecule)
    if (const double x = specimen.body.rest(0, molecule); x < 5e-3 + 1e-9 || x > 15e-3 - 1e-9)
      specimen.body.rest.col(molecule).tail<2>() *= 3;
  specimen.material.poissons_ratio = 0;
  TensionSetup setup = pull(Grip::clamped);
  setup.grip_depth = 5e-3;
  const Ends ends(specimen.body, setup.axis, setup);
  CHECK(ends.low == Approx(5e-3));
  CHECK(ends.high == Approx(15e-3));
  // Gripped at one end and in its middle.
  const Specimen whole = bar(8, 1);
  TensionSetup inner = pull(Grip::sliding);
  inner.loaded.emplace();
  for (int molecule = 0; molecule < whole.body.size(); ++molecule)
    if (std::abs(whole.body.rest(0, molecule) - 10e-3) < 1e-9) inner.loaded->push_back(molecule);
  CHECK(measured(whole, *make_tension(whole.body, inner), "poissons_ratio") == Approx(0.3).margin(0.02));
}

// A box of 5 x 5 x 5 cubes, each of five tetrahedra or more, without that in its middle.
TEST_CASE("cavities whose walls are moved with the surface are said", "[ends]") {
  Body body = tetrahedral_block(BlockKind::kuhn, {5, 5, 5}, {0.05, 0.05, 0.05});
  Findings whole, hollow;
  note_cavities(body, whole);
  CHECK(whole.warnings.empty());
  std::erase_if(body.tetrahedra, [&](const auto& cell) {
    Vector3 middle = Vector3::Zero();
    for (const int corner : cell) middle += body.rest.col(corner) / 4;
    return (middle - Vector3::Constant(0.025)).cwiseAbs().maxCoeff() < 0.005;
  });
  note_cavities(body, hollow);
  REQUIRE(hollow.warnings.size() == 1);
  CHECK_THAT(hollow.warnings[0], Contains("the walls of 1 cavity move as the surface does"));
}

TEST_CASE("sliding grips of several layers hold the narrowing, which is said", "[ends][tension]") {
  const Specimen specimen = bar(8, 1);
  const auto no_error = [&](Grip grip, double depth, double gauge = 0) {
    TensionSetup setup = pull(grip);
    setup.grip_depth = depth;
    if (gauge > 0) setup.gauge = {gauge, 0.02 - gauge};
    return make_tension(specimen.body, setup)->no_reference();
  };
  CHECK(no_error(Grip::sliding, 0).empty());
  CHECK_THAT(no_error(Grip::sliding, 2.6e-3), Contains("the grips hold several layers"));
  CHECK_THAT(no_error(Grip::clamped, 2.6e-3), Contains("the grips clamp"));
  CHECK_THAT(no_error(Grip::sliding, 2.6e-3, 6e-3), Contains("the grips hold several layers"));
  CHECK(no_error(Grip::sliding, 2.6e-3, 7.6e-3).empty());  // a width of 5 mm away from what is held
  // A force on several layers lets them narrow.
  TensionSetup loaded = pull(Grip::sliding);
  loaded.strain.reset(), loaded.force = 1e-5;
  loaded.grip_depth = 2.6e-3, loaded.fixed.emplace();
  for (int molecule = 0; molecule < specimen.body.size(); ++molecule)
    if (specimen.body.rest(0, molecule) < 1e-9) loaded.fixed->push_back(molecule);
  CHECK(make_tension(specimen.body, loaded)->no_reference().empty());
}

TEST_CASE("a stated gauge length or section that is far from the body's own is noted", "[ends][tension]") {
  const Specimen specimen = bar(8, 1);
  const auto noted = [&](double gauge_length, double section) {
    TensionSetup setup = pull(Grip::sliding);
    setup.gauge_length = gauge_length, setup.cross_section = section;
    ShearSetup sheared;
    sheared.axis = Vector3::UnitX(), sheared.direction = Vector3::UnitY(), sheared.strain = 1e-3;
    sheared.cross_section = section;
    std::vector<std::string> notes = make_tension(specimen.body, setup)->findings().notes;
    const auto by_shear = make_shear(specimen.body, sheared, Matrix3::Identity());
    notes.insert(notes.end(), by_shear->findings().notes.begin(), by_shear->findings().notes.end());
    return notes;
  };
  CHECK(noted(0, 0).empty());
  CHECK(noted(0.011, 24e-6).empty());
  CHECK(noted(0.039, 49e-6).empty());
  const std::vector<std::string> far = noted(0.2, 250e-6);
  REQUIRE(far.size() == 3);
  CHECK(far[0] ==
        "gauge_length: 200 mm is given, where the body's own is 20 mm: strain and modulus refer to what is given");
  CHECK_THAT(far[1], StartsWith("cross_section: 250 mm2 is given, where the body's own is 25 mm2"));
  CHECK(far[2] == far[1]);
  CHECK(noted(0, 10e-6).size() == 2);
}
