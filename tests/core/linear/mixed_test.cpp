#include "core/linear/mixed.h"

#include <catch2/catch.hpp>

#include "core/linear/linear_choice.h"
#include "core/shapes/orders.h"
#include "elastin/core/forces/load_table.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

constexpr double kSize = 0.06;  // m

Body block_of(const char* shape, int cubes) {
  const Vector3 size = Vector3::Constant(kSize);
  if (std::string(shape) == "tetrahedron10")
    return with_order(tetrahedral_block(BlockKind::body_centred, {cubes, cubes, cubes}, size), 2);
  const Body lattice = cubic_lattice({cubes + 1, cubes + 1, cubes + 1}, kSize / cubes, {.axis = true, .face = true});
  return with_order(lattice, std::string(shape) == "hexahedron8" ? 1 : 2);
}

/// A block clamped at both ends, one of them lifted.
struct Clamped {
  Clamped(const char* shape, int cubes, double nu) : body(block_of(shape, cubes)), model(body) {
    const Material material{.youngs_modulus = 5e3, .poissons_ratio = nu, .density = 1000};
    model.add(built_in_catalog().find("neo_hookean+volume").make(body, material, {}));
    for (int a = 0; a < body.size(); ++a) {
      const double z = body.rest(2, a);
      if (z < 1e-9 || z > kSize - 1e-9)
        model.supports.push_back({a, Matrix3::Zero(), Vector3(0, 0, z > 1e-9 ? lift : 0)});
    }
  }
  StaticResult solve(LinearMethod method, bool linear = true) {
    state = state_at_rest(body);
    return solve_static(model, state, {.linear = linear, .method = method, .tolerance = 1e-9, .probe = true});
  }
  static constexpr double lift = 0.05 * kSize;
  Body body;
  Model model;
  State state;
};

}  // namespace

TEST_CASE("displacements and pressures together keep their iterations near a Poisson's ratio of one half",
          "[mixed][slow]") {
  for (const auto& [shape, most] : {std::pair{"hexahedron27", 2.5}, {"tetrahedron10", 5.}, {"hexahedron8", 5.}}) {
    Clamped compressible(shape, 4, 0.4), nearly(shape, 4, 0.4999);
    const StaticResult one = compressible.solve("mixed"), other = nearly.solve("mixed");
    REQUIRE(one.outcome == Outcome::converged);
    REQUIRE(other.outcome == Outcome::converged);
    CAPTURE(shape, one.linear_iterations, other.linear_iterations);
    CHECK(other.linear_iterations < most * one.linear_iterations);
    CHECK(other.solver == "linear mixed");
  }
}

TEST_CASE("displacements and pressures together give what a factorisation gives", "[mixed][slow]") {
  for (const char* shape : {"hexahedron27", "tetrahedron10", "hexahedron8"})
    for (const bool linear : {true, false}) {
      Clamped block(shape, 3, 0.499);
      REQUIRE(block.solve("mixed", linear).outcome == Outcome::converged);
      const Positions found = block.state.positions;
      REQUIRE(block.solve("direct", linear).outcome == Outcome::converged);
      CAPTURE(shape, linear);
      CHECK((found - block.state.positions).norm() < 1e-6 * (found - block.body.rest).norm());
    }
}

TEST_CASE("displacements and pressures together: bitwise identical on any number of threads", "[mixed][slow]") {
  Clamped block("hexahedron8", 12, 0.499);
  Positions first;
  for (const int threads : {1, 2, 3}) {
    const ThreadScope scope(nullptr, threads);
    REQUIRE(block.solve("mixed").outcome == Outcome::converged);
    if (threads == 1) first = block.state.positions;
    CHECK(block.state.positions == first);
  }
}

TEST_CASE("displacements and pressures together are chosen where they pay, and leave what they cannot take",
          "[mixed][slow]") {
  const auto chosen = [](Clamped& block) {
    const State rest = state_at_rest(block.body);
    const Tangent tangent(block.model, rest);
    return choose_linear_solver(tangent, "automatic", 1e-10).method->name;
  };
  Clamped soft("hexahedron27", 6, 0.45), stiff("hexahedron27", 6, 0.4999);
  CHECK(chosen(soft) == "multigrid");
  CHECK(chosen(stiff) == "mixed");
  Clamped first_order("hexahedron8", 12, 0.4999);  // one pressure a cell: no gain
  CHECK(chosen(first_order) == "multigrid");
  {  // 2 ν / (1 − 2 ν)
    const State rest = state_at_rest(stiff.body);
    CHECK(SoftVolume::ratio(Tangent(stiff.model, rest)) == Approx(0.9998 / 0.0002).epsilon(1e-9));
  }
  // A load that changes as the body moves has a stiffness that is no cell's.
  stiff.body.radius = VectorX::Constant(stiff.body.size(), 1e-3);
  add_load(stiff.model, *built_in_loads().find("floor"),
           {.numbers = {{"stiffness", 1}}, .vectors = {{"point", {0, 0, -1}}, {"normal", Vector3::UnitZ()}}});
  CHECK(chosen(stiff) == "multigrid");
  const StaticResult result = stiff.solve("mixed");
  CHECK(result.outcome == Outcome::converged);
}
