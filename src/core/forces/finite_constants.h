#pragma once
#include <cmath>
#include <string>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/base/types.h"

namespace elastin {

/// Throws InputError where one of the connections' `values` is not finite; `what` and `unit` are said in the message.
inline void check_finite_constants(const VectorX& values, const std::string& what, const std::string& unit) {
  for (Eigen::Index c = 0; c < values.size(); ++c)
    if (!std::isfinite(values[c]))
      throw InputError("connection " + std::to_string(c) + " has a " + what + " of " + number(values[c]) + " " + unit +
                       ": it must be finite");
}

}  // namespace elastin
