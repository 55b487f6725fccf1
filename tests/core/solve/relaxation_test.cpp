// Ways to an equilibrium other than Newton's, and equilibria that are not stable.

#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "support/bodies.h"

using namespace elastin;

namespace {

const Catalog kCatalog = built_in_catalog();

/// A cube of springs that stands on its lowest plane, under a weight of its own that bends it sideways.
struct Loaded {
  Body body = cubic_lattice({3, 3, 4}, 0.01, {true, true, false});
  Model model{(set_matter(body, 0.005, 1000, 0, 1.2e-5), body)};
  Loaded() {
    model.add(kCatalog.find("lattice").make(body, {.youngs_modulus = 1e4}, {}));
    model.add(make_gravity(body, {40, 10, -9.81}));
    for (int molecule = 0; molecule < 9; ++molecule) model.supports.push_back({molecule});
  }
};

}  // namespace

TEST_CASE("stepping to rest, explicitly or implicitly, arrives where Newton does", "[relaxation]") {
  Loaded newton;
  State answer = state_at_rest(newton.body);
  const StaticResult found = solve_static(newton.model, answer);
  REQUIRE(found.outcome == Outcome::converged);
  const double displacement = (answer.positions - newton.body.rest).norm();
  REQUIRE(displacement > 1e-3);
  for (const StaticMethod by : {StaticMethod::explicit_steps, StaticMethod::implicit_steps}) {
    Loaded stepped;
    State state = state_at_rest(stepped.body);
    StaticOptions options;
    options.static_method = by;
    const StaticResult result = solve_static(stepped.model, state, options);
    INFO(result.solver << ": " << result.cause);
    REQUIRE(result.outcome == Outcome::converged);
    CHECK((state.positions - answer.positions).norm() < 1e-6 * displacement);
    CHECK(result.scale == Approx(found.scale).epsilon(1e-3));
  }
}

TEST_CASE("a straight column beyond its buckling load is left for the bent one", "[statics]") {
  // Two links of length 1 in line, their joint held sideways by two springs: it buckles at half their stiffness
  // [any text on stability]; links and springs alike, but the links a thousand times as stiff.
  std::vector<Vector3> positions{{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {1, 0, 1}, {0, 1, 1}};
  Body body = listed_body(positions, {{0, 1}, {1, 2}, {1, 3}, {1, 4}});
  set_matter(body, 0.1, 1000, 0, 1);
  const auto compressed = [&](double force, bool probe) {
    Model model(body);
    VectorX constants(4);
    constants << 1e5, 1e5, 100, 100;
    model.add(make_springs(body, constants));
    model.add(std::make_unique<PointLoads>(body, std::vector<int>{2}, Positions(Vector3(0, 0, -force))));
    Matrix3 along = Matrix3::Zero();
    along(2, 2) = 1;
    model.supports = {{0}, {2, along}, {3}, {4}};
    State state = state_at_rest(body);
    StaticOptions options;
    options.probe = probe;
    const StaticResult result = solve_static(model, state, options);
    REQUIRE(result.outcome == Outcome::converged);
    CHECK(result.left_saddle == (probe && force > 50));
    CHECK_FALSE((probe && result.unstable));
    return state.positions.col(1).head<2>().norm();
  };
  CHECK(compressed(45, true) < 1e-4);  // below k/2 = 50 N: straight, to what is left unbalanced
  CHECK(compressed(60, true) > 0.01);
}

TEST_CASE("a strut is probed for buckling at the cost of a solve, and buckles with any preconditioner",
          "[statics][slow]") {
  // 25 times as long as thick, held at both ends: it buckles at a strain of π²/3 (1/25)² = 0.5 % [Euler].
  Body body = tetrahedral_block(BlockKind::kuhn, {2, 2, 50}, {0.002, 0.002, 0.05});
  set_matter(body, 0.0005, 1000, 0, 2e-7);
  const auto strained = [&](double strain, const char* solver, bool probe) {
    Model model(body);
    model.add(kCatalog.find("neo_hookean").make(body, {.youngs_modulus = 1e4, .poissons_ratio = 0.3}, {}));
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      const double z = body.rest(2, molecule);
      if (z < 1e-9) model.supports.push_back({molecule});
      if (z > 0.05 - 1e-9) model.supports.push_back({molecule, Matrix3::Zero(), {0, 0, strain * 0.05}});
    }
    State state = state_at_rest(body);
    StaticOptions options;
    options.probe = probe;
    options.method = solver;
    const StaticResult result = solve_static(model, state, options);
    INFO(solver << ": " << result.cause);
    REQUIRE(result.outcome == Outcome::converged);
    const double aside = (state.positions - body.rest).topRows<2>().cwiseAbs().maxCoeff();
    return std::pair(result.linear_iterations, aside);
  };
  CHECK(strained(0.01, "multigrid", true).first < 3 * strained(0.01, "multigrid", false).first);
  for (const char* solver : {"pcg", "multigrid"}) {
    CHECK(strained(-0.002, solver, true).second < 2e-5);
    // What is too much of 1 % goes into the bent length: ∫ y'²/2 = π² a²/(4 L) for y = a (1 − cos 2πz/L)/2, a = 3 mm.
    CHECK(strained(-0.015, solver, true).second > 1e-3);
  }
}
