#include "elastin/core/solve/statics.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

const Matrix3 kHeld = Matrix3::Zero();

/// A chain of n connections along x, constant k, length 1 each, held at its first molecule.
struct Chain {
  Chain(int n, double k) {
    std::vector<Vector3> positions;
    std::vector<std::array<int, 2>> pairs;
    for (int i = 0; i <= n; ++i) positions.emplace_back(i, 0, 0);
    for (int i = 0; i < n; ++i) pairs.push_back({i, i + 1});
    body = listed_body(positions, pairs);
    body.mass = VectorX::Constant(n + 1, 0.5);
    body.radius = VectorX::Constant(n + 1, 0.5);
    model = std::make_unique<Model>(body);
    model->add(make_springs(body, VectorX::Constant(n, k)));
    model->supports.push_back({0, kHeld, Vector3::Zero()});
  }
  void pull(const Vector3& force) {
    model->add(std::make_unique<PointLoads>(body, std::vector<int>{body.size() - 1}, force));
  }
  Body body;
  std::unique_ptr<Model> model;
};

}  // namespace

TEST_CASE("a hanging chain stretches as its weight says", "[statics]") {
  // Connection i carries the weight of the n − i molecules below it.
  const int n = 30;
  const double k = 200, g = 9.81;
  for (const char* method : {"pcg", "direct", "multigrid", "automatic"})
    for (const bool linear : {true, false}) {
      Chain chain(n, k);
      chain.model->add(make_gravity(chain.body, {g, 0, 0}));
      State state = state_at_rest(chain.body);
      const StaticResult result = solve_static(*chain.model, state, {.linear = linear, .method = method});
      REQUIRE(result.outcome == Outcome::converged);
      for (int i = 0; i < n; ++i) {
        const double stretch = state.positions(0, i + 1) - state.positions(0, i) - 1;
        REQUIRE(stretch == Approx(0.5 * g * (n - i) / k).epsilon(1e-8));
      }
      CHECK(result.reactions(0, 0) == Approx(-0.5 * g * (n + 1)).epsilon(1e-8));  // the held molecule weighs too
      CHECK(result.residual <= 1e-10);
    }
}

TEST_CASE("a cantilever hangs down in a few iterations a load step, where many small steps lead",
          "[statics][cells][slow]") {
  // Under its weight the tip sinks by nearly its length. In eight load steps usual iterations are 49 to 51.
  const Material soft{.youngs_modulus = 1e5, .poissons_ratio = 0.3, .density = 1000};
  std::vector<Body> bodies;
  for (const char* kind : {"hexahedron20", "tetrahedron10"})
    bodies.push_back(cell_box(cell_kind(kind), {10, 2, 2}, {1, 0.2, 0.2}, 0));
  bodies.push_back(tetrahedral_block(BlockKind::body_centred, {15, 3, 3}, {1, 0.2, 0.2}));
  set_matter(bodies.back(), 0.01, 1000, 0, 0);
  for (const Body& body : bodies)
    for (const char* strategy : {"neo_hookean", "neo_hookean_log"}) {
      INFO((body.blocks.empty() ? "tetrahedra" : body.blocks.front().kind->name) << ", " << strategy);
      int iterations = 0;
      const auto hung = [&](int steps) {
        State state = state_at_rest(body);
        iterations = 0;
        for (int step = 1; step <= steps; ++step) {
          Model model(body);
          model.add(built_in_catalog().find(strategy).make(body, soft, {}));
          model.add(make_gravity(body, {0, 0, -9.81 * step / steps}));
          for (int a = 0; a < body.size(); ++a)
            if (body.rest(0, a) < 1e-9) model.supports.push_back({.molecule = a, .free = Matrix3::Zero()});
          const StaticResult result = solve_static(model, state, {});
          REQUIRE(result.outcome == Outcome::converged);
          iterations += result.newton_iterations;
        }
        return state.positions;
      };
      const Positions finely = hung(20), once = hung(8);
      CHECK(iterations <= 42);
      CHECK((once - finely).norm() <= 1e-7 * (finely - body.rest).norm());
      CHECK((finely - body.rest).row(2).minCoeff() < -0.9);
    }
}

TEST_CASE("near nu = 1/2 a body between clamps is drawn and bent in few Newton iterations", "[statics][cells][slow]") {
  // Hexahedra of 27 nodes found no equilibrium within 200 iterations where the first linear step was no more exact than
  // any other body's.
  for (const char* kind : {"hexahedron8", "hexahedron27", "tetrahedron10"})
    for (const char* strategy : {"neo_hookean+volume", "neo_hookean_log+volume"})
      for (const double aside : {0., 0.01}) {
        INFO(kind << ", " << strategy << ", " << aside << " m aside");
        const Body body = cell_box(cell_kind(kind), {4, 2, 2}, {0.06, 0.03, 0.03}, 0.1);
        const Material soft{.youngs_modulus = 1e4, .poissons_ratio = 0.4999, .density = 1000};
        int iterations = 0;
        const auto drawn = [&](int steps) {
          State state = state_at_rest(body);
          Model model(body);
          model.add(built_in_catalog().find(strategy).make(body, soft, {}));
          iterations = 0;
          for (int step = 1; step <= steps; ++step) {
            model.supports.clear();
            for (int a = 0; a < body.size(); ++a) {
              const Vector3 moved = Vector3(aside > 0 ? 0 : 0.009, aside, 0) * step / steps;
              if (body.rest(0, a) < 1e-9) model.supports.push_back({a, Matrix3::Zero()});
              if (body.rest(0, a) > 0.06 - 1e-9) model.supports.push_back({a, Matrix3::Zero(), moved});
            }
            const StaticResult result = solve_static(model, state, {});
            INFO(step << " of " << steps << ": " << result.cause);
            REQUIRE(result.outcome == Outcome::converged);
            iterations += result.newton_iterations;
          }
          return state.positions;
        };
        const Positions finely = drawn(4), once = drawn(1);
        CHECK(iterations <= 10);
        CHECK((once - finely).norm() <= 1e-6 * (finely - body.rest).norm());
      }
}

TEST_CASE("two molecules pulled by far are one spring, whatever the stretch", "[statics]") {
  for (const double force : {1e-6, 1., 100., 1e5}) {
    Chain chain(1, 10);
    chain.pull({force, 0, 0});
    State state = state_at_rest(chain.body);
    REQUIRE(solve_static(*chain.model, state).outcome == Outcome::converged);
    CHECK(state.positions(0, 1) - 1 == Approx(force / 10).epsilon(1e-7));
  }
}

TEST_CASE("a string under a sideways load: a zero-energy mode that stiffens", "[statics]") {
  // Two connections in line between held ends, the middle pulled sideways by F: 2 k (l − 1) h / l = F, l² = 1 + h².
  Chain chain(2, 1000);
  chain.model->supports.push_back({2, kHeld, Vector3::Zero()});
  chain.model->add(std::make_unique<PointLoads>(chain.body, std::vector<int>{1}, Vector3(0, 0, 5)));
  State state = state_at_rest(chain.body);
  const StaticResult result = solve_static(*chain.model, state);
  REQUIRE(result.outcome == Outcome::converged);
  const double h = state.positions(2, 1), l = std::sqrt(1 + h * h);
  CHECK(2 * 1000 * (l - 1) * h / l == Approx(5).epsilon(1e-8));
  // With small displacements there is no answer, and it says so.
  State again = state_at_rest(chain.body);
  const StaticResult linear = solve_static(*chain.model, again, {.linear = true});
  CHECK(linear.outcome == Outcome::mechanism);
  CHECK_THAT(linear.cause, Catch::Contains("zero-energy mode"));
  CHECK(again.positions == chain.body.rest);
}

TEST_CASE("a free molecule that is pushed ends as a named cause, with finite places", "[statics]") {
  Chain chain(1, 10);
  chain.model->supports.clear();
  chain.pull({1, 0, 0});
  State state = state_at_rest(chain.body);
  const StaticResult result = solve_static(*chain.model, state, {.newton_limit = 50});
  CHECK(result.outcome != Outcome::converged);
  CHECK_FALSE(result.cause.empty());
  CHECK(state.positions.allFinite());
}

TEST_CASE("negative constants: a stable body is solved, an unstable one is said to be", "[statics]") {
  // Springs 3 and −1 side by side make a spring of 2; −3 parallel to 1 pushes away.
  for (const auto& [one, other, stable] : {std::tuple{3., -1., true}, {1., -3., false}}) {
    Body body = listed_body({{0, 0, 0}, {1, 0, 0}}, {{0, 1}, {0, 1}});
    Model model(body);
    model.add(make_springs(body, Eigen::Vector2d(one, other)));
    model.supports = {{0, kHeld, Vector3::Zero()},
                      {1, Vector3::UnitX() * Vector3::UnitX().transpose(), Vector3::Zero()}};
    model.add(std::make_unique<PointLoads>(body, std::vector<int>{1}, Vector3(0.1, 0, 0)));
    State state = state_at_rest(body);
    const StaticResult result = solve_static(model, state);
    REQUIRE(result.outcome == Outcome::converged);
    CHECK(result.unstable == !stable);
    CHECK(state.positions(0, 1) - 1 == Approx(0.1 / (one + other)).epsilon(1e-8));
    for (const char* method : {"pcg", "direct"}) {
      const StaticResult small = solve_static(model, state, {.linear = true, .method = method});
      CHECK((small.outcome == Outcome::converged) == (stable || method == std::string("direct")));
      CHECK((small.cause.find("the solver `direct` finds the equilibrium") != std::string::npos) ==
            (small.outcome != Outcome::converged));
    }
  }
}

TEST_CASE("a start that no force moves is unstable where constants are negative, and nowhere else", "[statics]") {
  struct Row {
    Body body;
    VectorX constants;
    bool held, unstable;
  };
  const auto pair = [] { return listed_body({{0, 0, 0}, {1, 0, 0}}, {{0, 1}, {0, 1}}); };
  const Body chain = listed_body({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1}, {1, 2}}),
             cube = cubic_lattice({3, 3, 3}, 1, {true, true, false});
  const auto all = [](const Body& body, double k) -> VectorX { return VectorX::Constant(body.connections.size(), k); };
  for (const Row& row : {Row{pair(), Eigen::Vector2d(3, -1), true, false},
                         {pair(), Eigen::Vector2d(1, -3), true, true},
                         {pair(), Eigen::Vector2d(3, -1), false, false},  // free to move and to turn
                         {pair(), Eigen::Vector2d(1, -3), false, true},
                         {chain, Eigen::Vector2d(2, 1), true, false},  // a mechanism
                         {chain, Eigen::Vector2d(2, 0), false, false},
                         {cube, all(cube, 50), false, false},
                         {cube, all(cube, -50), false, true},
                         {cube, all(cube, -50), true, true}}) {
    CAPTURE(row.body.size(), row.constants[0], row.constants[1], row.held);
    Model model(row.body);
    model.add(make_springs(row.body, row.constants));
    if (row.held) model.supports = {{0, kHeld, Vector3::Zero()}};
    State state = state_at_rest(row.body);
    const StaticResult result = solve_static(model, state, {.probe = true});
    CHECK(result.outcome == Outcome::converged);
    CHECK(result.unstable == row.unstable);
    CHECK(state.positions == row.body.rest);
  }
}

TEST_CASE("a pulled bar that may turn about its axis is stable, whichever solver looks for a way down",
          "[statics][slow]") {
  const Body body = tetrahedral_block(BlockKind::kuhn, {16, 8, 8}, Vector3(0.16, 0.08, 0.08));
  const Matrix3 across = Matrix3::Identity() - Vector3::UnitX() * Vector3::UnitX().transpose();
  for (const double nu : {0.1, 0.15, 0.25})
    for (const char* method : {"pcg", "multigrid"}) {
      Model model(body);
      model.add(built_in_catalog().find("neo_hookean").make(body, {.youngs_modulus = 1.2e4, .poissons_ratio = nu}, {}));
      for (int i = 0; i < body.size(); ++i) {
        const Vector3 at = body.rest.col(i);
        if (at.x() != 0 && at.x() != body.rest.row(0).maxCoeff()) continue;
        const bool pin = (at - Vector3(0, 0.04, 0.04)).norm() < 1e-9;
        model.supports.push_back({i, pin ? kHeld : across, Vector3(0.01 * at.x(), 0, 0)});
      }
      State state = state_at_rest(body);
      const StaticResult result = solve_static(model, state, {.method = method, .probe = true});
      CAPTURE(nu, method, result.linear_iterations);
      CHECK(result.outcome == Outcome::converged);
      CHECK_FALSE(result.unstable);
    }
}

TEST_CASE("pcg and the factorisation agree, on springs and on cells, with slanted supports", "[statics]") {
  const Material material{.youngs_modulus = 1e4, .poissons_ratio = 0.3};
  const Vector3 normal = Vector3(1, 2, 3).normalized();
  for (const std::string name : {"standard", "van_gelder"}) {
    const Body body = jittered_block();
    Model model(body);
    model.add(built_in_catalog().find(name).make(body, material, {}));
    for (int i = 0; i < body.size(); ++i) {
      if (body.rest(2, i) == 0)
        model.supports.push_back(
            {i, i % 2 ? kHeld : Matrix3(Matrix3::Identity() - normal * normal.transpose()), Vector3::Zero()});
      if (body.rest(2, i) == 0.02)
        model.supports.push_back({i, Matrix3::Identity() - normal * normal.transpose(), 0.002 * normal});
    }
    for (const bool linear : {true, false}) {
      State one = state_at_rest(body), other = one;
      const StaticResult a = solve_static(model, one, {.linear = linear, .method = "pcg", .tolerance = 1e-12});
      const StaticResult b = solve_static(model, other, {.linear = linear, .method = "direct", .tolerance = 1e-12});
      REQUIRE(a.outcome == Outcome::converged);
      REQUIRE(b.outcome == Outcome::converged);
      CHECK((one.positions - other.positions).norm() <= 1e-8 * (one.positions - body.rest).norm());
      CHECK((a.reactions - b.reactions).norm() <= 1e-7 * a.reactions.norm());
      for (const Support& support : model.supports) {
        const Vector3 motion =
            one.positions.col(support.molecule) - body.rest.col(support.molecule) - support.displacement;
        REQUIRE((motion - support.free * motion).norm() <= 1e-16);
      }
    }
  }
}

TEST_CASE("forces and solutions are bitwise identical on any number of threads", "[threads][slow]") {
  Body body = cubic_lattice({19, 19, 19}, 0.01, {true, true, false});
  set_matter(body, 0.005, 1000, 0, 1);
  REQUIRE(body.connections.size() > 50000);  // large enough for several threads to be used
  const VectorX constants = built_in_catalog().find("lattice").constants(body, {.youngs_modulus = 1e4}, {});
  Positions forces, positions;
  for (const int count : {1, 2, 3, 5}) {
    set_threads(count);
    Model model(body);
    model.add(make_springs(body, constants));
    model.add(make_gravity(body, {1, 0, -9.81}));
    for (int i = 0; i < body.size(); ++i)
      if (body.rest(2, i) == 0) model.supports.push_back({i, kHeld, Vector3::Zero()});
    State state = state_at_rest(body);
    const Positions now = model.elastic_forces(deformed(body, 1e-4));
    REQUIRE(solve_static(model, state, {.newton_limit = 2}).newton_iterations == 2);  // bitwise identical all the way
    if (count == 1) forces = now, positions = state.positions;
    CHECK(now == forces);
    CHECK(state.positions == positions);
  }
  set_threads(0);
}

TEST_CASE("the response is the derivative of the equilibrium", "[statics]") {
  Chain chain(3, 50);
  auto load = std::make_unique<PointLoads>(chain.body, std::vector<int>{3}, Vector3(20, 4, 0));
  PointLoads* pull = load.get();
  chain.model->add(std::move(load));
  const auto positions = [&](double factor) {
    pull->set_factor(factor);
    State state = state_at_rest(chain.body);
    REQUIRE(solve_static(*chain.model, state, {.tolerance = 1e-13}).outcome == Outcome::converged);
    return state.positions;
  };
  const double h = 1e-4;
  const Positions measured = (positions(1 + h) - positions(1 - h)) / (2 * h), at = positions(1);
  Positions change = Positions::Zero(3, 4);
  change.col(3) = Vector3(20, 4, 0);
  const StaticResponse response = static_response(*chain.model, at, change, Positions::Zero(3, 4));
  CHECK((response.motion - measured).norm() <= 1e-5 * measured.norm());
  CHECK((response.result.reactions.col(0) + Vector3(20, 4, 0)).norm() <= 1e-8);
}
