#include "plain_loop.h"

#include <cmath>
#include <memory>

#include "measure.h"

namespace bench {

using namespace elastin;

namespace {

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

}  // namespace

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

}  // namespace bench
