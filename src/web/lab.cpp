#include "web/lab.h"

#include <algorithm>
#include <cmath>

#include "core/base/archive.h"
#include "core/solve/stable_step.h"
#include "elastin/core/laws/material_law.h"
#include "elastin/core/simulation/parts.h"
#include "web/lab_handle.h"

using elastin::c::given;
using elastin::c::guarded;

namespace elastin::web {
namespace {

/// The function of a law's constants does not travel.
void restore_law(Material& material) {
  if (!material.law) return;
  const double modulus = material.youngs_modulus, own = material.law->youngs_modulus;
  const auto row = c::catalog().material_laws.find(material.law->law);
  material = with_law(*row, *material.law, material);
  if (!row->from_moduli) material.youngs_modulus = modulus, material.law->youngs_modulus = own;
}

/// The scene's material, or one of its parts, under the sliders: moduli in proportion.
Material under(const elastin_lab_settings& settings, const Material& scene, const Material& own, bool whole) {
  Material material = own;
  material.youngs_modulus *= settings.youngs_modulus / scene.youngs_modulus;
  if (whole && !(material.law && !c::catalog().material_laws.find(material.law->law)->from_moduli))
    material.poissons_ratio = settings.poissons_ratio;
  material.density *= settings.density / scene.density;
  return material;
}

/// Damping and gravity are the sliders' affair.
bool by_sliders(const std::string& load) { return load == "gravity" || load == "cell_damping" || load == "rayleigh"; }

/// `tested`: in the scene's own test, whose weight is the scene's.
void add_loads(Simulation& simulation, const lab::Parcel& parcel, const elastin_lab_settings& settings, bool tested) {
  const auto add = [&](const char* name, const LoadValues& values) {
    simulation.add_load(*c::catalog().loads.find(name), values);
  };
  for (const lab::Parcel::NamedLoad& load : parcel.loads)
    if (!by_sliders(load.name) || (tested && load.name == "gravity")) add(load.name.c_str(), load.values);
  if (settings.bulk_viscosity > 0 || settings.shear_viscosity > 0)
    add("cell_damping", {{{"bulk", settings.bulk_viscosity}, {"shear", settings.shear_viscosity}}});
  if (settings.mass_damping > 0) add("rayleigh", {{{"mass", settings.mass_damping}}});
  if (settings.pressure != 0) add("pressure", {{{"pressure", settings.pressure}}});
}

/// The scene's own of this label, or else the catalog's of this name.
lab::Parcel::Strategy chosen(const lab::Parcel& parcel, const std::string& label) {
  for (const lab::Parcel::Strategy& strategy : parcel.strategies)
    if (strategy.label == label) return strategy;
  return {label, label, {}};
}

SimulationOptions options_of(const elastin_lab_settings& settings) {
  SimulationOptions options;
  options.stepper.method = c::catalog().steppers.find(&given(settings.stepper, "stepper"));
  if (settings.newton_iterations > 0)
    for (const ParameterInfo& info : options.stepper.method->parameters)
      if (info.name == "newton_iterations") options.stepper.parameters[info.name] = settings.newton_iterations;
  return options;
}

void require_molecules(const elastin_lab& lab, const Simulation& simulation) {
  if (simulation.body().size() != lab.parcel.body.size()) throw InputError("the simulation is of another body");
}

double von_mises(const Matrix3& s) {
  const Matrix3 shape = s - s.trace() / 3 * Matrix3::Identity();
  return std::sqrt(1.5 * shape.squaredNorm());
}

}  // namespace
}  // namespace elastin::web

using namespace elastin;

Material elastin_lab::material(const elastin_lab_settings& settings) const {
  return web::under(settings, parcel.material, parcel.material, true);
}

Simulation elastin_lab::simulation(const elastin_lab_settings& settings, bool alone) const {
  const lab::Parcel::Strategy choice = web::chosen(parcel, &given(settings.strategy, "strategy"));
  if (!(settings.youngs_modulus > 0 && settings.density > 0))
    throw InputError("youngs_modulus and density must be above 0");
  Body body = parcel.body;
  body.mass *= settings.density / parcel.material.density;
  std::vector<Material> materials;
  for (const Material& own : parcel.materials) materials.push_back(web::under(settings, parcel.material, own, false));
  SimulationOptions options = web::options_of(settings);
  options.parameters = choice.values;
  const Strategy strategy = in_parts(c::strategy_of(choice.name.c_str()), body, materials, &c::catalog());
  Simulation simulation(std::move(body), strategy, material(settings), std::move(options));
  web::add_loads(simulation, parcel, settings, alone && parcel.own_test);
  if (alone) return simulation;
  SimulationState begin = simulation.save();
  begin.state.positions = parcel.positions;
  simulation.restore(begin);
  for (const Support& support : parcel.supports) simulation.fix(support.molecule, support.free);
  return simulation;
}

extern "C" {

elastin_status elastin_lab_open(const void* bytes, size_t count, elastin_lab** lab) {
  return guarded([&] {
    given(lab, "lab");
    ByteReader reader(&given(static_cast<const char*>(bytes), "bytes"), count, "the body of this page");
    auto made = std::make_unique<elastin_lab>();
    visit(reader, made->parcel);
    if (reader.left() > 0) throw InputError("the body of this page is damaged: more stands in it than a body");
    web::restore_law(made->parcel.material);
    for (Material& material : made->parcel.materials) web::restore_law(material);
    if (lab::Parcel& parcel = made->parcel; !parcel.rest.points.empty())
      parcel.body.unstressed = std::make_shared<const Rest>(rest_of(parcel.body, parcel.rest));
    *lab = made.release();
  });
}

void elastin_lab_free(elastin_lab* lab) { delete lab; }

elastin_status elastin_lab_simulate(const elastin_lab* lab, const elastin_lab_settings* settings,
                                    elastin_simulation** simulation) {
  return guarded([&] {
    given(simulation, "simulation");
    Simulation made = given(lab, "lab").simulation(c::checked_copy(settings, "elastin_lab_settings"), false);
    *simulation = new elastin_simulation{nullptr, std::move(made)};
  });
}

elastin_status elastin_lab_carry(const elastin_simulation* from, elastin_simulation* to) {
  return guarded([&] {
    const Simulation &source = given(from, "from").simulation, &target = given(to, "to").simulation;
    if (source.body().size() != target.body().size()) throw InputError("`to` is a simulation of another body");
    SimulationState state = target.save();
    state.state.positions = source.positions();
    state.state.velocities = source.velocities();
    state.state.time = source.time();
    to->simulation.restore(state);
  });
}

elastin_status elastin_lab_stable_step(elastin_simulation* simulation, double* step) {
  return guarded([&] {
    Simulation& tissue = given(simulation, "simulation").simulation;
    given(step, "step") = find_stable_step(tissue.model(), state_at_rest(tissue.body())).step;
    tissue.model().begin_step(tissue.state(), tissue.time());
  });
}

elastin_status elastin_lab_push(const elastin_lab* lab, elastin_simulation* simulation, const double gravity[3],
                                double own_load, const double centre[3], double radius, double stiffness,
                                double force[3]) {
  return guarded([&] {
    Simulation& tissue = given(simulation, "simulation").simulation;
    const Positions& own = given(lab, "lab").parcel.own_load;
    web::require_molecules(*lab, tissue);
    const Vector3 g = c::position_of(gravity, "gravity"), middle = c::position_of(centre, "centre");
    Positions& forces = tissue.host_forces();
    const Body& body = tissue.body();
    Vector3 back = Vector3::Zero();
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      Vector3 on = body.mass[molecule] * g;
      if (own.cols() > 0 && own_load != 0) on += own_load * own.col(molecule);
      if (stiffness > 0) {
        const Vector3 away = tissue.positions().col(molecule) - middle;
        const double distance = away.norm(), depth = radius + body.radius[molecule] - distance;
        if (depth > 0 && distance > 0) {
          const Vector3 push = stiffness * depth / distance * away;
          on += push;
          back -= push;
        }
      }
      forces.col(molecule) = on;
    }
    for (int axis = 0; axis < 3; ++axis) (&given(force, "force"))[axis] = back[axis];
  });
}

elastin_status elastin_lab_energies(const elastin_simulation* simulation, double energies[2]) {
  return guarded([&] {
    const Simulation& tissue = given(simulation, "simulation").simulation;
    given(energies, "energies");
    energies[0] = 0.5 * (tissue.velocities().colwise().squaredNorm() * tissue.body().mass)(0);
    energies[1] = tissue.model().has_energy() ? tissue.model().elastic_energy(tissue.positions()) : NAN;
  });
}

elastin_status elastin_lab_stress(const elastin_lab* lab, elastin_simulation* simulation, double density,
                                  double* values) {
  return guarded([&] {
    const Simulation& tissue = given(simulation, "simulation").simulation;
    web::require_molecules(given(lab, "lab"), tissue);
    given(values, "values");
    const Body& body = tissue.body();
    const Positions& positions = tissue.positions();
    const VectorX densities = tissue.model().force_densities(positions);
    std::vector<Matrix3> sums(static_cast<std::size_t>(body.size()), Matrix3::Zero());
    for (int connection = 0; connection < body.connections.size(); ++connection) {
      const auto& [a, b] = body.connections.ends[connection];
      const Vector3 d = positions.col(b) - positions.col(a);
      const Matrix3 half = 0.5 * densities[connection] * d * d.transpose();
      sums[a] += half;
      sums[b] += half;
    }
    for (int molecule = 0; molecule < body.size(); ++molecule)
      values[molecule] = web::von_mises(sums[molecule] * (density / body.mass[molecule]));
  });
}
}
