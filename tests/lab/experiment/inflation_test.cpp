#include "lab/experiment/inflation/inflation.h"

#include <cmath>

#include "core/forces/pressure.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "support/experiments.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;
using Catch::Matchers::Contains;

namespace {

const std::vector<Vector3> kPlanes{Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()};

/// The first case of the two-parameter paper's Table 1.
const Material kLatex{.youngs_modulus = 50e6, .poissons_ratio = 0.3, .thickness = 1e-3};
/// Shear modulus 1 MPa, incompressible.
const Material kRubber{.youngs_modulus = 3e6, .poissons_ratio = 0.5, .thickness = 1e-3};

Specimen membrane(Body body, const Material& material) {
  set_matter(body, 0.01, material.density, material.thickness, 0);
  return {std::move(body), material, {}};
}

Measures inflated(const Specimen& specimen, const std::string& strategy, bool octant, double pressure = 10e3) {
  InflationSetup setup;
  setup.pressure = pressure;
  if (octant) setup.symmetry = kPlanes;
  const auto experiment = make_inflation(specimen.body, setup, specimen.material);
  return solve(specimen, *experiment, strategy).measures;
}

Measures inflated_octant(const std::string& strategy, int divisions, SphereMesh mesh = SphereMesh::type_1) {
  return inflated(membrane(sphere_octant(1, mesh, divisions), kLatex), strategy, true);
}

Run blown_up(const Specimen& specimen, InflationSetup setup, const std::string& strategy,
             const StaticOptions& statics = {}) {
  setup.symmetry = kPlanes;
  const auto experiment = make_inflation(specimen.body, setup, specimen.material);
  return solve(specimen, *experiment, strategy, statics);
}

/// p of the incompressible neo-Hookean balloon: (2μt/R) (1/λ − 1/λ⁷).
double balloon_pressure(double stretch, double radius) {
  return 2 * 1e6 * 1e-3 / radius * (1 / stretch - std::pow(stretch, -7));
}

}  // namespace

TEST_CASE("a sphere's radius converges at order 2 to the smooth one of its law", "[inflation]") {
  struct Case {
    const char* strategy;
    double radius;  // closed forms: p R l²/2 = N(l), N the tension per width at rest under equal stretches l
  };
  for (const auto& [strategy, radius] :
       {Case{"two_parameter", 1.0819419}, Case{"hencky_membrane", 1.0848351}, Case{"hencky_energy_membrane", 1.0848351},
        Case{"st_venant_kirchhoff_membrane", 1.0724470}}) {
    Refinement radii{};
    for (int level = 0; level < 3; ++level) radii[level] = inflated_octant(strategy, 6 << level).get("radius");
    INFO(strategy);
    CHECK(order_of(radii) == Approx(2).margin(0.15));
    CHECK(second_order_limit(radii[1], radii[2]) == Approx(radius).epsilon(2e-5));
  }
}

TEST_CASE("corners: laws of cells grow round under refinement, Van Gelder's springs do not", "[inflation]") {
  const auto spread = [](const char* strategy, int divisions, SphereMesh mesh) {
    return inflated_octant(strategy, divisions, mesh).get("radius_spread");
  };
  for (const SphereMesh mesh : {SphereMesh::type_1, SphereMesh::type_2}) {
    for (const char* strategy : {"two_parameter", "hencky_energy_membrane"})
      CHECK(spread(strategy, 20, mesh) < spread(strategy, 10, mesh) / 2.5);
    for (const char* strategy : {"van_gelder", "lloyd"}) CHECK(spread(strategy, 20, mesh) > spread(strategy, 10, mesh));
  }
  // The corner of one triangle is stiffer than that of two: the meshes differ there by more than anywhere else.
  const double one = inflated_octant("two_parameter", 10).get("corner_radius"),
               two = inflated_octant("two_parameter", 10, SphereMesh::type_2).get("corner_radius");
  CHECK(one < two);
}

TEST_CASE("an octant between planes of symmetry is the whole sphere", "[inflation]") {
  const Measures octant = inflated(membrane(sphere_octant(1, SphereMesh::type_2, 6), kLatex), "hencky_energy_membrane",
                                   true),
                 whole = inflated(membrane(sphere(1, SphereMesh::type_2, 6), kLatex), "hencky_energy_membrane", false);
  for (const char* measure : {"radius", "corner_radius", "radius_spread", "enclosed_volume", "wall_stress", "energy"}) {
    INFO(measure);
    CHECK(octant.get(measure) == Approx(whole.get(measure)).epsilon(1e-8));
  }
  CHECK(whole.get("reaction_balance") < 1e-9);
  CHECK(octant.get("stretch") == Approx(octant.get("radius")).epsilon(1e-14));
}

TEST_CASE("a balloon follows its curve past the limit pressure, with the volume controlled", "[inflation]") {
  InflationSetup setup;
  setup.volume_ratio = 27;
  setup.load_steps = 8;
  std::array<Run, 2> runs;
  for (const int level : {0, 1})
    runs[level] =
        blown_up(membrane(sphere_octant(0.1, SphereMesh::type_1, 8 << level), kRubber), setup, "neo_hookean_membrane");
  const Body round = sphere(0.1, SphereMesh::type_1, 16);
  const double rest = enclosed_volume(round.triangles, round.rest, Vector3::Zero());
  double highest = 0;
  for (std::size_t step = 0; step < 8; ++step) {
    const Measures &coarse = runs[0].curve[step].measures, &fine = runs[1].curve[step].measures;
    const double stretch = fine.get("stretch");
    CHECK(stretch == Approx(1 + (step + 1) / 4.).epsilon(2e-3));
    const double limit = second_order_limit(coarse.get("pressure"), fine.get("pressure"));
    CHECK(limit == Approx(balloon_pressure(stretch, 0.1)).epsilon(1e-3));
    highest = std::max(highest, fine.get("pressure"));
    CHECK(fine.get("enclosed_volume") / rest == Approx(std::pow(1 + (step + 1) / 4., 3)).epsilon(2e-6));
  }
  CHECK(runs[1].measures.get("pressure") < 0.6 * highest);
  // By pressure alone there is no way past the limit: an outcome with a cause, no number made up.
  const Specimen balloon = membrane(sphere_octant(0.1, SphereMesh::type_1, 4), kRubber);
  InflationSetup too_much;
  too_much.pressure = 14e3;  // the limit is 12.4 kPa
  too_much.symmetry = kPlanes;
  const auto experiment = make_inflation(balloon.body, too_much, kRubber);
  const Catalog catalog = built_in_catalog();
  const Run burst = run_strategy(balloon, *experiment, choose_strategy(catalog, "neo_hookean_membrane"), {});
  CHECK(burst.outcome != Outcome::converged);
  CHECK_FALSE(burst.cause.empty());
}

TEST_CASE("a volume is reached in one load step as in many", "[inflation]") {
  const Specimen balloon = membrane(sphere_octant(0.01, SphereMesh::type_1, 4), kRubber);
  const double rest = enclosed_volume(balloon.body.triangles, balloon.body.rest, Vector3::Zero());
  for (const double ratio : {8., 1.5}) {
    std::array<double, 2> pressures{};
    for (const int steps : {1, 8}) {
      InflationSetup setup;
      setup.volume_ratio = ratio;
      setup.load_steps = steps;
      const Run run = blown_up(balloon, setup, "neo_hookean_membrane");
      INFO(ratio << " in " << steps << ": " << run.cause);
      REQUIRE(run.outcome == Outcome::converged);
      CHECK(run.measures.get("enclosed_volume") / (8 * rest) == Approx(ratio).epsilon(2e-6));
      pressures[steps == 1 ? 0 : 1] = run.measures.get("pressure");
    }
    CHECK(pressures[0] == Approx(pressures[1]).epsilon(1e-5));
  }
}

TEST_CASE("gas inside keeps its law, and the membrane does not know it from a pressure", "[inflation]") {
  const Specimen ball = membrane(sphere_octant(1, SphereMesh::type_1, 8), kLatex);
  InflationSetup setup;
  setup.gas = GasSetup{.start_pressure = 120e3, .ambient = 100e3};
  const Measures start = blown_up(ball, setup, "hencky_energy_membrane").measures;
  const double rest = std::pow(start.get("stretch"), -3);  // volume at rest over now, but for the mesh
  CHECK((start.get("pressure") + 100e3) == Approx(120e3 * rest).epsilon(1e-4));
  setup.gas = GasSetup{.amount = 120e3 * start.get("enclosed_volume") * (start.get("pressure") + 100e3) / 120e3,
                       .ambient = 100e3};
  const Measures amount = blown_up(ball, setup, "hencky_energy_membrane", {.method = "direct"}).measures;
  CHECK(amount.get("radius") == Approx(start.get("radius")).epsilon(1e-9));
  CHECK(inflated(ball, "hencky_energy_membrane", true, start.get("pressure")).get("radius") ==
        Approx(start.get("radius")).epsilon(1e-9));
}

TEST_CASE("pressed from outside, slack or on bad triangles a membrane ends with an outcome that has a name",
          "[inflation][slow]") {
  const Catalog catalog = built_in_catalog();
  const Specimen ball = membrane(sphere(1, SphereMesh::icosahedron, 3), kLatex);
  InflationSetup setup;
  for (const double pressure : {-1e4, 1e-6}) {
    setup.pressure = pressure;
    const auto experiment = make_inflation(ball.body, setup, kLatex);
    for (const char* strategy :
         {"van_gelder", "two_parameter", "st_venant_kirchhoff_membrane", "hencky_energy_membrane"}) {
      INFO(strategy << " " << pressure);
      const Run run = run_strategy(ball, *experiment, choose_strategy(catalog, strategy), {});
      CHECK(run.cause.empty() == (run.outcome == Outcome::converged));
      if (pressure > 0) CHECK(run.outcome == Outcome::converged);
      if (pressure > 0) CHECK(run.measures.get("radius") == Approx(1).epsilon(1e-9));
    }
  }
  // Obtuse: the sphere is twisted, the more the higher, until springs of Van Gelder's are negative.
  Specimen obtuse = membrane(sphere(1, SphereMesh::type_1, 16), kLatex);
  for (int molecule = 0; molecule < obtuse.body.size(); ++molecule) {
    auto position = obtuse.body.rest.col(molecule);
    position = Eigen::AngleAxisd(2 * position.z(), Vector3::UnitZ()) * Vector3(position);
  }
  set_present_lengths(obtuse.body);
  setup.pressure = 10e3;
  const auto twisted = make_inflation(obtuse.body, setup, kLatex);
  for (const char* strategy : {"two_parameter", "hencky_energy_membrane"})
    CHECK(solve(obtuse, *twisted, strategy).measures.get("radius") == Approx(1.083).epsilon(0.01));
  const Run springs = run_strategy(obtuse, *twisted, choose_strategy(catalog, "van_gelder"), {});
  REQUIRE_FALSE(springs.warnings.empty());
  CHECK_THAT(springs.warnings.front(), Contains("negative"));
  // A triangle without area.
  Specimen flat = membrane(sphere(1, SphereMesh::type_1, 2), kLatex);
  const auto& [a, b, c] = flat.body.triangles[3];
  flat.body.rest.col(a) = (flat.body.rest.col(b) + flat.body.rest.col(c)) / 2;
  set_present_lengths(flat.body);
  const auto pinched = make_inflation(flat.body, setup, kLatex);
  const Run run = run_strategy(flat, *pinched, choose_strategy(catalog, "two_parameter"), {});
  CHECK(run.outcome == Outcome::inverted);
  CHECK_THAT(run.cause, Contains("cell 3 of 32 is flat or inverted at rest"));
}

TEST_CASE("bodies that can't be inflated are refused with what they lack", "[inflation]") {
  InflationSetup setup;
  setup.pressure = 1;
  const auto refusal = [&](Body body, Material material = kLatex) -> std::string {
    try {
      make_inflation(body, setup, material);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  CHECK_THAT(refusal(cubic_lattice({2, 2, 2}, 1, {})), Contains("inflation needs a body with triangles"));
  CHECK_THAT(refusal(sphere(1, SphereMesh::type_1, 3), {}), Contains("give material.thickness"));
  const Body octant = sphere_octant(1, SphereMesh::type_1, 3);
  CHECK_THAT(refusal(octant), Contains("9 sides of triangles are at a rim") && Contains("symmetry: [x, y, z]"));
  setup.symmetry = {Vector3::UnitX(), Vector3::UnitY()};
  CHECK_THAT(refusal(octant), Contains("3 sides of triangles are at a rim"));
  CHECK_THAT(refusal(sphere(1, SphereMesh::type_1, 2)), Contains("lies on both sides"));
  Body away = octant;
  away.rest.array() += 1;
  CHECK_THAT(refusal(away), Contains("no molecule lies in one of the planes"));
  setup.symmetry.clear();
  Body inwards = sphere(1, SphereMesh::type_1, 2);
  for (auto& triangle : inwards.triangles) std::swap(triangle[0], triangle[1]);
  CHECK_THAT(refusal(inwards), Contains("look inwards"));
}
