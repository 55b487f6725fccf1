// Displacements of points, as a camera or a scan sees them, and numbers of the whole scene as unknowns.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/base/random.h"
#include "elastin/core/base/error.h"
#include "lab/identify/identify.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();
constexpr double kStrain = 1e-5;  // so small that the law is linear to as many digits

/// A bar of 10 x 10 x 20 mm between grips on which it slides, in uniaxial stress along z.
std::string bar(const std::string& material, const std::string& unknowns, const std::string& more = "",
                const std::string& body = "") {
  return "title: points of a bar\nbody:\n  tetrahedra: {kind: kuhn, cubes: [2, 2, 4], size: [10 mm, 10 mm, 20 mm]}\n" +
         body + "material: {" + material +
         "}\nstiffness: neo_hookean\nexperiment: {kind: tension, axis: z, strain: " + fmt::format("{}", kStrain) +
         "}\nidentify:\n  unknowns: " + unknowns + "\n  tests:\n    - {name: camera, kind: points, file: points.csv" +
         more + "}\n";
}

/// Places within the bar, and where uniaxial stress moves them; seen from a frame that turns and moves.
std::string points(int count, double poissons_ratio, const Matrix3& turn, const Vector3& shift, double noise = 0) {
  std::mt19937_64 generator(7);
  const auto uniform = [&] { return unit_random(generator); };
  std::string text = "x [mm],y [mm],z [mm],ux [mm],uy [mm],uz [mm]\n";
  for (int i = 0; i < count; ++i) {
    const Vector3 at(10 * uniform(), 10 * uniform(), 20 * uniform());
    const Vector3 moved = at + kStrain * Vector3(-poissons_ratio * at.x(), -poissons_ratio * at.y(), at.z());
    const Vector3 scatter(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5);
    const Vector3 seen = turn * moved + shift - at + noise * scatter;
    text += fmt::format("{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n", at.x(), at.y(), at.z(), seen.x(), seen.y(),
                        seen.z());
  }
  return text;
}

Answer answer_of(const TemporaryFolder& folder, const std::string& scene, const std::string& data) {
  folder.write("points.csv", data);
  return identify(folder.write("scene.yaml", scene), kCatalog, {}).front();
}

}  // namespace

TEST_CASE("points alone give Poisson's ratio, from a frame that turned and moved", "[identify][points]") {
  const TemporaryFolder folder;
  const std::string scene = bar("youngs_modulus: 10 kPa, poissons_ratio: 0.2", "[poissons_ratio]");
  const Matrix3 turn = Eigen::AngleAxisd(0.3, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  for (const auto& [by, shift] :
       {std::pair<Matrix3, Vector3>{Matrix3::Identity(), Vector3::Zero()}, {turn, Vector3(3, -1, 2)}}) {
    const Answer answer = answer_of(folder, scene, points(50, 0.35, by, shift));
    CHECK(answer.outcome == FitOutcome::converged);
    CHECK(answer.numbers.front().value == Approx(0.35).epsilon(1e-4));
  }
  const Answer fixed =
      answer_of(folder, bar("youngs_modulus: 10 kPa, poissons_ratio: 0.2", "[poissons_ratio]", ", frame: fixed"),
                points(50, 0.35, Matrix3::Identity(), Vector3(3, -1, 2) * kStrain));
  CHECK(fixed.tests.front().relative_rms > 0.01);  // the shift is then a misfit
}

TEST_CASE("a modulus that moves no molecule has its slope by any linear solver", "[identify][points][slow]") {
  // Uniaxial stress under a prescribed elongation of 1 %, in which E changes the grips' forces alone.
  constexpr double strain = 0.01, modulus = 100e3, poissons_ratio = 0.3;
  const TemporaryFolder folder;
  std::string data = "x [mm],y [mm],ux [mm],uy [mm]\n";
  for (const double x : {3., 9., 15., 21., 27.})
    for (const double y : {2., 5., 8.})
      data += fmt::format("{},{},{},{:.3f}\n", x, y, strain * x, -poissons_ratio * strain * (y - 5));
  folder.write("points.csv", data);
  folder.write("force.csv", fmt::format("displacement [mm],force [N]\n0.15,{0}\n0.3,{1}\n", modulus * strain * 0.5e-4,
                                        modulus * strain * 1e-4));
  for (const std::string solver : {"automatic", "pcg", "multigrid", "direct", "mixed"}) {
    INFO(solver);
    const std::string scene =
        "body: {tetrahedra: {kind: body_centred, cubes: [6, 2, 2], size: [30 mm, 10 mm, 10 mm]}}\nmaterial: "
        "{youngs_modulus: 50 kPa, poissons_ratio: 0.2}\nstiffness: neo_hookean\nexperiment: {kind: tension, axis: x, "
        "displacement: 0.3 mm, load_steps: 2}\nsolver: {linear_solver: " +
        solver +
        "}\nidentify:\n  unknowns: [youngs_modulus, poissons_ratio]\n  tests:\n    - {name: camera, kind: points, "
        "file: "
        "points.csv}\n    - {name: pull, kind: specimen, file: force.csv}\n";
    const Answer answer = identify(folder.write("scene.yaml", scene), kCatalog, {}).front();
    INFO(answer.cause);
    if (solver == "mixed" && answer.outcome == FitOutcome::failed) {  // it serves solids near nu = 1/2
      CHECK_FALSE(answer.cause.empty());
      continue;
    }
    REQUIRE(answer.outcome == FitOutcome::converged);
    CHECK(answer.numbers[0].value == Approx(modulus).epsilon(0.02));  // of small strains
    CHECK(answer.numbers[1].value == Approx(poissons_ratio).epsilon(0.02));
  }
}

TEST_CASE("points alone do not give a modulus, which is said", "[identify][points]") {
  const TemporaryFolder folder;
  const Answer answer = answer_of(folder, bar("youngs_modulus: 10 kPa, poissons_ratio: 0.35", "[youngs_modulus]"),
                                  points(50, 0.35, Matrix3::Identity(), Vector3::Zero(), 1e-6));
  CHECK(answer.outcome == FitOutcome::flat_valley);
  CHECK_THAT(answer.cause, Contains("the data do not change with youngs_modulus: fix it, or measure a force"));
  CHECK_THAT(answer.material, Contains("# youngs_modulus is not determined by the data."));
}

TEST_CASE("any number of the scene may be unknown: the stiffness of a region by points and a force",
          "[identify][points]") {
  // Two halves in series, E below and 3 E above, ν = 0: σ = ε E 2 / (1 + 1/3), strains of σ/E and σ/(3 E).
  const TemporaryFolder folder;
  const double modulus = 20e3, stress = kStrain * modulus * 2 / (1 + 1. / 3);
  std::string data = "x [mm],y [mm],z [mm],ux [mm],uy [mm],uz [mm]\n";
  for (const double z : {1., 4., 9., 11., 16., 19.})
    for (const double x : {1., 8.})
      data += fmt::format("{},{},{},0,0,{:.17g}\n", x, 10 - x, z,
                          stress / modulus * (std::min(z, 10.) + std::max(z - 10, 0.) / 3));
  folder.write("force.csv", fmt::format("displacement [mm],force [N]\n{:.17g},{:.17g}\n{:.17g},{:.17g}\n", 10 * kStrain,
                                        0.5e-4 * stress, 20 * kStrain, 1e-4 * stress));
  const std::string region = "  regions: [{from: [0, 0, 10 mm], to: [10 mm, 10 mm, 20 mm], stiffness: 1}]\n";
  const std::string scene =
      bar("youngs_modulus: 10 kPa, poissons_ratio: 0", "[youngs_modulus, body.regions.0.stiffness]", "", region) +
      "    - {name: pull, kind: specimen, file: force.csv}\n";
  const Answer answer = answer_of(folder, scene, data);
  INFO(answer.cause);
  REQUIRE(answer.outcome == FitOutcome::converged);
  CHECK(answer.numbers[0].value == Approx(modulus).epsilon(1e-4));
  CHECK(answer.numbers[1].name == "body.regions.0.stiffness");
  CHECK(answer.numbers[1].value == Approx(3).epsilon(1e-4));
  REQUIRE(answer.keys.size() == 2);  // of each test of this scene
  CHECK(answer.keys.front().first == "body.regions.0.stiffness");
}

TEST_CASE("an unknown of the scene that changes more than forces is refused", "[identify][points]") {
  const TemporaryFolder folder;
  const std::string data = points(50, 0.35, Matrix3::Identity(), Vector3::Zero());
  const std::string material = "youngs_modulus: 10 kPa, poissons_ratio: 0.35";
  CHECK_THAT(answer_of(folder, bar(material, "[body.tetrahedra.size.2]"), data).cause,
             Contains("body.tetrahedra.size.2: it changes the body's shape at rest"));
  CHECK_THAT(answer_of(folder, bar(material, "[experiment.strain]"), data).cause,
             Contains("changes what its experiment prescribes"));
  CHECK_THROWS_WITH(answer_of(folder, bar(material, "[material.youngs_modulos]"), data),
                    Contains("material.youngs_modulus"));
}

TEST_CASE("files of points that cannot be meant are named with their line", "[identify][points]") {
  const TemporaryFolder folder;
  const std::string scene = bar("youngs_modulus: 10 kPa, poissons_ratio: 0.3", "[poissons_ratio]");
  const auto refused = [&](const std::string& data, const std::string& message, const std::string& own = "") {
    CHECK_THROWS_WITH(answer_of(folder, own.empty() ? scene : own, data), Contains(message));
  };
  refused("x,y,z,ux\n1,1,1,0.1\n", "points.csv:1: column 'x' has no unit; write for example 'x [mm]'");
  refused("x [mm],y [mm],ux [mm]\nmm,mm,um\n1,1,0.1\n", "points.csv:2: column 'ux [mm]': the unit 'um' here");
  refused("a [mm],b [mm]\n1,1\n", "no columns 'x [mm]' and 'y [mm]'");
  refused("x [mm],y [mm],z [mm]\n1,1,1\n", "no column says how the points moved");
  refused("x [m],y [m],z [m],uz [mm]\n1,1,1,0.1\n", "points.csv:2: this point lies");
  refused("x [mm],y [mm],z [mm],uz [mm]\n1,1,1,0.1\n2,2,2,0.1\n", "has 2 displacements at the load 1");
  refused("x [mm],y [mm],z [mm],uz [mm]\n1,1,1,0.1\n3\n2,2,2,0.1\n", "has 2 displacements at the load 1");
  refused("load_factor,x [mm],y [mm],z [mm],uz [mm]\n2,1,1,1,0.1\n", "load_factor 2 is no part of the scene's load",
          bar("youngs_modulus: 10 kPa, poissons_ratio: 0.3", "[poissons_ratio]", ", frame: fixed"));
  refused("x [mm],y [mm],z [mm],uz [mm],sigma [mm]\n1,1,1,0.1,0\n", "points.csv:2: sigma must be above 0");
  refused("x [mm],y [mm],z [mm],uz [mm]\n1,1,1,0\n", "no point moved");
  CHECK_THROWS_WITH(
      answer_of(folder, bar("youngs_modulus: 1 kPa, poissons_ratio: 0.3", "[poissons_ratio]", ", branch: loading"),
                points(9, 0.3, Matrix3::Identity(), Vector3::Zero())),
      Contains("branch"));
}

TEST_CASE("a cruciform's points and forces hold the constants that made them, each by its noise",
          "[identify][points][slow]") {
  const std::string scene = std::string(ELASTIN_SOURCE_DIR) + "/scenes/identify/cruciform.yaml";
  const Answer answer = identify(scene, kCatalog, {}).front();
  REQUIRE(answer.outcome == FitOutcome::converged);
  CHECK(answer.warnings.empty());
  const double made_with[] = {3.51e6, 0.93e6};
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(answer.numbers[i].low < made_with[i]);
    CHECK(answer.numbers[i].high > made_with[i]);
  }
  // 0.1 % of each force and 1 % of the largest displacement.
  CHECK(answer.tests[0].relative_rms == Approx(1e-3).epsilon(0.5));
  CHECK(answer.tests[2].relative_rms == Approx(1e-2).epsilon(0.1));
  CHECK(answer.tests[2].noise / answer.tests[0].noise > 5);
  CHECK_THAT(identify_page({answer}, ""), Contains("Where points are missed"));
  CHECK_THAT(points_csv(answer), Contains("camera,load_factor,"));
  // Without any force the scale is lost in the scatter, and the ratio is what is left.
  const Answer alone = identify(scene, kCatalog, {.tests = {"camera"}}).front();
  CHECK_FALSE(alone.numbers[0].determined);
  REQUIRE_FALSE(alone.warnings.empty());
  CHECK_THAT(alone.warnings.front(), Contains("and c2 / c1 is"));
}

TEST_CASE("points that are missed alike where they are neighbours are a warning", "[identify][points]") {
  const TemporaryFolder folder;
  std::string data = "x [mm],y [mm],z [mm],uz [mm]\n";
  for (int i = 1; i < 40; ++i) {
    const double z = i / 2.;
    data += fmt::format("5,5,{},{:.17g}\n", z, kStrain * (z + 0.02 * z * (20 - z) / 20));
  }
  const Answer answer =
      answer_of(folder, bar("youngs_modulus: 10 kPa, poissons_ratio: 0.3", "[poissons_ratio]", ", frame: fixed"), data);
  CHECK(std::any_of(answer.warnings.begin(), answer.warnings.end(), [](const std::string& warning) {
    return warning.find("agree between neighbouring points") != std::string::npos;
  }));
}

TEST_CASE("an interval is written with the digits that tell its ends from its value", "[identify]") {
  Answer answer;
  answer.numbers = {{"c_1", dimension::pressure, 119912, 0.8, 119910.4, 119913.6, 119912}};
  answer.correlation = MatrixX::Ones(1, 1);
  for (const std::string& text : {answer_text(answer, false), identify_page({answer}, "")}) {
    INFO(text);
    for (const char* number : {"119.912 kPa", "119.910 kPa", "119.914 kPa"})
      CHECK(text.find(number) != std::string::npos);
    CHECK(text.find("120 kPa") == std::string::npos);
  }
}

TEST_CASE("a point is missed by the root mean square of its readings, and is one mark", "[identify][points]") {
  // Two points of two directions each: one is missed by 1 and 1 mm, the other by 2 and 0 mm; all by 1.22 mm.
  TestAnswer test;
  test.name = "camera";
  test.data.places.resize(3, 4);
  test.data.places << 0, 5e-3, 0, 5e-3, 0, 0, 0, 0, 1e-2, 2e-2, 1e-2, 2e-2;
  test.data.axes = {0, 0, 2, 2};
  test.data.y = VectorX::Zero(4);
  test.fitted = VectorX::Zero(4);
  test.fitted << 1e-3, -2e-3, -1e-3, 0;
  Answer answer;
  answer.tests = {test};
  const Plot plot = residual_plot(answer);
  REQUIRE(plot.series.size() == 2);
  for (const auto& [name, at, text] : {std::tuple{"below the rms", 10., "rms 1.0000 mm of 2 readings"},
                                       {"up to twice", 20., "rms 1.4142 mm of 2 readings"}}) {
    const PlotSeries& series = plot.series[at > 15];
    CHECK(series.name == name);
    REQUIRE(series.points.size() == 1);
    CHECK(series.points[0].y == Approx(at));
    CHECK(series.points[0].text == text);
  }
}
