#include "elastin/core/model/parts.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/solve/modes.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/ties.h"
#include "elastin/core/geometry/cell_kind.h"
#include "elastin/core/model/surface.h"
#include "support/bodies.h"
#include "support/forces_of.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

Body block(int cubes, double height, double at = 0) {
  Body body = tetrahedral_block(BlockKind::body_centred, {cubes, cubes, 2}, {0.03, 0.03, height});
  set_matter(body, 0.002, 1000, 0, 0);
  body.rest.row(2).array() += at;
  return body;
}

Part named(const char* name, bool rigid = false) {
  Part part;
  part.name = name, part.rigid = rigid;
  return part;
}

/// One block on the other, `lower` and `upper` cubes along their sides.
Body stack(int lower, int upper, double gap = 0) {
  Body body;
  add_part(body, block(lower, 0.02), named("low"));
  add_part(body, block(upper, 0.02, 0.02 + gap), named("high"));
  return body;
}

}  // namespace

TEST_CASE("parts keep what they were, and come out alone again", "[parts]") {
  Body lattice = jittered_lattice(), tetrahedra = jittered_block();
  add_cell_sides(lattice, {{0, 35}, {2, 30}});
  Body whole;
  add_part(whole, lattice, named("one"));
  add_part(whole, tetrahedra, named("other"));
  add_part(whole, sheet(0.001), named("skin"));
  CHECK(whole.size() == lattice.size() + tetrahedra.size() + sheet(0.001).size());
  CHECK(whole.connections.cell_sides == 2);
  CHECK(inspect(whole).pieces == 3);
  const auto same = [&](const Body& was, const char* name) {
    const PartAlone now = part_alone(whole, find_part(whole, name));
    CHECK(now.body.rest == was.rest);
    CHECK(now.body.mass == was.mass);
    CHECK(now.body.connections.ends == was.connections.ends);
    CHECK(now.body.connections.rest_length == was.connections.rest_length);
    CHECK(now.body.connections.cell_sides == was.connections.cell_sides);
    CHECK(now.body.triangles == was.triangles);
    CHECK(now.body.tetrahedra == was.tetrahedra);
    CHECK(now.body.cubes == was.cubes);
  };
  same(lattice, "one"), same(tetrahedra, "other"), same(sheet(0.001), "skin");
  CHECK_THROWS_WITH(add_part(whole, lattice, named("skin")), Catch::Contains("'skin' already"));
  CHECK_THROWS_WITH(find_part(whole, "skn"), Catch::Contains("did you mean 'skin'?"));
  CHECK_THROWS_WITH(find_part(lattice, "skin"), Catch::Contains("no named bodies"));
}

TEST_CASE("a part of first-order cells beside one of blocks is in all that reads blocks", "[parts]") {
  const Body tetrahedra = block(2, 0.02),
             hexahedra = cell_box(cell_kind("hexahedron8"), {2, 2, 2}, {0.03, 0.03, 0.02}, 0),
             curved = cell_box(cell_kind("hexahedron27"), {1, 1, 1}, {0.03, 0.03, 0.02}, 0);
  std::vector<const Body*> bodies{&tetrahedra, &hexahedra, &curved, &tetrahedra};
  for (int turn = 0; turn < 4; ++turn) {
    std::rotate(bodies.begin(), bodies.begin() + 1, bodies.end());
    Body whole;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      Body moved = *bodies[i];
      moved.rest.row(2).array() += 0.1 * static_cast<double>(i);
      add_part(whole, moved, named(("part" + std::to_string(i)).c_str()));
    }
    const Body given = whole;
    std::size_t cells = 0, sides = 0;
    for (const Body* body : bodies) cells += count_cells(*body), sides += surface_of(*body).size();
    CHECK(count_cells(whole) == cells);
    CHECK(surface_of(whole).size() == sides);
    Body cut = whole;  // the tetrahedra of its blocks, in their order, are those of the parts
    set_simplices(cut);
    for (Body* one : {&cut, &whole})
      for (auto& cell : one->tetrahedra) std::sort(cell.begin(), cell.end());
    CHECK(cut.tetrahedra == whole.tetrahedra);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const PartAlone alone = part_alone(given, given.parts[i]);
      CHECK(alone.body.tetrahedra == bodies[i]->tetrahedra);
      CHECK(alone.body.blocks.size() == bodies[i]->blocks.size());
      for (std::size_t k = 0; k < alone.body.blocks.size(); ++k)
        CHECK(alone.body.blocks[k].nodes == bodies[i]->blocks[k].nodes);
    }
  }
}

TEST_CASE("regions go with their part", "[parts]") {
  Body soft = jittered_block(), stiff = jittered_block();
  set_region(stiff, {0, 0, 0}, {0.015, 1, 1}, 10, 2);
  Body whole;
  add_part(whole, soft, named("soft"));
  add_part(whole, stiff, named("stiff"));
  CHECK(part_alone(whole, whole.parts[0]).body.cell_stiffness.isOnes());
  CHECK(part_alone(whole, whole.parts[1]).body.cell_stiffness == stiff.cell_stiffness);
  CHECK(part_alone(whole, whole.parts[1]).body.connection_stiffness == stiff.connection_stiffness);
}

TEST_CASE("molecules in one place become one", "[parts][ties]") {
  Body body = stack(3, 3);
  const Body before = body;
  const TieReport report = tie_parts(body, "low", "high", 1e-6, 1e5);
  CHECK(report.joined == 16);
  CHECK(report.tied == 0);
  CHECK(body.ties.empty());
  CHECK(body.size() == before.size() - 16);
  CHECK(body.mass.sum() == Approx(before.mass.sum()).epsilon(1e-14));
  const BodyFindings findings = inspect(body);
  CHECK(findings.pieces == 1);
  CHECK(findings.duplicate_connections.empty());
  CHECK(body.parts[1].shared.size() == 16);
  CHECK(body.parts[1].count == before.parts[1].count - 16);
  // Each part by itself is as it was, but for the order of the shared molecules.
  for (const std::size_t p : {0U, 1U}) {
    const Body now = part_alone(body, body.parts[p]).body, was = part_alone(before, before.parts[p]).body;
    CHECK(now.size() == was.size());
    CHECK(now.connections.size() == was.connections.size());
    double volume = 0, first = 0;
    for (const auto& cell : now.tetrahedra) volume += signed_volume(now.rest, cell);
    for (const auto& cell : was.tetrahedra) first += signed_volume(was.rest, cell);
    CHECK(volume == Approx(first).epsilon(1e-12));
  }
  CHECK(body.connections.size() == before.connections.size() - 33);  // 24 edges and 9 … of one face of 3 × 3 squares
}

TEST_CASE("other molecules are moved onto the surface and held there", "[parts][ties]") {
  Body body = stack(3, 4, 2e-4);
  const Body before = body;
  CHECK(find_modes_in_parts(body, {}, {}).rigid_motions == 12);
  const TieReport report = tie_parts(body, "high", "low", 3e-4, 1e5);
  CHECK(report.tied == 25);  // of the finer block
  CHECK(find_modes_in_parts(body, {}, {}).rigid_motions == 6);
  CHECK(find_modes_in_parts(body, {{body.ties.front().molecule, Matrix3::Zero()}}, {}).rigid_motions == 3);
  CHECK(report.furthest == Approx(2e-4));
  CHECK(body.size() == before.size());
  for (const Tie& tie : body.ties) {
    CHECK(tie.molecule >= body.parts[1].first);
    Vector3 position = Vector3::Zero();
    double sum = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      position += tie.weights[j] * body.rest.col(tie.corners[j]), sum += tie.weights[j];
      CHECK(tie.corners[j] < body.parts[1].first);
    }
    CHECK(sum == Approx(1).epsilon(1e-12));
    CHECK((position - body.rest.col(tie.molecule)).norm() < 1e-15);
  }
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto& [a, b] = body.connections.ends[c];
    REQUIRE(body.connections.rest_length[c] == Approx((body.rest.col(b) - body.rest.col(a)).norm()));
  }
}

TEST_CASE("ties: forces from an energy, momentum kept, nothing at rest or turned", "[ties]") {
  Body body = stack(2, 3);
  tie_parts(body, "low", "high", 1e-5, 1e5);
  REQUIRE(body.ties.size() == 12);  // 16 of the finer block, but for four corners that are one
  const auto ties = make_ties(body);
  const State state{deformed(body, 5e-4), Positions::Zero(3, body.size())};
  const Positions forces = forces_of(*ties, state), motion = random_motion(body, 3);
  const double size = forces.cwiseAbs().sum();
  CHECK(size > 0);
  CHECK(forces.rowwise().sum().norm() < 1e-13 * size);
  const auto energy = [&](double step) { return ties->energy({state.positions + step * motion, state.velocities}); };
  CHECK((energy(1e-6) - energy(-1e-6)) / 2e-6 == Approx(-forces.cwiseProduct(motion).sum()).epsilon(1e-8));
  Positions change = Positions::Zero(3, body.size()), assembled = change;
  ties->add_change(state, motion, motion, change);
  ties->visit_blocks(state, 0, [&](int a, int b, const Matrix3& part) { assembled.col(a) -= part * motion.col(b); });
  CHECK((change - assembled).norm() < 1e-13 * change.norm());
  CHECK((forces_of(*ties, {state.positions + motion, state.velocities}) - forces - change).norm() <
        1e-12 * change.norm());
  const Matrix3 turn = Eigen::AngleAxisd(1.1, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  CHECK(ties->energy({turn * body.rest, state.velocities}) < 1e-20);
}

TEST_CASE("what is near bone becomes bone", "[parts][ties]") {
  Body body;
  add_part(body, block(2, 0.02), named("bone", true));
  add_part(body, block(3, 0.01, 0.0203), named("cartilage"));
  const Positions before = body.rest;
  const TieReport report = tie_parts(body, "cartilage", "bone", 5e-4, 1e5);
  CHECK(report.fixed == 16);
  CHECK(body.rest == before);
  CHECK(body.ties.empty());
  CHECK(body.parts[0].shared.size() == 16);
  const std::vector<int> bone = molecules_of(body.parts[0]);
  CHECK(bone.size() == static_cast<std::size_t>(body.parts[0].count) + 16);
  for (const int molecule : body.parts[0].shared) CHECK(body.rest(2, molecule) == Approx(0.0203));
}

TEST_CASE("ties that cannot be are refused by name", "[parts][ties]") {
  Body body = stack(2, 3, 1e-3);
  CHECK_THROWS_WITH(tie_parts(body, "low", "hgh", 1e-3, 1), Catch::Contains("did you mean 'high'?"));
  CHECK_THROWS_WITH(tie_parts(body, "low", "low", 1e-3, 1), Catch::Contains("itself"));
  CHECK_THROWS_WITH(tie_parts(body, "low", "high", 1e-4, 1), Catch::Contains("nearest are 1 mm apart"));
  body.parts[0].rigid = body.parts[1].rigid = true;
  CHECK_THROWS_WITH(tie_parts(body, "low", "high", 2e-3, 1), Catch::Contains("both rigid"));
  Body loose;
  for (const double at : {0., 0.031}) {
    Body packing = random_packing({0.03, 0.03, 0.03}, 0.008, 0.012, 1);
    set_matter(packing, 0.004, 1000, 0, 1e-6);
    packing.rest.row(2).array() += at;
    add_part(loose, packing, named(at > 0 ? "b" : "a"));
  }
  CHECK_THROWS_WITH(tie_parts(loose, "a", "b", 2e-3, 1), Catch::Contains("cells: delaunay"));
}
