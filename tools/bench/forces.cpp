#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "elastin/base/threads.h"
#include "elastin/forces/model.h"
#include "elastin/simulation/catalog.h"
#include "measure.h"

namespace bench {
namespace {

using namespace elastin;

/// Where a fixed number of threads wait for each other. Looks for a while before it sleeps: sleeping and waking costs
/// more than a small pass, and looking forever starves the rest of a busy machine.
class Gate {
 public:
  explicit Gate(int size) : size_(size) {}
  void arrive_and_wait() {
    const int round = round_.load();
    if (arrived_.fetch_add(1) + 1 == size_) {
      arrived_ = 0;
      round_ = round + 1;
      round_.notify_all();
      return;
    }
    for (int look = 0; look < 20000; ++look)
      if (round_.load() != round) return;
    round_.wait(round);
  }

 private:
  int size_;
  std::atomic<int> arrived_{0}, round_{0};
};

/// Threads that wait for work: starting one a pass would cost more than a small pass itself.
class Team {
 public:
  explicit Team(int size) : size_(size), start_(size), end_(size) {
    for (int member = 1; member < size; ++member)
      others_.emplace_back([this, member] {
        for (start_.arrive_and_wait(); work_; start_.arrive_and_wait()) {
          (*work_)(member);
          end_.arrive_and_wait();
        }
      });
  }
  ~Team() {
    work_ = nullptr;
    start_.arrive_and_wait();
  }
  int size() const { return size_; }
  /// Calls work(member) once for each member, each on its own thread.
  void run(const std::function<void(int member)>& work) {
    work_ = &work;
    start_.arrive_and_wait();
    work(0);
    end_.arrive_and_wait();
  }
  /// Where a member's part of `count` items begins; it ends where the next one's begins.
  int begin(int member, int count) const { return static_cast<int>(static_cast<long long>(count) * member / size_); }

 private:
  int size_;
  Gate start_, end_;
  const std::function<void(int)>* work_ = nullptr;
  std::vector<std::jthread> others_;
};

struct Springs {
  const Connections& connections;
  const VectorX& constants;
};

/// What one writes by hand: one loop over the connections that adds ± k (1 − L/l) d to both ends.
void add_plain(const Springs& springs, const Positions& positions, int begin, int end, Positions& forces) {
  const double* x = positions.data();
  double* f = forces.data();
  for (int c = begin; c < end; ++c) {
    const auto [a, b] = springs.connections.ends[c];
    const double dx = x[3 * b] - x[3 * a], dy = x[3 * b + 1] - x[3 * a + 1], dz = x[3 * b + 2] - x[3 * a + 2];
    const double q =
        springs.constants[c] * (1 - springs.connections.rest_length[c] / std::sqrt(dx * dx + dy * dy + dz * dz));
    f[3 * a] += q * dx, f[3 * a + 1] += q * dy, f[3 * a + 2] += q * dz;
    f[3 * b] -= q * dx, f[3 * b + 1] -= q * dy, f[3 * b + 2] -= q * dz;
  }
}

/// The same on several threads, each with forces of its own, added up afterwards. forces[0] is the result.
void plain_forces(Team& team, const Springs& springs, const Positions& positions, std::vector<Positions>& forces) {
  const int count = springs.connections.size(), molecules = static_cast<int>(positions.cols());
  team.run([&](int member) {
    forces[member].setZero(3, molecules);
    add_plain(springs, positions, team.begin(member, count), team.begin(member + 1, count), forces[member]);
  });
  if (team.size() == 1) return;
  team.run([&](int member) {
    const int begin = team.begin(member, molecules), width = team.begin(member + 1, molecules) - begin;
    for (int other = 1; other < team.size(); ++other)
      forces[0].middleCols(begin, width) += forces[other].middleCols(begin, width);
  });
}

/// Elastin and the plain loop in turn, at each number of threads: two figures for each of them.
std::vector<Figures> race(int side, const Settings& settings) {
  const Body body = make_cube(side);
  const VectorX constants = built_in_catalog().find("lattice").constants(body, kMaterial, {});
  Model model(body);
  model.add(make_springs(body, constants));
  // Stretched, sheared and bent a little, so that no spring is at rest.
  Positions positions = body.rest;
  positions.row(2) *= 1.01;
  positions.row(0) += 0.02 * positions.row(1) + 0.01 * positions.row(2).cwiseAbs2();
  const Springs springs{body.connections, constants};
  // A sample of some 4 million springs: long against the clock and one wake-up.
  const int passes = std::max(1, 4000000 / body.connections.size());

  std::vector<std::unique_ptr<Team>> teams;
  std::vector<std::vector<Positions>> plain;
  std::vector<Positions> ours(settings.threads.size());
  for (const int count : settings.threads) {
    teams.push_back(std::make_unique<Team>(count));
    plain.emplace_back(count);
  }
  std::vector<std::function<void()>> works;
  for (std::size_t i = 0; i < settings.threads.size(); ++i) {
    works.push_back([&, i] {
      set_threads(settings.threads[i]);
      for (int pass = 0; pass < passes; ++pass) ours[i] = model.elastic_forces(positions);
    });
    works.push_back([&, i] {
      for (int pass = 0; pass < passes; ++pass) plain_forces(*teams[i], springs, positions, plain[i]);
    });
  }
  const std::vector<Sample> samples = interleaved(works, settings.repeats);
  for (std::size_t i = 0; i < settings.threads.size(); ++i)
    if (!((ours[i] - plain[i][0]).cwiseAbs().maxCoeff() <= 1e-10 * plain[0][0].cwiseAbs().maxCoeff()))
      throw std::runtime_error("the plain loop and elastin differ");

  std::vector<Figures> found;
  for (std::size_t i = 0; i < works.size(); ++i) {
    Figures figures;
    figures.springs = body.connections.size();
    figures.minimum = samples[i].minimum / passes;
    figures.median = samples[i].median / passes;
    figures.rate = figures.springs / figures.minimum;
    // A plain loop that several threads only slow down is measured by what it does on fewer.
    double peer = samples[i | 1].minimum;
    for (std::size_t j = 1; j < works.size(); j += 2)
      if (settings.threads[j / 2] <= settings.threads[i / 2]) peer = std::min(peer, samples[j].minimum);
    figures.ratio = peer / samples[i].minimum;
    found.push_back(figures);
  }
  return found;
}

/// a = b + s c over 240 MB: bytes read and written a second, those that a cache fetches to write into not counted.
std::vector<Figures> triad(const Settings& settings) {
  constexpr int count = 10'000'000;
  std::vector<double> a(count), b(count, 1.), c(count, 2.);
  std::vector<std::unique_ptr<Team>> teams;
  std::vector<std::function<void()>> works;
  for (const int size : settings.threads) {
    teams.push_back(std::make_unique<Team>(size));
    works.push_back([&, team = teams.back().get()] {
      team->run([&](int member) {
        for (int i = team->begin(member, count), end = team->begin(member + 1, count); i < end; ++i)
          a[i] = b[i] + 3 * c[i];
      });
    });
  }
  std::vector<Figures> found;
  for (const Sample& sample : interleaved(works, settings.repeats)) {
    found.emplace_back();
    found.back().minimum = sample.minimum;
    found.back().median = sample.median;
    found.back().bandwidth = 3. * sizeof(double) * count / sample.minimum;
  }
  return found;
}

/// Bytes a pass moves at least: each connection's ends, L and k once, each molecule's place in and force out.
double least_bytes(double molecules, double springs) { return springs * (2 * 4 + 8 + 8) + molecules * (24 + 24); }

}  // namespace

std::vector<Row> run_forces(const Settings& settings) {
  say("forces, memory bandwidth");
  std::vector<Row> rows;
  const std::vector<Figures> memory = in_child([&] { return triad(settings); });
  for (std::size_t i = 0; i < memory.size(); ++i)
    rows.push_back({"forces", "triad, 240 MB", 0, settings.threads[i], settings.repeats, memory[i], ""});
  for (const int side : settings.sides) {
    say("forces, side " + std::to_string(side));
    std::vector<Figures> found = in_child([&] { return race(side, settings); });
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double bytes = least_bytes(std::pow(side, 3), found[i].springs);
      // Arrays that fit a cache are not bounded by memory.
      const bool cached = bytes < 8e6;
      if (!cached) found[i].allowed = memory[i / 2].bandwidth / bytes * found[i].springs;
      rows.push_back({"forces", i % 2 ? "plain loop" : "elastin", side, settings.threads[i / 2], settings.repeats,
                      found[i], cached ? "in cache" : ""});
    }
  }
  return rows;
}

}  // namespace bench
