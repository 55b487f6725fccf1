#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/simulation.h"
#include "measure.h"
#include "peers.h"
#include "support/allocations.h"

namespace bench {
namespace {

using namespace elastin;

constexpr double kStep = 1e-3;  // s, as a haptic loop has it
constexpr double kEdge = 0.1;   // m, of the cube
constexpr Material kSoft{.youngs_modulus = 1e4, .poissons_ratio = 0.25, .density = 1000};

Body soft_cube(int side) {
  const double spacing = kEdge / (side - 1);
  Body body = cubic_lattice({side, side, side}, spacing, {.axis = true, .face = true});
  elastin::set_matter(body, spacing / 2, kSoft.density, 0, std::pow(kEdge, 3));
  return body;
}

/// A cube that stands, and a tool that goes round at the middle of its top: all that a haptic host does.
class Host {
 public:
  Host(int side, const IntegratorOptions& integrator)
      : tissue_(soft_cube(side), built_in_catalog().find("lattice"), kSoft, {.integrator = integrator, .threads = 1}) {
    const Body& body = tissue_.body();
    tissue_.model().add(make_gravity(body, {0, 0, -9.81}));
    tissue_.model().add(make_mass_damping(body, 10));
    for (int molecule = 0; molecule < side * side; ++molecule) tissue_.fix(molecule);
    const int middle = body.size() - side * side / 2 - 1;
    start_ = body.rest.col(middle);
    tool_ = tissue_.couple(middle, start_, 50, 0.1);
    host_force_ = &tissue_.host_forces();
    tissue_.observe(16, [this](const Simulation& seen) { lowest_ = seen.positions().row(2).minCoeff(); });
    for (int step = 0; step < 20; ++step) one_step();
  }

  void one_step() {
    const double angle = 2 * tissue_.time();
    tissue_.move_coupling(tool_, start_ + 5e-3 * Vector3(std::sin(angle), std::cos(angle) - 1, std::sin(3 * angle)));
    host_force_->col(0).setConstant(1e-3);
    const StepResult result = tissue_.step(kStep);
    if (result.outcome != Outcome::converged) throw std::runtime_error("a step failed: " + result.cause);
    parts = result.substeps;
    pull_ += tissue_.coupling_force(tool_).norm();
  }
  Simulation& tissue() { return tissue_; }
  int parts = 1;

 private:
  Simulation tissue_;
  CouplingId tool_ = 0;
  Vector3 start_;
  Positions* host_force_;
  double pull_ = 0, lowest_ = 0;
};

/// Of this thread alone [s]: what others take from it does not count.
double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double share(const std::vector<double>& sorted, double part) {
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(part * static_cast<double>(sorted.size())))];
}

void set_distribution(std::vector<double>& seconds, Figures& figures) {
  std::sort(seconds.begin(), seconds.end());
  figures.minimum = seconds.front();
  figures.median = share(seconds, 0.5);
  figures.late = share(seconds, 0.99);
  figures.later = share(seconds, 0.999);
  figures.most = seconds.back();
}

/// Processor time that 99.9 % of the steps stay within [s], one after the other; the least of three tries.
double later_of(int side, const IntegratorOptions& integrator) {
  Host host(side, integrator);
  double least = 1;
  std::vector<double> seconds(1000);
  for (int attempt = 0; attempt < 3; ++attempt) {
    for (double& one : seconds) {
      const double start = processor_seconds();
      host.one_step();
      one = processor_seconds() - start;
    }
    std::sort(seconds.begin(), seconds.end());
    least = std::min(least, share(seconds, 0.999));
  }
  return least;
}

int largest_side(const IntegratorOptions& integrator) {
  int fits = 2, fails = 0;
  for (int side = 4; !fails || fails - fits > 1; side = fails ? (fits + fails) / 2 : side * 3 / 2)
    (later_of(side, integrator) <= kStep ? fits : fails) = side;
  return fits;
}

/// A step every millisecond: first by the clock, then the same by the thread's own time.
std::vector<Figures> steady(int side, const IntegratorOptions& integrator, double seconds) {
  using Clock = std::chrono::steady_clock;
  Host host(side, integrator);
  Figures clock;
  clock.molecules = host.tissue().body().size();
  clock.springs = host.tissue().body().connections.size();
  clock.missed = 0;
  std::vector<double> walls(static_cast<std::size_t>(seconds / kStep)), own(walls.size());
  const long before = elastin::testing::allocations();
  auto deadline = Clock::now();
  for (std::size_t step = 0; step < walls.size(); ++step) {
    std::this_thread::sleep_until(deadline);
    deadline += std::chrono::microseconds(1000);
    const auto begin = Clock::now();
    const double start = processor_seconds();
    host.one_step();
    own[step] = processor_seconds() - start;
    const auto end = Clock::now();
    walls[step] = std::chrono::duration<double>(end - begin).count();
    if (end <= deadline) continue;
    ++clock.missed;
    deadline = end;
  }
  clock.asked = static_cast<double>(elastin::testing::allocations() - before);
  clock.parts = host.parts;
  Figures processor = clock;
  processor.missed = processor.asked = kNone;
  set_distribution(walls, clock);
  set_distribution(own, processor);
  return {clock, processor};
}

/// The force pass alone, as often as a step has parts: nothing explicit can be quicker; and a peer's step.
std::vector<Figures> limits(int side, int parts, int repeats) {
  Host host(side, {"symplectic_euler"});
  Simulation& tissue = host.tissue();
  const ThreadScope alone(nullptr, 1);
  const SimulationState saved = tissue.save();
  Workspace workspace;
  Positions forces;
  const VectorX constants = built_in_catalog().find("lattice").constants(tissue.body(), kSoft, {});
  const auto bullet = make_bullet({tissue.body(), constants, saved.state.positions, kStep});
  std::vector<double> passes, steps;
  for (int repeat = 0; repeat < 100 * repeats; ++repeat) {
    passes.push_back(seconds_of([&] {
      for (int part = 0; part < parts; ++part) tissue.model().set_forces(saved.state, forces, workspace);
    }));
    if (bullet) steps.push_back(bullet(1));
  }
  std::vector<Figures> found(2);
  for (Figures& one : found) one.molecules = tissue.body().size(), one.springs = tissue.body().connections.size();
  set_distribution(passes, found[0]);
  found[0].parts = parts;
  if (bullet) set_distribution(steps, found[1]);
  return found;
}

}  // namespace

std::vector<Row> run_embed(const Settings& settings) {
  std::vector<Row> rows;
  const auto add = [&](const char* name, const IntegratorOptions& integrator) {
    say(std::string("embed, ") + name);
    const int side = static_cast<int>(in_child([&] {
                                        Figures found;
                                        found.molecules = largest_side(integrator);
                                        return std::vector{found};
                                      })
                                          .front()
                                          .molecules);
    const auto found = in_child([&] { return steady(side, integrator, settings.seconds); });
    const int steps = static_cast<int>(settings.seconds / kStep);
    rows.push_back({"embed", name, side, 1, steps, found[0], "by the clock"});
    rows.push_back({"embed", name, side, 1, steps, found[1], "processor time"});
    return std::pair{side, static_cast<int>(found[0].parts)};
  };
  const auto [side, parts] = add("symplectic_euler", {"symplectic_euler"});
  const auto found = in_child([&, side = side, parts = parts] { return limits(side, parts, settings.repeats); });
  rows.push_back({"embed", "force passes alone", side, 1, 100 * settings.repeats, found[0], "the limit of the above"});
  rows.push_back({"embed", "Bullet soft body", side, 1, 100 * settings.repeats, found[1],
                  bullet_missing().empty() ? "one position iteration, single precision" : bullet_missing()});
  add("backward_euler", {.scheme = "backward_euler", .parameters = {{"newton_iterations", 1}}});
  return rows;
}

}  // namespace bench
