#include "lab/experiment/shear/shear.h"

#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "support/bodies.h"
#include "support/experiments.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;

namespace {

const StaticOptions kExact{.tolerance = 1e-13};

Run shear(const Specimen& specimen, const ShearSetup& setup, const std::string& strategy,
          const StaticOptions& statics = {}) {
  const auto experiment = make_shear(specimen.body, setup, Matrix3::Identity());
  return solve(specimen, *experiment, strategy, statics);
}

}  // namespace

TEST_CASE("simple shear of a homogeneous body is the closed form of its law", "[shear]") {
  // F = I + g d nᵀ. neo_hookean: stress = mu g, normal stress 0. st_venant_kirchhoff: S = (lambda/2 + mu) g² on the
  // plane, S_dn = mu g, so P_dn = mu g + (lambda/2 + mu) g³ and P_nn = (lambda/2 + mu) g².
  for (const BlockKind kind : {BlockKind::kuhn, BlockKind::body_centred})
    for (const double g : {0.1, 0.6, -0.4}) {
      const Specimen specimen = jittered_specimen(kind, 0.4);
      const double mu = lame_mu(specimen.material), bend = lame_lambda(specimen.material) / 2 + mu, area = 0.01;
      ShearSetup setup;
      setup.axis = Vector3::UnitX();
      setup.direction = Vector3(0, 0.6, 0.8);
      setup.strain = g;
      setup.sides = Sides::affine;
      INFO("strain " << g);
      const Run rubber = shear(specimen, setup, "neo_hookean", kExact);
      CHECK(rubber.measures.get("shear_modulus") == Approx(mu).epsilon(1e-10));
      CHECK(rubber.measures.get("force") == Approx(mu * g * area).epsilon(1e-10));
      CHECK(std::abs(rubber.measures.get("axial_force")) < 1e-10 * mu * area);
      const Run kirchhoff = shear(specimen, setup, "st_venant_kirchhoff", kExact);
      CHECK(kirchhoff.measures.get("shear_modulus") == Approx(mu + bend * g * g).epsilon(1e-10));
      CHECK(kirchhoff.measures.get("axial_force") == Approx(bend * g * g * area).epsilon(1e-10));
      CHECK(kirchhoff.measures.get("strain") == g);
    }
}

TEST_CASE("the lattice rule has G = 2E/5 in small shear along and across its axes", "[shear]") {
  Specimen specimen;
  specimen.material.youngs_modulus = 1e4;
  specimen.body = cubic_lattice({4, 5, 6}, 0.01, {true, true, true});
  set_matter(specimen.body, 0.005, 1000, 0, 6e-5);
  for (const Vector3& direction : {Vector3(1, 0, 0), Vector3(0.6, -0.8, 0)}) {
    ShearSetup setup;
    setup.direction = direction;
    setup.displacement = 1e-3;
    setup.sides = Sides::affine;
    const Run run = shear(specimen, setup, "lattice", {.linear = true});
    CHECK(run.measures.get("shear_modulus") == Approx(4000).epsilon(1e-8));
    CHECK(run.measures.get("strain") == Approx(0.02));
    CHECK(run.measures.get("reaction_balance") < 1e-9);
  }
}

TEST_CASE("a clamped cube in shear tends to the converged finite elements", "[shear][reference][slow]") {
  // Q2-Q4 hexahedra, neo-Hookean; force to 1e-3, axial force to 1e-2. The singular edges of the plates leave order 1.5,
  // and an extrapolation from 12 cubes a side another 1e-3: from 16 it hits 2588.0, 7903.7 and 13609.
  const OneThread alone;
  struct Row {
    double displacement, force, axial;
  };
  for (const Row& row : {Row{0.1, 2588.9, 168.5}, {0.3, 7905, 1476}, {0.5, 13598, 3902}}) {
    Refinement force{}, axial{};
    for (const std::size_t i : {0u, 1u, 2u}) {
      ShearSetup setup;
      setup.displacement = row.displacement;
      const Run run = shear(reference_cube(3 << i), setup, "neo_hookean", {.tolerance = 1e-6});
      force[i] = run.measures.get("force");
      axial[i] = run.measures.get("axial_force");
      CHECK(run.measures.get("shear_modulus") == Approx(force[i] / row.displacement));
    }
    INFO(row.displacement << ": order " << order_of(force) << ", " << order_of(axial));
    CHECK(order_of(force) == Approx(1.5).margin(0.1));
    CHECK(limit_of(force) == Approx(row.force).epsilon(2e-3));
    CHECK(limit_of(axial) == Approx(row.axial).epsilon(1e-2));
  }
}

TEST_CASE("the force of shear is the slope of the energy over the displacement", "[shear]") {
  const Specimen specimen = jittered_specimen(BlockKind::alternating, 0.3);
  const auto at = [&](double displacement) {
    ShearSetup setup;
    setup.displacement = displacement;
    return shear(specimen, setup, "neo_hookean", kExact).measures;
  };
  const double step = 1e-5;
  const double slope = (at(0.03 + step).get("energy") - at(0.03 - step).get("energy")) / (2 * step);
  CHECK(at(0.03).get("force") == Approx(slope).epsilon(1e-6));
}

TEST_CASE("shear that cannot be is refused", "[shear]") {
  Specimen specimen = jittered_specimen(BlockKind::kuhn, 0.3);
  ShearSetup setup;
  setup.strain = 0.1;
  setup.sides = Sides::affine;
  setup.grip_depth = 0.01;
  CHECK_THROWS_WITH(make_shear(specimen.body, setup, Matrix3::Identity()), Catch::Contains("grip_depth"));
  setup.grip_depth = 0;
  const Body flat = cubic_lattice({4, 4, 1}, 1, {true, true, false});
  CHECK_THROWS_AS(make_shear(flat, setup, Matrix3::Identity()), InputError);
  const Body sheet = rectangular_sheet({0.05, 0.03}, {5, 3}, SheetPattern::one_way);
  CHECK_THROWS_WITH(make_shear(sheet, setup, Matrix3::Identity()),
                    Catch::Contains("a membrane of triangles: leave `sides` out"));
  Body ball = cubic_lattice({5, 5, 5}, 1, {true, true, false});
  for (int i = 0; i < ball.size(); ++i) {  // every molecule further out than 2 spacings comes in to the sphere
    const Vector3 arm = ball.rest.col(i) - Vector3(2, 2, 2);
    if (arm.norm() > 2) ball.rest.col(i) = Vector3(2, 2, 2) + arm * (2 / arm.norm());
  }
  CHECK_THROWS_WITH(make_shear(ball, setup, Matrix3::Identity()), Catch::Contains("no box"));
}

TEST_CASE("a body that bends as it shears has the material's G for no target", "[shear]") {
  ShearSetup setup;
  setup.strain = 1e-3;
  const Body cube = tetrahedral_block(BlockKind::kuhn, {2, 2, 2}, {0.01, 0.01, 0.01}),
             plate = tetrahedral_block(BlockKind::kuhn, {8, 8, 1}, {0.1, 0.1, 0.005});
  const Material material{.youngs_modulus = 1e4, .poissons_ratio = 0.25};
  const auto target = [&](const Body& body, Sides sides) {
    setup.sides = sides;
    const auto experiment = make_shear(body, setup, Matrix3::Identity());
    CHECK(experiment->no_reference().empty() == !experiment->apparent());
    return experiment->main_measures(material, {}).front().prescribed;
  };
  CHECK(std::isnan(target(cube, Sides::free)));
  CHECK(target(cube, Sides::affine) == Approx(4000));
  CHECK(target(plate, Sides::free) == Approx(4000));
}

TEST_CASE("half a block behind a plane of symmetry takes half the force of the whole", "[shear]") {
  Specimen whole, half;
  whole.material = half.material = {.youngs_modulus = 25e3, .poissons_ratio = 0.25};
  whole.body = cell_box(cell_kind("hexahedron8"), {4, 2, 3}, {0.02, 0.01, 0.015}, 0);
  half.body = cell_box(cell_kind("hexahedron8"), {2, 2, 3}, {0.01, 0.01, 0.015}, 0);
  ShearSetup setup;
  setup.direction = Vector3::UnitY();
  setup.strain = 0.1;
  const Run of_whole = shear(whole, setup, "neo_hookean", kExact);
  const auto experiment = make_shear(half.body, setup, Matrix3::Identity());
  std::vector<Support> plane;
  for (int molecule = 0; molecule < half.body.size(); ++molecule)
    if (half.body.rest(0, molecule) == 0) plane.push_back({molecule, Matrix3(Vector3(0, 1, 1).asDiagonal())});
  experiment->set_further_supports(plane);
  const Run of_half = solve(half, *experiment, "neo_hookean", kExact);
  for (const char* measure : {"force", "axial_force"})
    CHECK(2 * of_half.measures.get(measure) == Approx(of_whole.measures.get(measure)).epsilon(1e-8));
  CHECK(of_half.measures.get("shear_modulus") == Approx(of_whole.measures.get("shear_modulus")).epsilon(1e-8));
}
