#pragma once
#include "elastin/core/solve/integrator.h"

namespace elastin {

std::unique_ptr<Integrator> make_implicit(const IntegratorOptions& options);

}  // namespace elastin
