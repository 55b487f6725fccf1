#pragma once
#include "elastin/core/forces/model.h"

namespace elastin {

/// Force of each connection [N], elastic and of its damping, pulling is positive; without an allocation once
/// `workspace` and `tensions` have served this model.
void set_tensions(const Model& model, const State& state, VectorX& tensions, Workspace& workspace);

}  // namespace elastin
