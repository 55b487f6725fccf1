#pragma once
#include <string_view>
#include <tuple>

#include "elastin/core/base/table.h"

namespace elastin {

/// A law's own parameter, described once, next to the law: scenes, range errors, `elastin list` and docs come from it.
/// The default is the member's initial value.
template <class Law>
struct Parameter {
  std::string_view name;
  double Law::*value;
  Dimension unit;
  double low, high;  ///< admissible range, ends included, SI
  std::string_view text;
};

}  // namespace elastin
