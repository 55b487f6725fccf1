#pragma once
#include "elastin/core/forces/time_function.h"
#include "lab/run/config_names.h"

namespace elastin::lab {

/// {ramp: {duration: 1 s}}, {step: {at: 1 s}}, {sine: …} or {table: [[0 s, 0], …]}.
TimeFunction read_time_function(const Reader& reader);

/// Its table in the key reference.
KeySection time_function_section();

}  // namespace elastin::lab
