#include "contact_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "elastin/contact/contact.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/integrator.h"

namespace bench {
namespace {

using namespace elastin;
using namespace elastin::contact;

enum class Kind { none, far_spheres, far_triangles, pressed_spheres, pressed_triangles };
constexpr const char* kNames[] = {"steps: no contact", "steps: plane far away, spheres",
                                  "steps: plane far away, triangles", "steps: on the plane, spheres",
                                  "steps: on the plane, triangles"};

/// Velocity Verlet of the cube on its lattice pass, the fastest there is: contact has to be cheap beside it.
struct Run {
  Body body;
  Model model;
  State state;
  std::unique_ptr<Integrator> integrator = make_integrator({.scheme = "velocity_verlet"});
  double dt;

  Run(Kind kind, int side) : body(make_cube(side)), model(body), state(state_at_rest(body)) {
    const VectorX constants = built_in_catalog().find("lattice").constants(body, kMaterial, {});
    dt = 0.1 * std::sqrt(body.mass.minCoeff() / (18 * constants.maxCoeff()));
    model.add(make_springs(body, constants));
    state.positions.row(2) *= 1.001;  // so that it moves
    if (kind == Kind::none) return;
    ContactOptions options;
    options.stiffness = default_contact_stiffness(body, kMaterial.youngs_modulus);
    const bool spheres = kind == Kind::far_spheres || kind == Kind::pressed_spheres;
    options.surface = spheres ? ContactSurface::spheres : ContactSurface::triangles;
    const bool far = kind == Kind::far_spheres || kind == Kind::far_triangles;
    const double spacing = kCubeLength / (side - 1);
    Pose pose;
    pose.position.z() = far ? -1 : 0.01 * spacing - (spheres ? spacing / 2 : 0);
    options.obstacles.push_back({"plane", shape::Plane{}, pose});
    model.add(make_contact(body, options));
  }
  void advance(int steps) {
    for (int step = 0; step < steps; ++step)
      if (integrator->advance(model, state, dt).outcome != Outcome::converged) throw std::runtime_error("diverged");
  }
};

std::vector<Figures> race(int side, int threads, int repeats) {
  set_threads(threads);
  std::vector<std::unique_ptr<Run>> runs;
  for (int kind = 0; kind < static_cast<int>(std::size(kNames)); ++kind)
    runs.push_back(std::make_unique<Run>(static_cast<Kind>(kind), side));
  const double springs = runs[0]->body.connections.size();
  const int steps =
      std::clamp(static_cast<int>(2e6 / springs), 1, 200);  // short: few are disturbed, and the minimum counts
  std::vector<std::function<void()>> works;
  for (const auto& run : runs) works.emplace_back([&run, steps] { run->advance(steps); });
  std::vector<Figures> found;
  for (const Sample& sample : interleaved(works, 10 * repeats)) {
    Figures figures;
    figures.molecules = runs[0]->body.size();
    figures.springs = springs;
    figures.minimum = sample.minimum / steps;
    figures.median = sample.median / steps;
    figures.without = figures.minimum / (found.empty() ? figures.minimum : found[0].minimum);
    found.push_back(figures);
  }
  return found;
}

}  // namespace

std::vector<Row> run_contact_steps(const Settings& settings) {
  std::vector<Row> rows;
  for (const int side : settings.sides)
    for (const int threads : settings.threads) {
      say(fmt::format("contact, steps, side {}, threads {}", side, threads));
      const auto found = in_child([&] { return race(side, threads, settings.repeats); });
      for (std::size_t i = 0; i < found.size(); ++i)
        rows.push_back({"contact", kNames[i], side, threads, 10 * settings.repeats, found[i], ""});
    }
  return rows;
}

}  // namespace bench
