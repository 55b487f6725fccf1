#include "core/linear/assembled.h"

#include <catch2/catch.hpp>

#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

TEST_CASE("rows of a stiffness multiply as the cells themselves do, on one body after another", "[linear]") {
  AssembledStiffness rows;
  for (const char* law : {"neo_hookean", "st_venant_kirchhoff", "neo_hookean+volume"})
    for (const char* kind : {"hexahedron8", "prism6", "tetrahedron4"}) {
      Body body = cell_box(cell_kind(kind), {3, 2, 2}, {0.03, 0.02, 0.02}, 0.1, 3);
      const Material material{.youngs_modulus = 1e4, .poissons_ratio = 0.45};
      Model model(body);
      model.add(built_in_catalog().find(law).make(body, material, {}));
      State state = state_at_rest(body);
      state.positions.row(0) *= 1.3;
      state.positions += 5e-4 * scattered_directions(body.size());
      const Tangent tangent(model, state);
      const bool blocks = !model.nodal_laws().empty();
      CHECK(AssembledStiffness::pays(tangent, [] { return 100.; }) == blocks);
      CHECK_FALSE(AssembledStiffness::pays(tangent, [] { return 5.; }));
      CHECK_FALSE(AssembledStiffness::pays(Tangent(model, state, {.acceleration = 1e4}), [] { return 100.; }));
      rows.assemble(tangent);
      const Positions motion = scattered_directions(body.size());
      Positions by_cells = Positions::Zero(3, body.size()), by_rows = by_cells;
      tangent.apply(motion, by_cells);
      rows.apply(motion, by_rows);
      INFO(law << " " << kind);
      CHECK((by_rows - by_cells).norm() < 1e-13 * by_cells.norm());
    }
}
