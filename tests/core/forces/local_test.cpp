// What an elastic law makes of one molecule's position: the force on it, and how that changes as it moves.

#include "elastin/core/laws/local.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/solve/stiffness_slopes.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/model/rest.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

LocalBlock block_of(const LocalElasticity& law, const Positions& positions, int molecule) {
  LocalBlock block;
  std::vector<LocalSlot> slots;
  for (int element = 0; element < law.elements(); ++element) {
    const auto molecules = law.molecules_of(element);
    for (std::size_t node = 0; node < molecules.size(); ++node)
      if (molecules[node] == molecule) slots.push_back({element, static_cast<int>(node)});
  }
  law.add_blocks(positions, slots, block);
  return block;
}

void check(const Body& body, const Strategy& strategy, const Positions& positions, bool with_hessian) {
  const Material material{.youngs_modulus = 2e4, .poissons_ratio = 0.3};
  Model model(body);
  model.add(strategy.make(body, material, {}));
  REQUIRE(model.elasticity().size() == 1);
  const LocalElasticity* law = model.elasticity()[0]->local();
  REQUIRE(law);
  const Positions forces = model.elastic_forces(positions);
  const State state{positions, Positions::Zero(3, body.size())};
  const Tangent tangent(model, state);
  double energy = 0;
  for (int element = 0; element < law->elements(); ++element) energy += law->element_energy(positions, element);
  INFO(strategy.name);
  CHECK(energy == Approx(model.elastic_energy(positions)).epsilon(1e-12));
  // Each element by itself, with what stays the same as it moves: its works along any motion.
  const Positions motion = random_motion(body, 3);
  const VectorX works = work_by_stiffness(*law, positions, motion);
  CHECK(works.sum() == Approx(forces.cwiseProduct(motion).sum()).epsilon(1e-10));
  const VectorX stored = StiffnessSlopes(*law, positions).work(motion);
  CHECK((works - stored).norm() <= 1e-13 * works.norm());
  for (int element = 0; element < law->elements(); ++element) {
    double work = 0;
    const auto molecules = law->molecules_of(element);
    for (std::size_t node = 0; node < molecules.size(); ++node) {
      LocalBlock block;
      const LocalSlot slot{element, static_cast<int>(node)};
      law->add_blocks(positions, {&slot, 1}, block);
      work -= block.gradient.dot(motion.col(molecules[node]));
    }
    CHECK(std::abs(works[element] - work) <= 1e-11 * works.cwiseAbs().maxCoeff());
  }
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    const LocalBlock block = block_of(*law, positions, molecule);
    CHECK((block.gradient + forces.col(molecule)).norm() <= 1e-11 * forces.norm());
    if (with_hessian)
      CHECK((block.hessian - tangent.diagonal(molecule)).norm() <= 1e-9 * tangent.diagonal(molecule).norm());
  }
}

}  // namespace

TEST_CASE("local terms give forces, energy and the tangent's own blocks", "[local]") {
  const Catalog catalog = built_in_catalog();
  Body block = jittered_block(), lattice = jittered_lattice();
  if (GENERATE(false, true))
    block.unstressed = lattice.unstressed = std::make_shared<const Rest>(Rest{[](const Vector3& place, const Vector3&) {
      return Matrix3(Vector3(1.05 + place.x(), 0.98, 1.02).asDiagonal());
    }});
  for (const char* law : {"neo_hookean", "st_venant_kirchhoff", "neo_hookean_log"})
    check(block, catalog.find(law), deformed(block, 1e-3), true);
  // Springs that are drawn out: of pressed ones the part that would turn them aside is left out.
  check(lattice, catalog.find("standard"), 1.3 * lattice.rest, true);
  check(lattice, catalog.find("standard"), deformed(lattice, 1e-3), false);
  const Body membrane = sheet(0.001);
  check(membrane, catalog.find("st_venant_kirchhoff_membrane"), deformed(membrane, 1e-3), true);
  for (const char* kind : {"hexahedron8", "tetrahedron10", "hexahedron20"}) {
    Body cells = cell_box(cell_kind(kind), {2, 2, 2}, {0.03, 0.03, 0.03}, 0.1);
    cells.unstressed = block.unstressed;
    check(cells, catalog.find("neo_hookean"), deformed(cells, 1e-3), true);
    if (kind != std::string("hexahedron20"))
      check(cells, catalog.find("neo_hookean+volume"), deformed(cells, 1e-3), true);
  }
}
