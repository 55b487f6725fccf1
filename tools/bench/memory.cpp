#include <memory>

#include "measure.h"
#include "plain_loop.h"

namespace bench {

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
