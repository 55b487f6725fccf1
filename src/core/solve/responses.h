#pragma once
#include "core/solve/newton.h"

namespace elastin {

/// Small motions about one state of a model: all share its tangent and the solver's picture of it.
class Responses {
 public:
  /// The model, its supports and the state must stay until the last response.
  Responses(Model& model, const State& state, const StaticOptions& options);
  const Tangent& tangent() const { return tangent_; }
  /// As static_response.
  /// @param tolerance of the unbalanced force over the size of loads and reactions
  StaticResponse to(const Positions& load_change, const Positions& displacement, double tolerance);

 private:
  Model& model_;
  const StaticOptions& options_;
  Tangent tangent_;
  CachedSolver solver_;
};

}  // namespace elastin
