#include "elastin/core/model/material.h"

#include <cmath>

namespace elastin {

void rotate(Material& material, const Matrix3& rotation) {
  if (material.fibre) material.fibre->direction = rotation * material.fibre->direction;
  if (material.law)
    for (auto& [name, direction] : material.law->directions) direction = rotation * direction;
}

UniaxialResponse uniaxial_response(const Material& material, const Vector3& direction) {
  const double E = material.youngs_modulus, nu = material.poissons_ratio;
  if (!material.fibre) return {E, nu};
  const double fibres = material.fibre->curve.modulus(0), cosine = direction.dot(material.fibre->direction);
  // Under unit stress: the strain of the matrix along the fibres, and the stress that they take over.
  const double along = ((1 + nu) * cosine * cosine - nu) / E, taken = fibres * along / (1 + fibres / E);
  const double strain = 1 / E - taken * along, volume = (1 - 2 * nu) / E * (1 - taken);
  return {1 / strain, (1 - volume / strain) / 2};
}

std::optional<double> uniaxial_stress(const Material& material, const Vector3& direction, double strain) {
  if (!material.curve && !material.fibre) return std::nullopt;
  const double matrix = material.curve ? material.curve->stress(strain) : material.youngs_modulus * strain;
  if (!material.fibre) return matrix;
  if (std::abs(direction.dot(material.fibre->direction)) < 1 - 1e-9) return std::nullopt;
  return matrix + material.fibre->curve.stress(strain);
}

}  // namespace elastin
