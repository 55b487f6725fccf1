// Linear tetrahedra lock near incompressibility; a volume term on molecules does not. Pure bending of a bar is known in
// closed form for any Poisson's ratio.

#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"

using namespace elastin;

namespace {

const Vector3 kSize(1, 0.5, 0.5);  // a quarter of the bar: mid planes at x = 0 and y = 0, neutral plane at z = 0

/// The traction E c z of bending with curvature c on the end x = size, as forces of the molecules.
std::unique_ptr<Load> end_moment(const Body& body, double stress_slope) {
  std::vector<int> molecules;
  Positions forces = Positions::Zero(3, body.size());
  for (const auto& cell : body.tetrahedra)
    for (int left_out = 0; left_out < 4; ++left_out) {
      std::array<int, 3> face{};
      for (int corner = 0, at = 0; corner < 4; ++corner)
        if (corner != left_out) face[at++] = cell[corner];
      const auto position = [&](int i) { return Vector3(body.rest.col(face[i])); };
      if (position(0).x() + position(1).x() + position(2).x() < 3 * kSize.x() - 1e-9) continue;
      const double area = (position(1) - position(0)).cross(position(2) - position(0)).norm() / 2;
      const double sum = position(0).z() + position(1).z() + position(2).z();
      for (int i = 0; i < 3; ++i)  // ∫ N_i z dA
        forces(0, face[i]) += stress_slope * area / 12 * (sum + position(i).z());
    }
  for (int molecule = 0; molecule < body.size(); ++molecule) molecules.push_back(molecule);
  return std::make_unique<PointLoads>(body, molecules, forces);
}

/// Compliance of the bar over the closed form's, ∫ σ²/E dV, less 1; and the linear iterations.
struct Bending {
  double error;
  int iterations;
};

Bending bend(int n, const std::string& law, bool averaged, double nu) {
  Body body = tetrahedral_block(BlockKind::kuhn, {2 * n, n, n}, kSize);
  add_jitter(body, 0.06 / n, 4);
  const Material material{.youngs_modulus = 1e5, .poissons_ratio = nu};
  Model model(body);
  const Catalog catalog = built_in_catalog();
  const Strategy strategy = averaged ? with_volume(catalog.find(law)) : catalog.find(law);
  model.add(strategy.make(body, material, {}));
  const double curvature = 1e-4, slope = material.youngs_modulus * curvature;
  model.add(end_moment(body, slope));
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    const Vector3 position = body.rest.col(molecule);
    Vector3 free(position.x() > 1e-9 && position.z() > 1e-9, position.y() > 1e-9 && position.z() > 1e-9,
                 position.norm() > 1e-9);
    if (free.minCoeff() == 0) model.supports.push_back({molecule, free.asDiagonal(), Vector3::Zero()});
  }
  State state = state_at_rest(body);
  const StaticResult result = solve_static(model, state, {.linear = true, .tolerance = 1e-8});
  REQUIRE(result.outcome == Outcome::converged);
  const double exact = slope * slope / material.youngs_modulus * kSize.x() * kSize.y() * std::pow(kSize.z(), 3) / 3;
  return {-model.load_energy(state) / exact - 1, result.linear_iterations};
}

}  // namespace

TEST_CASE("nearly incompressible bending: plain tetrahedra lock, averaged volumes do not", "[volume][locking][slow]") {
  for (const double nu : {0.3, 0.49, 0.499}) {
    std::array<double, 3> plain{}, averaged{};
    for (const std::size_t i : {0u, 1u, 2u}) {
      const Bending p = bend(2 << i, "neo_hookean", false, nu), a = bend(2 << i, "neo_hookean", true, nu);
      plain[i] = p.error;
      averaged[i] = a.error;
      UNSCOPED_INFO("nu " << nu << ", " << (2 << i) << " cubes: plain " << p.error << " (" << p.iterations
                          << " iterations), averaged " << a.error << " (" << a.iterations << ")");
    }
    UNSCOPED_INFO("orders " << std::log2(averaged[0] / averaged[1]) << " " << std::log2(averaged[1] / averaged[2]));
    CHECK(std::abs(averaged[2]) < 0.02);
    CHECK(std::log2(averaged[1] / averaged[2]) > 1.5);
    if (nu > 0.4) CHECK(std::abs(plain[2]) > 5 * std::abs(averaged[2]));
  }
}
