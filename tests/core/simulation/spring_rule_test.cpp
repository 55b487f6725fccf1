#include <catch2/catch.hpp>

#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"

using namespace elastin;
using Catch::Matchers::Equals;

namespace {

std::string refusal(const Strategy& rule, const Body& body, const ParameterValues& values) {
  try {
    rule.constants(body, {5000}, values);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("A spring rule made at run time is one as any other", "[strategy]") {
  const Strategy standard = built_in_catalog().find("standard");
  const Strategy rule =
      make_spring_rule("own",
                       [&](const Body& body, const Material& material, const ParameterValues& values) -> VectorX {
                         return values.at("factor") * standard.constants(body, material, {});
                       },
                       {{"factor", dimension::none, 0.1, 10, 2, "by how much it is stiffer"}});
  Body block = tetrahedral_block(BlockKind::kuhn, {1, 1, 1}, {1, 1, 1});
  set_matter(block, 0.1, 1000, 0, 0);
  const VectorX once = standard.constants(block, {5000}, {});
  CHECK(rule.constants(block, {5000}, {}) == 2 * once);
  CHECK(rule.constants(block, {5000}, {{"factor", 3}}) == 3 * once);
  CHECK_THAT(
      refusal(rule, block, {{"factor", 11}}),
      Equals("own.factor: 11 is out of range: it must be at least 0.1 and at most 10 (by how much it is stiffer)"));
  CHECK_THAT(refusal(rule, block, {{"facto", 1}}), Catch::Contains("did you mean 'factor'"));

  // It is not shown the sides of cells, and a stiffer region multiplies what it gives.
  block.connections.cell_sides = 3;
  const int proper = block.connections.proper();
  block.connection_stiffness = VectorX::Constant(block.connections.size(), 5);
  const VectorX some = rule.constants(block, {5000}, {});
  CHECK(some.tail(3) == VectorX::Zero(3));
  CHECK(some.head(proper).isApprox(10 * once.head(proper), 1e-15));
  const ElasticTerms elasticity = rule.make(block, {5000}, {});
  CHECK(elasticity.terms.front()->energy(1.01 * block.rest) > 0);
}

TEST_CASE("A spring rule that gives another number of constants is refused", "[strategy]") {
  const Strategy rule = make_spring_rule(
      "short", [](const Body&, const Material&, const ParameterValues&) -> VectorX { return VectorX::Ones(2); });
  const Body cube = cubic_lattice({2, 2, 2}, 1, {true, false, false});
  CHECK(refusal(rule, cube, {}) == "strategy short gives 2 constants; allowed: 12, one a connection");
}
