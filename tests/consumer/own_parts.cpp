// A scene with a stepper and a load of this program's own, and one with an experiment that has a measure of its own:
//   own_parts ratchet.yaml hanging.yaml
#include "own_parts.h"

#include <cmath>
#include <cstdio>

#include "elastin/lab/study/laboratory.h"

namespace {

using namespace elastin;

/// N substeps of h take the centre of a free body of mass m by h²/m (N F_0 / 2 + Σ (N − n) F_n), n = 1 … N − 1, by
/// Verlet's rule. The state at time 0 is accepted first, so F_0 = g; F_n = n g, found before state n is accepted.
bool moves_as_it_must(const char* scene, const Catalog& catalog) {
  lab::Laboratory laboratory(scene, {}, catalog);
  const lab::LaboratoryResult result = laboratory.run();
  if (!result.good || result.positions.cols() == 0) return false;
  const Body& body = laboratory.body();
  const double growth = 1e-6, h = 10e-6, N = 100, mass = body.mass.sum();
  const double expected = h * h / mass * growth * (N / 2 + N * (N * N - 1) / 6);
  const double moved = (result.positions - body.rest).row(2).dot(body.mass) / mass;
  std::printf("moved by %.9g m; expected %.9g m\n", moved, expected);
  return result.solver == "in_parts" && std::abs(moved / expected - 1) < 1e-9;
}

/// Two molecules of the mass m, joined by a spring: the lower one sinks by m g / k, under half of g by half of that.
bool hangs_as_it_must(const char* scene, const Catalog& catalog) {
  lab::ExperimentCatalog experiments = lab::built_in_experiments();
  experiments.add(own::hanging_row());
  lab::Laboratory laboratory(scene, {}, catalog, experiments);
  const lab::LaboratoryResult result = laboratory.run();
  const double expected = laboratory.body().mass[0] * 9.81 / 300;
  std::printf("sinks by %.9g m; expected %.9g m\n", result.get("sag"), expected);
  if (!result.good || result.main != std::vector<std::string>{"sag"} || result.measures.front().unit != "m")
    return false;
  return std::abs(result.get("sag") / expected - 1) < 1e-9 && result.curve.size() == 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    Catalog catalog = built_in_catalog();
    catalog.steppers.add(own::in_parts_row());
    catalog.loads.add(own::ratchet_row());
    return moves_as_it_must(argv[1], catalog) && hangs_as_it_must(argv[2], catalog) ? 0 : 1;
  } catch (const InputError& error) {
    std::fprintf(stderr, "own_parts: %s\n", error.what());
    return 2;
  }
}
