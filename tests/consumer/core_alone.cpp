// A bar of tissue in a program on elastin::core alone, with a spring rule of its own: pulled, it settles at the stretch
// that its Young's modulus says; stepped in time with damping it comes to the same.
#include <cmath>
#include <cstdio>

#include "columns.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/simulation.h"

using namespace elastin;

namespace {

constexpr int kSide = 6;
constexpr double kSpacing = 0.01, kLength = (kSide - 1) * kSpacing;  // [m]
constexpr double kStress = 50;                                       // [Pa]
const Material kMaterial{.youngs_modulus = 1e4, .density = 1000};    // [Pa], [kg/m³]

Body make_bar() {
  Body body = cubic_lattice({kSide, kSide, kSide}, kSpacing, {});
  set_matter(body, kSpacing / 2, kMaterial.density, 0, std::pow(kLength, 3));
  return body;
}

/// Stands on the ground, free to slide, and is pulled up: each molecule of the top by the part of it that is its own.
void fix_and_pull(Simulation& tissue) {
  const Body& body = tissue.body();
  const auto at_side = [](double at) { return at < kSpacing / 2 || at > kLength - kSpacing / 2; };
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    const Vector3 position = body.rest.col(molecule);
    if (!at_side(position.z())) continue;
    const double area = kSpacing * kSpacing * (at_side(position.x()) ? 0.5 : 1) * (at_side(position.y()) ? 0.5 : 1);
    if (position.z() < kLength / 2)
      tissue.fix(molecule, Vector3(1, 1, 0).asDiagonal());
    else
      tissue.host_forces()(2, molecule) = kStress * area;
  }
}

/// Effective Young's modulus [Pa] by how far the top has come.
double modulus(const Simulation& tissue) {
  return kStress * kLength / (tissue.positions().row(2).maxCoeff() - kLength);
}

/// Says what was found, and whether it is what was expected.
bool holds(const char* how, const StepResult& result, const Simulation& tissue, double tolerance) {
  std::printf("%s: %.6f Pa of %.6g Pa %s\n", how, modulus(tissue), kMaterial.youngs_modulus, result.cause.c_str());
  return result.outcome == Outcome::converged && std::abs(modulus(tissue) / kMaterial.youngs_modulus - 1) < tolerance;
}

}  // namespace

int main() {
  Catalog catalog;
  catalog.add<Columns>();
  Simulation tissue(make_bar(), catalog.find("columns"), kMaterial);
  fix_and_pull(tissue);
  const StaticResult still = tissue.settle();
  const bool settles = holds("settled", {still.outcome, still.cause}, tissue, 1e-8);

  Simulation moving(make_bar(), catalog.find("columns"), kMaterial);
  fix_and_pull(moving);
  moving.model().add(make_mass_damping(moving.body(), 50));
  StepResult result;
  while (moving.time() < 2 && result.outcome == Outcome::converged) result = moving.step(1e-3);
  return settles && holds("stepped", result, moving, 1e-8) ? 0 : 1;
}
