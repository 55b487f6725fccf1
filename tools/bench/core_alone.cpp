// The tension cube in a program on elastin::core alone: core_alone SIDE prints seconds to build it, seconds to solve it
// to 1e-8, iterations, and the most memory [B] that the process ever held. The same source is also compiled with
// everything linked (ELASTIN_BENCH_EVERYTHING), to show that what a program does not use costs it nothing.

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#ifdef ELASTIN_BENCH_EVERYTHING
#include "elastin/command/command.h"
#endif

using namespace elastin;

namespace {

constexpr double kLength = 0.86;  // [m]
const Material kMaterial{.youngs_modulus = 1e5};

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Not by getrusage: that counts what the program held from which this one was started.
double peak_memory() {
  double kilobytes = 0;
  char line[256];
  std::FILE* status = std::fopen("/proc/self/status", "r");
  while (status && std::fgets(line, sizeof line, status))
    if (std::strncmp(line, "VmHWM:", 6) == 0) kilobytes = std::atof(line + 6);
  if (status) std::fclose(status);
  return 1024 * kilobytes;
}

Body make_cube(int side) {
  Body cube = cubic_lattice({side, side, side}, kLength / (side - 1), {.axis = true, .face = true});
  set_matter(cube, kLength / (side - 1) / 2, kMaterial.density, 0, std::pow(kLength, 3));
  return cube;
}

/// Held along z at the bottom, pulled at the top by what stretches it by 1e-5, each molecule by the area it stands for.
void pull(Model& model, int side) {
  const Body& body = model.body();
  const double spacing = kLength / (side - 1);
  std::vector<int> top;
  std::vector<double> area;
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    const Vector3 position = body.rest.col(molecule) / spacing;
    if (position.z() < 0.5) model.supports.push_back({molecule, Vector3(1, 1, 0).asDiagonal()});
    if (position.z() < side - 1.5) continue;
    const auto inside = [&](double at) { return at < 0.5 || at > side - 1.5 ? 0.5 : 1; };
    top.push_back(molecule);
    area.push_back(spacing * spacing * inside(position.x()) * inside(position.y()));
  }
  Positions forces = Positions::Zero(3, static_cast<int>(top.size()));
  for (std::size_t i = 0; i < top.size(); ++i)
    forces(2, static_cast<int>(i)) = 1e-5 * kMaterial.youngs_modulus * area[i];
  model.add(std::make_unique<PointLoads>(body, top, forces));
}

}  // namespace

int main(int argc, char** argv) {
#ifdef ELASTIN_BENCH_EVERYTHING
  if (argc != 2) return elastin::command::run_command(argc, argv, built_in_catalog());
#endif
  const int side = argc == 2 ? std::atoi(argv[1]) : 0;
  if (side < 3)
    return std::fprintf(stderr, "usage: core_alone SIDE (molecules along the cube's side, at least 3)\n"), 2;
  const double start = now();
  const Body body = make_cube(side);
  Model model(body);
  model.add(built_in_catalog().find("lattice").make(body, kMaterial, {}));
  pull(model, side);
  const double built = now();
  State state = state_at_rest(body);
  const StaticResult result = solve_static(model, state, {.linear = true, .tolerance = 1e-8});
  const double solved = now();
  const double stretch = (state.positions.row(2).maxCoeff() / kLength - 1) / 1e-5;
  if (result.outcome != Outcome::converged || std::abs(stretch - 1) > 1e-6)
    return std::fprintf(stderr, "core_alone: not solved: %s\n", result.cause.c_str()), 1;
  std::printf("%.9g %.9g %d %.0f\n", built - start, solved - built, result.linear_iterations, peak_memory());
}
