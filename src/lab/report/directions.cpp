#include "lab/report/directions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/model/faces.h"
#include "lab/report/comparison.h"
#include "lab/report/table.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Directions on the half sphere: 2° apart.                                          [Fibonacci lattice, González 2010]
constexpr int kDirections = 4000;

/// As engineering strains, Voigt's order, of the dyad (a bᵀ + b aᵀ)/2, and as stresses.
Vector6 stress_of(const Vector3& a, const Vector3& b) {
  Vector6 stress;
  stress << a[0] * b[0], a[1] * b[1], a[2] * b[2], (a[1] * b[2] + a[2] * b[1]) / 2, (a[0] * b[2] + a[2] * b[0]) / 2,
      (a[0] * b[1] + a[1] * b[0]) / 2;
  return stress;
}

void widen(double value, double& least, double& largest) {
  least = std::min(least, value);
  largest = std::max(largest, value);
}

/// Range of E over all directions, and of G.
struct ModulusRanges {
  double least_youngs = INFINITY, largest_youngs = 0, least_shear = INFINITY, largest_shear = 0;
  void add(const Stiffness6& compliance, const Vector3& n) {
    const Vector6 along = stress_of(n, n);
    widen(1 / along.dot(compliance * along), least_youngs, largest_youngs);
    const auto plane = across(n);
    const Vector6 a = stress_of(n, plane.col(0)), b = stress_of(n, plane.col(1));
    const double aa = 4 * a.dot(compliance * a), bb = 4 * b.dot(compliance * b), ab = 4 * a.dot(compliance * b);
    const double middle = (aa + bb) / 2, radius = std::hypot((aa - bb) / 2, ab);
    widen(1 / (middle + radius), least_shear, largest_shear);
    widen(1 / (middle - radius), least_shear, largest_shear);
  }
};

std::string range_text(double least, double largest) {
  constexpr double same = 5e-4;
  return largest - least < same ? percent(std::abs(least) > std::abs(largest) ? least : largest)
                                : percent(least) + " to " + percent(largest);
}

std::string advice_of(const DirectionErrors& errors) {
  const auto far = [](double error) { return !(std::abs(error) <= kNear); };
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (far(errors.youngs[axis])) text += (text.empty() ? " along " : ", ") + std::string(1, "xyz"[axis]);
  if (far(errors.least_shear) || far(errors.largest_shear)) text += text.empty() ? " in shear" : ", or in shear";
  if (text.empty() && (far(errors.least_youngs) || far(errors.largest_youngs))) text = " askew to its axes";
  return text.empty() ? "" : ": do not use it" + text;
}

}  // namespace

double DirectionErrors::worst() const {
  double largest = 0;
  for (const double error : {youngs[0], youngs[1], youngs[2], least_youngs, largest_youngs, least_shear, largest_shear})
    largest = std::max(largest, std::isfinite(error) ? std::abs(error) : INFINITY);
  return largest;
}

DirectionErrors direction_errors(const Stiffness6& stiffness, const Material& material) {
  DirectionErrors errors;
  const auto compliance = compliance_of(stiffness);
  if (!compliance) {
    errors.trouble = "its stiffness is singular or not positive";
    return errors;
  }
  ModulusRanges ranges;
  for (int axis = 0; axis < 3; ++axis) ranges.add(*compliance, Vector3::Unit(axis));
  for (int i = 0; i < kDirections; ++i) {
    const double z = (i + 0.5) / kDirections, radius = std::sqrt(1 - z * z);
    const double angle = i * 3.14159265358979323846 * (3 - std::sqrt(5.));
    ranges.add(*compliance, {radius * std::cos(angle), radius * std::sin(angle), z});
  }
  const double E = material.youngs_modulus, G = shear_modulus(material);
  for (int axis = 0; axis < 3; ++axis) errors.youngs[axis] = 1 / (*compliance)(axis, axis) / E - 1;
  errors.least_youngs = ranges.least_youngs / E - 1;
  errors.largest_youngs = ranges.largest_youngs / E - 1;
  errors.least_shear = ranges.least_shear / G - 1;
  errors.largest_shear = ranges.largest_shear / G - 1;
  return errors;
}

std::string direction_text(const DirectionErrors& errors) {
  if (!errors.measured()) return "not measured (" + errors.trouble + "): what is said holds for this experiment alone";
  constexpr double near = 1e-3;
  if (errors.worst() <= near) return "E and G within 0.1 % in all of them";
  const auto [least, largest] = std::minmax_element(errors.youngs.begin(), errors.youngs.end());
  std::string axes = range_text(*least, *largest);
  if (axes.find(" to ") != std::string::npos)
    axes = percent(errors.youngs[0]) + ", " + percent(errors.youngs[1]) + ", " + percent(errors.youngs[2]);
  std::string text = "E " + axes + " along x, y, z";
  if (errors.largest_youngs - *largest > near || *least - errors.least_youngs > near)
    text += " (" + range_text(errors.least_youngs, errors.largest_youngs) + " over all)";
  return text + ", G " + range_text(errors.least_shear, errors.largest_shear) + advice_of(errors);
}

}  // namespace elastin::lab
