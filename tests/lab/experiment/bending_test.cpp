#include "lab/experiment/bending/bending.h"

#include "elastin/core/base/error.h"
#include "support/experiments.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;

namespace {

/// The cantilever of the references: 1 x 0.2 x 0.2 m, nu = 0.3, 1000 kg/m³, `cubes` across.
Specimen beam(int cubes, double E) {
  Specimen specimen;
  specimen.material = {.youngs_modulus = E, .poissons_ratio = 0.3};
  specimen.body = tetrahedral_block(BlockKind::body_centred, {5 * cubes, cubes, cubes}, {1, 0.2, 0.2});
  set_matter(specimen.body, 0.1 / cubes, 1000, 0, 0);
  return specimen;
}

BendingSetup own_weight() {
  BendingSetup setup;
  setup.gravity = 9.81;
  return setup;
}

Run bend(const Specimen& specimen, const BendingSetup& setup, const std::string& strategy,
         const StaticOptions& statics = {}) {
  const auto experiment = make_bending(specimen.body, setup, specimen.material);
  return solve(specimen, *experiment, strategy, statics);
}

}  // namespace

TEST_CASE("a linear cantilever tends to the converged finite elements with order 2", "[bending][reference][slow]") {
  const OneThread alone;
  Refinement tip{};
  for (const std::size_t i : {0u, 1u, 2u})
    tip[i] = bend(beam(2 << i, 1e6), own_weight(), "st_venant_kirchhoff", {.linear = true, .tolerance = 1e-8})
                 .measures.get("tip_deflection");
  INFO(tip[0] << " " << tip[1] << " " << tip[2]);
  CHECK(order_of(tip) == Approx(2).margin(0.2));
  CHECK(second_order_limit(tip[1], tip[2]) == Approx(0.37666).epsilon(6e-4));  // the reference's own error
}

TEST_CASE("a neo-Hookean cantilever tends to the converged finite elements", "[bending][reference][slow]") {
  const OneThread alone;
  const Measures coarse = bend(beam(3, 1e6), own_weight(), "neo_hookean", {.tolerance = 1e-6}).measures,
                 fine = bend(beam(6, 1e6), own_weight(), "neo_hookean", {.tolerance = 1e-6}).measures;
  const auto limit = [&](const char* name) { return second_order_limit(coarse.get(name), fine.get(name)); };
  // The reference's own error is 6e-4; from 12 cubes across these are 0.34544 and 0.06663.
  CHECK(limit("tip_deflection") == Approx(0.34556).epsilon(1e-3));
  CHECK(limit("tip_shortening") == Approx(0.06667).epsilon(3e-3));
  CHECK(std::isnan(fine.get("effective_modulus")));  // too far for the beam formula
}

TEST_CASE("a soft cantilever hangs down in any number of load steps", "[bending][reference][slow]") {
  const Specimen specimen = beam(2, 1e5);
  BendingSetup setup = own_weight();
  const double at_once = bend(specimen, setup, "neo_hookean").measures.get("tip_deflection");
  for (const int steps : {2, 4, 5, 10}) {
    setup.load_steps = steps;
    const Run run = bend(specimen, setup, "neo_hookean");
    CHECK(run.measures.get("tip_deflection") == Approx(at_once).epsilon(1e-7));
    CHECK(run.curve.size() == static_cast<std::size_t>(steps));
  }
  const Measures finer = bend(beam(4, 1e5), own_weight(), "neo_hookean", {.tolerance = 1e-6}).measures;
  // Converged: 0.9689 and 0.6955. So soft a beam shows order 2 on finer meshes only: 8 cubes across hit 0.9684.
  CHECK(second_order_limit(at_once, finer.get("tip_deflection")) == Approx(0.9689).epsilon(6e-3));
  CHECK(finer.get("tip_shortening") < 0.6955);
}

TEST_CASE("gravity and a tip force measure one modulus, which tends to that of the clamped beam", "[bending][slow]") {
  const OneThread alone;
  const StaticOptions small{.linear = true, .tolerance = 1e-8};
  const Specimen specimen = beam(4, 1e6);
  const double modulus = bend(specimen, own_weight(), "neo_hookean", small).measures.get("effective_modulus");
  for (const Vector3& direction : {Vector3(0, 0, -1), Vector3(0, 0.6, 0.8)}) {  // a square section bends alike in all
    BendingSetup setup;
    setup.direction = direction;
    setup.force = 0.01;
    const Measures tip = bend(specimen, setup, "neo_hookean", small).measures;
    CHECK(tip.get("effective_modulus") == Approx(modulus).epsilon(0.01));
    CHECK(tip.get("force") == Approx(0.01));
    CHECK(tip.get("reaction_balance") < 1e-6);
  }
  // The clamped root cannot widen: converged finite elements sink by 0.37666 m only. The Timoshenko beam,
  // rho g A L⁴/(8 E I) + (12 + 11 nu) rho g L²/(10 E), does so at 1.0165 E.
  const double expected = (9810 * 12 / (8 * 0.2 * 0.2) + 15.3 * 9810 / 10) / 0.37666;
  const double finer = bend(beam(8, 1e6), own_weight(), "neo_hookean", small).measures.get("effective_modulus");
  CHECK(second_order_limit(modulus, finer) == Approx(expected).epsilon(2e-3));
}

TEST_CASE("the small-deflection formula is kept to small deflections", "[bending]") {
  BendingSetup setup = own_weight();
  const Run stiff = bend(beam(2, 1e7), setup, "neo_hookean"), soft = bend(beam(2, 1e6), setup, "neo_hookean");
  CHECK(stiff.measures.get("effective_modulus") > 1e7);
  CHECK(stiff.remark.empty());
  CHECK(std::isnan(soft.measures.get("effective_modulus")));
  CHECK_THAT(soft.remark, Catch::Contains("the tip sinks by 25.8 % of the length"));
}

TEST_CASE("calibrated bends as the beam of the material", "[bending]") {
  Specimen specimen = beam(2, 1e7);
  BendingSetup setup = own_weight();
  const Run run = bend(specimen, setup, "calibrated:van_gelder", {.linear = true});
  CHECK(run.measures.get("effective_modulus") == Approx(1e7).epsilon(1e-8));
}

TEST_CASE("the tip is read at the middle of the end face, whatever sits there", "[bending]") {
  // With an even number of cubes a molecule sits there, with an odd one four are equally near: both lie on one line of
  // convergence.
  const StaticOptions small{.linear = true, .tolerance = 1e-8};
  const auto tip = [&](int cubes) {
    return bend(beam(cubes, 1e6), own_weight(), "neo_hookean", small).measures.get("tip_deflection");
  };
  const double even = tip(4), odd = tip(5);
  CHECK((25 * odd - 16 * even) / 9 == Approx(0.37666).epsilon(2e-3));
}

TEST_CASE("the tip is read at its centre where no molecules are evenly about it", "[bending]") {
  Specimen specimen = beam(5, 1e6);
  int nearest = -1;
  for (int molecule = 0; molecule < specimen.body.size(); ++molecule)
    if (specimen.body.rest(0, molecule) > 1 - 1e-9 &&
        (nearest < 0 || (specimen.body.rest.col(molecule).tail<2>().array() - 0.1).matrix().norm() <
                            (specimen.body.rest.col(nearest).tail<2>().array() - 0.1).matrix().norm() - 1e-9))
      nearest = molecule;
  specimen.body.rest(2, nearest) += specimen.body.rest(2, nearest) < 0.1 ? 1e-5 : -1e-5;  // alone from now on
  const Run run = bend(specimen, own_weight(), "neo_hookean", {.linear = true, .tolerance = 1e-10});
  const double deflection = run.measures.get("tip_deflection");
  CHECK(deflection == Approx(0.37666).epsilon(0.1));
  CHECK(std::abs(run.measures.get("tip_shortening")) < 1e-3 * deflection);  // a tip that turns comes no nearer
}
