#include "lab/experiment/hydrostatic/hydrostatic.h"

#include "elastin/core/base/error.h"
#include "support/experiments.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;

namespace {

Run press(const Specimen& specimen, const HydrostaticSetup& setup, const std::string& strategy,
          const StaticOptions& statics = {}) {
  const auto experiment = make_hydrostatic(specimen.body, setup, Matrix3::Identity());
  return solve(specimen, *experiment, strategy, statics);
}

}  // namespace

TEST_CASE("pressure of a homogeneous body is the closed form of its law", "[hydrostatic]") {
  // F = a I, J = a³. neo_hookean: stress = lambda (J - 1) + mu (a² - 1)/J; st_venant_kirchhoff: 3K (a² - 1)/(2a).
  for (const Walls walls : {Walls::sliding, Walls::affine})
    for (const double strain : {-0.25, -0.01, 0.3}) {
      const Specimen specimen = jittered_specimen(BlockKind::kuhn, 0.45);
      const double lambda = lame_lambda(specimen.material), mu = lame_mu(specimen.material);
      const double a = 1 + strain, J = a * a * a;
      HydrostaticSetup setup;
      setup.strain = strain;
      setup.walls = walls;
      INFO("strain " << strain << (walls == Walls::affine ? ", affine" : ", walls"));
      const double rubber = lambda * (J - 1) + mu * (a * a - 1) / J,
                   kirchhoff = (3 * lambda + 2 * mu) * (a * a - 1) / (2 * a);
      for (const auto& [law, stress] : {std::pair{"neo_hookean", rubber}, {"st_venant_kirchhoff", kirchhoff}}) {
        const Run run = press(specimen, setup, law, {.tolerance = 1e-13});
        CHECK(run.measures.get("pressure") == Approx(-stress).epsilon(1e-10));
        CHECK(run.measures.get("bulk_modulus") == Approx(stress / (J - 1)).epsilon(1e-10));
        CHECK(run.measures.get("volume_strain") == Approx(J - 1).epsilon(1e-12));
      }
    }
}

TEST_CASE("small pressure: K of cells for any nu, and 2E/3 of the lattice rule", "[hydrostatic]") {
  HydrostaticSetup setup;
  setup.strain = -0.1;  // small displacements: the amount does not matter
  for (const double nu : {0., 0.3, 0.49}) {
    const Run run = press(jittered_specimen(BlockKind::body_centred, nu), setup, "neo_hookean", {.linear = true});
    CHECK(run.measures.get("bulk_modulus") == Approx(1e4 / (3 * (1 - 2 * nu))).epsilon(1e-8));
  }
  Specimen lattice;
  lattice.material.youngs_modulus = 1e4;
  lattice.body = cubic_lattice({4, 5, 6}, 0.01, {true, true, true});
  set_matter(lattice.body, 0.005, 1000, 0, 6e-5);
  for (const Walls walls : {Walls::sliding, Walls::affine}) {
    setup.walls = walls;
    CHECK(press(lattice, setup, "lattice", {.linear = true}).measures.get("bulk_modulus") ==
          Approx(2e4 / 3).epsilon(1e-8));
    CHECK(press(lattice, setup, "calibrated:standard", {.linear = true}).measures.get("bulk_modulus") ==
          Approx(2e4 / 3).epsilon(1e-8));
  }
}

TEST_CASE("pressure is the slope of the energy over the volume, of springs too", "[hydrostatic]") {
  Specimen specimen;
  specimen.material.youngs_modulus = 1e4;
  specimen.body = random_packing({0.02, 0.02, 0.02}, 0.004, 0.0065, 2);
  set_matter(specimen.body, 0.002, 1000, 0, 8e-6);
  const auto at = [&](double strain) {
    HydrostaticSetup setup;
    setup.strain = strain;
    setup.grip_depth = 0.0008;
    return press(specimen, setup, "standard", {.tolerance = 1e-13}).measures;
  };
  const double step = 1e-5, a = 0.95;
  const double slope = (at(a - 1 + step).get("energy") - at(a - 1 - step).get("energy")) / (2 * step);
  const Vector3 size = specimen.body.rest.rowwise().maxCoeff() - specimen.body.rest.rowwise().minCoeff();
  CHECK(at(a - 1).get("pressure") == Approx(-slope / (3 * a * a * size.prod())).epsilon(1e-6));
}

TEST_CASE("walls need a box", "[hydrostatic]") {
  HydrostaticSetup setup;
  setup.strain = -0.01;
  Body wedge = tetrahedral_block(BlockKind::kuhn, {3, 3, 3}, {1, 1, 1});
  for (int i = 0; i < wedge.size(); ++i) wedge.rest(0, i) *= 1 - 0.8 * wedge.rest(2, i);
  CHECK_THROWS_WITH(make_hydrostatic(wedge, setup, Matrix3::Identity()),
                    Catch::Contains("no box along these axes: its side at the end of +x is tilted by 39°"));
  setup.walls = Walls::affine;  // its cells say what its surface is
  CHECK_NOTHROW(make_hydrostatic(wedge, setup, Matrix3::Identity()));
}
