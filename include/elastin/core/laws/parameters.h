#pragma once
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "elastin/core/base/units.h"

namespace elastin {

/// A law's own parameter, described once, beside the law: scenes, range errors, `elastin list` and docs come from it.
/// The default is the member's initial value.
template <class Law>
struct Parameter {
  std::string_view name;
  double Law::*value;
  Dimension unit;
  double low, high;  ///< admissible range, ends included, SI
  std::string_view text;
};

/// The same, without the law's type.
struct ParameterInfo {
  std::string name;
  Dimension unit;
  double low = 0, high = 0, fallback = 0;
  std::string text;
};

/// Values by parameter name, SI units; what is not named keeps its default.
using ParameterValues = std::map<std::string, double>;

}  // namespace elastin
