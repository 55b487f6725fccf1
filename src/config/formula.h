#pragma once
#include <yaml-cpp/yaml.h>

#include <functional>
#include <map>
#include <string>

#include "elastin/core/base/error.h"
#include "elastin/core/base/types.h"
#include "elastin/core/base/units.h"

namespace elastin::config {

/// A number in SI units, and what it measures.
struct FormulaValue {
  double number = 0;
  Dimension unit;
  bool angle = false;  ///< written with deg or rad
};
using FormulaValues = std::map<std::string, FormulaValue>;

/// Puts numbers in the place of formulas, values that are not quoted and begin with "=": "= side / 9" becomes
/// "0.0033 m". A formula has numbers with units, the names of the section `values` of the root, + - * / ^, brackets,
/// pi, and sqrt abs min max round floor ceil sin cos tan exp log. Formulas of a place stay as they are. Returns the
/// section `values`. Throws InputError with a location.
FormulaValues put_in_formulas(const YAML::Node& root,
                              const std::function<SourceLocation(const YAML::Node&)>& location_of);

/// A formula of x, y, z, each of what `of_place` says, and of named values. It need not be finite.
FormulaValue formula_at(const std::string& text, const Vector3& place, const Dimension& of_place,
                        const FormulaValues& values);

}  // namespace elastin::config
