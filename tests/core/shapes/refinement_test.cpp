#include "elastin/core/shapes/refinement.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/geometry/boundary.h"
#include "core/model/faces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/shapes/arrays.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/shapes/surfaces.h"

using namespace elastin;
using Catch::Matchers::Contains;

namespace {

double surface_of(const Body& body) {
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
  CHECK(surface_of(fine) == Approx(surface_of(coarse)).epsilon(1e-12));
  CHECK(inspect(fine).pieces == 1);
  CHECK(fine.rest.leftCols(coarse.size()) == coarse.rest);
  for (std::size_t i = 0; i < fine.between.size(); ++i) {
    const auto& [a, b] = fine.between[i];
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

TEST_CASE("tetrahedra in the cubes of a lattice fill its box", "[refinement]") {
  const Body lattice = cubic_lattice({3, 4, 2}, 0.5, {});
  const Body body = with_tetrahedra_in_cubes(lattice);
  CHECK(body.size() == 3 * 4 * 2 + 2 * 3 * 1);
  CHECK(body.tetrahedra.size() == 12u * 6u);
  for (const auto& cell : body.tetrahedra) REQUIRE(signed_volume(body.rest, cell) > 0);
  // A box of a × b × c from the origin: V, V a/2 …, V a²/3, V a b/4 …
  const double a = 1, b = 1.5, c = 0.5, volume = a * b * c;
  const std::array<double, 10> wanted{1,         a / 2,     b / 2,     c / 2,     a * a / 3,
                                      a * b / 4, a * c / 4, b * b / 3, b * c / 4, c * c / 3};
  const auto found = moments_of_cells(body);
  for (std::size_t i = 0; i < wanted.size(); ++i) CHECK(found[i] == Approx(volume * wanted[i]).epsilon(1e-12));
  CHECK(surface_of(body) == Approx(2 * (a * b + b * c + c * a)).epsilon(1e-12));
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
  CHECK_THROWS_WITH(with_tetrahedra_in_cubes(disc(1, 1)), Contains("no cubes"));
  Body parts, block = irregular_block();
  Part one;
  one.name = "one";
  add_part(parts, block, one);
  CHECK_THROWS_WITH(refined(parts), Contains("several parts"));
  block.cables.push_back({0, 1});
  CHECK_THROWS_WITH(refined(block), Contains("cables"));
}
