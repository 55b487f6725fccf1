#include "lab/run/uniform_block.h"

#include <cmath>

#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/shapes/arrays.h"
#include "elastin/core/simulation/simulation.h"

namespace elastin::lab {
namespace {

constexpr double kSide = 0.01;  // m

/// A cube of six tetrahedra with its sides along the frame.
Body solid_block(const Matrix3& frame) {
  BodyArrays arrays;
  arrays.positions.resize(3, 8);
  for (int corner = 0; corner < 8; ++corner)
    arrays.positions.col(corner) = kSide * frame * Vector3(corner & 1, corner >> 1 & 1, corner >> 2);
  for (const auto& [first, second] : {std::pair{1, 2}, {2, 4}, {4, 1}, {2, 1}, {4, 2}, {1, 4}})
    arrays.tetrahedra.push_back({0, first, first + second, 7});
  return make_body(arrays);
}

/// A square of two triangles in the plane of the specimen's first one, a side along the frame's first direction.
Body flat_block(const Body& specimen, const Matrix3& frame, double thickness) {
  const Vector3 along = frame.col(0),
                across = area_vector(specimen.rest, specimen.triangles.front()).cross(along).normalized();
  BodyArrays arrays;
  arrays.thickness = thickness;
  arrays.positions.resize(3, 4);
  arrays.positions << Vector3::Zero(), kSide * along, kSide * (along + across), kSide * across;
  arrays.triangles = {{0, 1, 2}, {0, 2, 3}};
  return make_body(arrays);
}

}  // namespace

std::optional<Measures> measured_on_block(const UniformTest& test, const Body& specimen, const Strategy& law,
                                          const Material& material, const ParameterValues& values) {
  constexpr double longest = 0.1;  // strain of a step
  try {
    SimulationOptions options;
    options.stepper.method = "backward_euler";
    options.parameters = values;
    Simulation block(
        law.dimensions == 3 ? solid_block(test.frame) : flat_block(specimen, test.frame, material.thickness), law,
        material, std::move(options));
    Model& model = block.model();
    const auto experiment = test.make(block.body());
    const auto rig = experiment->static_rig(model);
    State state = state_at_rest(block.body());
    model.declare_history(state);
    const StaticOptions statics;
    rig->set_load(0);
    StaticResult solved = solve_static(model, state, statics);  // of a muscle at work
    if (solved.outcome != Outcome::converged) return std::nullopt;
    const Start start{state.positions, solved.reactions};
    const int steps = 1 + static_cast<int>(std::abs(test.strain) / longest);
    for (int step = 1; step <= steps; ++step) {
      rig->set_load(static_cast<double>(step) / steps);
      solved = solve_static(model, state, statics);
      if (solved.outcome != Outcome::converged) return std::nullopt;
      model.commit_step(state);
    }
    return rig->measure(start, state, statics, solved);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace elastin::lab
