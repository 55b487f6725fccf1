#pragma once
#include "measure.h"

namespace bench {

/// Explicit steps of the cube's springs without contact, with an obstacle far away, and on a plane.
std::vector<Row> run_contact_steps(const Settings& settings);

}  // namespace bench
