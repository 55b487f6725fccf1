#pragma once
#include <vector>

#include "elastin/core/simulation/simulation.h"

namespace elastin {

/// What the host moves, and between which times it does.
struct Tools {
  std::vector<Tool> all;
  std::vector<Pose> first;    ///< as they were added
  double start = 0, end = 0;  ///< of the step in progress, or the last one [s]

  /// The tool's pose at a time; at 0, from the first step on, as it was added.
  Pose pose(ToolId tool, double time) const;
  void arrive() {
    for (Tool& tool : all)
      if (tool.next) tool.pose = *std::exchange(tool.next, std::nullopt);
    start = end;
  }
  void go_back() { end = start; }
};

}  // namespace elastin
