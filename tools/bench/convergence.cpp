#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "lab/experiment/bending/bending.h"
#include "lab/experiment/shear/shear.h"
#include "lab/experiment/tension/tension.h"
#include "lab/experiment/torsion/torsion.h"
#include "lab/run/specimen.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;
using namespace elastin::lab;

struct BlockCase {
  std::string name;
  Vector3 size;    ///< [m]
  double modulus;  ///< E [Pa]
  double poissons_ratio;
  const char* law;  ///< "linear", or a cell law at large displacements
  std::function<std::unique_ptr<lab::Experiment>(const Body&, const Material&)> experiment;
  const char* measure;
  double reference;  ///< of the measure, SI
  double error;      ///< of the reference, relative
  int finest;        ///< cubes along the shortest side that make some 1e5 cells

  /// A run on a grid with `level` cubes along the shortest side; throws std::runtime_error if it fails.
  lab::Run run(BlockKind kind, int level, double tolerance) const;
  std::array<int, 3> cubes(int level) const;
};

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

/// Boxes of tetrahedra whose converged solutions are known from other programs (dolfinx, CalculiX, GetFEM). Of tension:
/// T1 = 30 × 30 × 15 mm, 5 kPa, 1 N; T2 = 1 × 1 × 0.86 m, 100 kPa, 1 kN. One end is wholly held, the other under a
/// uniform dead traction and else free; the elongation is the mean of the loaded end.
std::vector<BlockCase> block_cases() {
  const auto block1 = [](const char* law, double poissons_ratio, double elongation, double error) {
    return tension("T1", {0.03, 0.03, 0.015}, 5e3, 1, law, poissons_ratio, elongation, error, 16);
  };
  const auto block2 = [](const char* law, double poissons_ratio, double elongation, double error) {
    return tension("T2", {1, 1, 0.86}, 1e5, 1000, law, poissons_ratio, elongation, error, 24);
  };
  return {block1("linear", 0.25, 0.00320297919, 1e-5),
          block1("linear", 0.3, 0.00314180381, 1e-5),
          block2("linear", 0.25, 0.00840022538, 1e-5),
          block2("linear", 0.3, 0.00830615765, 2e-5),
          block1("neo_hookean", 0.3, 0.0036002, 6e-5),
          block2("neo_hookean", 0.3, 0.00836035, 6e-5),
          block1("st_venant_kirchhoff", 0.3, 0.00242709, 6e-5),
          shear(0.3, 7905),
          torsion(30, 2930.2),
          cantilever("linear", 0.37666),
          cantilever("neo_hookean", 0.34556)};
}

struct Grid {
  BlockKind kind;
  const char* name;
  int cells;  ///< of a cube
};
constexpr Grid kGrids[] = {{BlockKind::kuhn, "kuhn", 6}, {BlockKind::body_centred, "body_centred", 12}};

int cells_of(const BlockCase& one, const Grid& grid, int level) {
  const auto [x, y, z] = one.cubes(level);
  return grid.cells * x * y * z;
}

Figures solve(const BlockCase& one, const Grid& grid, int level, int threads) {
  set_threads(threads);
  const Run run = one.run(grid.kind, level, 1e-9);
  Figures figures;
  figures.cells = static_cast<double>(cells_of(one, grid, level));
  figures.build = run.build_seconds;
  figures.minimum = figures.median = run.solve_seconds;
  figures.newton = run.newton_iterations;
  figures.iterations = run.linear_iterations;
  figures.value = run.measures.get(one.measure) / one.reference;
  figures.error = std::abs(figures.value - 1);
  return figures;
}

}  // namespace

std::vector<Row> run_convergence(const Settings& settings) {
  std::vector<Row> rows;
  const int threads = settings.threads.back();
  for (const BlockCase& one : block_cases())
    for (const Grid& grid : kGrids) {
      double coarser = kNone;
      for (const int level : {one.finest / 8, one.finest / 4, one.finest / 2, one.finest}) {
        const std::string name = fmt::format("{} {}, nu {}, {}", one.name, one.law, one.poissons_ratio, grid.name);
        say(fmt::format("convergence, {}, {}", name, level));
        Figures figures = in_child([&] { return std::vector{solve(one, grid, level, threads)}; }).front();
        figures.order = std::log2(coarser / figures.error);
        coarser = figures.error;
        const bool exact = figures.error < 3 * one.error;
        rows.push_back({"convergence", name, level, threads, 1, figures, exact ? "as exact as the reference" : ""});
      }
    }
  return rows;
}

}  // namespace bench
