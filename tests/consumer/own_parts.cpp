// A scene with a stepper and a load of this program's own:
//   own_parts ratchet.yaml
#include "own_parts.h"

#include <cmath>
#include <cstdio>

#include "elastin/lab/study/laboratory.h"

namespace {

using namespace elastin;

/// The force on a free body of mass m is n g in step n, so that its centre moves by g dt²/m Σ n²/2.
bool moves_as_it_must(const char* scene, const Catalog& catalog) {
  lab::Laboratory laboratory(scene, {}, catalog);
  const lab::LaboratoryResult result = laboratory.run();
  if (!result.good || result.positions.cols() == 0) return false;
  const Body& body = laboratory.body();
  const double growth = 1e-6, dt = 20e-6, steps = 50, mass = body.mass.sum();
  const double expected = growth * dt * dt / mass * (steps - 1) * steps * (2 * steps - 1) / 12;
  const double moved = (result.positions - body.rest).row(2).dot(body.mass) / mass;
  std::printf("moved by %.9g m; expected %.9g m\n", moved, expected);
  return result.solver == "in_parts" && std::abs(moved / expected - 1) < 1e-9;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    Catalog catalog = built_in_catalog();
    catalog.steppers.add(own::in_parts_row());
    catalog.loads.add(own::ratchet_row());
    return moves_as_it_must(argv[1], catalog) ? 0 : 1;
  } catch (const InputError& error) {
    std::fprintf(stderr, "own_parts: %s\n", error.what());
    return 2;
  }
}
