#pragma once
#include "core/model/incidence.h"
#include "elastin/core/model/body.h"

namespace elastin {

/// Tetrahedra in groups that share one pressure. Every tetrahedron counts in each of its groups with the same weight.
struct VolumeGroups {
  Cells<4> tetrahedra;
  Rows members;    ///< tetrahedra of each group, ascending
  Rows groups_of;  ///< groups of each tetrahedron, ascending
  double weight;
  int size() const { return static_cast<int>(members.start.size()) - 1; }
};

/// One group a cube: both ways of cutting it into five tetrahedra, weight ½. Their sides are its edges and face
/// diagonals.
VolumeGroups groups_of_cubes(const Cells<8>& cubes);

/// One group a molecule: the tetrahedra around it, weight ¼. Molecules without tetrahedra have empty groups.
VolumeGroups groups_of_molecules(int molecules, const Cells<4>& tetrahedra);

}  // namespace elastin
