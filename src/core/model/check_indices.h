#pragma once
#include "elastin/core/model/body.h"

namespace elastin {

/// Throws InputError that names the first number in a body's lists of what the body does not have: "the body's
/// connection 3 has molecule 9; there are molecules 0 to 8". Bodies of the shapes and readers of meshes pass; one that
/// a caller has filled may not, and nothing that works on a body looks again. Cost O(n).
void check_indices(const Body& body);

}  // namespace elastin
