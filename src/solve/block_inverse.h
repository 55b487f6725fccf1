#pragma once
#include "elastin/base/types.h"

namespace elastin {

/// Inverse of a symmetric block on the directions where it has stiffness, zero on the others. Blocks of negative
/// stiffness are taken by size, which keeps a preconditioner positive.
Matrix3 positive_inverse(const Matrix3& block);

}  // namespace elastin
