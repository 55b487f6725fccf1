#pragma once
#include "core/model/visit_state.h"
#include "elastin/core/forces/model.h"

/// The one description of what a support is made of, for saved states; see base/archive.
namespace elastin {

inline auto members(Support& support) {
  return std::tie(support.molecule, support.free, support.displacement, support.velocity);
}

}  // namespace elastin
