#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "lab/experiment/tension/tension.h"
#include "lab/run/specimen.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();

Run pressed(Specimen& specimen, double force, const std::string& strategy, int steps = 1) {
  TensionSetup setup;
  setup.force = force;
  setup.load_steps = steps;
  const auto experiment = make_tension(specimen.body, setup);
  return run_strategy(specimen, *experiment, choose_strategy(kCatalog, strategy), {});
}

/// Numbers of the cells whose corners do not turn as they should.
std::vector<int> inverted_cells(const Body& body, const Positions& positions) {
  std::vector<int> cells;
  for (std::size_t cell = 0; cell < body.tetrahedra.size(); ++cell) {
    Eigen::Matrix4d corners = Eigen::Matrix4d::Ones();
    for (int corner = 0; corner < 4; ++corner)
      corners.block<3, 1>(1, corner) = positions.col(body.tetrahedra[cell][corner]);
    if (!(corners.determinant() > 0)) cells.push_back(static_cast<int>(cell));
  }
  return cells;
}

}  // namespace

TEST_CASE("a step that would invert a cell is cut, counted, and the answer is right", "[inversion]") {
  // Nominal stress −1.5 E at once: the first Newton step, linear, would press the slab to −50 % of its height. The slab
  // is so wide that it does not tilt.
  constexpr double E = 1e4, nu = 0.3, stress = -1.5 * E, area = 0.06 * 0.06;
  Specimen specimen{tetrahedral_block(BlockKind::kuhn, {4, 4, 2}, {0.06, 0.06, 0.015}), {}, {}};
  specimen.material = {.youngs_modulus = E, .poissons_ratio = nu};
  add_jitter(specimen.body, 0.0008, 3);
  set_matter(specimen.body, 0.003, 1000, 0, 0);
  const Run run = pressed(specimen, stress * area, "neo_hookean");
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  CHECK_FALSE(run.unstable);
  CHECK(run.cut_steps > 0);
  CHECK(run.cut_steps <= run.newton_iterations);
  // Neo-Hookean bar: y = lateral stretch², λ l² y² + (μ − λ l) y − μ = 0; nominal stress μ (l − 1/l) + λ y (l y − 1).
  const double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  const double l = 1 + run.measures.get("strain"), b = mu - lambda * l, a = lambda * l * l;
  const double y = (-b + std::sqrt(b * b + 4 * a * mu)) / (2 * a);
  CHECK(mu * (l - 1 / l) + lambda * y * (l * y - 1) == Approx(stress).epsilon(1e-8));
  CHECK(std::abs(run.measures.get("lateral_strain") - (std::sqrt(y) - 1)) < 1e-8);
  // In small steps nothing needs to be cut, and the answer is the same.
  const Run gentle = pressed(specimen, stress * area, "neo_hookean", 40);
  REQUIRE(gentle.outcome == Outcome::converged);
  CHECK(gentle.cut_steps == 0);
  CHECK(gentle.measures.get("strain") == Approx(run.measures.get("strain")).epsilon(1e-8));
}

TEST_CASE("cells that are inverted at rest are named", "[inversion]") {
  Specimen specimen{jittered_block(), {.youngs_modulus = 1e4}, {}};
  Body& body = specimen.body;
  const auto& cell = body.tetrahedra[17];
  const Vector3 face = (body.rest.col(cell[1]) + body.rest.col(cell[2]) + body.rest.col(cell[3])) / 3;
  body.rest.col(cell[0]) += 1.2 * (face - body.rest.col(cell[0]));
  body.connections = connections_of_cells(body.rest, {}, body.tetrahedra);
  const std::vector<int> turned = inverted_cells(body, body.rest);
  REQUIRE(std::find(turned.begin(), turned.end(), 17) != turned.end());
  CHECK(flat_or_inverted_cells(body, body.rest) == turned);
  std::string names;
  for (const int number : turned) names += (names.empty() ? "" : ", ") + std::to_string(number);
  for (const std::string strategy : {"neo_hookean", "st_venant_kirchhoff", "van_gelder"}) {
    const Run run = pressed(specimen, 1e-6, strategy);
    CHECK(run.outcome == Outcome::inverted);
    CHECK_THAT(run.cause, Contains(names + " of " + std::to_string(body.tetrahedra.size())) &&
                              Contains("flat or inverted at rest"));
  }
  CHECK(pressed(specimen, 1e-6, "standard").outcome == Outcome::converged);  // springs have no cells to invert
}

TEST_CASE("a state that starts with cells inverted is named", "[inversion]") {
  const Body body = jittered_block();
  Model model(body);
  model.add(kCatalog.find("neo_hookean").make(body, {}, {}));
  State state = state_at_rest(body);
  state.positions.row(2) *= -1;
  const StaticResult mirrored = solve_static(model, state);
  CHECK(mirrored.outcome == Outcome::inverted);
  const std::string all = std::to_string(body.tetrahedra.size());
  CHECK_THAT(mirrored.cause, Contains("cells 0, 1, 2, 3, 4, 5, 6, 7, 8, 9 and " +
                                      std::to_string(body.tetrahedra.size() - 10) + " more of " + all + " are flat"));
  state = state_at_rest(body);
  state.positions.col(body.tetrahedra[3][0]) = state.positions.col(body.tetrahedra[3][1]);  // flat, not turned
  CHECK_THAT(solve_static(model, state).cause, Contains("3") && Contains("at the start of the step"));
}
