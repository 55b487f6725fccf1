// Loads of FEBio's models: forces against energies, tangents against differences.

#include "febio/loads.h"

#include <catch2/catch.hpp>

#include "febio/constraints.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;
using namespace elastin::febio;

namespace {

Positions forces_of(const Load& load, const State& state) {
  Positions forces = Positions::Zero(3, state.positions.cols());
  load.add_forces(state, forces);
  return forces;
}

void check_derivatives(const Load& load, const State& at, unsigned seed) {
  Body body;
  body.rest = at.positions;
  const Positions motion = random_motion(body, seed);
  const double step = 1e-5;
  State before = at, after = at;
  before.positions -= step * motion;
  after.positions += step * motion;
  const Positions measured = (forces_of(load, after) - forces_of(load, before)) / (2 * step);
  Positions change = Positions::Zero(3, motion.cols()), by_blocks = change;
  load.add_change(at, motion, {}, change);
  load.visit_blocks(at, 0, [&](int a, int b, const Matrix3& block) { by_blocks.col(a) -= block * motion.col(b); });
  const double scale = 1e-7 * (1 + measured.norm());
  CHECK((change - measured).norm() < scale);
  CHECK((by_blocks - measured).norm() < scale);
  if (!load.has_energy()) return;
  const double work = (load.energy(after) - load.energy(before)) / (2 * step);
  CHECK(work == Approx(-forces_of(load, at).cwiseProduct(motion).sum()).epsilon(1e-6).margin(1e-9));
}

}  // namespace

TEST_CASE("loads of FEBio's models: energy and tangent by differences", "[febio]") {
  const Body body = cell_box(cell_kind("hexahedron27"), {1, 1, 1}, {1, 1, 1}, 0.05, true);
  State state{deformed(body, 0.02), Positions::Zero(3, body.size())};
  const CellBlock& block = body.blocks.front();
  std::vector<LoadedFace> faces;
  for (std::size_t f = 0; f < 2; ++f) {
    LoadedFace face{block.kind->face_kinds[f], {}};
    for (const int a : block.kind->faces[f]) face.nodes.push_back(block.cell(0)[a]);
    faces.push_back(face);
  }
  for (const bool at_rest : {false, true}) {
    INFO("at rest: " << at_rest);
    check_derivatives(*make_surface_load(body, {faces, true, Vector3::Zero(), at_rest, {0.7}}), state, 1);
    check_derivatives(*make_surface_load(body, {faces, false, {0.3, -0.2, 1}, at_rest, {2}}), state, 2);
  }
  VolumeConstraint volume{{}, -3, {}, 2};
  for (std::size_t f = 0; f < block.kind->faces.size(); ++f) {
    LoadedFace face{block.kind->face_kinds[f], {}};
    for (const int a : block.kind->faces[f]) face.nodes.push_back(block.cell(0)[a]);
    volume.faces.push_back(face);
  }
  const auto enclosed = make_volume_constraint(body, volume, 0);
  enclosed->set_step(2);
  CHECK(enclosed->energy(state) != 0);
  check_derivatives(*enclosed, state, 5);
  enclosed->set_step(1);
  CHECK(enclosed->energy(state) == 0);
  check_derivatives(*make_linear_springs(body, {{{0, 5}, {2}}, {{3, 9}, {0.5}}}), state, 3);

  std::vector<MassPair> mass;
  for (int a = 0; a < body.size(); ++a)
    mass.push_back({a, a, 2}), mass.push_back({a, (a + 1) % body.size(), 0.25}),
        mass.push_back({(a + 1) % body.size(), a, 0.25});
  const Integration integration{0.3, 0.6, 1.5};
  const auto inertia = make_inertia(body, mass, 0.1 * random_motion(body, 5));
  state.history = inertia->history();
  inertia->set_integration(&integration);
  inertia->set_time(0.5);
  check_derivatives(*inertia, state, 4);
  inertia->commit_step(state);
  CHECK(forces_of(*inertia, state).norm() == 0);  // until the next increment
}
