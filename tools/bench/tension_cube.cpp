#include "tension_cube.h"

#include <algorithm>
#include <numeric>
#include <random>

#include "core/linear/sparse_stiffness.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/model/renumbered.h"
#include "elastin/core/simulation/catalog.h"
#include "lab/experiment/tension/tension.h"
#include "measure.h"

namespace bench {

using namespace elastin;
using namespace elastin::lab;

/// The cube with its springs; of a cube that was numbered at random nothing says that it is a lattice.
TensionCube::Cube TensionCube::numbered(int side, Numbering numbering) {
  Body cube = make_cube(side);
  VectorX constants = built_in_catalog().find("lattice").constants(cube, kMaterial, {});
  if (numbering == Numbering::lattice) return {std::move(cube), std::move(constants), 0};
  auto shuffled = [generator = std::mt19937(1)](int count) mutable {
    std::vector<int> order(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), generator);
    return order;
  };
  Body body = cube;
  body.grid.reset();
  body.cubes.clear();
  const std::vector<int> molecules = shuffled(cube.size()), connections = shuffled(cube.connections.size());
  for (int a = 0; a < cube.size(); ++a) body.rest.col(molecules[a]) = cube.rest.col(a);
  VectorX own(constants.size());
  for (int c = 0; c < cube.connections.size(); ++c) {
    const auto& [a, b] = cube.connections.ends[connections[c]];
    body.connections.ends[c] = {molecules[a], molecules[b]};
    body.connections.rest_length[c] = cube.connections.rest_length[connections[c]];
    own[c] = constants[connections[c]];
  }
  if (numbering == Numbering::at_random) return {std::move(body), std::move(own), 0};
  RenumberedBody ordered;
  const double seconds = seconds_of([&] { ordered = numbered_in_space(body); });
  return {std::move(ordered.body), own(ordered.connection_from).eval(), seconds};
}

TensionCube::TensionCube(int side, Numbering numbering) : TensionCube(numbered(side, numbering)) {}

TensionCube::TensionCube(Cube cube) : body(std::move(cube.body)), model(body), renumbering(cube.renumbering) {
  TensionSetup setup;
  setup.force = kMaterial.youngs_modulus * kCubeLength * kCubeLength * 1e-5;
  experiment = make_tension(body, setup);
  model.add(make_springs(body, std::move(cube.constants)));
  experiment->static_rig(model)->set_load(1);
  loads = model.load_forces(state_at_rest(body));
}

Eigen::SparseMatrix<double> assembled(TensionCube& cube) {
  const State rest = state_at_rest(cube.body);
  const Tangent tangent(cube.model, rest);
  return sparse_stiffness(tangent, cube.model.supports, 0, stiffness_scale(tangent));
}

VectorX free_loads(const TensionCube& cube) {
  Positions loads = cube.loads;
  keep_free(cube.model.supports, loads);
  return Eigen::Map<const VectorX>(loads.data(), loads.size());
}

}  // namespace bench
