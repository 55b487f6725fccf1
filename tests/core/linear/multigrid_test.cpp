#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/linear/linear_choice.h"
#include "core/linear/linear_solver.h"
#include "elastin/core/forces/volume.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

constexpr double kSpacing = 0.01;  // m

Body lattice(std::array<int, 3> counts, bool space = false) {
  return cubic_lattice(counts, kSpacing, {.axis = true, .face = true, .space = space});
}

/// The same molecules, moved at random and in another order: no grid, no band, no box that fits.
Body scattered(const Body& ordered, double amount) {
  std::mt19937_64 generator(3);
  std::vector<int> places(static_cast<std::size_t>(ordered.size()));
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = static_cast<int>(i);
  for (std::size_t i = places.size(); i > 1; --i) std::swap(places[i - 1], places[generator() % i]);
  Body body = ordered;
  body.grid.reset();
  body.cubes.clear();
  const Positions moved = ordered.rest + amount * random_motion(ordered, 5);
  for (int i = 0; i < body.size(); ++i) body.rest.col(places[static_cast<std::size_t>(i)]) = moved.col(i);
  for (auto& ends : body.connections.ends)
    for (int& end : ends) end = places[static_cast<std::size_t>(end)];
  set_present_lengths(body);
  return body;
}

/// A body held at its lowest molecules along z (within a quarter of the spacing) and pulled askew at the others' top.
struct Held {
  explicit Held(Body a_body, double constant = 100) : body(std::move(a_body)), model(body) {
    constants = VectorX::Constant(body.connections.size(), constant);
    loads = Positions::Zero(3, body.size());
    const double low = body.rest.row(2).minCoeff(), high = body.rest.row(2).maxCoeff();
    for (int a = 0; a < body.size(); ++a) {
      if (body.rest(2, a) < low + 0.5 * kSpacing) model.supports.push_back({a});
      if (body.rest(2, a) > high - 0.5 * kSpacing) loads.col(a) = Vector3(1e-3, 2e-4, 3e-3);
    }
  }
  void add_springs() { model.add(make_springs(body, constants)); }

  LinearResult solve(std::unique_ptr<LinearSolver> solver, Positions& motion, double tolerance = 1e-9) {
    const State rest = state_at_rest(body);
    const Tangent tangent(model, rest);
    Positions rhs = loads;
    keep_free(model.supports, rhs);
    return solver->solve(tangent, model.supports, rhs, tolerance, motion);
  }
  int iterations() {
    Positions motion;
    const LinearResult result = solve(make_multigrid(), motion, 1e-8);
    REQUIRE(result.status == LinearStatus::solved);
    return result.iterations;
  }

  Body body;
  Model model;
  VectorX constants;
  Positions loads;
};

void check_against_factorisation(Held& held, double tolerance = 1e-6) {
  Positions motion, exact;
  const LinearResult result = held.solve(make_multigrid(), motion, 1e-11);
  REQUIRE(held.solve(make_direct(), exact, 1e-11).residual < 1e-9);
  CHECK(result.status == LinearStatus::solved);
  CHECK((motion - exact).norm() < tolerance * exact.norm());
}

/// A stiff lump in the middle, as of bone in fat.
void stiffen_middle(Held& held, double times) {
  const Vector3 middle = (held.body.rest.rowwise().minCoeff() + held.body.rest.rowwise().maxCoeff()) / 2;
  const double reach = 0.25 * (held.body.rest.rowwise().maxCoeff() - held.body.rest.rowwise().minCoeff()).maxCoeff();
  for (int c = 0; c < held.body.connections.size(); ++c) {
    const auto& [a, b] = held.body.connections.ends[static_cast<std::size_t>(c)];
    if (((held.body.rest.col(a) + held.body.rest.col(b)) / 2 - middle).norm() < reach) held.constants[c] *= times;
  }
}

}  // namespace

TEST_CASE("multigrid's answer is the factorisation's, whatever the body", "[multigrid]") {
  SECTION("lattice") {
    Held held(lattice({7, 6, 8}));
    held.add_springs();
    check_against_factorisation(held);
  }
  SECTION("lattice with space diagonals, an odd number of layers in every direction") {
    Held held(lattice({6, 8, 10}, true));
    held.add_springs();
    check_against_factorisation(held);
  }
  SECTION("no order and no grid") {
    Held held(scattered(lattice({7, 7, 7}), 0.2 * kSpacing));
    held.add_springs();
    check_against_factorisation(held);
  }
  SECTION("rod, 40 times as long as thick") {
    Held held(lattice({3, 3, 81}));
    held.add_springs();
    check_against_factorisation(held, 1e-5);
  }
  SECTION("sheet of one layer on edge") {
    Held held(lattice({12, 1, 14}));
    for (int a = 0; a < held.body.size(); ++a) held.loads(1, a) = 0;  // it has no stiffness across
    held.add_springs();
    check_against_factorisation(held);
  }
  SECTION("stiffness a million times as high in the middle") {
    Held held(lattice({7, 7, 7}));
    stiffen_middle(held, 1e6);
    held.add_springs();
    check_against_factorisation(held);
  }
  SECTION("a million times as high, no order, no grid") {
    Held held(scattered(lattice({7, 7, 7}), 0.2 * kSpacing));
    stiffen_middle(held, 1e6);
    held.add_springs();
    check_against_factorisation(held);
  }
  SECTION("nearly incompressible by a volume term") {
    Held held(lattice({6, 6, 6}));
    held.add_springs();
    held.model.add(make_volume(held.body, 100 * 100 / kSpacing));
    check_against_factorisation(held);
  }
  SECTION("supports that hold askew directions") {
    Held held(lattice({6, 6, 6}));
    const Vector3 across = Vector3(1, 2, 3).normalized();
    for (int a = 0; a < held.body.size(); a += 5)
      if (held.loads.col(a).isZero(0) && held.body.rest(2, a) > kSpacing)
        held.model.supports.push_back({a, Matrix3::Identity() - across * across.transpose()});
    held.add_springs();
    check_against_factorisation(held);
  }
  SECTION("tetrahedra of every law") {
    for (const char* law : {"st_venant_kirchhoff", "neo_hookean"})
      for (const double nu : {0.3, 0.499}) {
        Held held(tetrahedral_block(BlockKind::kuhn, {5, 5, 6}, {0.05, 0.05, 0.06}));
        held.model.add(built_in_catalog().find(law).make(held.body, {.youngs_modulus = 1e4, .poissons_ratio = nu}, {}));
        INFO(law << ", nu " << nu);
        check_against_factorisation(held);
      }
  }
}

TEST_CASE("multigrid's iterations do not grow with the body", "[multigrid]") {
  // Conjugate gradients alone take 10 iterations for each connection from end to end: 88, 210, 466 at 10, 22, 47 a
  // side.
  for (const bool ordered : {true, false}) {
    std::vector<int> iterations;
    for (const int side : {8, 12, 18}) {
      Held held(ordered ? lattice({side, side, side}) : scattered(lattice({side, side, side}), 0.15 * kSpacing));
      held.add_springs();
      iterations.push_back(held.iterations());
    }
    INFO(iterations[0] << ", " << iterations[1] << ", " << iterations[2]);
    CHECK(iterations[2] <= (ordered ? 32 : 36));
    CHECK(iterations[2] <= iterations[0] + 8);
  }
}

TEST_CASE("multigrid takes rods a hundred times as long as thick in some forty iterations", "[multigrid]") {
  Held held(lattice({3, 3, 201}));
  held.add_springs();
  CHECK(held.iterations() <= 50);  // conjugate gradients alone: thousands
}

TEST_CASE("multigrid gives the same bits on any number of threads", "[multigrid]") {
  for (const bool ordered : {true, false}) {
    Held held(ordered ? lattice({20, 20, 20}) : scattered(lattice({20, 20, 20}), 0.2 * kSpacing));
    held.add_springs();
    Positions first;
    for (const int count : {1, 2, 4}) {
      set_threads(count);
      Positions motion;
      const LinearResult result = held.solve(make_multigrid(), motion, 1e-5);
      set_threads(0);
      REQUIRE(result.status == LinearStatus::solved);
      if (count == 1) first = motion;
      CHECK((motion.array() == first.array()).all());
    }
  }
}

TEST_CASE("multigrid says of what has no answer what conjugate gradients alone say", "[multigrid]") {
  SECTION("a pull on a mechanism: axis connections alone do not resist shear") {
    Held held(cubic_lattice({5, 5, 5}, kSpacing, {.axis = true, .face = false, .space = false}));
    held.add_springs();
    Positions motion;
    CHECK(held.solve(make_pcg(), motion).status == LinearStatus::zero_mode);
    CHECK(held.solve(make_multigrid(), motion).status == LinearStatus::zero_mode);
    CHECK(motion.allFinite());
  }
  SECTION("negative stiffness") {
    Held held(lattice({6, 6, 6}), -100);
    held.add_springs();
    Positions motion;
    CHECK(held.solve(make_pcg(), motion).status == LinearStatus::negative_mode);
    const LinearResult result = held.solve(make_multigrid(), motion);
    CHECK(result.status == LinearStatus::negative_mode);
    CHECK(result.negative_direction.allFinite());
  }
  SECTION("a free body under loads in balance keeps what it may do as a whole") {
    Held held(lattice({6, 7, 8}));
    held.model.supports.clear();
    held.add_springs();
    held.loads.setZero();
    for (int a = 0; a < held.body.size(); ++a) {
      if (held.body.rest(2, a) < 0.5 * kSpacing) held.loads(2, a) = -1e-3;
      if (held.body.rest(2, a) > 6.5 * kSpacing) held.loads(2, a) = 1e-3;
    }
    Positions motion;
    REQUIRE(held.solve(make_multigrid(), motion).status == LinearStatus::solved);
    Vector3 turn = Vector3::Zero();
    double size = 0;
    const Vector3 middle = held.body.rest.rowwise().mean();
    for (int a = 0; a < held.body.size(); ++a) {
      const Vector3 arm = held.body.rest.col(a) - middle;
      turn += arm.cross(Vector3(motion.col(a)));
      size += arm.norm() * motion.col(a).norm();
    }
    CHECK(motion.rowwise().mean().norm() < 1e-6 * std::sqrt(motion.squaredNorm() / held.body.size()));
    CHECK(turn.norm() < 1e-6 * size);
  }
}

TEST_CASE("large displacements by multigrid end where conjugate gradients alone do", "[multigrid]") {
  const auto bent = [](LinearMethod method) {
    Held held(lattice({4, 4, 24}));
    held.add_springs();
    std::vector<int> all;
    for (int a = 0; a < held.body.size(); ++a) all.push_back(a);
    held.model.add(std::make_unique<PointLoads>(held.body, all, 0.3 * held.loads));
    State state = state_at_rest(held.body);
    const StaticResult result = solve_static(held.model, state, {.method = method});
    REQUIRE(result.outcome == Outcome::converged);
    CHECK(result.solver == (method == LinearMethod::pcg ? "newton pcg" : "newton multigrid"));
    return state.positions;
  };
  const Positions alone = bent(LinearMethod::pcg), coarse = bent(LinearMethod::multigrid);
  CHECK((alone - coarse).norm() < 1e-7 * alone.norm());
}

TEST_CASE("the linear solver is chosen by the body's size and the digits asked for", "[multigrid]") {
  const auto choice = [](std::array<int, 3> counts, double tolerance, Weights weights = {}) {
    Held held(lattice(counts));
    held.body.mass = VectorX::Ones(held.body.size());
    held.add_springs();
    const State rest = state_at_rest(held.body);
    return choose_linear_solver(Tangent(held.model, rest, weights), LinearMethod::automatic, tolerance);
  };
  CHECK(choice({3, 3, 3}, 1e-8).method == LinearMethod::direct);
  CHECK(choice({10, 10, 10}, 1e-8).method == LinearMethod::pcg);
  CHECK(choice({24, 24, 24}, 1e-8).method == LinearMethod::multigrid);
  CHECK(choice({4, 4, 100}, 1e-3).method == LinearMethod::multigrid);
  CHECK(choice({24, 24, 24}, 0.1).method == LinearMethod::pcg);
  CHECK(choice({24, 24, 24}, 1e-8, {1e3, 1e6}).method == LinearMethod::pcg);
  CHECK(choice({4, 4, 100}, 1e-8).reason.find("1600 molecules, ") == 0);
}
