#include <algorithm>
#include <tuple>

#include "c/handles.h"
#include "elastin/core/laws/local.h"
#include "elastin/core/simulation/saved_state.h"
#include "elastin/core/solve/block_rows.h"
#include "elastin/core/solve/sensitivity.h"
#include "elastin/core/solve/vibrations.h"

namespace elastin::c {
namespace {

/// What a step said, as the caller's structure; a status.
template <class Result>
elastin_status reported(const Result& result, int substeps, bool unstable, elastin_step_result* out) {
  if (out) {
    const elastin_step_result values{
        0, static_cast<int>(result.outcome), substeps, result.newton_iterations, result.linear_iterations, unstable};
    put(values, out, "elastin_step_result");
  }
  return result.outcome == Outcome::converged ? ELASTIN_OK : failed(ELASTIN_STOPPED, result.cause.c_str());
}

BlockRows matrix_of(elastin_simulation* simulation) {
  Simulation& own = given(simulation, "simulation").simulation;
  return stiffness_blocks(own.model(), own.state());
}

Matrix3 free_directions(int axes) {
  if (axes < 0 || axes > 7)
    throw InputError("free_axes is " + std::to_string(axes) + "; it must be 0, or 1 (x), 2 (y) and 4 (z) or-ed");
  return Vector3(axes & 1, (axes >> 1) & 1, (axes >> 2) & 1).asDiagonal();
}

void require_molecule(const Simulation& simulation, int molecule) {
  if (molecule < 0 || molecule >= simulation.body().size())
    throw InputError("molecule " + std::to_string(molecule) + ": there are " +
                     std::to_string(simulation.body().size()) + ", from 0");
}

void write(const Vector3& vector, double numbers[3], const char* name) {
  given(numbers, name);
  for (int axis = 0; axis < 3; ++axis) numbers[axis] = vector[axis];
}

/// Of a law that is a sum of elements; else 0.
int elements_of(const Elasticity& law) { return law.local() ? law.local()->elements() : 0; }

Positions columns_or_zero(const double* numbers, const Simulation& simulation) {
  const int molecules = simulation.body().size();
  return numbers ? Positions(Eigen::Map<const Positions>(numbers, 3, molecules)) : Positions::Zero(3, molecules);
}

void copy_out(const Positions& values, double* numbers) {
  if (numbers) std::copy(values.data(), values.data() + values.size(), numbers);
}

void check_solve(const StaticResult& result) {
  if (result.outcome != Outcome::converged) throw InputError("no derivative at this equilibrium: " + result.cause);
}

std::unique_ptr<elastin_simulation> simulate(const elastin_body& body, const char* name,
                                             const elastin_material* material, const elastin_options* options) {
  const Strategy strategy = strategy_of(name);
  const Material made_of = material_of(material);
  std::unique_ptr<CallbackRunner> runner;
  SimulationOptions chosen = options_of(options, runner);
  Simulation simulation(body.body, strategy, made_of, std::move(chosen));
  return std::make_unique<elastin_simulation>(
      elastin_simulation{std::move(runner), std::move(simulation), made_of.youngs_modulus});
}

}  // namespace
}  // namespace elastin::c

using elastin::c::given;
using elastin::c::guarded;

extern "C" {

elastin_status elastin_simulate(const elastin_body* body, const char* strategy, const elastin_material* material,
                                const elastin_options* options, elastin_simulation** simulation) {
  return guarded([&] {
    given(simulation, "simulation");
    *simulation = elastin::c::simulate(given(body, "body"), strategy, material, options).release();
  });
}

void elastin_simulation_free(elastin_simulation* simulation) { delete simulation; }

elastin_status elastin_step(elastin_simulation* simulation, double dt, elastin_step_result* result) {
  return guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    if (result) elastin::c::checked_copy(result, "elastin_step_result");
    const elastin::StepResult reached = handle.simulation.step(dt);
    return elastin::c::reported(reached, reached.substeps, false, result);
  });
}

elastin_status elastin_effort(const elastin_simulation* simulation, int* effort) {
  return guarded([&] { given(effort, "effort") = given(simulation, "simulation").simulation.effort(); });
}

elastin_status elastin_set_effort(elastin_simulation* simulation, int effort) {
  return guarded([&] { given(simulation, "simulation").simulation.set_effort(effort); });
}

elastin_status elastin_iteration_error(elastin_simulation* simulation, double dt, double* off, double* motion) {
  return guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    given(off, "off"), given(motion, "motion");
    std::tie(*off, *motion) = handle.simulation.iteration_error(dt);
  });
}

elastin_status elastin_settle(elastin_simulation* simulation, elastin_step_result* result) {
  return guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    if (result) elastin::c::checked_copy(result, "elastin_step_result");
    const elastin::StaticResult reached = handle.simulation.settle();
    return elastin::c::reported(reached, 1, reached.unstable, result);
  });
}

elastin_status elastin_stiffness_count(const elastin_simulation* simulation, size_t* count) {
  return guarded([&] {
    const auto& laws = given(simulation, "simulation").simulation.model().elasticity();
    given(count, "count") = 0;
    for (const auto& law : laws) *count += static_cast<size_t>(elastin::c::elements_of(*law));
  });
}

elastin_status elastin_vjp(elastin_simulation* simulation, const double* of_positions, const double* of_reactions,
                           double* by_forces, double* by_displacement, double* by_stiffness) {
  return guarded([&] {
    elastin::Simulation& own = given(simulation, "simulation").simulation;
    elastin::Sensitivity sensitivity = own.sensitivity();
    const elastin::Adjoint found = sensitivity.adjoint(elastin::c::columns_or_zero(of_positions, own),
                                                       elastin::c::columns_or_zero(of_reactions, own));
    elastin::c::check_solve(found.result);
    elastin::c::copy_out(found.forces, by_forces), elastin::c::copy_out(found.displacement, by_displacement);
    for (const auto& law : own.model().elasticity())
      if (by_stiffness && elastin::c::elements_of(*law) > 0) {
        const elastin::VectorX slopes = sensitivity.by_stiffness(*law, found);
        by_stiffness = std::copy(slopes.begin(), slopes.end(), by_stiffness);
      }
  });
}

elastin_status elastin_matrix_blocks(elastin_simulation* simulation, size_t* blocks) {
  return guarded([&] { given(blocks, "blocks") = elastin::c::matrix_of(simulation).columns.size(); });
}

elastin_status elastin_matrix(elastin_simulation* simulation, double* values, int* columns, int* starts) {
  return guarded([&] {
    given(values, "values"), given(columns, "columns"), given(starts, "starts");
    const elastin::BlockRows rows = elastin::c::matrix_of(simulation);
    std::copy(rows.values.begin(), rows.values.end(), values);
    std::copy(rows.columns.begin(), rows.columns.end(), columns);
    std::copy(rows.starts.begin(), rows.starts.end(), starts);
  });
}

elastin_status elastin_vibrations(elastin_simulation* simulation, size_t count, double* frequencies, double* shapes,
                                  size_t* found) {
  return guarded([&] {
    elastin::Simulation& own = given(simulation, "simulation").simulation;
    given(frequencies, "frequencies"), given(found, "found");
    if (count < 1 || count > 1000000) throw elastin::InputError("count: allowed: 1 to 1000000");
    const elastin::Vibrations all = elastin::find_vibrations(own.model(), own.state(), static_cast<int>(count));
    if (all.outcome != elastin::Outcome::converged)
      throw elastin::InputError("no vibrations of this state: " + all.cause);
    std::copy(all.frequencies.begin(), all.frequencies.end(), frequencies);
    for (std::size_t i = 0; shapes && i < all.shapes.size(); ++i)
      std::copy_n(all.shapes[i].data(), all.shapes[i].size(), shapes + i * all.shapes[i].size());
    *found = static_cast<size_t>(all.frequencies.size());
  });
}

elastin_status elastin_jvp(elastin_simulation* simulation, const double* forces, const double* displacement,
                           const double* stiffness, double* positions, double* reactions) {
  return guarded([&] {
    elastin::Simulation& own = given(simulation, "simulation").simulation;
    elastin::Sensitivity sensitivity = own.sensitivity();
    elastin::Positions by = elastin::c::columns_or_zero(forces, own);
    for (const auto& law : own.model().elasticity())
      if (const int count = elastin::c::elements_of(*law); stiffness && count > 0) {
        by += sensitivity.forces_by_stiffness(*law, Eigen::Map<const elastin::VectorX>(stiffness, count));
        stiffness += count;
      }
    const elastin::StaticResponse found = sensitivity.forward(by, elastin::c::columns_or_zero(displacement, own));
    elastin::c::check_solve(found.result);
    elastin::c::copy_out(found.motion, positions);
    elastin::Positions of_molecules = elastin::Positions::Zero(3, by.cols());
    for (std::size_t i = 0; i < own.model().supports.size(); ++i)
      of_molecules.col(own.model().supports[i].molecule) = found.result.reactions.col(static_cast<Eigen::Index>(i));
    elastin::c::copy_out(of_molecules, reactions);
  });
}

elastin_status elastin_time(const elastin_simulation* simulation, double* time) {
  return guarded([&] { given(time, "time") = given(simulation, "simulation").simulation.time(); });
}

elastin_status elastin_positions(const elastin_simulation* simulation, const double** values, size_t* count) {
  return guarded([&] { elastin::c::show(given(simulation, "simulation").simulation.positions(), values, count); });
}

elastin_status elastin_set_positions(elastin_simulation* simulation, const double* positions, size_t count) {
  return guarded([&] {
    given(positions, "positions");
    if (count % 3) throw elastin::InputError("count is " + std::to_string(count) + "; it must be 3 a molecule");
    given(simulation, "simulation")
        .simulation.set_positions(
            Eigen::Map<const elastin::Positions>(positions, 3, static_cast<Eigen::Index>(count / 3)));
  });
}

elastin_status elastin_velocities(const elastin_simulation* simulation, const double** values, size_t* count) {
  return guarded([&] { elastin::c::show(given(simulation, "simulation").simulation.velocities(), values, count); });
}

elastin_status elastin_forces(const elastin_simulation* simulation, const double** values, size_t* count) {
  return guarded([&] { elastin::c::show(given(simulation, "simulation").simulation.forces(), values, count); });
}

elastin_status elastin_tensions(const elastin_simulation* simulation, const double** values, size_t* count) {
  return guarded([&] { elastin::c::show(given(simulation, "simulation").simulation.tensions(), values, count); });
}

elastin_status elastin_host_forces(elastin_simulation* simulation, double** values, size_t* count) {
  return guarded([&] { elastin::c::show(given(simulation, "simulation").simulation.host_forces(), values, count); });
}

elastin_status elastin_fix(elastin_simulation* simulation, int molecule, int free_axes) {
  return guarded(
      [&] { given(simulation, "simulation").simulation.fix(molecule, elastin::c::free_directions(free_axes)); });
}

elastin_status elastin_release(elastin_simulation* simulation, int molecule) {
  return guarded([&] { given(simulation, "simulation").simulation.release(molecule); });
}

elastin_status elastin_move_to(elastin_simulation* simulation, int molecule, const double position[3]) {
  return guarded([&] {
    given(simulation, "simulation").simulation.move_to(molecule, elastin::c::position_of(position, "position"));
  });
}

elastin_status elastin_reaction(const elastin_simulation* simulation, int molecule, double force[3]) {
  return guarded([&] {
    const elastin::Simulation& tissue = given(simulation, "simulation").simulation;
    elastin::c::require_molecule(tissue, molecule);
    elastin::c::write(tissue.reaction(molecule), force, "force");
  });
}

elastin_status elastin_couple(elastin_simulation* simulation, int molecule, const double position[3], double stiffness,
                              double damping, int* coupling) {
  return guarded([&] {
    elastin::Simulation& tissue = given(simulation, "simulation").simulation;
    given(coupling, "coupling");
    *coupling = tissue.couple(molecule, elastin::c::position_of(position, "position"), stiffness, damping);
  });
}

elastin_status elastin_move_coupling(elastin_simulation* simulation, int coupling, const double position[3],
                                     const double velocity[3]) {
  return guarded([&] {
    elastin::Simulation& tissue = given(simulation, "simulation").simulation;
    const elastin::Vector3 at = elastin::c::position_of(position, "position"), still = elastin::Vector3::Zero();
    tissue.move_coupling(coupling, at, velocity ? elastin::c::position_of(velocity, "velocity") : still);
  });
}

elastin_status elastin_coupling_force(const elastin_simulation* simulation, int coupling, double force[3]) {
  return guarded(
      [&] { elastin::c::write(given(simulation, "simulation").simulation.coupling_force(coupling), force, "force"); });
}

elastin_status elastin_decouple(elastin_simulation* simulation, int coupling) {
  return guarded([&] { given(simulation, "simulation").simulation.decouple(coupling); });
}

elastin_status elastin_warnings(elastin_simulation* simulation, const char** text) {
  return guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    given(text, "text");
    handle.warnings.clear();
    for (const std::string& warning : handle.simulation.warnings())
      handle.warnings += (handle.warnings.empty() ? "" : "\n") + warning;
    *text = handle.warnings.c_str();
  });
}

elastin_status elastin_observe(elastin_simulation* simulation, int every, elastin_observer see, void* context) {
  return guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    given(see, "see");
    handle.simulation.observe(every, [see, context, &handle](const elastin::Simulation&) { see(context, &handle); });
  });
}

elastin_status elastin_save(const elastin_simulation* simulation, void* buffer, size_t capacity, size_t* needed) {
  return guarded([&] {
    const auto bytes = elastin::bytes_of(given(simulation, "simulation").simulation.save());
    given(needed, "needed") = bytes.size();
    if (capacity == 0) return;
    given(static_cast<char*>(buffer), "buffer");
    if (capacity < bytes.size())
      throw elastin::InputError("capacity is " + std::to_string(capacity) + "; the state takes " +
                                std::to_string(bytes.size()) + " bytes");
    std::memcpy(buffer, bytes.data(), bytes.size());
  });
}

elastin_status elastin_restore(elastin_simulation* simulation, const void* buffer, size_t bytes) {
  return guarded([&] {
    elastin_simulation& handle = given(simulation, "simulation");
    given(static_cast<const char*>(buffer), "buffer");
    handle.simulation.restore(elastin::simulation_state_of(buffer, bytes));
  });
}
}
