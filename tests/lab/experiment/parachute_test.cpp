#include <catch2/catch.hpp>
#include <cmath>

#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/air.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/stepper.h"
#include "lab/experiment/parachute/parachute.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

/// A cross of 2 m² with 2 kg under it.
Body canopy() {
  Body body = cross_canopy(0.8, 1.65, 2);
  body.connections = connections_of_cells(body.rest, body.triangles, {});
  body.radius = VectorX::Constant(body.size(), 0.05);
  body.mass = lumped_mass(body.rest, body.triangles, {}, 600, 2e-4);
  hang_load(body, HungFrom::ends, {0, 0, -1.5}, 2000, 2, 0.1);
  return body;
}

}  // namespace

TEST_CASE("a load hangs on cables from the tips of the arms", "[parachute]") {
  const Body body = canopy();
  const int load = body.size() - 1;
  CHECK(body.mass[load] == 2);
  CHECK(body.cables.size() == 4 * 3);  // two squares across each tip
  for (const Cable& cable : body.cables) {
    const auto& [end, other] = body.connections.ends[cable.connection];
    CHECK(other == load);
    CHECK(body.rest.col(end).head<2>().cwiseAbs().maxCoeff() == Approx(1.65 / 2));
  }
  // Cables pull and never push.
  const auto cables = make_cables(body);
  Positions positions = body.rest;
  positions(2, load) += 0.3;
  CHECK(cables->energy(positions) == 0);
  positions(2, load) = -1.5 - 0.3;
  CHECK(cables->energy(positions) > 0);
  CHECK_THROWS_AS(make_parachute(cross_canopy(1, 3, 2), {}), InputError);
}

TEST_CASE("a parachute ends at the speed at which drag carries the weight", "[parachute]") {
  const Body body = canopy();
  const Air air{.density = 1.225, .drag_coefficient = 1.2};
  Model model(body);
  const Material cloth{.youngs_modulus = 1e7, .poissons_ratio = 0.3, .density = 600, .thickness = 2e-4};
  model.add(built_in_catalog().find("st_venant_kirchhoff_membrane").make(body, cloth, {}));
  model.add(make_cables(body));
  model.add(make_air(body, air));
  const auto parachute = make_parachute(body, {.speed = 6});
  const auto rig = parachute->timed_rig(model);
  State state = state_at_rest(body);
  rig->start(state, {});
  const auto stepper = make_stepper({.method = "backward_euler"});
  std::vector<CurvePoint> history;
  for (int step = 0; step <= 150; ++step) {
    CurvePoint row;
    row.time = state.time;
    row.measures = rig->read(state);
    history.push_back(row);
    INFO("step " << step);
    REQUIRE(stepper->advance(model, state, 0.02).outcome == Outcome::converged);
  }
  const Measures& end = history.back().measures;
  CHECK(end.get("drag_balance") == Approx(0).margin(0.02));
  CHECK(end.get("line_force") == Approx(2 * 9.81).epsilon(0.02));
  // By hand: ½ ρ C v² Σ A n_z³ of what has opened is the weight.
  double cubes = 0;
  for (const auto& triangle : body.triangles) {
    const Vector3 area = area_vector(state.positions, triangle);
    cubes += std::pow(std::abs(area.z()), 3) / area.squaredNorm();
  }
  const double weight = body.mass.sum() * 9.81;
  CHECK(end.get("fall_speed") == Approx(std::sqrt(weight / (0.5 * 1.225 * 1.2 * cubes))).epsilon(0.02));
  Measures measured;
  parachute->read_history(history, measured);
  CHECK(measured.get("largest_line_force") > 1.2 * 2 * 9.81);  // it opens with a jerk
  CHECK(measured.get("opening_time") > 0);
}
