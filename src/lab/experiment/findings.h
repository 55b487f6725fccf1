#pragma once
#include <string>
#include <vector>

#include "elastin/core/forces/model.h"
#include "lab/experiment/run.h"

namespace elastin::lab {

/// What a user should know of a specimen before it is loaded, in sentences: cells that are given twice, overlap with
/// obstacles or between bodies, obstacles that fit between what they meet.
std::vector<std::string> findings_at_start(const Specimen& specimen, const Model& model, bool uses_cells);

/// What a user should know of a run that ended: a rebound faster than the impact, obstacles that something has passed
/// or may have passed through.
std::vector<std::string> findings_at_end(const Specimen& specimen, const Run& run);

}  // namespace elastin::lab
