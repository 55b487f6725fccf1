// The little of FCL that is used here, made here: its templates are instantiated in the library as well, but with them
// come 28 000 symbols that a program looks up before it begins, which takes longer than many a scene.
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/detail/traversal/collision/intersect.h>

namespace fcl {

template class AABB<double>;
template OBB<double>::OBB();
template bool OBB<double>::overlap(const OBB<double>&) const;
template class CollisionGeometry<double>;
template class ShapeBase<double>;
template class Sphere<double>;
template class Box<double>;
template class OcTree<double>;
template class CollisionObject<double>;
template class BroadPhaseCollisionManager<double>;
template class DynamicAABBTreeCollisionManager<double>;
template void computeChildBV(const AABB<double>&, unsigned int, AABB<double>&);
template void constructBox(const AABB<double>&, const Transform3<double>&, Box<double>&, Transform3<double>&);
template void normalize(Vector3<double>&, bool*);
template bool obbDisjoint(const Matrix3<double>&, const Vector3<double>&, const Vector3<double>&,
                          const Vector3<double>&);

namespace detail {

template class Intersect<double>;
template class PolySolver<double>;
template class ConvertBVImpl<double, AABB<double>, OBB<double>>;
template struct morton_functor<double, uint32>;
template uint32 quantize(double, uint32);

/// Ten bits of each, in turn: the one function of these that is no template.                           [Morton 1966]
uint32 morton_code(uint32 x, uint32 y, uint32 z) {
  const auto spread = [](uint32 bits) {
    bits = (bits | bits << 16) & 0x030000FF;
    bits = (bits | bits << 8) & 0x0300F00F;
    bits = (bits | bits << 4) & 0x030C30C3;
    return (bits | bits << 2) & 0x09249249;
  };
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}

}  // namespace detail
}  // namespace fcl
