#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

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
constexpr int kLeastSide = 3;
constexpr double kMayMiss = 1e-3;  // of all deadlines, beyond what an empty loop misses
constexpr Material kSoft{.youngs_modulus = 1e4, .poissons_ratio = 0.25, .density = 1000};

/// What is stepped, and how.
struct Contender {
  const char* name;
  StepperOptions stepper;
  const char* strategy = "lattice";
  double safety = 0.98;  // of explicit steps
};

/// Of springs, or of six tetrahedra a cube, molecules in the same places. Each cube's mass goes to its corners, as the
/// cubes share out the springs' stiffness: equal masses would be too heavy on faces and edges, and too light inside.
Body soft_cube(int side, bool cells) {
  const double spacing = kEdge / (side - 1);
  Body body = cells ? tetrahedral_block(BlockKind::kuhn, {side - 1, side - 1, side - 1}, Vector3::Constant(kEdge))
                    : cubic_lattice({side, side, side}, spacing, {.axis = true, .face = true});
  elastin::set_matter(body, spacing / 2, kSoft.density, 0, cells ? 0 : std::pow(kEdge, 3));
  if (cells) return body;
  body.mass.setZero();
  for (const auto& cube : body.cubes)
    for (const int corner : cube) body.mass[corner] += kSoft.density * std::pow(spacing, 3) / 8;
  return body;
}

/// A cube that stands, and a tool that goes round at the middle of its top: all that a haptic host does.
class Host {
 public:
  Host(int side, const Contender& contender)
      : tissue_(soft_cube(side, std::string_view(contender.strategy) != "lattice"),
                built_in_catalog().find(contender.strategy), kSoft,
                {.stepper = contender.stepper, .safety = contender.safety, .threads = 1}) {
    const Body& body = tissue_.body();
    tissue_.model().add(make_gravity(body, {0, 0, -9.81}));
    tissue_.model().add(make_mass_damping(body, 10));
    int middle = 0;
    const Vector3 top(kEdge / 2, kEdge / 2, kEdge);
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      if (body.rest(2, molecule) < 1e-6 * kEdge) tissue_.fix(molecule);
      if ((body.rest.col(molecule) - top).norm() < (body.rest.col(middle) - top).norm()) middle = molecule;
    }
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

/// Processor time of half of the steps, one after the other [s]: whatever keeps its time is quicker.
double median_of(int side, const Contender& contender) {
  Host host(side, contender);
  std::vector<double> seconds(500);
  for (double& one : seconds) {
    const double start = processor_seconds();
    host.one_step();
    one = processor_seconds() - start;
  }
  std::sort(seconds.begin(), seconds.end());
  return share(seconds, 0.5);
}

int largest_side(const Contender& contender) {
  int fits = 2, fails = 0;
  for (int side = 4; !fails || fails - fits > 1; side = fails ? (fits + fails) / 2 : side * 3 / 2)
    (median_of(side, contender) <= kStep ? fits : fails) = side;
  return fits;
}

/// A step every millisecond, waited for as servo loops wait on a core of their own: first by the clock, then the same
/// by the thread's own time.
template <class Step>
std::pair<Figures, Figures> steady(double seconds, Step&& one_step) {
  using Clock = std::chrono::steady_clock;
  Figures clock;
  clock.missed = 0;
  std::vector<double> walls(static_cast<std::size_t>(seconds / kStep)), own(walls.size());
  const long before = elastin::testing::allocations();
  auto deadline = Clock::now();
  for (std::size_t step = 0; step < walls.size(); ++step) {
    while (Clock::now() < deadline) {
    }
    deadline += std::chrono::microseconds(1000);
    const auto begin = Clock::now();
    const double start = processor_seconds();
    one_step();
    own[step] = processor_seconds() - start;
    const auto end = Clock::now();
    walls[step] = std::chrono::duration<double>(end - begin).count();
    if (end <= deadline) continue;
    ++clock.missed;
    deadline = end;
  }
  clock.asked = static_cast<double>(elastin::testing::allocations() - before);
  Figures processor = clock;
  processor.missed = processor.asked = kNone;
  set_distribution(walls, clock);
  set_distribution(own, processor);
  return {clock, processor};
}

std::vector<Figures> steady(int side, const Contender& contender, double seconds) {
  Host host(side, contender);
  auto [clock, processor] = steady(seconds, [&] { host.one_step(); });
  double off = 0, motion = 0;
  if (!contender.stepper.method->effort.empty())
    for (int look = 0; look < 100; ++look) {
      host.one_step();
      const auto [distance, step] = host.tissue().iteration_error(kStep);
      off = std::max(off, distance), motion = std::max(motion, step);
    }
  for (Figures* figures : {&clock, &processor}) {
    figures->molecules = host.tissue().body().size();
    figures->springs = host.tissue().body().connections.size();
    figures->cells = static_cast<double>(host.tissue().body().tetrahedra.size());
    figures->parts = host.parts;
    if (motion > 0) figures->error = off / motion;
  }
  return {clock, processor};
}

/// The force pass alone, as often as a step has parts: nothing explicit can be quicker; and a peer's step.
std::vector<Figures> limits(int side, int parts, int repeats) {
  Host host(side, {"", {"symplectic_euler"}});
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
  const int steps = static_cast<int>(settings.seconds / kStep);
  say("embed, an empty loop");
  const auto empty = in_child([&] {
    const auto [clock, processor] = steady(settings.seconds, [] {});
    return std::vector{clock, processor};
  });
  rows.push_back({"embed", "an empty loop", 0, 1, steps, empty[0], "what this machine misses by itself"});
  const auto add = [&](const Contender& contender) -> std::pair<int, int> {
    if (std::string_view(contender.name).find(settings.only) == std::string_view::npos) return {};
    say(std::string("embed, ") + contender.name);
    int side = static_cast<int>(in_child([&] {
                                  Figures found;
                                  found.molecules = largest_side(contender);
                                  return std::vector{found};
                                })
                                    .front()
                                    .molecules);
    const auto keeps = [&](const std::vector<Figures>& figures, double seconds) {
      return figures.front().missed / (seconds / kStep) - empty.front().missed / steps <= kMayMiss;
    };
    // What others take from this machine comes in bursts: one of three tries is enough.
    const auto steadily = [&](double seconds) {
      std::vector<Figures> found;
      for (int attempt = 0; attempt < 3 && (attempt == 0 || !keeps(found, seconds)); ++attempt)
        found = in_child([&] { return steady(side, contender, seconds); });
      return found;
    };
    while (side > kLeastSide && !keeps(steadily(settings.seconds / 6), settings.seconds / 6)) --side;
    auto found = steadily(settings.seconds);
    while (side > kLeastSide && !keeps(found, settings.seconds)) --side, found = steadily(settings.seconds);
    rows.push_back({"embed", contender.name, side, 1, steps, found[0], "by the clock"});
    rows.push_back({"embed", contender.name, side, 1, steps, found[1], "processor time"});
    return {side, static_cast<int>(found[0].parts)};
  };
  const auto [side, parts] = add({"springs, symplectic_euler", {"symplectic_euler"}});
  if (side > 0) {
    const auto found = in_child([&, side = side, parts = parts] { return limits(side, parts, settings.repeats); });
    rows.push_back(
        {"embed", "force passes alone", side, 1, 100 * settings.repeats, found[0], "the limit of the above"});
    rows.push_back({"embed", "Bullet soft body", side, 1, 100 * settings.repeats, found[1],
                    bullet_missing().empty() ? "one position iteration, single precision" : bullet_missing()});
  }
  const auto with = [](const char* method, const char* name, double value) {
    return StepperOptions{.method = method, .parameters = {{name, value}}};
  };
  add({"springs, backward_euler, one Newton iteration", with("backward_euler", "newton_iterations", 1)});
  add({"springs, block_descent, one sweep", with("block_descent", "sweeps", 1)});
  add({"springs, xpbd, one substep", with("xpbd", "substeps", 1)});
  add({"springs, projective, one solve", with("projective", "solves", 1)});
  add({"neo-Hookean cells, symplectic_euler", {"symplectic_euler"}, "neo_hookean"});
  add({"neo-Hookean cells, block_descent, one sweep", with("block_descent", "sweeps", 1), "neo_hookean"});
  add({"neo-Hookean cells, backward_euler, one Newton iteration", with("backward_euler", "newton_iterations", 1),
       "neo_hookean"});
  return rows;
}

}  // namespace bench
