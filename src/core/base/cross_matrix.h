#pragma once
#include "elastin/core/base/types.h"

namespace elastin {

/// [v]×, the matrix whose product with w is v × w.
inline Matrix3 cross_matrix(const Vector3& v) {
  Matrix3 result;
  result << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return result;
}

}  // namespace elastin
