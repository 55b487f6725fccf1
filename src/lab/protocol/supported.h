#pragma once
#include <vector>

#include "elastin/lab/experiment/protocol.h"

namespace elastin::lab {

/// An experiment at rest on a body with further supports: planes of symmetry, a clamped rim. What a molecule is held
/// along by either stays held; the supports' own displacements are 0. A release frees what the experiment held alone.
std::unique_ptr<StaticProtocol> with_supports(std::unique_ptr<const StaticProtocol> experiment,
                                              std::vector<Support> supports);

/// The experiment that with_supports was given, or itself.
const Protocol& without_supports(const Protocol& experiment);

}  // namespace elastin::lab
