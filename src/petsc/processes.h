#pragma once
#include <memory>

#include "elastin/core/model/share.h"

namespace elastin::petsc {

/// Those of PETSc's communicator.
std::shared_ptr<const Processes> make_processes();

}  // namespace elastin::petsc
