#pragma once
#include <functional>
#include <vector>

#include "core/model/neighbours.h"
#include "elastin/core/model/topology.h"

namespace elastin {

/// What is to be removed from a body, and between which neighbours it is split.
struct TopologyChange {
  std::vector<char> split;        ///< one of Neighbours::sides each: 1 = its cells no longer hang together there
  std::vector<char> cells;        ///< one a cell: 1 = removed
  std::vector<char> connections;  ///< one a connection: 1 = removed
  /// Whether what belongs to no cell is split between two positions [m]; empty: nothing is.
  std::function<bool(const Vector3&, const Vector3&)> crosses;
};

/// The body after the change, in its present positions [m].
ChangedBody changed_body(const Body& body, const Positions& positions, const Neighbours& cells, TopologyChange change);

}  // namespace elastin
