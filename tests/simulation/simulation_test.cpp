#include "elastin/simulation/simulation.h"

#include <catch2/catch.hpp>

#include "elastin/base/error.h"
#include "elastin/model/shapes.h"

namespace elastin {
namespace {

const Material kTissue{.youngs_modulus = 10e3, .poissons_ratio = 0.25, .density = 1000};

/// A cube of n³ molecules, 2 mm apart.
Body tissue_cube(int n) {
  constexpr double spacing = 2e-3;
  Body body = cubic_lattice({n, n, n}, spacing, {true, true, false});
  set_matter(body, spacing / 2, 1000, 0, std::pow((n - 1) * spacing, 3));
  return body;
}

}  // namespace

TEST_CASE("a simulation falls as its weight says") {
  Simulation tissue(tissue_cube(3), built_in_catalog().find("lattice"), kTissue);
  tissue.model().add(make_gravity(tissue.body(), {0, 0, -10}));
  for (int step = 0; step < 100; ++step) REQUIRE(tissue.step(1e-3).outcome == Outcome::converged);
  CHECK(tissue.time() == Approx(0.1));
  CHECK(tissue.velocities()(2, 0) == Approx(-1));
}

}  // namespace elastin
