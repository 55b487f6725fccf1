#pragma once
#include <functional>
#include <map>
#include <string>

#include "elastin/core/base/error.h"
#include "elastin/core/base/types.h"
#include "elastin/core/base/units.h"

namespace YAML {
class Node;
}

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

/// How formulas are written, where it is not as in scenes.
struct FormulaLanguage {
  bool units = true;              ///< whether units are values, and may stand behind numbers
  bool powers_from_left = false;  ///< whether 2^3^2 is (2^3)^2
  /// Functions of plain numbers, in addition to those of scenes or in their place.
  std::map<std::string, double (*)(double)> functions = {};
};

/// The value of a formula; it need not be finite. `value_of` gives the value of a name or throws InputError. Throws
/// InputError.
FormulaValue formula_value(const std::string& text, const std::function<FormulaValue(const std::string&)>& value_of,
                           const FormulaLanguage& language = {});

/// A formula of x, y, z, each of what `of_place` says, and of named values. It need not be finite.
FormulaValue formula_at(const std::string& text, const Vector3& place, const Dimension& of_place,
                        const FormulaValues& values);

}  // namespace elastin::config
