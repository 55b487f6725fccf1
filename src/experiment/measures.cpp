#include "experiment/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "elastin/base/error.h"

namespace elastin {

const std::vector<MeasureInfo>& measure_list() {
  using namespace dimension;
  static const std::vector<MeasureInfo> list{
      {"effective_modulus", pressure,
       "Young's modulus: secant F l0 / (A dl) of a bar; of the beam that sinks so; Hill's mean of a material", "E"},
      {"elongation", length, "dl, read as the scene says; negative in compression"},
      {"poissons_ratio", none, "- lateral strain at mid height / strain; Hill's mean of a material", "Poisson's ratio"},
      {"shear_modulus", pressure, "secant modulus G = shear stress / strain, torque / twist; Hill's mean of a material",
       "G"},
      {"bulk_modulus", pressure, "secant modulus K = - pressure / volume strain; Hill's mean of a material", "K"},
      {"force", force, "F on the loaded end, along the axis (negative in compression) or the shear"},
      {"axial_force", force, "force of shear or torsion along the axis; positive = the plate pulls the body up"},
      {"stress", pressure, "F / A; true stress of a bubble as a spherical cap that keeps its volume"},
      {"strain", none, "dl / l0; shear: sideways way / height; bubble: stretch - 1"},
      {"lateral_strain", none, "mean in-plane strain of the molecules at mid height"},
      {"torque", dimension::energy, "about the axis, on the turned end", {}, "N m"},
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
      {"tip_deflection", length, "way of the tip's centre along the load"},
      {"tip_shortening", length, "way of the tip's centre back along the axis"},
      {"youngs_modulus_x", pressure, "1 / compliance along x, of the stiffness matrix", "E along x"},
      {"youngs_modulus_y", pressure, "along y", "E along y"},
      {"youngs_modulus_z", pressure, "along z", "E along z"},
      {"anisotropy_index", none, "universal: 5 G_V/G_R + K_V/K_R - 6; 0 = isotropic", "anisotropy"},
      {"patch_residual", none, "largest force on an inner molecule under affine strain / on a surface one; 0 = exact"},
      {"stiffness_asymmetry", none, "| C - C transposed | / | C | of the stiffness matrix"},
      {"radius", length, "mean distance from the middle, by area at rest"},
      {"corner_radius", length, "mean distance from the middle of the molecules on the axes"},
      {"radius_spread", none, "(largest - smallest distance from the middle) / mean"},
      {"stretch", none, "mean radius / that at rest; of a bubble, arc over chord of its cap"},
      {"enclosed_volume", volume, "inside, of the whole where planes of symmetry cut the body"},
      {"wall_stress", pressure, "p R / (2 t), t the thickness at rest"},
      {"tangent_modulus", pressure, "d stress / d strain at the last load step, from a linear solve there"},
      {"average_modulus", pressure, "mean of the secant moduli over the load steps"},
      {"curve_error", none, "largest |stress - the material's at that strain| over the largest such stress",
       "curve error"},
      {"energy", dimension::energy, "elastic energy stored"},
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

}  // namespace elastin
