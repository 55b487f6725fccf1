#include "elastin/forces/loads.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "bodies.h"
#include "elastin/forces/model.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

Positions forces_of(const Load& load, const State& state) {
  Positions forces = Positions::Zero(3, state.positions.cols());
  load.add_forces(state, forces);
  return forces;
}

State moving(const Body& body) {
  State state = state_at_rest(body);
  state.positions = deformed(body, 3e-4);
  state.velocities = random_motion(body, 31);
  return state;
}

}  // namespace

TEST_CASE("drag balances weight at the terminal velocity of the textbooks", "[loads]") {
  Body body = listed_body({{0, 0, 0}, {1, 0, 0}}, {});
  body.radius = VectorX::Constant(2, 0.002);
  body.mass = VectorX::Constant(2, 3e-5);
  const Vector3 g(0, 0, -9.81);
  const auto gravity = make_gravity(body, g);
  State state = state_at_rest(body);
  // 6π η r v = m g, and ½ ρ C π r² v² = m g
  state.velocities = (g * (3e-5 / (6 * std::numbers::pi * 0.1 * 0.002))).replicate(1, 2);
  CHECK((forces_of(*gravity, state) + forces_of(*make_stokes_drag(body, 0.1), state)).norm() < 1e-16);
  const double speed = std::sqrt(3e-5 * 9.81 / (0.5 * 1000 * 0.47 * std::numbers::pi * 4e-6));
  state.velocities = (g.normalized() * speed).replicate(1, 2);
  CHECK((forces_of(*gravity, state) + forces_of(*make_quadratic_drag(body, 1000, 0.47), state)).norm() < 1e-16);
}

TEST_CASE("internal damping works along connections only and never adds energy", "[loads]") {
  const Body body = jittered_lattice();
  const State state = moving(body);
  const auto damping = make_damping(body, 0.3);
  const Positions forces = forces_of(*damping, state);
  CHECK(forces.cwiseProduct(state.velocities).sum() < 0);
  CHECK(forces.rowwise().sum().norm() <= 1e-13 * forces.norm());
  // A rigid motion is not damped.
  State rigid = state;
  const Vector3 spin(1, -2, 0.5);
  for (int i = 0; i < body.size(); ++i)
    rigid.velocities.col(i) = Vector3(3, 1, 2) + spin.cross(Vector3(state.positions.col(i)));
  CHECK(forces_of(*damping, rigid).norm() <= 1e-12 * forces.norm());
  // Two molecules by hand: F = −b (Δv·u) u.
  Body pair = listed_body({{0, 0, 0}, {2, 0, 0}}, {{0, 1}});
  State apart = state_at_rest(pair);
  apart.velocities.col(1) = Vector3(0.5, 7, 0);
  CHECK((forces_of(*make_damping(pair, 4), apart).col(1) - Vector3(-2, 0, 0)).norm() < 1e-15);
}

TEST_CASE("damping of cells is the finite-element force of its stress, takes energy, and lets a body turn", "[loads]") {
  const Body body = jittered_block();
  const State state = moving(body);
  const double bulk = 0.7, shear = 0.4;
  const auto damping = make_cell_damping(body, bulk, shear);
  const Positions forces = forces_of(*damping, state);
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
    CHECK(forces_of(*damping, other).cwiseProduct(other.velocities).sum() < 0);
    CHECK(forces_of(*make_cell_damping(body, bulk, 0), other).cwiseProduct(other.velocities).sum() < 0);
    CHECK(forces_of(*make_cell_damping(body, 0, shear), other).cwiseProduct(other.velocities).sum() < 0);
  }
  State rigid = state;
  const Vector3 spin(1, -2, 0.5);
  for (int i = 0; i < body.size(); ++i)
    rigid.velocities.col(i) = Vector3(3, 1, 2) + spin.cross(Vector3(state.positions.col(i)));
  CHECK(forces_of(*damping, rigid).norm() <= 1e-12 * forces.norm());
}

TEST_CASE("loads: energies and changes agree with differences", "[loads]") {
  const Body body = jittered_block();
  const State state = moving(body);
  const Positions dx = random_motion(body, 32), dv = random_motion(body, 33);
  std::vector<std::unique_ptr<Load>> loads;
  loads.push_back(make_gravity(body, {0, 1, -9.81}));
  loads.push_back(std::make_unique<PointLoads>(body, std::vector<int>{0, 5}, Positions::Ones(3, 2)));
  loads.push_back(make_stokes_drag(body, 0.2));
  loads.push_back(make_quadratic_drag(body, 1000, 0.5));
  loads.push_back(make_damping(body, 0.3));
  loads.push_back(make_cell_damping(body, 0.7, 0.4));
  const double h = 1e-7;
  for (const auto& load : loads) {
    State plus = state, minus = state;
    plus.positions += h * dx, minus.positions -= h * dx;
    if (load->acts_at_rest())
      CHECK(-(load->energy(plus) - load->energy(minus)) / (2 * h) ==
            Approx(forces_of(*load, state).cwiseProduct(dx).sum()).epsilon(1e-7));
    plus.velocities += h * dv, minus.velocities -= h * dv;
    const Positions measured = (forces_of(*load, plus) - forces_of(*load, minus)) / (2 * h);
    Positions predicted = Positions::Zero(3, body.size());
    load->add_change(state, dx, dv, predicted);
    CHECK((predicted - measured).norm() <= 1e-6 * std::max(1e-3, measured.norm()));
  }
}
