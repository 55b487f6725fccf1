#pragma once
#include <string>
#include <vector>

#include "elastin/core/model/state.h"
#include "lab/run/run.h"
#include "lab/run/step_control.h"

namespace elastin::lab {

/// All that a run in time needs to go on as if it had not stopped.
struct RestartPoint {
  int frame = 0;
  State state;
  double dissipated = 0, work = 0, taken = 0, jumps = 0;  ///< [J], of the ledger
  StepControl::Memory memory;
  int newton_iterations = 0, linear_iterations = 0;
  std::vector<CurvePoint> curve, history;  ///< of the frames; of steps too
};

/// As text, every number with all its bits. `identity` names what must be the same when it is read.
std::string restart_text(const RestartPoint& point, const std::string& identity);
/// Throws InputError, with `path`, line and column if there is a path, where the text is no restart file, one of
/// another version, or that of another run.
RestartPoint parse_restart(const std::string& text, const std::string& identity, const std::string& path = "");

/// What a run must share with the one that it goes on from: body, strategy, scheme and frames.
std::string restart_identity(const Body& body, const std::string& strategy, const TimeOptions& options,
                             const std::string& scheme);

}  // namespace elastin::lab
