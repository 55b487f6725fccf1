#include "lab/run/common_measures.h"

#include <algorithm>
#include <optional>
#include <set>
#include <string>

#include "core/model/solid_cells.h"
#include "elastin/core/model/share.h"

namespace elastin::lab {
namespace {

using Role = MeasureRole;

const MeasureList& measures_of_every_run() {
  static const MeasureList list{
      {"energy", dimension::energy, "elastic energy stored, with that of the preload", Role::detail},
      {"volume_ratio", dimension::none,
       "volume of the cells over that of the body as described; where it has a `rest`"}};
  return list;
}

/// Of an equilibrium.
const MeasureList& measures_at_rest() {
  using namespace dimension;
  static const MeasureList list{
      {"energy_increase", dimension::energy, "energy without that of the preload; under preload only"},
      {"total_force", force, "force with that of the preload; under preload only"},
      {"total_torque", dimension::energy, "torque with that of the preload; under preload only", Role::none, "", "N m"},
      {"total_elongation", length, "elongation from rest; under preload only, as the scene's loads or its own start"},
      {"preload_strain", none, "largest strain of a connection before the load, by size; under preload only",
       Role::share},
      {"material_stress", pressure, "stress of the material's own law or curve at that strain, in uniaxial stress",
       Role::material_stress},
      {"curve_error", none, "largest |stress - the material's at that strain| over the largest such stress", Role::none,
       "curve error"},
      {"average_modulus", pressure, "mean of the secant moduli over the load steps"},
      {"unloaded_displacement", length, "largest displacement from the unloaded shape that was found to the given one"},
      {"unloading_error", length,
       "how far from the given shape the loads bring a molecule of the unloaded one at most"},
      {"unloading_steps", none, "linear solves in which the unloaded shape was found"},
      {"prestrain_error", length, "how far the shape that is kept in place still moves at most"},
      {"prestrain_remaining", none,
       "part of the given prestrain that remains, in the mean over the connections: what nothing bears is lost"},
      {"prestrain_steps", none, "equilibria in which the rest that keeps the shape in place was found"},
      {"solution_norm", length, "root of the sum of squares of all free displacements"},
      {"reaction_balance", none, "| loads + reactions | / | F |: 0 for a body in balance", Role::detail}};
  return list;
}

const MeasureList& measures_in_time() {
  using namespace dimension;
  static const MeasureList list{
      {{"speed", velocity, "speed of the mass centre; rigid bodies do not count"},
       {"centre_displacement", length, "displacement of the mass centre since the start; rigid bodies do not count",
        Role::history, "displacement of the centre", "", "centre_way"},
       {"largest_strain", none, "largest strain of a connection, by size", Role::share},
       {"kinetic_energy", dimension::energy, "kinetic energy of all molecules"},
       {"potential_energy", dimension::energy, "energy of the loads that stay as they are, 0 at rest", Role::history},
       {"dissipated_energy", dimension::energy, "energy dissipated by damping and drag since the start", Role::history},
       {"work", dimension::energy,
        "work of moved supports, of a rest that changes in time and of loads that do or have no energy, since the "
        "start",
        Role::history},
       {"energy_balance", dimension::energy,
        "kinetic + elastic + potential + dissipated - work, less its start: an error"},
       {"energy_drift", none,
        "largest |energy balance| / largest of kinetic + elastic energy, work, dissipated energy"},
       {"momentum", {1, 1, -1}, "size of the momentum of all molecules", Role::history},
       {"angular_momentum", {2, 1, -1}, "size of the angular momentum about the origin", Role::history}},
      {{"time", "centre_displacement"}, {"time", "largest_strain"}}};
  return list;
}

const MeasureList& measures_of_contact() {
  using namespace dimension;
  static const MeasureList list{
      {"contact_force", force,
       "largest force on one obstacle; without obstacles that of two pieces on each other; none of a piece on itself"},
      {"contact_area", area, "area of the samples in contact"},
      {"largest_pressure", pressure, "contact pressure, the largest of a molecule's part of the surface"},
      {"largest_penetration", length, "largest penetration of a contact"},
      {"contacts", none, "number of contact pairs under pressure"},
      {"sticking", none, "number of contacts that do not slide"}};
  return list;
}

const MeasureList& measures_of_identification() {
  using namespace dimension;
  static const MeasureList list{
      {"identified_modulus", pressure, "E of the identified material at no strain"},
      {"identified_modulus_middle", pressure, "its secant modulus half way to the strain up to which it counts"},
      {"identified_modulus_end", pressure, "its secant modulus at that strain"},
      {"identified_misfit", none, "root of the mean of (shown / measured - 1)^2 with the identified material"}};
  return list;
}

}  // namespace

void add_state(const Model& model, const State& state, const StaticResult& solved, double scale, Measures& measures,
               double copies) {
  const Body& body = model.body();
  if (model.has_energy() && !solved.linear)
    measures.set("energy", copies * sum_over(body, model.stored_energy(state.positions)));
  if (body.unstressed && any_over(body, !body.tetrahedra.empty()))
    measures.set("volume_ratio", volume_of_cells(body, state.positions) / volume_of_cells(body, body.rest));
  std::optional<State> at_rest;  // where small displacements have all loads
  if (solved.linear) at_rest = state, at_rest->positions = body.rest;
  const Positions loads = model.load_forces(at_rest ? *at_rest : state);
  const Vector3 left = vector_sum_over(
      body, Vector3(loads.leftCols(owned_molecules(body)).rowwise().sum() + solved.reactions.rowwise().sum()));
  measures.set("reaction_balance", copies * left.norm() / scale);
}

double largest_strain(const Model& model, const Positions& positions) {
  const Connections& connections = model.body().connections;
  double largest = 0;
  for (int c = 0; c < connections.proper(); ++c) {
    const auto& [a, b] = connections.ends[c];
    const double rest = connections.rest_length[c];
    if (rest > 0) largest = std::max(largest, std::abs((positions.col(b) - positions.col(a)).norm() / rest - 1));
  }
  return largest_over(model.body(), largest);
}

MeasureList measures_of(const Experiment& experiment) {
  MeasureList list = experiment.measures();
  list.add(measures_of_every_run()).add(experiment.in_time() ? measures_in_time() : measures_at_rest());
  if (experiment.at_rest() && experiment.at_rest()->identification()) list.add(measures_of_identification());
  return list.add(measures_of_contact());
}

bool is_smooth(const std::string& measure) {
  static const std::set<std::string> rough{
      "reaction_balance",    "contacts",        "sticking",        "energy_balance",  "energy_drift",
      "stiffness_asymmetry", "unloading_error", "unloading_steps", "prestrain_error", "prestrain_steps"};
  return rough.count(measure) == 0;
}

const MeasureList& common_measures() {
  static const MeasureList list = MeasureList(measures_of_every_run())
                                      .add(measures_at_rest())
                                      .add(measures_in_time())
                                      .add(measures_of_contact())
                                      .add(measures_of_identification());
  return list;
}

}  // namespace elastin::lab
