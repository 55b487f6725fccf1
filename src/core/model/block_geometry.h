#pragma once
#include <span>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// Of some molecules [m], a column each.
Eigen::MatrixXd positions_of(const Positions& positions, std::span<const int> nodes);

/// flat_or_inverted_cells of a body with blocks of three dimensions.
std::vector<int> flat_or_inverted_in_blocks(const Body& body, const Positions& positions);

/// Of the vectors ∂x/∂ξ: what they span, signed where there are three.
double measure_of(const Eigen::MatrixXd& edges);

/// A face of a cell that no other cell has: its kind, and its nodes in that kind's order, outward.
struct BlockFace {
  const CellKind* kind;
  std::vector<int> nodes;
};
std::vector<BlockFace> boundary_faces(const Body& body);

/// ∫ N_a dA [m²], seen along `direction`, over the boundary faces of blocks all of whose nodes are among the molecules:
/// the load that an even traction puts on each of them.
VectorX face_shares(const Body& body, const std::vector<int>& molecules, const Vector3& direction);

}  // namespace elastin
