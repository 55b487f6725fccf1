#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "core/forces/surface_load.h"
#include "core/linear/linear_choice.h"
#include "core/linear/sparse_stiffness.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

/// A nearly incompressible block, held at x = 0, with a pressure that follows its side at x = 30 mm.
struct Pressed {
  Pressed()
      : body(cell_box(cell_kind("hexahedron8"), {5, 3, 3}, {0.03, 0.02, 0.02}, 0.1)),
        model(body),
        state(state_at_rest(body)) {
    const Material material{.youngs_modulus = 1e4, .poissons_ratio = 0.4995};
    model.add(built_in_catalog().find("neo_hookean+volume").make(body, material, {}));
    std::vector<int> side;
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      if (body.rest(0, molecule) < 1e-9) model.supports.push_back({molecule, Matrix3::Zero()});
      if (body.rest(0, molecule) > 0.03 - 1e-9) side.push_back(molecule);
    }
    model.add(std::make_unique<SurfaceForces>(body, SurfaceLoad{.faces = outer_faces(body, side)}, 1e3));
  }
  Body body;
  Model model;
  State state;
};

}  // namespace

TEST_CASE("bicgstab behind a factor solves what is not symmetric, in few iterations", "[bicgstab]") {
  Pressed pressed;
  pressed.state.positions = deformed(pressed.body, 1e-3);
  Tangent tangent(pressed.model);
  tangent.linearise_at(pressed.state, {});
  const int n = pressed.body.size();
  Eigen::MatrixXd K(3 * n, 3 * n);
  Positions column(3, n);
  for (int i = 0; i < 3 * n; ++i) {
    Positions unit = Positions::Zero(3, n);
    unit.data()[i] = 1;
    keep_free(pressed.model.supports, unit);
    tangent.apply(unit, column);
    keep_free(pressed.model.supports, column);
    if (unit.isZero(0)) column.data()[i] = stiffness_scale(tangent);
    K.col(i) = Eigen::Map<const VectorX>(column.data(), 3 * n);
  }
  REQUIRE((K - K.transpose()).norm() > 1e-5 * K.norm());
  Positions rhs = random_motion(pressed.body, 3);
  keep_free(pressed.model.supports, rhs);
  const VectorX expected = K.fullPivLu().solve(Eigen::Map<const VectorX>(rhs.data(), 3 * n));
  const auto solve = [&](std::unique_ptr<LinearSolver> solver) {
    Positions x;
    const LinearResult result = solver->solve(tangent, pressed.model.supports, rhs, 1e-10, x);
    CHECK(result.status == LinearStatus::solved);
    CHECK((Eigen::Map<const VectorX>(x.data(), 3 * n) - expected).norm() <= 1e-6 * expected.norm());
    return result.iterations;
  };
  CHECK(solve(make_bicgstab_by_factor()) <= 12);
  // Without being asked for it: after a look at how many iterations are still to come.
  CHECK(solve(make_bicgstab()) <= 70);
}

TEST_CASE("any linear solver finds the equilibrium under a follower pressure, and says what it gave way to",
          "[bicgstab]") {
  std::vector<Positions> found;
  for (const char* name : {"bicgstab", "direct", "multigrid", "automatic"}) {
    Pressed pressed;
    const StaticResult result = solve_static(pressed.model, pressed.state, {.method = name});
    INFO(name << ": " << result.cause);
    CHECK(result.outcome == Outcome::converged);
    CHECK(result.solver == "newton bicgstab");
    const bool asked = std::string(name) == "direct" || std::string(name) == "multigrid";
    CHECK((result.reason.find("as `" + std::string(name) + "` needs it") != std::string::npos) == asked);
    found.push_back(pressed.state.positions);
    CHECK((found.back() - found.front()).norm() <= 1e-6 * (found.front() - pressed.body.rest).norm());
  }
}
