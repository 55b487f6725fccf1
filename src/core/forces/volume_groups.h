#pragma once
#include "core/model/incidence.h"
#include "elastin/core/model/body.h"
#include "elastin/core/model/subdomain.h"

namespace elastin {

/// Tetrahedra in groups that share one pressure. Every tetrahedron counts in each of its groups with the same weight.
struct VolumeGroups {
  Cells<4> tetrahedra;
  Rows members;    ///< tetrahedra of each group, ascending
  Rows groups_of;  ///< groups of each tetrahedron, ascending
  double weight;
  bool of_molecules = false;  ///< one group a molecule, by its number; else one a cube
  int size() const { return static_cast<int>(members.start.size()) - 1; }
};

/// One group a cube: both cuts of it into five tetrahedra, weight ½. Their sides are its edges and face
/// diagonals.
VolumeGroups groups_of_cubes(const Cells<8>& cubes);

/// One group a molecule: the tetrahedra around it, weight ¼. Molecules without tetrahedra have empty groups.
VolumeGroups groups_of_molecules(int molecules, const Cells<4>& tetrahedra);

/// Numbers of the groups that a subdomain computes: a molecule's by its owner, a cube's by that of its lowest corner.
std::vector<int> chosen_groups(const VolumeGroups& whole, const Subdomain& own);

/// The chosen groups on a subdomain, which must have all their molecules, with the tetrahedra that they have.
VolumeGroups groups_on(const VolumeGroups& whole, const Subdomain& own, const std::vector<int>& chosen);

}  // namespace elastin
