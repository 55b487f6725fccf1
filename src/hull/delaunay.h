#pragma once
#include <functional>

#include "elastin/core/model/body.h"

namespace elastin::hull {

/// Tetrahedra that fill the convex hull of the molecules [m], face to face, positively oriented: their Delaunay
/// triangulation but for a random weight of up to 1 % of the squared mean spacing on each molecule. The weights decide
/// where many molecules lie on one sphere (lattices), so that no cell is flat there and neighbours agree; those of the
/// corners of nearly flat cells are drawn again a few times [Cheng et al. 2000, sliver exudation]. The same positions
/// give the same cells. A body that is not convex is filled to its hull. In elastin::lab, by Qhull. Throws InputError
/// on fewer than four molecules, or if they lie in one plane. Draws go on, up to eight of them, while there are nearly
/// flat cells that `matter`; empty = all do.
Cells<4> delaunay_tetrahedra(const Positions& positions,
                             const std::function<bool(const std::array<int, 4>&)>& matter = {});

/// Tetrahedra whose volume is below 1e-4 of the cube of their longest side (a regular one has 0.118).
int count_slivers(const Positions& positions, const Cells<4>& tetrahedra);

}  // namespace elastin::hull
