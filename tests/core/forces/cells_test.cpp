// The cell driver: who adds what on several threads.

#include "elastin/core/forces/cells.h"

#include <catch2/catch.hpp>
#include <random>

#include "core/shapes/surfaces.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

Body large_sheet() {
  Body sheet = rectangular_sheet({0.2, 0.2}, {170, 170}, SheetPattern::alternating);  // 57 800 triangles
  set_matter(sheet, 0.001, 1000, 1e-4, 0);
  return sheet;
}

/// The same with its triangles in any order, so that they reach everywhere among the connections.
Body with_shuffled_cells(Body body) {
  std::shuffle(body.triangles.begin(), body.triangles.end(), std::mt19937(3));
  return body;
}

}  // namespace

TEST_CASE("ranges of connections: each has one owner, and all its cells", "[cell_driver][threads]") {
  const Body sheet = large_sheet();
  const CellGraph graph(sheet.connections, sheet.triangles);
  for (const int count : {1, 2, 3, 7}) {
    int end_before = 0;
    for (int number = 0; number < count; ++number) {
      const auto [first, last, begin, end] = graph.range(number, count);
      CHECK(begin == end_before);
      end_before = end;
      for (int cell = 0; cell < graph.cells(); ++cell)
        for (int side = 0; side < 3; ++side) {
          const int connection = graph.slot_connection[cell * 3 + side];
          if (begin <= connection && connection < end && (cell < first || cell >= last)) FAIL("cell " << cell);
        }
    }
    CHECK(end_before == sheet.connections.size());
  }
}

TEST_CASE("passes over cells are split where cells lie in order, and slotted where they do not",
          "[cell_driver][threads]") {
  const Body sheet = large_sheet(), mixed = with_shuffled_cells(sheet);
  const CellGraph in_order(sheet.connections, sheet.triangles), anyhow(mixed.connections, mixed.triangles);
  set_threads(2);
  const bool several = threads() == 2;
  const int ordered = in_order.ranges(), shuffled = anyhow.ranges();
  set_threads(1);
  CHECK(in_order.ranges() == 1);
  set_threads(0);
  if (!several) return;
  CHECK(ordered == 2);
  CHECK(shuffled == 0);
}

TEST_CASE("passes over cells are bitwise identical on any number of threads", "[cell_driver][threads][slow]") {
  const Material material{.youngs_modulus = 1e6, .poissons_ratio = 0.3, .thickness = 1e-4};
  const Body sheet = large_sheet(), mixed = with_shuffled_cells(sheet);
  for (const Body* body : {&sheet, &mixed})
    for (const char* name : {"st_venant_kirchhoff_membrane", "neo_hookean_membrane"}) {
      const ElasticTerms made = built_in_catalog().find(name).make(*body, material, {});
      const auto& law = dynamic_cast<const EdgeDensities&>(*made.terms.front());
      const auto slopes = law.slopes();
      const Positions positions = deformed(*body, 1e-5);
      const VectorX change = VectorX::LinSpaced(body->connections.size(), -1, 1);
      VectorX expected, expected_change;
      for (const int count : {1, 2, 3}) {
        set_threads(count);
        Workspace workspace;
        VectorX q = VectorX::Constant(body->connections.size(), 0.1), changed = q;
        law.add_force_densities(positions, q, workspace);
        slopes->linearise_at(positions);
        slopes->add_change(change, changed, workspace);
        if (count == 1) expected = q, expected_change = changed;
        CHECK(q == expected);
        CHECK(changed == expected_change);
      }
      set_threads(0);
    }
}
