#include "contact/triangles_cross.h"

#include <fcl/narrowphase/detail/traversal/collision/intersect.h>

namespace elastin::contact {

bool triangles_cross(const std::array<Vector3, 3>& one, const std::array<Vector3, 3>& other) {
  return fcl::detail::Intersect<double>::intersect_Triangle(one[0], one[1], one[2], other[0], other[1], other[2]);
}

}  // namespace elastin::contact
