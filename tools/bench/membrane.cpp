#include <fmt/format.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/shapes/surfaces.h"
#include "lab/experiment/inflation/inflation.h"
#include "lab/run/specimen.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;
using namespace elastin::lab;

/// The sphere of [TP] Table 1, first case; radii [m] of the smooth sphere under each law.
constexpr double kPressure = 10e3, kReference = 1.0848351;  // logarithmic strain, thinning: the material itself
constexpr Material kLatex{.youngs_modulus = 50e6, .poissons_ratio = 0.3, .thickness = 1e-3};
struct Contender {
  const char* strategy;
  double limit;  ///< [m]; kNone where the meshes keep their directions and there is no smooth sphere
};
constexpr Contender kContenders[] = {{"van_gelder", kNone},
                                     {"van_gelder_simplified", kNone},
                                     {"two_parameter", 1.0819419},
                                     {"st_venant_kirchhoff_membrane", 1.0724470},
                                     {"neo_hookean_membrane", 1.0884528},
                                     {"hencky_membrane", kReference}};

Figures inflate(const Contender& contender, int divisions, int repeats) {
  Specimen specimen;
  specimen.material = kLatex;
  specimen.body = sphere_octant(1, SphereMesh::type_1, divisions);
  elastin::set_matter(specimen.body, 0.3 / divisions, kLatex.density, kLatex.thickness, 0);
  InflationSetup setup;
  setup.pressure = kPressure;
  setup.symmetry = {Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()};
  const Catalog catalog = built_in_catalog();
  const StrategyChoice choice = choose_strategy(catalog, contender.strategy);
  std::vector<double> seconds;
  Figures figures;
  for (int repeat = 0; repeat <= repeats; ++repeat) {
    const auto experiment = make_inflation(specimen.body, setup, specimen.material);
    const Run run = run_strategy(specimen, *experiment, choice, {.statics = {.tolerance = 1e-8}});
    if (run.outcome != Outcome::converged) throw std::runtime_error(fmt::format("{}: {}", choice.label, run.cause));
    if (repeat > 0) seconds.push_back(run.build_seconds + run.solve_seconds);
    figures.newton = run.newton_iterations;
    figures.iterations = run.linear_iterations;
    const double radius = run.measures.get("radius");
    figures.value = radius / kReference;
    figures.error = std::abs(figures.value - 1);
    figures.mesh_error = std::abs(radius / contender.limit - 1);
  }
  figures.cells = static_cast<double>(specimen.body.triangles.size());
  const Sample sample = summary(seconds);
  figures.minimum = sample.minimum;
  figures.median = sample.median;
  return figures;
}

}  // namespace

std::vector<Row> run_membrane(const Settings& settings) {
  std::vector<Row> rows;
  for (const Contender& contender : kContenders) {
    double coarser = kNone;
    for (const int divisions : {8, 16, 32, 64}) {
      say(fmt::format("membrane, {}, {}", contender.strategy, divisions));
      Figures figures = in_child([&] {
                          set_threads(1);
                          return std::vector{inflate(contender, divisions, settings.repeats)};
                        }).front();
      figures.order = std::log2(coarser / figures.mesh_error);
      coarser = figures.mesh_error;
      rows.push_back({"membrane", contender.strategy, divisions, 1, settings.repeats, figures, ""});
    }
  }
  return rows;
}

}  // namespace bench
