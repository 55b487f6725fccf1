#include "core/base/rows.h"

#include <array>
#include <catch2/catch.hpp>
#include <limits>

#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"

using namespace elastin;
using Catch::Matchers::Contains;

TEST_CASE("counts end where 32 bits do, and say so before anything is allocated", "[count]") {
  constexpr std::int64_t most = std::numeric_limits<int>::max();
  CHECK(numbered(most, "molecules") == most);
  CHECK_THROWS_WITH(numbered(most + 1, "molecules"), Contains("2147483648 molecules are more than 2147483647"));
  // As many slots as 10⁸ connections with 6 sides of 4 cells each would have; none is read.
  const int one = 0;
  CHECK_THROWS_AS(rows_by_target(1, {&one, std::size_t{2400000000}}), InputError);
  // Products that 32 bits, and those that 64 bits do not hold.
  const CubicPattern axis_and_face{true, true, false};
  for (const std::array<int, 3> counts :
       {std::array{70000, 70000, 1}, {2000, 2000, 2000}, {2000000000, 2000000000, 2000000000}})
    CHECK_THROWS_WITH(cubic_lattice(counts, 1, axis_and_face), Contains("molecules are more than"));
  // 2.4·10⁸ molecules have their numbers; their 3 · 621·622² + 6 · 621²·622 connections have not.
  CHECK_THROWS_WITH(cubic_lattice({622, 622, 622}, 1, axis_and_face),
                    Contains("2159977104 connections are more than 2147483647"));
}

TEST_CASE("a cubic lattice has the connections that are counted, and no other memory", "[count]") {
  for (const std::array<int, 3> n : {std::array{1, 1, 1}, {2, 3, 4}, {1, 5, 6}, {7, 7, 7}}) {
    const Body body = cubic_lattice(n, 1, {true, true, true});
    const auto [x, y, z] = n;
    const int axis = (x - 1) * y * z + x * (y - 1) * z + x * y * (z - 1);
    const int face = 2 * ((x - 1) * (y - 1) * z + (x - 1) * y * (z - 1) + x * (y - 1) * (z - 1));
    const int cubes = (x - 1) * (y - 1) * (z - 1);
    CHECK(body.connections.size() == axis + face + 4 * cubes);
    CHECK(body.connections.ends.capacity() == body.connections.ends.size());
    CHECK(body.cubes.capacity() == static_cast<std::size_t>(cubes));
  }
}
