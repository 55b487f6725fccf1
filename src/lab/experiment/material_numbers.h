#pragma once
#include <string>
#include <vector>

#include "elastin/core/laws/homogeneous.h"
#include "elastin/core/laws/material_law.h"

namespace elastin::lab {

/// A number of a material that can be unknown: one of its law's, of a law's term ("mu_1"), of its relaxation ("g_1",
/// "tau_1"), or E or ν where these are given and not derived.
struct MaterialNumber {
  enum class Kind { law_number, law_term, youngs_modulus, poissons_ratio, share, relaxation_time };

  std::string name;
  Dimension unit;
  double low, high;  ///< admissible range, SI
  bool above_low;    ///< whether `low` itself is not admissible
  double value;      ///< SI, of the material that it was read off
  Kind kind;
  std::size_t term = 0, column = 0;

  bool operator==(const MaterialNumber&) const = default;
};

/// All numbers that the material has, in the order of its law's row. `row` is null where it has no law.
std::vector<MaterialNumber> material_numbers(const MaterialLaw* row, const Material& material);

/// The material with other numbers. Throws InputError where the law does not admit them or is unstable at rest with
/// them.
Material with_numbers(const MaterialLaw* row, const Material& material, const std::vector<MaterialNumber>& numbers,
                      const VectorX& values);

/// How the material changes with each number, about these values: central differences over `steps`, one-sided ones of
/// second order where a side is not admissible.
std::vector<MaterialChange> material_changes(const MaterialLaw* row, const Material& material,
                                             const std::vector<MaterialNumber>& numbers, const VectorX& values,
                                             const VectorX& steps);

/// Axes of a test, a column each: 1 along the law's first direction, 2 in the plane of its first two, as far as it has
/// any.
Matrix3 axes_of_law(const MaterialLaw& row, const Material& material);

}  // namespace elastin::lab
