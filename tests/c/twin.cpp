#include "twin.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "elastin/core/shapes/arrays.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/simulation.h"
#ifdef ELASTIN_C_LAB
#include "elastin/lab/study/laboratory.h"
#include "elastin/mesh/voronoi.h"
#endif

using namespace elastin;
using namespace elastin::lab;

namespace {

Body lattice() {
  Body body = cubic_lattice({3, 3, 4}, 1, {true, true, false});
  stretch(body, {1e-3, 1e-3, 1e-3});
  set_matter(body, 5e-4, 1000, 0, 2e-3 * 2e-3 * 3e-3);
  return body;
}

Material material() {
  Material soft;
  soft.youngs_modulus = 5000;
  soft.poissons_ratio = 0.25;
  return soft;
}

void copy(const Positions& from, double* to) { std::copy_n(from.data(), from.size(), to); }

template <class Work>
std::string said(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

void twin_step(twin_run* run) {
  Simulation tissue(lattice(), built_in_catalog().find("lattice"), material());
  tissue.model().add(make_gravity(tissue.body(), {0, 0, -9.81}));
  tissue.model().add(make_mass_damping(tissue.body(), 20));
  for (int molecule = 0; molecule < 9; ++molecule) tissue.fix(molecule);
  const CouplingId coupling = tissue.couple(35, tissue.positions().col(35), 50, 0.01);
  for (int step = 0; step < kTwinSteps; ++step) {
    tissue.move_coupling(coupling, Vector3(2e-3, 2e-3, 3e-3 + 1e-5 * step), Vector3(0, 0, 1e-2));
    tissue.move_to(0, Vector3(-1e-6 * step, 0, 0));
    tissue.host_forces()(0, 20) = 1e-5;
    tissue.step(1e-3);
  }
  copy(tissue.positions(), run->positions);
  copy(tissue.velocities(), run->velocities);
  copy(tissue.forces(), run->forces);
  run->tension_count = static_cast<std::size_t>(tissue.tensions().size());
  std::copy_n(tissue.tensions().data(), run->tension_count, run->tensions);
  Eigen::Map<Vector3>(run->reaction) = tissue.reaction(4);
  Eigen::Map<Vector3>(run->coupling_force) = tissue.coupling_force(coupling);
}

void twin_prepared(const char* strategy, int sheet, double* forces) {
  Body body = lattice();
  Material soft = material();
  soft.poissons_ratio = 0.4;
  soft.thickness = 1e-3;
  if (sheet) {
    BodyArrays arrays;
    arrays.positions.resize(3, 4);
    arrays.positions << 0, 1e-2, 0, 1e-2, 0, 0, 1e-2, 1e-2, 0, 0, 0, 0;
    arrays.triangles = {{0, 1, 2}, {1, 3, 2}};
    arrays.thickness = 1e-3;
    body = make_body(arrays);
    soft.bending_rigidity = 1e-4;
  }
  SimulationOptions options;
#ifdef ELASTIN_C_LAB
  options.make_voronoi = mesh::voronoi_cells;
#endif
  Simulation tissue(std::move(body), built_in_catalog().find(strategy), soft, std::move(options));
  tissue.host_forces()(2, tissue.body().size() - 1) = 1e-4;
  for (int step = 0; step < 2; ++step) tissue.step(1e-4);
  copy(tissue.forces(), forces);
}

void twin_message(int number, char* message, size_t capacity) {
  std::string text;
  if (number == 0) text = said([] { built_in_catalog().find("latice"); });
  if (number == 1) text = said([] { Simulation(lattice(), built_in_catalog().find("neo_hookean"), material()); });
#ifdef ELASTIN_C_LAB
  if (number == 2) text = said([] { Laboratory(ELASTIN_SOURCE_DIR "/scenes/tension/table1-e.yaml"); });
  if (number == 3) text = said([] { Laboratory(ELASTIN_SOURCE_DIR "/scenes/tension/table1-b.yaml", {"bdy=1"}); });
#endif
  std::snprintf(message, capacity, "%s", text.c_str());
}

double twin_modulus() {
#ifdef ELASTIN_C_LAB
  return Laboratory(ELASTIN_SOURCE_DIR "/scenes/tension/table1-b.yaml").run("angles").get("effective_modulus");
#else
  return 0;
#endif
}
