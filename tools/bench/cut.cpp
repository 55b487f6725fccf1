#include <algorithm>
#include <stdexcept>

#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/saved_state.h"
#include "elastin/core/simulation/simulation.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;

constexpr double kStep = 1e-3;  // s
constexpr int kSteps = 60, kCutAt = 30;

/// A block of neo-Hookean tetrahedra that swings, its bottom held.
Simulation swinging(int side, const char* method, int threads) {
  Body block = tetrahedral_block(BlockKind::kuhn, {side, side, side}, Vector3::Constant(kCubeLength));
  bench::set_matter(block, side + 1);
  Material material = kMaterial;
  material.poissons_ratio = 0.3;
  SimulationOptions options;
  options.stepper.method = method;
  if (options.stepper.method->effort == "newton_iterations") options.stepper.parameters = {{"newton_iterations", 1}};
  options.threads = threads;
  Simulation tissue(std::move(block), built_in_catalog().find("neo_hookean"), material, std::move(options));
  SimulationState begin = tissue.save();
  for (int molecule = 0; molecule < tissue.body().size(); ++molecule) {
    begin.state.velocities(0, molecule) = tissue.body().rest(2, molecule);
    if (tissue.body().rest(2, molecule) < 1e-9) begin.supports.push_back({molecule});
  }
  tissue.restore(begin);
  return tissue;
}

double volume_of(const Body& body) {
  double sum = 0;
  for (const auto& cell : body.tetrahedra) sum += signed_volume(body.rest, cell);
  return sum;
}

struct Times {
  std::vector<double> steps;
  double cut = 0;
  std::vector<char> end;  // the last state
};

/// A plane goes through it half-way, at an angle to its layers; the state of the step before is what it begins again
/// from.
Times cut_through(int side, const char* method, int threads) {
  const auto stepped = [&](Simulation& tissue, int count, std::vector<double>& took) {
    for (int step = 0; step < count; ++step) {
      StepResult result;
      took.push_back(seconds_of([&] { result = tissue.step(kStep); }));
      if (result.outcome != Outcome::converged) throw std::runtime_error("cut: " + result.cause);
    }
  };
  const CutSurface plane = CutSurface::plane(Vector3::Constant(0.43), {1, 0.3, 0.1});
  Simulation tissue = swinging(side, method, threads);
  const double volume = volume_of(tissue.body()), mass = tissue.body().mass.sum();
  Times times;
  stepped(tissue, kCutAt, times.steps);
  TopologyReport report;
  times.cut = seconds_of([&] { report = tissue.cut(plane); });
  if (report.split_molecules == 0 || volume_of(tissue.body()) != volume ||
      std::abs(tissue.body().mass.sum() / mass - 1) > 1e-13)
    throw std::runtime_error("the cut has changed the body's volume or mass");
  const std::vector<char> saved = bytes_of(tissue.save());
  stepped(tissue, kSteps - kCutAt, times.steps);
  times.end = bytes_of(tissue.save());
  Simulation other = swinging(side, method, threads);  // that was never cut
  other.restore(simulation_state_of(saved.data(), saved.size()));
  std::vector<double> unused;
  stepped(other, kSteps - kCutAt, unused);
  if (bytes_of(other.save()) != times.end) throw std::runtime_error("what was restored goes another way");
  return times;
}

}  // namespace

/// Rows of a body that is cut while it moves: its steps, and the longest one with the cut before it. All states are
/// compared: bitwise the same on each number of threads and after a restore, volume and mass as before.
std::vector<Row> run_cut(const Settings&) {
  std::vector<Row> rows;
  for (const char* method : {"symplectic_euler", "backward_euler", "block_descent"}) {
    constexpr int side = 15;  // 20 250 cells
    say(std::string("cut: ") + method);
    std::vector<char> first;
    for (const int threads : {1, 2, 3}) {
      const Times times = cut_through(side, method, threads);
      if (!first.empty() && times.end != first) throw std::runtime_error("threads change the result of a cut");
      first = times.end;
      std::vector<double> steady(times.steps.begin() + 1, times.steps.end());
      steady.erase(steady.begin() + kCutAt - 1);
      std::sort(steady.begin(), steady.end());
      Figures figures;
      figures.molecules = (side + 1) * (side + 1) * (side + 1);
      figures.cells = 6 * side * side * side;
      figures.build = times.cut;
      figures.minimum = steady.front();
      figures.median = steady[steady.size() / 2];
      figures.most = times.cut + times.steps[kCutAt];
      rows.push_back({"cut", method, side, threads, 1, figures, "build: the cut; most: the cut and the step after it"});
    }
  }
  return rows;
}

}  // namespace bench
