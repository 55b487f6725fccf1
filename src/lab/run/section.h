#pragma once
#include "elastin/core/model/body.h"

namespace elastin::lab {

/// The cross-section that a body offers to a load along an axis.
struct Section {
  double area = 0;  ///< mean over the length [m²]; 0 where the molecules span none
  double variation =
      0;  ///< largest difference of a slab's section from the mean, over the mean; 0 if there are too few
  bool of_hull = false;  ///< the body has no cells that fill it: the area is that of its molecules' convex hull
  /// Whether the section is the same all along the axis, as far as it can be measured.
  bool prism() const { return variation <= (of_hull ? 0.1 : 0.05); }
};

/// The section between the heights `from` and `to` [m] along the unit axis, from < to. Volume over length of what fills
/// the body: its tetrahedra, else its cubes, else its triangles times `thickness` [m]. Where some molecule belongs to
/// no such cell it is the hull of the molecules seen along the axis. The variation is that of ten slabs, or, for the
/// hull, of slabs at least two mean connections thick.
Section find_section(const Body& body, const Vector3& axis, double from, double to, double thickness);

}  // namespace elastin::lab
