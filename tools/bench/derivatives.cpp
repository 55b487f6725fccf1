#include <fmt/format.h>

#include <array>
#include <memory>
#include <stdexcept>

#include "core/shapes/orders.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/sensitivity.h"
#include "elastin/core/solve/statics.h"
#include "lab/experiment/tension/tension.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;
using namespace elastin::lab;

constexpr double kTolerance = 1e-8;  ///< of the unbalanced force and of the adjoint solve

struct Kind {
  const char *name, *strategy;
  bool cells, driven;  ///< `driven`: a grip moves, and its force is the measure; else a force pulls, and its path is
  int largest_side;
};
constexpr Kind kKinds[] = {{"lattice under a force", "lattice", false, false, 1 << 20},
                           {"hexahedron27 between grips", "neo_hookean", true, true, 30}};
constexpr double kStrains[] = {1e-3, 0.1};

enum class Measure { none, of_load, of_one_molecule };
constexpr std::pair<Measure, const char*> kMeasures[] = {
    {Measure::none, "forward"},
    {Measure::of_load, "and all derivatives of the load's measure"},
    {Measure::of_one_molecule, "and those of one displacement"}};

Body make_body(const Kind& kind, int side) {
  if (!kind.cells) return make_cube(side);
  const int boxes = (side - 1) / 2;
  const std::array<int, 3> sides{boxes + 1, boxes + 1, boxes + 1};
  Body body = with_cells(cubic_lattice(sides, kCubeLength / boxes, {true, false, false}), cell_kind("hexahedron27"));
  elastin::set_matter(body, kCubeLength / boxes / 4, kMaterial.density, 0, 0);
  return body;
}

/// The tension cube, clamped at both ends, ready to be solved.
struct Cube {
  Cube(const Kind& kind, int side, double strain) : body(make_body(kind, side)), model(body), driven(kind.driven) {
    TensionSetup setup;
    setup.fixed_grip = setup.loaded_grip = Grip::clamped;
    if (driven)
      setup.strain = strain;
    else
      setup.force = kMaterial.youngs_modulus * kCubeLength * kCubeLength * strain;
    experiment = make_tension(body, setup);
    model.add(built_in_catalog().find(kind.strategy).make(body, kMaterial, {}));
    rig = experiment->static_rig(model);
    rig->set_load(1);
  }

  /// @return linear iterations
  int solve(Measure measure) {
    State state = state_at_rest(body);
    const StaticOptions options{.tolerance = kTolerance};
    const std::shared_ptr<LastSolve> last = make_last_solve();
    const StaticResult result =
        measure == Measure::none ? solve_static(model, state, options) : solve_static(model, state, options, *last);
    if (result.outcome != Outcome::converged) throw std::runtime_error(result.cause);
    newton = result.newton_iterations, residual = result.residual;
    if (measure == Measure::none) return result.linear_iterations;
    Positions of_positions = Positions::Zero(3, body.size()), of_reactions = of_positions;
    if (measure == Measure::of_one_molecule)
      of_positions(0, body.size() / 2) = 1;
    else if (driven)
      of_reactions.row(2) = (body.rest.row(2).array() > body.rest.row(2).mean()).cast<double>();
    else
      of_positions = model.load_forces(state);
    Sensitivity at(model, state, options, kTolerance, *last);
    const Adjoint adjoint = at.adjoint(of_positions, of_reactions);
    if (adjoint.result.outcome != Outcome::converged) throw std::runtime_error(adjoint.result.cause);
    for (const auto& law : model.elasticity())
      if (!at.by_stiffness(*law, adjoint).allFinite()) throw std::runtime_error("no derivatives");
    return result.linear_iterations + adjoint.result.linear_iterations;
  }

  Body body;
  Model model;
  bool driven;
  std::unique_ptr<StaticExperiment> experiment;
  std::unique_ptr<StaticRig> rig;
  int newton = 0;
  double residual = 0;
};

std::vector<Figures> race(const Kind& kind, int side, double strain, int threads, int repeats) {
  set_threads(threads);
  std::unique_ptr<Cube> cube;
  const double build =
      interleaved({[&] { cube = std::make_unique<Cube>(kind, side, strain); }}, repeats, true).front().median;
  std::vector<Figures> found;
  std::vector<std::function<void()>> works;
  for (const auto& [measure, name] : kMeasures) {
    Figures one;
    one.molecules = cube->body.size(), one.springs = cube->body.connections.size();
    one.cells = static_cast<double>(count_cells(cube->body)), one.build = build;
    one.iterations = cube->solve(measure), one.newton = cube->newton, one.residual = cube->residual;
    found.push_back(one);
    works.push_back([&cube, own = measure] { cube->solve(own); });
  }
  const std::vector<Sample> samples = interleaved(works, repeats, true);
  for (std::size_t i = 0; i < found.size(); ++i)
    found[i].minimum = samples[i].minimum, found[i].median = samples[i].median;
  return found;
}

}  // namespace

std::vector<Row> run_derivatives(const Settings& settings) {
  std::vector<Row> rows;
  for (const Kind& kind : kKinds)
    for (const int side : settings.sides)
      for (const double strain : kStrains)
        for (const int threads : settings.threads) {
          if (side > kind.largest_side || std::string(kind.name).find(settings.only) == std::string::npos) continue;
          say(fmt::format("derivatives, {}, side {}, strain {}", kind.name, side, strain));
          std::vector<Figures> found = in_child([&] { return race(kind, side, strain, threads, settings.repeats); });
          for (std::size_t i = 0; i < found.size(); ++i) {
            found[i].peak = in_child([&] {
                              const double before = peak_memory();
                              set_threads(threads);
                              Cube cube(kind, side, strain);
                              cube.solve(kMeasures[i].first);
                              Figures figures;
                              figures.peak = peak_memory() - before;
                              return std::vector{figures};
                            })
                                .front()
                                .peak;
            found[i].ratio = found[0].median / found[i].median;
            found[i].whole_ratio = (found[0].build + found[0].median) / (found[i].build + found[i].median);
            rows.push_back({"derivatives", fmt::format("{}, strain {}: {}", kind.name, strain, kMeasures[i].second),
                            side, threads, settings.repeats, found[i], "processor time"});
          }
        }
  return rows;
}

}  // namespace bench
