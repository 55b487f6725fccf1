// A renderer that only reads positions: the tissue moves in a thread of its own and leaves a picture every 16 ms of its
// time; who draws takes the newest one, and neither waits for the other.
//   renderer [frames]
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/simulation.h"
#include "latest.h"

using namespace elastin;

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::atoi(argv[1]) : 60;
  Body body = cubic_lattice({25, 5, 5}, 4e-3, {.axis = true, .face = true});  // a strip that bends down
  set_matter(body, 2e-3, 1000, 0, 0.096 * 0.016 * 0.016);
  Simulation tissue(std::move(body), built_in_catalog().find("lattice"), Material{.youngs_modulus = 50e3},
                    {.stepper = {.method = "backward_euler", .parameters = {{"newton_iterations", 1}}}});
  tissue.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", {0, 0, -9.81}}}});
  for (int molecule = 0; molecule < tissue.body().size(); molecule += 25) tissue.fix(molecule);

  struct Picture {
    Positions positions;  // m
    double time = 0;      // s
  };
  Latest<Picture> newest({tissue.positions(), 0});
  tissue.observe(4, [&](const Simulation& seen) {
    newest.next().positions = seen.positions();
    newest.next().time = seen.time();
    newest.publish();
  });

  std::atomic<bool> done = false, failed = false;
  std::thread moving([&] {
    while (!done && !failed) {
      failed = tissue.step(4e-3).outcome != Outcome::converged;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  });
  double lowest = 0, last = -1;
  int drawn = 0;
  while (drawn < frames && !failed) {
    const Picture& picture = newest.newest();
    if (picture.time > last) {  // here a program of its own would hand picture.places.data() to the graphics card
      lowest = picture.positions.row(2).minCoeff();
      last = picture.time;
      ++drawn;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  done = true;
  moving.join();
  std::printf("%d frames of %d molecules up to t = %.3f s; the strip's end hangs %.1f mm down\n", drawn,
              tissue.body().size(), last, -1e3 * lowest);
  return failed || !(lowest < -1e-4) ? 1 : 0;
}
