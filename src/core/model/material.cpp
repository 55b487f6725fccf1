#include "elastin/core/model/material.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace elastin {

namespace {

void rotate_directions(Material& material, const Matrix3& rotation) {
  if (material.fibre) material.fibre->direction = rotation * material.fibre->direction;
  if (material.active) material.active->direction = rotation * material.active->direction;
  if (material.law)
    for (auto& [name, direction] : material.law->directions) direction = rotation * direction;
}

}  // namespace

void rotate(Material& material, const Matrix3& rotation) {
  if (material.field) {
    material.field->rotation = rotation * material.field->rotation;
    material.field->shift = rotation * material.field->shift;
  }
  if (!material.around) return rotate_directions(material, rotation);
  material.around->point = rotation * material.around->point;
  material.around->direction = rotation * material.around->direction;
}

Matrix3 frame_at(const RoundAxis& axis, const Vector3& place) {
  Vector3 radius = place - axis.point;
  radius -= axis.direction.dot(radius) * axis.direction;
  if (!(radius.norm() > 0)) radius = axis.direction.unitOrthogonal();
  radius.normalize();
  Matrix3 frame;
  frame << radius, axis.direction.cross(radius), axis.direction;
  return frame;
}

Material local_material(const Material& material, const Vector3& place) {
  Material local = material;
  if (const auto& field = material.field) {
    local.field.reset();
    if (!material.around) rotate_directions(local, field->rotation.transpose());
    field->set(local, field->rotation.transpose() * (place - field->shift));
    if (!material.around) rotate_directions(local, field->rotation);
  }
  if (!material.around) return local;
  local.around.reset();
  rotate_directions(local, frame_at(*material.around, place));
  return local;
}

UniaxialResponse uniaxial_response(const Material& material, const Vector3& direction) {
  const double E = material.youngs_modulus, nu = material.poissons_ratio;
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (material.active || (material.varies() && (material.fibre || material.law))) return {none, none};
  if (!material.fibre) return {E, nu};
  const double fibres = material.fibre->curve.modulus(0), cosine = direction.dot(material.fibre->direction);
  // Under unit stress: the strain of the matrix along the fibres, and the stress that they take over.
  const double along = ((1 + nu) * cosine * cosine - nu) / E, taken = fibres * along / (1 + fibres / E);
  const double strain = 1 / E - taken * along, volume = (1 - 2 * nu) / E * (1 - taken);
  return {1 / strain, (1 - volume / strain) / 2};
}

std::optional<double> uniaxial_stress(const Material& material, const Vector3& direction, double strain) {
  const bool law = material.law && material.law->uniaxial_stress;
  if (!material.curve && !material.fibre && !law) return std::nullopt;
  if (material.active || (material.varies() && (material.fibre || law))) return std::nullopt;
  const std::optional<double> matrix = law              ? material.law->uniaxial_stress(material, direction, strain)
                                       : material.curve ? material.curve->stress(strain)
                                                        : material.youngs_modulus * strain;
  if (!material.fibre || !matrix) return matrix;
  if (std::abs(direction.dot(material.fibre->direction)) < 1 - 1e-9) return std::nullopt;
  return *matrix + material.fibre->curve.stress(strain);
}

}  // namespace elastin
