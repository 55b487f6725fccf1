// A bar of tissue in a program that links elastin::core and nothing else: a spring rule of its own, the modulus that
// the bar then has by an equilibrium, and the same bar stepped in time until it hangs still.
#include <cmath>
#include <cstdio>

#include "columns.h"
#include "elastin/model/shapes.h"
#include "elastin/simulation/catalog.h"
#include "elastin/solve/statics.h"

using namespace elastin;

namespace {

constexpr int kSide = 8;
constexpr double kSpacing = 0.01, kLength = (kSide - 1) * kSpacing;  // [m]
constexpr double kStress = 50;                                       // [Pa]
const Material kMaterial{.youngs_modulus = 1e4};                     // [Pa]

bool at_bottom(const Body& body, int molecule) { return body.rest(2, molecule) < kSpacing / 2; }

/// Force on each molecule [N]: the stress on the top face, each molecule its own part of that.
Positions pull(const Body& body) {
  Positions forces = Positions::Zero(3, body.size());
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    const Vector3 place = body.rest.col(molecule);
    if (place.z() < kLength - kSpacing / 2) continue;
    double area = kSpacing * kSpacing;
    for (const double along : {place.x(), place.y()})
      if (along < kSpacing / 2 || along > kLength - kSpacing / 2) area /= 2;
    forces(2, molecule) = kStress * area;
  }
  return forces;
}

double modulus(const Positions& positions) {
  return kStress / (positions.row(2).maxCoeff() - positions.row(2).minCoeff() - kLength) * kLength;
}

double static_modulus(const Body& body, const Strategy& strategy) {
  Model model(body);
  model.add(strategy.make(body, kMaterial, {}));
  std::vector<int> all(body.size());
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    all[molecule] = molecule;
    if (at_bottom(body, molecule)) model.supports.push_back({molecule, Vector3(1, 1, 0).asDiagonal()});
  }
  model.add(std::make_unique<PointLoads>(body, all, pull(body)));
  State state = state_at_rest(body);
  const StaticResult result = solve_static(model, state);
  if (result.outcome != Outcome::converged) std::printf("%s\n", result.cause.c_str());
  return modulus(state.positions);
}

}  // namespace

int main() {
  Catalog catalog;
  catalog.add<Columns>();
  Body body = cubic_lattice({kSide, kSide, kSide}, kSpacing, {});
  set_matter(body, kSpacing / 2, kMaterial.density, 0, std::pow(kLength, 3));
  const double still = static_modulus(body, catalog.find("columns"));
  std::printf("asked for E = %.6g Pa; at rest %.6f Pa\n", kMaterial.youngs_modulus, still);
  return std::abs(still / kMaterial.youngs_modulus - 1) < 1e-8 ? 0 : 1;
}
