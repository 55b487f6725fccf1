#include "tension_cube.h"

#include "elastin/simulation/catalog.h"
#include "experiment/tension.h"
#include "measure.h"
#include "solve/linear_solver.h"
#include "solve/sparse_stiffness.h"

namespace bench {

using namespace elastin;

TensionCube::TensionCube(int side) : body(make_cube(side)), model(body) {
  TensionSetup setup;
  setup.force = kMaterial.youngs_modulus * kCubeLength * kCubeLength * 1e-5;
  experiment = make_tension(body, setup);
  model.add(make_springs(body, built_in_catalog().find("lattice").constants(body, kMaterial, {})));
  experiment->hold(model);
  experiment->set_load(model, 1);
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
