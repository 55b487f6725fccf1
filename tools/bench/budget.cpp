#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/integrator.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;

constexpr double kStep = 1e-3;  // s, as a haptic loop has it

struct BudgetCase {
  const char* name;
  Body (*body)(int side);
  const char* law;
};

Body make_block(int side) {
  Body block = tetrahedral_block(BlockKind::kuhn, {side, side, side}, Vector3::Constant(kCubeLength));
  bench::set_matter(block, side + 1);
  return block;
}

constexpr BudgetCase kCases[] = {{"cube, lattice springs", make_cube, "lattice"},
                                 {"block, neo_hookean tetrahedra", make_block, "neo_hookean"}};

/// Figures of a body that swings, its bottom held: backward Euler, one Newton iteration a step.
Figures time_steps(const BudgetCase& one, int side, int threads) {
  const Body body = one.body(side);
  Material material = kMaterial;
  material.poissons_ratio = 0.3;
  const Strategy strategy = built_in_catalog().find(one.law);
  Model model(body);
  model.add(strategy.make(body, material, {}));
  State state = state_at_rest(body);
  for (int i = 0; i < body.size(); ++i) {
    if (body.rest(2, i) < 1e-9) model.supports.push_back({i, Matrix3::Zero(), Vector3::Zero()});
    state.velocities(0, i) = body.rest(2, i);  // m/s: some tenths of a radian of shear to come
  }
  const auto integrator = make_integrator({.scheme = "backward_euler", .parameters = {{"newton_iterations", 1}}});
  set_threads(threads);
  constexpr int warm_up = 20, steps = 200;
  std::vector<double> seconds;
  int iterations = 0;
  for (int step = 0; step < warm_up + steps; ++step) {
    StepResult result;
    const double took = seconds_of([&] { result = integrator->advance(model, state, kStep); });
    if (result.outcome != Outcome::converged) throw std::runtime_error("the implicit step failed: " + result.cause);
    if (step < warm_up) continue;
    seconds.push_back(took);
    iterations += result.linear_iterations;
  }
  std::sort(seconds.begin(), seconds.end());
  Figures figures;
  figures.springs = body.connections.size();
  if (!body.tetrahedra.empty()) figures.cells = static_cast<double>(body.tetrahedra.size());
  figures.late = seconds[seconds.size() * 99 / 100];
  figures.iterations = static_cast<double>(iterations) / steps;
  const Sample sample = summary(std::move(seconds));
  figures.minimum = sample.minimum;
  figures.median = sample.median;
  return figures;
}

/// The largest side whose median is within the limit, by halves; none if not even the smallest is.
std::optional<std::pair<int, Figures>> largest_within(double limit, const std::function<Figures(int)>& time) {
  int fits = 2, fails = 0;
  std::optional<std::pair<int, Figures>> best;
  for (int side = 3; !fails || fails - fits > 1; side = fails ? (fits + fails) / 2 : side * 3 / 2) {
    const Figures figures = time(side);
    if (figures.median <= limit)
      fits = side, best = {side, figures};
    else
      fails = side;
  }
  return best;
}

}  // namespace

std::vector<Row> run_budget(const Settings& settings) {
  std::vector<Row> rows;
  for (const BudgetCase& one : kCases)
    for (const double limit : {1e-3, 16e-3})
      for (const int threads : settings.threads) {
        say(std::string("budget, ") + one.name);
        const auto best = largest_within(limit, [&](int side) {
          return in_child([&] { return std::vector{time_steps(one, side, threads)}; }).front();
        });
        const std::string note = limit < 2e-3 ? "under 1 ms" : "under 16 ms";
        rows.push_back({"budget", one.name, best ? best->first : 0, threads, 200, best ? best->second : Figures{},
                        best ? note : "nothing " + note});
      }
  return rows;
}

}  // namespace bench
