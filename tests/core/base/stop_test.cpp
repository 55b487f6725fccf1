// A scope ends what its thread solves and fits, and nothing outside of it.

#include "elastin/core/base/stop.h"

#include <catch2/catch.hpp>
#include <thread>

#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/simulation/simulation.h"

using namespace elastin;

TEST_CASE("a scope ends the solves and fits of its thread", "[stop]") {
  Body body = cubic_lattice({4, 4, 4}, 1e-3, {.axis = true, .face = true});
  set_matter(body, 0.5e-3, 1000, 0, 27e-9);
  const Catalog catalog = built_in_catalog();
  const Material material{.youngs_modulus = 5e3};
  Simulation tissue(body, catalog.find("lattice"), material);
  for (int molecule = 0; molecule < 16; ++molecule) tissue.fix(molecule);
  tissue.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", {0, 0, -9.81}}}});
  {
    const StopScope stop([] { return true; });
    CHECK(stop_requested());
    CHECK(tissue.settle().outcome == Outcome::interrupted);
    CHECK(tissue.positions() == body.rest);
    CHECK_THROWS_AS(Simulation(body, catalog.find("fitted:lattice"), material), InputError);
    bool elsewhere = true;
    std::thread([&] { elsewhere = stop_requested(); }).join();
    CHECK_FALSE(elsewhere);
    const StopScope inner([] { return false; });  // the innermost counts
    CHECK(tissue.settle().outcome == Outcome::converged);
  }
  CHECK_FALSE(stop_requested());
  CHECK_NOTHROW(Simulation(body, catalog.find("fitted:lattice"), material));
}
