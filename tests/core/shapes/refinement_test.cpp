#include "core/shapes/refinement.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/geometry/boundary.h"
#include "core/model/block_geometry.h"
#include "core/model/faces.h"
#include "core/shapes/orders.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/shapes/arrays.h"
#include "elastin/core/shapes/shapes.h"
#include "support/bodies.h"

using namespace elastin;
using Catch::Matchers::Contains;

namespace {

double area_of(const Body& body) {
  double sum = 0;
  for (const auto& triangle : boundary_of(body.tetrahedra)) sum += area_vector(body.rest, triangle).norm();
  return sum;
}

/// 6 √2 volume over the cube of the root mean square side: 1 of a regular tetrahedron.
double worst_shape(const Body& body) {
  double worst = 1;
  for (const auto& cell : body.tetrahedra) {
    double squares = 0;
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < a; ++b)
        squares += (body.rest.col(cell[a]) - body.rest.col(cell[b])).squaredNorm() / 6;
    worst = std::min(worst, 6 * std::sqrt(2.) * signed_volume(body.rest, cell) / std::pow(squares, 1.5));
  }
  return worst;
}

Body irregular_block() {
  Body body = tetrahedral_block(BlockKind::alternating, {2, 3, 2}, {0.2, 0.3, 0.4});
  add_jitter(body, 0.01, 3);
  set_matter(body, 1000, 0);
  return body;
}

}  // namespace

TEST_CASE("halved tetrahedra fill the same space, face to face, eight to one", "[refinement]") {
  const Body coarse = irregular_block();
  const Body fine = refined(coarse);
  CHECK(fine.tetrahedra.size() == 8 * coarse.tetrahedra.size());
  CHECK(fine.size() == coarse.size() + coarse.connections.size());  // its connections are the sides of its cells
  for (const auto& cell : fine.tetrahedra) REQUIRE(signed_volume(fine.rest, cell) > 0);
  const auto before = moments_of_cells(coarse), after = moments_of_cells(fine);
  for (std::size_t i = 0; i < before.size(); ++i) CHECK(after[i] == Approx(before[i]).epsilon(1e-12));
  // Inner faces that did not fit would count as surface.
  CHECK(area_of(fine) == Approx(area_of(coarse)).epsilon(1e-12));
  CHECK(inspect(fine).pieces == 1);
  CHECK(fine.rest.leftCols(coarse.size()) == coarse.rest);
  for (std::size_t i = 0; i < fine.between.size(); ++i) {
    REQUIRE(fine.between[i].size() == 2);
    const auto& [a, b] = std::pair(fine.between[i][0].first, fine.between[i][1].first);
    CHECK((fine.rest.col(coarse.size() + static_cast<int>(i)) - (coarse.rest.col(a) + coarse.rest.col(b)) / 2).norm() <
          1e-15);
  }
  CHECK(fine.mass.sum() == Approx(coarse.mass.sum()).epsilon(1e-12));
}

TEST_CASE("cells stay as regular as they are, however often they are halved", "[refinement]") {
  // The tetrahedra of a body-centred lattice fall into eight of their own shape [Bey 1995]. 12 a cube have sides 1 and
  // √3/2: 6 √2 (1/12) / (5/6)^(3/2), but for those on the surface.
  Body body = tetrahedral_block(BlockKind::body_centred, {2, 2, 2}, {1, 1, 1});
  const double first = worst_shape(body);
  for (int level = 0; level < 2; ++level) {
    body = refined(body);
    CHECK(worst_shape(body) == Approx(first).epsilon(1e-9));
  }
  Body bent = irregular_block();
  const double before = worst_shape(bent);
  for (int level = 0; level < 3; ++level) bent = refined(bent);
  CHECK(worst_shape(bent) > 0.4 * before);
}

TEST_CASE("masses keep their differences, stiffness its regions", "[refinement]") {
  Body coarse = tetrahedral_block(BlockKind::kuhn, {2, 1, 1}, {2, 1, 1});
  set_matter(coarse, 1000, 0);
  set_region(coarse, {1, 0, 0}, {2, 1, 1}, 7, 3);
  const Body fine = refined(coarse);
  CHECK(fine.mass.sum() == Approx(coarse.mass.sum()).epsilon(1e-12));
  for (std::size_t cell = 0; cell < fine.tetrahedra.size(); ++cell) {
    double x = 0;
    for (const int corner : fine.tetrahedra[cell]) x += fine.rest(0, corner) / 4;
    CHECK(fine.cell_stiffness[static_cast<int>(cell)] == (x > 1 ? 7 : 1));
  }
  // Molecules of the far end weigh three times as much as those of the near one, each for what it stands for.
  double near = 0, far = 0;
  for (int molecule = 0; molecule < fine.size(); ++molecule) {
    if (fine.rest(0, molecule) == 0) near += fine.mass[molecule];
    if (fine.rest(0, molecule) == 2) far += fine.mass[molecule];
  }
  CHECK(far > 1.5 * near);
}

TEST_CASE("halved triangles keep their sheet and how they are turned", "[refinement]") {
  Body coarse = disc(1, 3);
  set_matter(coarse, 1000, 0.01);
  const Body fine = refined(coarse);
  CHECK(fine.triangles.size() == 4 * coarse.triangles.size());
  double area = 0;
  for (const auto& triangle : fine.triangles) {
    CHECK(area_vector(fine.rest, triangle).z() > 0);
    area += area_vector(fine.rest, triangle).norm();
  }
  CHECK(area == Approx(moments_of_cells(coarse)[0]).epsilon(1e-12));
  CHECK(moments_of_cells(fine)[4] == Approx(moments_of_cells(coarse)[4]).epsilon(1e-12));
}

TEST_CASE("cells of any shape are halved: the same space, face to face, the same field", "[refinement]") {
  const Vector3 size(0.03, 0.02, 0.02);
  for (const CellKind& kind : cell_kinds()) {
    if (kind.dimensions != 3) continue;
    INFO(kind.name);
    const Body coarse = testing::cell_box(kind, {3, 2, 2}, size, 0.03, kind.order == 2);
    const Body fine = refined(coarse);
    const std::vector<MoleculeBetween> between(fine.between.end() - (fine.size() - coarse.size()), fine.between.end());
    REQUIRE(fine.blocks.size() == 1);
    CHECK(fine.blocks[0].kind == &kind);
    CHECK(fine.blocks[0].size() == 8 * coarse.blocks[0].size());
    CHECK(flat_or_inverted_cells(fine, fine.rest).empty());
    CHECK(inspect(fine).pieces == 1);
    CHECK(fine.mass.sum() == Approx(coarse.mass.sum()).epsilon(1e-12));
    CHECK(lumped_volumes(fine, 1).sum() == Approx(size.prod()).epsilon(kind.order == 1 ? 1e-12 : 1e-4));
    CHECK(boundary_faces(fine).size() == 4 * boundary_faces(coarse).size());  // all inner faces meet another
    // A field of the cells' order is interpolated exactly where the cells are straight.
    for (std::size_t i = 0; i < between.size() && kind.order == 1; ++i) {
      double sum = 0;
      for (const auto& [molecule, weight] : between[i]) sum += weight * coarse.rest.col(molecule).sum();
      CHECK(sum == Approx(fine.rest.col(coarse.size() + static_cast<int>(i)).sum()).epsilon(1e-12));
    }
  }
}

TEST_CASE("the order of a body's cells changes its molecules and not its matter", "[refinement]") {
  Body lattice = cubic_lattice({3, 3, 2}, 0.01, {true, false, false});
  set_matter(lattice, 1000, 0, 0.004);
  const double volume = 0.02 * 0.02 * 0.01;
  const Body first = with_order(lattice, 1), second = with_order(lattice, 2);
  CHECK(first.blocks[0].kind->name == "hexahedron8");
  CHECK(first.size() == 18);
  CHECK(second.blocks[0].kind->name == "hexahedron27");
  CHECK(second.size() == 5 * 5 * 3);
  CHECK(moments_of_cells(second)[0] == Approx(volume));
  CHECK(second.mass.sum() == Approx(lattice.mass.sum()));
  CHECK(with_order(second, 2).rest == second.rest);
  const Body back = with_order(second, 1);
  CHECK(back.rest == first.rest);
  CHECK_THROWS_WITH(with_order(cubic_lattice({3, 1, 1}, 1, {true, false, false}), 2), Contains("no cells"));
}

TEST_CASE("a grip holds the same matter on finer cells", "[refinement]") {
  // 0.25 deep into cubes of 0.2: two layers of molecules, whose matter ends at 0.2 however fine the cells are.
  Body body = tetrahedral_block(BlockKind::kuhn, {1, 1, 5}, {0.2, 0.2, 1});
  for (int level = 0; level < 3; ++level) {
    const Face face = end_face(body, -Vector3::UnitZ(), 0.25);
    double depth = 0;
    for (const int molecule : face.molecules) depth = std::max(depth, body.rest(2, molecule));
    CHECK(depth == Approx(0.2));
    const int across = (1 << level) + 1;
    CHECK(static_cast<int>(face.molecules.size()) == across * across * across);
    body = refined(body);
  }
}

TEST_CASE("what has no cells, or more than cells, cannot be refined", "[refinement]") {
  CHECK_THROWS_WITH(refined(cubic_lattice({2, 2, 2}, 1, {})), Contains("without cells"));
  Body parts, block = irregular_block();
  Part one;
  one.name = "one";
  add_part(parts, block, one);
  CHECK_THROWS_WITH(refined(parts), Contains("several parts"));
  block.cables.push_back({0, 1});
  CHECK_THROWS_WITH(refined(block), Contains("cables"));
}

TEST_CASE("a lattice of equal molecules has one density once it has cells", "[order]") {
  Body lattice = cubic_lattice({3, 3, 4}, 1e-3, {true, true, false});
  set_matter(lattice, 5e-4, 1000, 0, 12e-9);
  const Body cells = with_order(lattice, 2);
  const VectorX even = 1000 * lumped_volumes(cells, 1);
  CHECK((cells.mass - even).norm() < 1e-12 * even.norm());
}
