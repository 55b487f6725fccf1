#include "elastin/core/simulation/energy_law.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/laws/moduli.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/cells.h"
#include "elastin/core/laws/any_law.h"

namespace elastin {
namespace {

const std::vector<std::string> kOfMaterial{"E", "nu", "mu", "lam", "kappa"};

double of_material(const std::string& name, const Material& material) {
  if (name == "E") return material.youngs_modulus;
  if (name == "nu") return material.poissons_ratio;
  if (name == "mu") return material.youngs_modulus / (2 * (1 + material.poissons_ratio));
  const auto [lambda, mu] = lame<3>(material);
  return name == "lam" ? lambda : lambda + 2 * mu / 3;
}

/// An isotropic solid in plane stress: C₃₃ is such that S₃₃ = 0. Stress and tangent are condensed, times the thickness.
class PlaneStress {
 public:
  PlaneStress(EnergyExpression::Point law, double thickness) : law_(std::move(law)), thickness_(thickness) {}

  Tensor<2> stress(const Tensor<2>& A) const { return thickness_ * law_.stress(whole(A)).topLeftCorner<2, 2>(); }

  TangentModuli<2> tangent(const Tensor<2>& A) const {
    static constexpr int plane[] = {0, 1, 3}, across = 2;  // 11 22 12 and 33 among 11 22 33 12 13 23
    const TangentModuli<3> T = law_.tangent(whole(A));
    TangentModuli<2> result;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        result(row, column) =
            T(plane[row], plane[column]) - T(plane[row], across) * T(across, plane[column]) / T(across, across);
    return thickness_ * result;
  }

  double energy(const Tensor<2>& A) const { return thickness_ * law_.energy(whole(A)); }

 private:
  /// Newton's method from where the volume stays; a step changes C₃₃ by a factor of 4 at most.
  Matrix3 whole(const Tensor<2>& A) const {
    const double area = 1 + A.trace() + A.determinant();  // det C in the plane
    double across = std::clamp(1 / area, 1e-6, 1e6);
    if (!(area > 0)) across = 1;
    Matrix3 result = Matrix3::Zero();
    result.topLeftCorner<2, 2>() = A;
    for (int iteration = 0; iteration < 50; ++iteration) {
      result(2, 2) = across - 1;
      const double S = law_.stress(result)(2, 2), slope = law_.tangent(result)(2, 2);
      const double next =
          slope > 0 ? std::clamp(across - S / slope, across / 4, across * 4) : (S > 0 ? across / 2 : across * 2);
      const bool there = std::abs(next - across) <= 1e-15 * across;
      across = next;
      if (there) break;
    }
    result(2, 2) = across - 1;
    return result;
  }

  EnergyExpression::Point law_;
  double thickness_;
};

bool comes_from_material(const std::string& name) {
  return std::find(kOfMaterial.begin(), kOfMaterial.end(), name) != kOfMaterial.end();
}

/// A law as a program states it.
struct Written {
  std::string name;
  EnergyExpression energy;
  std::vector<ParameterInfo> parameters;

  /// At work in a material, with its constants of this law, if it has any. What is `given` counts before these. All of
  /// W grows with E over `modulus`, or over that of the constants.
  EnergyExpression::Point at(const Material& here, const ParameterValues& given, double modulus) const {
    const LawConstants* constants = here.law && here.law->law == name ? &*here.law : nullptr;
    if (constants) modulus = constants->youngs_modulus;
    ParameterValues own = given;
    if (constants) own.insert(constants->numbers.begin(), constants->numbers.end());
    own = complete_values(name, parameters, own);
    Material even = here;
    if (modulus > 0) even.youngs_modulus = modulus;
    std::vector<double> values;
    for (const std::string& parameter : energy.parameters())
      values.push_back(comes_from_material(parameter) ? of_material(parameter, even) : own.at(parameter));
    if (energy.has_fibre() && !constants)
      throw InputError("law '" + name + "': the material has no direction of fibres");
    try {
      return energy.at(values, modulus > 0 ? here.youngs_modulus / modulus : 1,
                       energy.has_fibre() ? constants->directions.at("direction") : Vector3::UnitX());
    } catch (const InputError& error) {
      throw InputError("law '" + name + "': " + error.what());
    }
  }
};

}  // namespace

Strategy make_energy_law(const std::string& name, EnergyExpression energy, std::vector<ParameterInfo> parameters,
                         int dimensions) {
  if (dimensions != 2 && dimensions != 3)
    throw InputError("law '" + name + "': has " + std::to_string(dimensions) + " dimensions; allowed: 2, 3");
  const std::vector<std::string> names = energy.parameters();
  std::vector<std::string> known = kOfMaterial;
  for (const ParameterInfo& parameter : parameters) {
    if (comes_from_material(parameter.name))
      throw InputError("law '" + name + "': '" + parameter.name + "' comes from the material");
    known.push_back(parameter.name);
  }
  for (const std::string& wanted : names)
    if (std::find(known.begin(), known.end(), wanted) == known.end())
      throw InputError("law '" + name + "': there is no parameter '" + wanted + "'" + suggestion(wanted, known));
  if (dimensions == 2 && energy.has_fibre())
    throw InputError("law '" + name + "': I4 and I5 are those of solids; a membrane's fibres have no direction here");
  const bool from_moduli = std::any_of(names.begin(), names.end(), comes_from_material);
  Strategy law;
  law.name = name;
  law.parameters = parameters;
  law.kind = StrategyKind::cell_law;
  law.dimensions = dimensions;
  law.unsuited = dimensions == 3 ? &no_cells<3> : &no_cells<2>;
  const Written written{name, std::move(energy), std::move(parameters)};
  law.make = [written, dimensions](const Body& body, const Material& material, const ParameterValues& given) {
    const auto make = [written, given, modulus = material.youngs_modulus](const Material& here) {
      return written.at(here, given, modulus);
    };
    if (dimensions == 2)
      return make_cells<2>(body, material, AnyMembrane{[make](const Material& here) {
                             return AnyPoint<2>(PlaneStress(make(here), here.thickness));
                           }});
    return make_cells<3>(body, material, AnySolid{[make](const Material& here) { return AnyPoint<3>(make(here)); }});
  };
  if (dimensions == 2) return law;
  law.law = name;
  if (written.energy.has_fibre())
    law.unsuited_material = [name](const Material& material) {
      return material.law && material.law->law == name
                 ? std::string()
                 : "needs the direction of its fibres: `law: " + name + "` and `direction` in the material";
    };
  MaterialLaw row;
  row.name = name;
  row.parameters = written.parameters;
  if (written.energy.has_fibre())
    row.parameters.push_back({"direction", dimension::none, 0, 0, std::numeric_limits<double>::quiet_NaN(),
                              "direction of the fibres at rest, of I4 and I5", false, ValueKind::direction, true});
  row.from_moduli = from_moduli, row.whole = true;
  row.shape = [written](const Material& material) {
    return AnyPoint<3>(written.at(material, {}, material.youngs_modulus));
  };
  row.solid = [shape = row.shape](const Material& material) {
    return SplitPoint<AnyPoint<3>>{shape(material), Volumetric{}};
  };
  law.own_law = std::make_shared<const MaterialLaw>(std::move(row));
  return law;
}

}  // namespace elastin
