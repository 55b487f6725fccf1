#pragma once
#include <memory>
#include <vector>

#include "core/linear/box_level.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"

namespace elastin {

/// What a body is to a grid of boxes of twice its molecules' spacing, or as long as its longer connections.
struct GridLevel {
  std::unique_ptr<BoxLevel> level;
  BoxMembers members;
};

/// The stiffness of the trilinear functions over any body: each connection and cell deforms with the gradient in its
/// middle, so that it lies in one box. On lattices, whose connections end at the boxes' faces, that is Pᵀ K P. Supports
/// hold the boxes by the stiffness of what they hold. What belongs to one piece of a box is what connections join that
/// have their middle in it.
GridLevel assemble_level(const Tangent& tangent, const std::vector<Support>& supports);

/// The frame of that grid.
BoxGrid::Frame frame_of(const Body& body);

/// Of a tangent on a subdomain its part of the level on the whole's frame, see BoxLevel::finish: the sum over all
/// subdomains, point by point, is the whole's. `supports` are those of all its molecules.
GridLevel assemble_part(const Tangent& tangent, const std::vector<Support>& supports, const BoxGrid::Frame& frame);

}  // namespace elastin
