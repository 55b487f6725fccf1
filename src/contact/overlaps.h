#pragma once
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin::contact {

/// Two molecules whose spheres run into each other.
struct Overlap {
  int first, second;
  double depth;  ///< [m], > 0
};

/// Molecules that overlap at the given positions by more than `tolerance` of the smaller radius and are not joined by a
/// connection, ascending by pair. Broad phase by FCL's dynamic tree.
std::vector<Overlap> find_overlaps(const Body& body, const Positions& positions, double tolerance = 1e-6);

}  // namespace elastin::contact
