#pragma once
#include <string>

#include "elastin/core/forces/model.h"

namespace elastin {

/// Why the tangent at these positions is not the whole derivative of the forces, or "": that of springs whose constants
/// change with the shape leaves their change out, which counts as soon as they are strained, by a millionth.
std::string without_full_tangent(const Model& model, const Positions& positions);

}  // namespace elastin
