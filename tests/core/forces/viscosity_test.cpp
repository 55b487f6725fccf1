#include "elastin/core/forces/viscosity.h"

#include <catch2/catch.hpp>

#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

Positions forces_of(const Body& body, const Viscosity& viscosity, const State& state) {
  const Model model(body);
  const auto [squared_lengths, rates] = model.squared_lengths_and_rates(state);
  VectorX force_densities = VectorX::Zero(body.connections.size());
  Workspace workspace;
  viscosity.add_force_densities(squared_lengths, rates, force_densities, workspace);
  Positions forces = Positions::Zero(3, body.size());
  model.gather(state.positions, force_densities, forces);
  return forces;
}

}  // namespace

TEST_CASE("internal damping works along connections only and never adds energy", "[viscosity]") {
  const Body body = jittered_lattice();
  const State state = moving(body);
  const auto damping = make_damping(0.3);
  const Positions forces = forces_of(body, *damping, state);
  CHECK(forces.cwiseProduct(state.velocities).sum() < 0);
  CHECK(forces.rowwise().sum().norm() <= 1e-13 * forces.norm());
  // A rigid motion is not damped.
  State rigid = state;
  const Vector3 spin(1, -2, 0.5);
  for (int i = 0; i < body.size(); ++i)
    rigid.velocities.col(i) = Vector3(3, 1, 2) + spin.cross(Vector3(state.positions.col(i)));
  CHECK(forces_of(body, *damping, rigid).norm() <= 1e-12 * forces.norm());
  // Two molecules by hand: F = −b (Δv·u) u.
  Body pair = listed_body({{0, 0, 0}, {2, 0, 0}}, {{0, 1}});
  State apart = state_at_rest(pair);
  apart.velocities.col(1) = Vector3(0.5, 7, 0);
  CHECK((forces_of(pair, *make_damping(4), apart).col(1) - Vector3(-2, 0, 0)).norm() < 1e-15);
}

TEST_CASE("damping of cells is the finite-element force of its stress, takes energy, and lets a body turn",
          "[viscosity]") {
  const Body body = jittered_block();
  const State state = moving(body);
  const double bulk = 0.7, shear = 0.4;
  const auto damping = make_cell_damping(body, bulk, shear);
  const Positions forces = forces_of(body, *damping, state);
  // f_a = −V F S ∇N_a, S = φ tr(Ė) I + 2ψ Ė, Ė = sym(Fᵀ Ḟ), all from the deformation gradient.
  Positions expected = Positions::Zero(3, body.size());
  for (const auto& cell : body.tetrahedra) {
    const auto edges = [&](const Positions& vectors) {
      Matrix3 matrix;
      for (int i = 0; i < 3; ++i) matrix.col(i) = vectors.col(cell[i + 1]) - vectors.col(cell[0]);
      return matrix;
    };
    const Matrix3 rest = edges(body.rest), gradients = rest.inverse().transpose();  // ∇N of corners 1, 2, 3
    const Matrix3 F = edges(state.positions) * rest.inverse(), rate = edges(state.velocities) * rest.inverse();
    const Matrix3 strain_rate = (F.transpose() * rate + rate.transpose() * F) / 2;
    const Matrix3 stress = bulk * strain_rate.trace() * Matrix3::Identity() + 2 * shear * strain_rate;
    const Matrix3 pull = -rest.determinant() / 6 * F * stress * gradients;
    for (int i = 0; i < 3; ++i) {
      expected.col(cell[i + 1]) += pull.col(i);
      expected.col(cell[0]) -= pull.col(i);
    }
  }
  CHECK((forces - expected).norm() <= 1e-12 * expected.norm());
  // Power, for motions of every kind: never positive, even without resistance to change of volume.
  for (const unsigned seed : {41u, 42u, 43u}) {
    State other = state;
    other.velocities = random_motion(body, seed);
    CHECK(forces_of(body, *damping, other).cwiseProduct(other.velocities).sum() < 0);
    CHECK(forces_of(body, *make_cell_damping(body, bulk, 0), other).cwiseProduct(other.velocities).sum() < 0);
    CHECK(forces_of(body, *make_cell_damping(body, 0, shear), other).cwiseProduct(other.velocities).sum() < 0);
  }
  State rigid = state;
  const Vector3 spin(1, -2, 0.5);
  for (int i = 0; i < body.size(); ++i)
    rigid.velocities.col(i) = Vector3(3, 1, 2) + spin.cross(Vector3(state.positions.col(i)));
  CHECK(forces_of(body, *damping, rigid).norm() <= 1e-12 * forces.norm());
}

TEST_CASE("damping in proportion to stiffness is that of the law at rest, and lets a body turn", "[viscosity]") {
  const Body body = jittered_block();
  const Material material{.youngs_modulus = 2e4, .poissons_ratio = 0.3};
  // S = β C Ė of St Venant-Kirchhoff is Labelle's damping with φ = β λ, ψ = β μ.
  const ElasticTerms made = built_in_catalog().find("st_venant_kirchhoff").make(body, material, {});
  const Elasticity& law = *made.terms.front();
  const double beta = 0.01, lambda = 2e4 * 0.3 / (1.3 * 0.4), mu = 2e4 / 2.6;
  const State state = moving(body);
  const Positions expected = forces_of(body, *make_cell_damping(body, beta * lambda, beta * mu), state);
  CHECK((forces_of(body, *make_stiffness_damping(body, law, beta), state) - expected).norm() <=
        1e-12 * expected.norm());
  // Springs at rest: −β K v.
  const Body lattice = jittered_lattice();
  Model model(lattice);
  model.add(make_springs(lattice, VectorX::LinSpaced(lattice.connections.size(), 50, 150)));
  State still = state_at_rest(lattice);
  still.velocities = random_motion(lattice, 5);
  Positions stiff(3, lattice.size());
  Tangent(model, still).apply(still.velocities, stiff);
  const auto damping = make_stiffness_damping(lattice, *model.elasticity()[0], beta);
  CHECK((forces_of(lattice, *damping, still) + beta * stiff).norm() <= 1e-12 * beta * stiff.norm());
}

TEST_CASE("the tangent's damping part is the change of the forces with the velocities", "[viscosity]") {
  const Body body = jittered_block();
  const ElasticTerms made = built_in_catalog().find("neo_hookean").make(body, Material{.youngs_modulus = 2e4}, {});
  const Elasticity& law = *made.terms.front();
  const State state = moving(body);
  const Positions dv = random_motion(body, 33);
  for (const int kind : {0, 1, 2}) {
    Model model(body);
    model.add(kind == 0   ? make_damping(0.3)
              : kind == 1 ? make_cell_damping(body, 0.7, 0.4)
                          : make_stiffness_damping(body, law, 0.01));
    State plus = state, minus = state;
    const double h = 1e-6;
    plus.velocities += h * dv, minus.velocities -= h * dv;
    Positions at_plus, at_minus, with(3, body.size()), without(3, body.size());
    model.set_forces(plus, at_plus);
    model.set_forces(minus, at_minus);
    const Positions measured = -(at_plus - at_minus) / (2 * h);
    Tangent(model, state, {.velocity = 1}).apply(dv, with);
    Tangent(model, state).apply(dv, without);
    CHECK((with - without - measured).norm() <= 1e-7 * measured.norm());
    // And its diagonal is that of the same operator.
    const Matrix3 block = Tangent(model, state, {.velocity = 1, .acceleration = 3}).diagonal(4);
    Positions unit = Positions::Zero(3, body.size());
    unit(1, 4) = 1;
    Tangent(model, state, {.velocity = 1, .acceleration = 3}).apply(unit, with);
    CHECK((with.col(4) - block.col(1)).norm() <= 1e-12 * with.col(4).norm());
  }
}

namespace {
/// Of one tetrahedron: 1, 2, 3 …
class OneCellSlopes final : public EdgeSlopes {
 public:
  OneCellSlopes() {
    for (int slope = 0; slope < 36; ++slope) slopes_.push_back(slope + 1);
  }
  void linearise_at(const Positions&) override {}
  void add_own_slopes(VectorX&) const override {}
  void visit_cells(const CellVisitor& visit) const override { visit({6, nodes_, connections_, slopes_.data()}); }

 private:
  std::vector<int> nodes_{0, 1, 2, 3}, connections_{0, 1, 2, 3, 4, 5};
  std::vector<double> slopes_;
};

/// A law with these slopes and no force.
class OneCell final : public EdgeDensities {
 public:
  std::unique_ptr<Elasticity> clone() const override { return std::make_unique<OneCell>(*this); }
  double energy(const Positions&) const override { return 0; }
  void add_force_densities(const Positions&, VectorX&, Workspace&) const override {}
  bool coupled() const override { return true; }
  std::unique_ptr<EdgeSlopes> slopes() const override { return std::make_unique<OneCellSlopes>(); }
};
}  // namespace

TEST_CASE("stiffness damping hands on the slopes of cells", "[viscosity]") {
  const Body body = jittered_lattice();
  int visited = 0;
  make_stiffness_damping(body, OneCell(), 0.5)->visit_cells([&](const CellSlopes& cells) {
    ++visited;
    REQUIRE(cells.sides == 6);
    REQUIRE(cells.size() == 1);
    for (int slope = 0; slope < 36; ++slope)
      if (cells.factor * cells.slopes_of(0)[slope] != 0.5 * (slope + 1)) FAIL("slope " << slope);
  });
  CHECK(visited == 1);
}
