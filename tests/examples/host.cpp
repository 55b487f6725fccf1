// A host's program: a slab of liver on a table that shakes, pulled at by an instrument.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/simulation.h"

using namespace elastin;

int main() {
  // Molecules 5 mm apart, joined along axes and face diagonals; their radius, and 1050 kg/m³ in all.
  Body body = cubic_lattice({13, 9, 5}, 5e-3, {.axis = true, .face = true});
  set_matter(body, 2.5e-3, 1050, 0, 0.060 * 0.040 * 0.020);

  // A strategy by name turns the modulus of the whole piece into the stiffness of each connection.
  Simulation liver(std::move(body), built_in_catalog().find("lattice"), Material{.youngs_modulus = 6e3});
  liver.add_load(*built_in_loads().find("gravity"), {.vectors = {{"acceleration", {0, 0, -9.81}}}});
  liver.add_load(*built_in_loads().find("rayleigh"), {.numbers = {{"mass", 30}}});

  // It lies on a table, where it sticks: its lowest layer is held and moved.
  const Positions& rest = liver.body().rest;
  std::vector<int> table;
  for (int molecule = 0; molecule < liver.body().size(); ++molecule)
    if (rest(2, molecule) == 0) table.push_back(molecule);
  for (const int molecule : table) liver.fix(molecule);
  if (liver.settle().outcome != Outcome::converged) return 1;

  const int top = liver.body().size() - 1;
  for (int frame = 0; frame < 60; ++frame) {
    const double shake = frame < 30 ? 1e-3 * std::sin(2 * std::numbers::pi * frame / 15) : 0;  // m
    for (const int molecule : table) liver.move_to(molecule, rest.col(molecule) + Vector3(shake, 0, 0));
    liver.host_forces().col(top) = Vector3(0, 0, frame < 30 ? 0 : 0.02);  // N

    const StepResult result = liver.step(1. / 60);  // in as many parts as it takes to be stable
    if (result.outcome != Outcome::converged) {
      std::printf("frame %d: %s\n", frame, result.cause.c_str());
      return 1;
    }
  }

  // Views, not copies: they stay where they are as the body moves.
  double carried = 0;
  for (const int molecule : table) carried += liver.reaction(molecule).z();
  std::printf("%d molecules, %d connections, t = %g s\n", liver.body().size(), liver.body().connections.size(),
              liver.time());
  std::printf("pulled up by %.2f mm; the tightest connection bears %.2f mN\n",
              1e3 * (liver.positions()(2, top) - rest(2, top)), 1e3 * liver.tensions().maxCoeff());
  std::printf("the table carries %.3f N of %.3f N\n", carried, 9.81 * liver.body().mass.sum() - 0.02);
  return std::abs(carried / (9.81 * liver.body().mass.sum() - 0.02) - 1) < 0.01 ? 0 : 1;
}
