#include "blocks.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "elastin/core/simulation/catalog.h"
#include "lab/experiment/bending/bending.h"
#include "lab/experiment/shear/shear.h"
#include "lab/experiment/tension/tension.h"
#include "lab/experiment/torsion/torsion.h"

namespace bench {

using namespace elastin;
using namespace elastin::lab;

namespace {

BlockCase tension(const char* name, const Vector3& size, double modulus, double force, const char* law,
                  double poissons_ratio, double elongation, double error, int finest) {
  const auto experiment = [force](const Body& body, const Material&) {
    TensionSetup setup;
    setup.fixed_grip = Grip::clamped;
    setup.force = force;
    return make_tension(body, setup);
  };
  return {name, size, modulus, poissons_ratio, law, experiment, "elongation", elongation, error, finest};
}

/// Unit cube, bottom held, top moved sideways at constant height; F [N] along the way.
BlockCase shear(double displacement, double force) {
  const auto experiment = [displacement](const Body& body, const Material&) {
    ShearSetup setup;
    setup.displacement = displacement;
    return make_shear(body, setup, Matrix3::Identity());
  };
  return {fmt::format("shear by {} m", displacement),
          Vector3::Ones(),
          1e5,
          0.3,
          "neo_hookean",
          experiment,
          "force",
          force,
          1e-3,
          24};
}

/// Unit cube, bottom held, top turned at constant height; torque [N m].
BlockCase torsion(double degrees, double torque) {
  const auto experiment = [degrees](const Body& body, const Material&) {
    TorsionSetup setup;
    setup.angle = degrees * std::numbers::pi / 180;
    setup.load_steps = 2;
    return make_torsion(body, setup);
  };
  return {fmt::format("torsion by {} deg", degrees),
          Vector3::Ones(),
          1e5,
          0.3,
          "neo_hookean",
          experiment,
          "torque",
          torque,
          5e-4,
          24};
}

/// 1 × 0.2 × 0.2 m under its own weight, root held.
BlockCase cantilever(const char* law, double sink) {
  const auto experiment = [](const Body& body, const Material& material) {
    BendingSetup setup;
    setup.gravity = 9.81;
    return make_bending(body, setup, material);
  };
  return {"cantilever", {1, 0.2, 0.2}, 1e6, 0.3, law, experiment, "tip_deflection", sink, 6e-4, 8};
}

}  // namespace

std::array<int, 3> BlockCase::cubes(int level) const {
  const double shortest = size.minCoeff();
  std::array<int, 3> counts;
  for (int axis = 0; axis < 3; ++axis) counts[axis] = static_cast<int>(std::lround(level * size[axis] / shortest));
  return counts;
}

Run BlockCase::run(BlockKind kind, int level, double tolerance) const {
  Specimen specimen{tetrahedral_block(kind, cubes(level), size), {}, {}};
  specimen.material.youngs_modulus = modulus;
  specimen.material.poissons_ratio = poissons_ratio;
  elastin::set_matter(specimen.body, size.minCoeff() / level / 4, specimen.material.density, 0, 0);
  const bool linear = std::string(law) == "linear";
  const auto held = experiment(specimen.body, specimen.material);
  RunOptions options;
  options.statics = {.linear = linear, .tolerance = tolerance};
  Run run =
      run_strategy(specimen, *held, choose_strategy(built_in_catalog(), linear ? "st_venant_kirchhoff" : law), options);
  if (!run.suited || run.outcome != Outcome::converged) throw std::runtime_error(name + ": " + run.cause);
  return run;
}

BlockCase tension_block1(const char* law, double poissons_ratio, double elongation, double error, double part) {
  return tension("T1", {0.03, 0.03, 0.015}, 5e3, part, law, poissons_ratio, elongation, error, 16);
}

BlockCase tension_block2(const char* law, double poissons_ratio, double elongation, double error) {
  return tension("T2", {1, 1, 0.86}, 1e5, 1000, law, poissons_ratio, elongation, error, 24);
}

std::vector<BlockCase> block_cases() {
  return {tension_block1("linear", 0.25, 0.00320297919, 1e-5),
          tension_block1("linear", 0.3, 0.00314180381, 1e-5),
          tension_block2("linear", 0.25, 0.00840022538, 1e-5),
          tension_block2("linear", 0.3, 0.00830615765, 2e-5),
          tension_block1("neo_hookean", 0.3, 0.0036002, 6e-5),
          tension_block2("neo_hookean", 0.3, 0.00836035, 6e-5),
          tension_block1("st_venant_kirchhoff", 0.3, 0.00242709, 6e-5),
          shear(0.3, 7905),
          torsion(30, 2930.2),
          cantilever("linear", 0.37666),
          cantilever("neo_hookean", 0.34556)};
}

}  // namespace bench
