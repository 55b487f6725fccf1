// A haptic loop: a thousand times a second the place of a device's tip becomes a grip's, and the grip's force goes
// back. Nothing in the loop waits for another thread, allocates memory or throws.
//   haptic [seconds]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/simulation.h"
#include "latest.h"

using namespace elastin;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// A device that nobody holds: its tip goes round and presses, as fast as a device's driver asks it.
void device(const Vector3& start, Latest<Vector3>& tip, Latest<Vector3>& force, const std::atomic<bool>& done) {
  for (double t = 0; !done; t += 5e-4) {
    tip.next() = start + 2e-3 * Vector3(std::sin(9 * t), 1 - std::cos(9 * t), std::cos(14 * t) - 1);
    tip.publish();
    if (!force.newest().allFinite()) std::abort();  // a real one would switch its motors off
    std::this_thread::sleep_for(500us);
  }
}

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10;
  Body body = cubic_lattice({10, 10, 6}, 4e-3, {.axis = true, .face = true});
  set_matter(body, 2e-3, 1000, 0, 0.036 * 0.036 * 0.020);
  Simulation tissue(std::move(body), built_in_catalog().find("lattice"), Material{.youngs_modulus = 10e3});
  tissue.add_load(*built_in_loads().find("rayleigh"), {.numbers = {{"mass", 10}}});
  for (int molecule = 0; molecule < 100; ++molecule) tissue.fix(molecule);  // the lowest layer

  const int touched = 555;
  const Vector3 start = tissue.body().rest.col(touched);
  const CouplingId tool = tissue.couple(touched, start, 200, 0.1);
  tissue.step(1e-3);  // the first one finds the longest stable step, and room for all that follow

  Latest<Vector3> tip(start), force(Vector3::Zero());
  std::atomic<bool> done = false;
  std::thread hand([&] { device(start, tip, force, done); });

  std::vector<double> took(static_cast<std::size_t>(seconds * 1000));  // ms
  int misses = 0;
  Clock::time_point deadline = Clock::now();
  for (double& milliseconds : took) {
    std::this_thread::sleep_until(deadline);
    deadline += 1ms;
    const Clock::time_point begin = Clock::now();
    tissue.move_coupling(tool, tip.newest());
    if (tissue.step(1e-3).outcome != Outcome::converged) return 1;
    force.next() = -tissue.coupling_force(tool);
    force.publish();
    milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    if (Clock::now() > deadline) {
      ++misses;
      deadline = Clock::now();  // what is late is late: no hurry to catch up
    }
  }
  done = true;
  hand.join();

  std::sort(took.begin(), took.end());
  std::printf("%d molecules, %d connections, %zu steps of 1 ms\n", tissue.body().size(),
              tissue.body().connections.size(), took.size());
  std::printf("median %.3f ms, 99.9 %% %.3f ms, most %.3f ms; %d deadlines missed\n", took[took.size() / 2],
              took[took.size() * 999 / 1000], took.back(), misses);
  return 0;
}
