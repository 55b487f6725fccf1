#include "elastin/lab/run/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "elastin/core/base/error.h"

namespace elastin::lab {

const std::vector<MeasureInfo>& measure_list() {
  using namespace dimension;
  constexpr Dimension rate{0, 0, -1};
  static const std::vector<MeasureInfo> list{
      {"effective_modulus", pressure,
       "Young's modulus: secant F l0 / (A dl) of a bar; of the beam with this deflection; Hill's mean of a material",
       "E"},
      {"elongation", length, "dl, read as the scene says; negative in compression; from the state under preload"},
      {"total_elongation", length, "that from rest; under preload only, as the scene's loads or its own start"},
      {"poissons_ratio", none, "- lateral strain at mid height / strain; Hill's mean of a material", "Poisson's ratio"},
      {"shear_modulus", pressure, "secant modulus G = shear stress / strain, torque / twist; Hill's mean of a material",
       "G"},
      {"bulk_modulus", pressure, "secant modulus K = - pressure / volume strain; Hill's mean of a material", "K"},
      {"force", force, "F on the loaded end, along the axis (negative in compression) or the shear; beyond preload"},
      {"total_force", force, "that and what preload puts there; under preload only"},
      {"axial_force", force, "force of shear or torsion along the axis; positive = the plate pulls the body up"},
      {"stress", pressure, "F / A; true stress of a bubble as a spherical cap that keeps its volume"},
      {"material_stress", pressure, "that the material's own law or curve has at that strain, in uniaxial stress"},
      {"stress_across", pressure, "nominal stress along the second direction of biaxial and planar tension"},
      {"strain", none, "dl / l0; shear: lateral displacement / height; bubble: stretch - 1"},
      {"lateral_strain", none, "mean in-plane strain of the molecules at mid height"},
      {"torque", dimension::energy, "about the axis, on the turned end; beyond preload", {}, "N m"},
      {"total_torque", dimension::energy, "that and what preload puts there; under preload only", {}, "N m"},
      {"angle", none, "by which the loaded end is turned [rad]"},
      {"torsional_stiffness", dimension::energy, "torque / angle [a radian]", {}, "N m"},
      {"pressure", pressure, "- mean of the normal stresses, volume mean; of an inflated body, inside over outside"},
      {"volume_strain", none, "volume / volume at rest - 1"},
      {"height", length, "of a bubble's pole above its rim"},
      {"cap_radius", length, "of the sphere through a bubble's pole and rim: (a^2 + h^2) / 2h"},
      {"pole_radius", length, "of curvature at a bubble's pole, fitted to the molecules around it"},
      {"pole_stretch", none, "at a bubble's pole, fitted to the molecules around it"},
      {"pole_stress", pressure, "nominal, at a bubble's pole, fitted to the triangles around it"},
      {"measured_height", length, "of a bubble, as the scene gives it"},
      {"height_misfit", none, "height / measured height - 1"},
      {"identified_modulus", pressure, "E of the material found, at no strain"},
      {"identified_modulus_middle", pressure, "its secant modulus half way to the strain up to which it counts"},
      {"identified_modulus_end", pressure, "its secant modulus at that strain"},
      {"identified_misfit", none, "root of the mean of (shown / measured - 1)^2 with the material found"},
      {"tip_deflection", length, "displacement of the tip's centre along the load"},
      {"tip_shortening", length, "displacement of the tip's centre back along the axis"},
      {"youngs_modulus_x", pressure, "1 / compliance along x, of the stiffness matrix", "E along x"},
      {"youngs_modulus_y", pressure, "along y", "E along y"},
      {"youngs_modulus_z", pressure, "along z", "E along z"},
      {"anisotropy_index", none, "universal: 5 G_V/G_R + K_V/K_R - 6; 0 = isotropic", "anisotropy"},
      {"patch_residual", none, "largest force on an inner molecule under affine strain / on a surface one; 0 = exact"},
      {"stiffness_asymmetry", none, "| C - C transposed | / | C | of the stiffness matrix"},
      {"radius", length, "mean distance from the middle, by area at rest"},
      {"corner_radius", length, "mean distance from the middle of the molecules on the axes"},
      {"radius_spread", none, "(largest - smallest distance from the middle) / mean"},
      {"stretch", none, "of a sphere: mean radius / that at rest; of a bubble: arc over chord of its cap"},
      {"enclosed_volume", volume, "inside, of the whole where planes of symmetry cut the body"},
      {"wall_stress", pressure, "p R / (2 t), t the thickness at rest"},
      {"tangent_modulus", pressure, "d stress / d strain at the last load step, from a linear solve there"},
      {"average_modulus", pressure, "mean of the secant moduli over the load steps"},
      {"curve_error", none, "largest |stress - the material's at that strain| over the largest such stress",
       "curve error"},
      {"line_force", force, "of all lines of a parachute on its load, against the fall"},
      {"largest_line_force", force, "the opening force: the largest of all frames"},
      {"opening_time", dimension::time, "until a parachute's open area first has its largest value"},
      {"open_area", area, "of a canopy as the load sees it, along the fall"},
      {"open_part", none, "that over the canopy's area at rest"},
      {"fall_speed", velocity, "of a parachute's load"},
      {"drag_balance", none, "drag of the air along the fall / weight - 1: 0 at the terminal speed"},
      {"solution_norm", length, "root of the sum of squares of all free displacements, as FEBio states it"},
      {"energy", dimension::energy, "elastic energy stored, with what preload stores"},
      {"energy_increase", dimension::energy, "that less what preload stores; under preload only"},
      {"frequency", rate, "of the free vibration: a damped cosine fitted to the displacement", {}, "Hz"},
      {"period", dimension::time, "of the free vibration: between crossings of its mean in one direction"},
      {"logarithmic_decrement", none, "of the free vibration: ln of the ratio of two peaks one period apart"},
      {"damping_ratio", none, "of the free vibration: decay rate / undamped circular frequency"},
      {"first_peak", length, "displacement where it first turns back"},
      {"first_peak_time", dimension::time, "when that is"},
      {"return_time", dimension::time, "when it turns for the second time"},
      {"retardation_time", dimension::time, "of creep: an exponential fitted to the displacement"},
      {"relaxation_time", dimension::time, "of relaxation: an exponential fitted to the force, after the ramp"},
      {"relaxed_ratio", none, "force in the end / at the end of the ramp, of the fit"},
      {"storage_modulus", pressure, "of cyclic loading, over its last period: of the stress in phase with the strain"},
      {"loss_modulus", pressure, "of the stress a quarter period ahead of the strain"},
      {"loss_tangent", none, "loss modulus / storage modulus"},
      {"amplitude_ratio", none, "of the far end to the shaken one, over the last periods"},
      {"phase", none, "by which the far end is behind [rad]"},
      {"sine_misfit", none, "of the far end over the last periods: what a sine leaves / all, as root mean squares"},
      {"base_way", length, "displacement of the shaken end", "displacement of the shaken end"},
      {"far_way", length, "displacement of the far end, in the mean", "displacement of the far end"},
      {"impact_speed", velocity, "of the mass centre towards the floor at first contact"},
      {"rebound_speed", velocity, "of the mass centre away from the floor at its end"},
      {"restitution", none, "rebound speed / impact speed"},
      {"contact_duration", dimension::time, "of the first contact"},
      {"compression", none, "shortening of the body across the floor / its length; of a drop, the deepest"},
      {"floor_force", force, "of the floor on the body; of a drop, the largest"},
      {"gap", length, "between the floor and the nearest sphere; negative: pressed in"},
      {"depth", length, "by which an indenter, or what is moved, has gone since the start"},
      {"indentation_modulus", pressure, "Hertz's of a sphere, or that of a flat punch, on a half-space: E* (1 - nu^2)",
       "E of indentation"},
      {"contact_force", force, "the largest on one obstacle; where none is pressed, of two pieces on each other"},
      {"contact_area", area, "of the samples that touch"},
      {"mean_pressure", pressure, "of contact: force / area"},
      {"largest_pressure", pressure, "of contact, on one molecule's part of the surface"},
      {"pressure_spread", none, "of contact: largest |pressure / mean - 1| of the molecules that are pressed"},
      {"largest_penetration", length, "of what touches"},
      {"contacts", none, "pairs that are pressed together"},
      {"sticking", none, "of these, those that do not slide"},
      {"slide_distance", length, "of the mass centre down the slope, since the start"},
      {"slide_speed", velocity, "of the mass centre down the slope"},
      {"slide_acceleration", acceleration, "down the slope, while it slides: a line fitted to the speed"},
      {"creep", length, "largest displacement of a molecule on the slope, of all frames"},
      {"slope", none, "of the plane [rad]"},
      {"slip_angle", none, "slope at which the body begins to slide [rad]"},
      {"slip_friction", none, "tan of that angle"},
      {"speed", velocity, "of the mass centre"},
      {"centre_way", length, "displacement of the mass centre since the start", "displacement of the centre"},
      {"largest_strain", none, "of a connection, by size"},
      {"kinetic_energy", dimension::energy, "of all molecules"},
      {"potential_energy", dimension::energy, "of the loads that stay as they are, 0 at rest"},
      {"dissipated_energy", dimension::energy, "by damping and drag, since the start"},
      {"work", dimension::energy, "of loads that change in time and of moved supports, since the start"},
      {"energy_balance", dimension::energy,
       "kinetic + elastic + potential + dissipated - work, less its start: an error"},
      {"energy_drift", none, "largest |energy balance| / largest of kinetic + elastic energy, work, dissipated energy"},
      {"momentum", {1, 1, -1}, "of all molecules, its size"},
      {"angular_momentum", {2, 1, -1}, "about the origin, its size"},
      {"rigid_motions", none, "of the whole body that supports leave free"},
      {"frequency_1", rate, "natural frequencies about the state under the scene's loads, lowest first", {}, "Hz"},
      {"frequency_2", rate, "", {}, "Hz"},
      {"frequency_3", rate, "", {}, "Hz"},
      {"frequency_4", rate, "", {}, "Hz"},
      {"frequency_5", rate, "", {}, "Hz"},
      {"frequency_6", rate, "", {}, "Hz"},
      {"frequency_7", rate, "", {}, "Hz"},
      {"frequency_8", rate, "", {}, "Hz"},
      {"frequency_9", rate, "", {}, "Hz"},
      {"frequency_10", rate, "", {}, "Hz"},
      {"reaction_balance", none, "| loads + reactions | / | F |: 0 for a body in balance"}};
  return list;
}

const MeasureInfo& find_measure(const std::string& name) {
  std::vector<std::string> names;
  for (const MeasureInfo& info : measure_list()) {
    if (info.name == name) return info;
    names.emplace_back(info.name);
  }
  throw InputError("unknown measure '" + name + "'" + suggestion(name, names));
}

std::string MeasureInfo::label() const {
  std::string words(symbol.empty() ? name : symbol);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string MeasureInfo::unit_text() const { return unit_name.empty() ? si_unit(unit) : std::string(unit_name); }

void Measures::set(std::string_view name, double value) {
  if (!std::isfinite(value)) return;
  for (auto& [known, old] : values_)
    if (known == name) {
      old = value;
      return;
    }
  values_.emplace_back(name, value);
}

double Measures::get(std::string_view name) const {
  for (const auto& [known, value] : values_)
    if (known == name) return value;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace elastin::lab
