#pragma once
#include <memory>

#include "core/solve/trial.h"
#include "elastin/core/solve/statics.h"
#include "petsc/boxes.h"
#include "petsc/shared_model.h"

namespace elastin::petsc {

/// What is made once for a body.
struct SharedSetting {
  explicit SharedSetting(const Body& given) : body(given, PETSC_COMM_WORLD) {}
  SharedBody body;
  std::unique_ptr<BoxHierarchy> boxes = {};  ///< made when they are needed first
};

/// As elastin::static_response, of a model that can be shared out.
StaticResponse respond(Model& model, SharedSetting& setting, const Positions& at, const Positions& load_change,
                       const Positions& displacement, const StaticOptions& options);

/// Newton's method with a line search on the energy, as elastin::solve_newton; `kinematics`: of a step in time of a
/// model with complete rows, null: an equilibrium.
StaticResult balance(Model& model, SharedSetting& setting, State& state, const StaticOptions& options,
                     const Kinematics* kinematics = nullptr);

}  // namespace elastin::petsc
