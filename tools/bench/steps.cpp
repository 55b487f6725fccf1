#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/stepper.h"
#include "measure.h"
#include "peers.h"
#include "plain_loop.h"

namespace bench {
namespace {

using namespace elastin;

/// Elastin's velocity Verlet through its public face.
struct Ours {
  Body body;
  Model model;
  State state;
  std::unique_ptr<Stepper> stepper = make_stepper({.method = "velocity_verlet"});

  Ours(Body of, const VectorX& constants, const Positions& positions)
      : body(std::move(of)), model(body), state(state_at_rest(body)) {
    model.add(make_springs(body, constants));
    state.positions = positions;
  }
  double seconds(int steps, int threads, double dt) {
    set_threads(threads);
    return seconds_of([&] {
      for (int step = 0; step < steps; ++step)
        if (stepper->advance(model, state, dt).outcome != Outcome::converged) throw std::runtime_error("diverged");
    });
  }
};

/// The same by hand: a loop over the connections between two over the molecules.
class ByHand {
 public:
  ByHand(const Start& start, int threads)
      : team_(threads),
        springs_{start.body.connections, start.constants},
        mass_(start.body.mass),
        x_(start.positions),
        v_(Positions::Zero(3, x_.cols())),
        a_(v_),
        forces_(static_cast<std::size_t>(threads)) {
    plain_forces(team_, springs_, x_, forces_);
    a_ = forces_[0] * mass_.cwiseInverse().asDiagonal();
  }
  double seconds(int steps, double dt) {
    return seconds_of([&] {
      for (int step = 0; step < steps; ++step) advance(dt);
    });
  }
  const Positions& positions() const { return x_; }

 private:
  void advance(double dt) {
    const int count = static_cast<int>(3 * x_.cols());
    double *x = x_.data(), *v = v_.data(), *a = a_.data();
    team_.run([&](int member) {
      for (int i = team_.begin(member, count), end = team_.begin(member + 1, count); i < end; ++i)
        x[i] += dt * (v[i] + dt / 2 * a[i]);
    });
    plain_forces(team_, springs_, x_, forces_);
    const double* f = forces_[0].data();
    team_.run([&](int member) {
      for (int i = team_.begin(member, count), end = team_.begin(member + 1, count); i < end; ++i) {
        const double next = f[i] / mass_[i / 3];
        v[i] += dt / 2 * (a[i] + next);
        a[i] = next;
      }
    });
  }

  Team team_;
  Springs springs_;
  const VectorX& mass_;
  Positions x_, v_, a_;
  std::vector<Positions> forces_;
};

enum class Kind { lattice, any_graph, by_hand, lammps, bullet };
constexpr const char* kNames[] = {"elastin, lattice", "elastin, any graph", "plain loop", "LAMMPS", "Bullet soft body"};

struct Contender {
  Kind kind;
  int threads;
  std::string missing;  ///< why it cannot run; empty if it can
};

constexpr int kBulletLimit = 50;  // molecules a side: links take 1 GB at 100

std::vector<Contender> contenders_of(int side, const Settings& settings) {
  std::vector<Contender> all;
  for (const int threads : settings.threads) {
    for (const Kind kind : {Kind::lattice, Kind::any_graph, Kind::by_hand}) all.push_back({kind, threads, ""});
    all.push_back({Kind::lammps, threads, lammps_missing(threads)});
  }
  all.push_back({Kind::bullet, 1, side > kBulletLimit ? "left out: links take 1 GB" : bullet_missing()});
  return all;
}

/// The cube of `side`³ molecules and its springs, stretched and sheared a little, so that it moves.
struct Scene {
  Body body;
  VectorX constants;
  Positions positions;
  double dt;

  explicit Scene(int side) : body(make_cube(side)) {
    constants = built_in_catalog().find("lattice").constants(body, kMaterial, {});
    positions = body.rest;
    positions.row(2) *= 1.01;
    positions.row(0) += 0.02 * positions.row(1);
    // Far below the stable step, which 18 springs on a molecule set.
    dt = 0.1 * std::sqrt(body.mass.minCoeff() / (18 * constants.maxCoeff()));
  }
  Start start() const { return {body, constants, positions, dt}; }
};

Body without_grid(Body body) {
  body.grid.reset();
  return body;
}

/// How long a number of steps takes one of the contenders [s].
using Seconds = std::function<double(int steps)>;

Seconds make(const Contender& contender, const Scene& scene) {
  const int threads = contender.threads;
  if (!contender.missing.empty()) return [](int) { return kNone; };
  switch (contender.kind) {
    case Kind::lattice:
    case Kind::any_graph: {
      const auto ours = std::make_shared<Ours>(contender.kind == Kind::lattice ? scene.body : without_grid(scene.body),
                                               scene.constants, scene.positions);
      return [ours, threads, dt = scene.dt](int steps) { return ours->seconds(steps, threads, dt); };
    }
    case Kind::by_hand: {
      const auto by_hand = std::make_shared<ByHand>(scene.start(), threads);
      return [by_hand, dt = scene.dt](int steps) { return by_hand->seconds(steps, dt); };
    }
    case Kind::lammps:
      return make_lammps(scene.start(), threads);
    case Kind::bullet:
      break;
  }
  return make_bullet(scene.start());
}

/// After the same steps Elastin on its lattice, Elastin on the list and the plain loop are in the same position.
void check_agreement(const Scene& scene) {
  constexpr int steps = 20;
  Ours lattice(scene.body, scene.constants, scene.positions),
      list(without_grid(scene.body), scene.constants, scene.positions);
  ByHand by_hand(scene.start(), 1);
  lattice.seconds(steps, 1, scene.dt), list.seconds(steps, 1, scene.dt), by_hand.seconds(steps, scene.dt);
  for (const Ours* one : {&lattice, &list})
    if (!((one->state.positions - by_hand.positions()).cwiseAbs().maxCoeff() <= 1e-12 * kCubeLength))
      throw std::runtime_error("the plain loop and elastin differ");
}

/// Every contender's figures, in turn.
std::vector<Figures> race(int side, const std::vector<Contender>& contenders, int repeats) {
  const Scene scene(side);
  check_agreement(scene);
  const double springs = scene.body.connections.size();
  // Some 40 million springs a sample: long against the clock and one wake-up.
  const int steps = std::clamp(static_cast<int>(4e7 / springs), 4, 4000);
  std::vector<Seconds> works;
  for (const Contender& contender : contenders) works.push_back(make(contender, scene));
  std::vector<std::vector<double>> seconds(contenders.size());
  for (int repeat = -1; repeat < repeats; ++repeat)  // one to warm up
    for (std::size_t i = 0; i < works.size(); ++i) {
      const double one = works[i](steps) / steps;
      if (repeat >= 0) seconds[i].push_back(one);
    }
  std::vector<Figures> found;
  for (std::size_t i = 0; i < works.size(); ++i) {
    const Sample sample = summary(std::move(seconds[i]));
    Figures figures;
    figures.springs = springs;
    if (contenders[i].missing.empty()) {
      figures.minimum = sample.minimum;
      figures.median = sample.median;
      figures.rate = springs / sample.median;
    }
    found.push_back(figures);
  }
  // Against Elastin's lattice pass, and against the plain loop, on as many threads.
  for (std::size_t i = 0; i < found.size(); ++i)
    for (std::size_t j = 0; j < found.size(); ++j) {
      if (contenders[j].threads != contenders[i].threads) continue;
      if (contenders[j].kind == Kind::lattice) found[i].behind = found[i].median / found[j].median;
      if (contenders[j].kind == Kind::by_hand) found[i].ratio = found[j].median / found[i].median;
    }
  return found;
}

}  // namespace

std::vector<Row> run_steps(const Settings& settings) {
  say("steps, memory bandwidth");
  std::vector<Row> rows;
  const std::vector<Figures> memory = in_child([&] { return triad(settings); });
  for (std::size_t i = 0; i < memory.size(); ++i)
    rows.push_back({"steps", "triad, 240 MB", 0, settings.threads[i], settings.repeats, memory[i], ""});
  for (const int side : settings.sides) {
    say("steps, side " + std::to_string(side));
    const std::vector<Contender> contenders = contenders_of(side, settings);
    const std::vector<Figures> found = in_child([&] { return race(side, contenders, settings.repeats); });
    for (std::size_t i = 0; i < found.size(); ++i)
      rows.push_back({"steps", kNames[static_cast<int>(contenders[i].kind)], side, contenders[i].threads,
                      settings.repeats, found[i], contenders[i].missing});
  }
  return rows;
}

}  // namespace bench
