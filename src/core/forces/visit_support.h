#pragma once
#include "core/model/visit_state.h"
#include "elastin/core/forces/model.h"

/// The one description of what a support is made of, for saved states; see base/archive.
namespace elastin {

template <class Archive>
void visit(Archive& archive, Support& support) {
  archive.whole(support.molecule);
  visit(archive, support.free);
  visit(archive, support.displacement);
  visit(archive, support.velocity);
}

}  // namespace elastin
