// The tangent with predicted stresses.

#include "elastin/core/forces/tangent.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "core/linear/smoothing.h"
#include "elastin/core/forces/loads.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

/// Motion of the whole body by a linear map.
Positions mapped(const Body& body, const Matrix3& map) { return map * body.rest; }

/// ½ m·K m with the stresses at `now` less that with predicted ones, from rest on.
double false_energy(const Model& model, const State& rest, const State& now, const Positions& motion) {
  Positions forces;
  Tangent tangent(model, rest);
  tangent.linearise_onward(now, forces);
  // Laws that are linear in the strain are what they are.
  const Positions expected = model.elastic_forces(now.positions);
  CHECK((forces - expected).norm() <= 1e-10 * expected.norm());
  tangent.apply(motion, forces);
  const double predicted = motion.cwiseProduct(forces).sum();
  tangent.linearise_at(now, {});
  tangent.apply(motion, forces);
  return (motion.cwiseProduct(forces).sum() - predicted) / 2;
}

}  // namespace

TEST_CASE("predicted stresses leave out what a turn in one step adds: cells of every shape, and simplices",
          "[tangent][cells]") {
  // u = W x, W skew: E = ½ Wᵀ W, and none that is linear in W. St. Venant and Kirchhoff's S = λ tr E + 2 μ E is the
  // same everywhere, so that a motion G x has the energy ½ V S : Gᵀ G by it.
  const Vector3 size(0.03, 0.02, 0.02);
  Matrix3 W, G;
  W << 0, -0.3, 0.1, 0.3, 0, -0.2, -0.1, 0.2, 0;
  G << 0.5, -0.2, 0.3, 0.1, 0.4, -0.6, 0.7, -0.1, 0.2;
  const Material material{.youngs_modulus = 2e4, .poissons_ratio = 0.3, .density = 1000};
  const double lambda = 2e4 * 0.3 / (1.3 * 0.4), mu = 2e4 / 2.6;
  const Matrix3 E = W.transpose() * W / 2, S = lambda * E.trace() * Matrix3::Identity() + 2 * mu * E;
  const double expected = size.prod() / 2 * S.cwiseProduct(G.transpose() * G).sum();
  std::vector<Body> bodies;
  for (const CellKind& kind : cell_kinds())
    if (kind.dimensions == 3) bodies.push_back(cell_box(kind, {3, 2, 2}, size, 0.1));
  bodies.push_back(tetrahedral_block(BlockKind::kuhn, {3, 2, 2}, size));  // no blocks: by force densities
  set_matter(bodies.back(), 0.003, 1000, 0, 0);
  for (const Body& body : bodies) {
    INFO((body.blocks.empty() ? "tetrahedra" : body.blocks.front().kind->name));
    Model model(body);
    model.add(built_in_catalog().find("st_venant_kirchhoff").make(body, material, {}));
    const State rest = state_at_rest(body);
    State now = rest;
    now.positions += mapped(body, W);
    CHECK(false_energy(model, rest, now, mapped(body, G)) == Approx(expected).epsilon(1e-10));
  }
}

TEST_CASE("strains are predicted from those that are there, and end as these", "[tangent][cells]") {
  // A motion of no length has its own tangent and forces, whatever was predicted before.
  for (const char* strategy : {"neo_hookean", "neo_hookean+volume", "st_venant_kirchhoff"}) {
    INFO(strategy);
    const Body body = cell_box(cell_kind("hexahedron20"), {2, 2, 2}, {0.02, 0.02, 0.02}, 0.1);
    Model model(body);
    model.add(built_in_catalog().find(strategy).make(body, {.youngs_modulus = 2e4, .poissons_ratio = 0.4}, {}));
    State rest = state_at_rest(body), now = rest, same;
    now.positions = deformed(body, 3e-4);
    same = now;
    const Positions motion = random_motion(body, 5);
    Positions expected(3, body.size()), forces;
    Tangent(model, now).apply(motion, expected);
    Tangent tangent(model, rest);
    tangent.linearise_onward(now, forces);
    tangent.apply(motion, forces);
    CHECK((forces - expected).norm() > 1e-3 * expected.norm());
    tangent.linearise_onward(same, forces);
    const Positions exerted = model.elastic_forces(now.positions);
    CHECK((forces - exerted).norm() <= 1e-12 * exerted.norm());
    tangent.apply(motion, forces);
    CHECK((forces - expected).norm() <= 1e-12 * expected.norm());
  }
}

TEST_CASE("links that resist leave no eigenvalue of the diagonal's inverse times the stiffness above 2", "[tangent]") {
  const Body body = jittered_lattice();
  const State rest = state_at_rest(body);
  State pulled = rest, pressed = rest;
  pulled.positions *= 1.3;
  pressed.positions *= 0.5;
  const Material material{.youngs_modulus = 2e4, .poissons_ratio = 0.3};
  const auto model_of = [&](const char* strategy) {
    Model model(body);
    model.add(built_in_catalog().find(strategy).make(body, material, {}));
    return model;
  };
  const Model springs = model_of("lattice");
  // By powers, which find it from below.
  const auto largest = [&](const State& state, const Weights& weights) {
    const Tangent tangent(springs, state, weights);
    CHECK(is_of_resisting_links(tangent));
    Positions x = random_motion(body, 3), y(3, body.size());
    double size = 0;
    for (int power = 0; power < 300; ++power) {
      tangent.apply(x, y);
      for (int a = 0; a < body.size(); ++a) y.col(a) = tangent.diagonal(a).inverse() * y.col(a);
      size = y.norm() / x.norm();
      x = y / y.norm();
    }
    return size;
  };
  CHECK(largest(rest, {}) > 1.5);
  CHECK(largest(rest, {}) <= kLargestOfLinks);
  CHECK(largest(pulled, {}) <= kLargestOfLinks);
  CHECK(largest(pulled, {.velocity = 10, .acceleration = 1e4}) <= kLargestOfLinks);
  CHECK_FALSE(is_of_resisting_links(Tangent(springs, pressed)));
  CHECK_FALSE(is_of_resisting_links(Tangent(model_of("lattice+volume"), rest)));
  Model dragged = model_of("lattice");
  dragged.add(make_gravity(body, {0, 0, -9.81}));
  CHECK(is_of_resisting_links(Tangent(dragged, rest)));
  const Body block = cell_box(cell_kind("hexahedron8"), {2, 2, 2}, {0.02, 0.02, 0.02}, 0.1);
  Model solid(block);
  solid.add(built_in_catalog().find("neo_hookean").make(block, material, {}));
  CHECK_FALSE(is_of_resisting_links(Tangent(solid, state_at_rest(block))));
}
