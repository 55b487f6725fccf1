#pragma once
#include <utility>

#include "core/solve/last_solve.h"

namespace elastin {

/// Small motions about one state of a model: all share its tangent and the solver's picture of it.
class Responses {
 public:
  /// The model, its supports and the state must stay until the last response.
  /// @param last what the solve that ended in this state has left, which it takes; may be null
  Responses(Model& model, const State& state, const StaticOptions& options, LastSolve* last = nullptr);
  const Tangent& tangent() const { return tangent_; }
  CachedSolver take_solver() { return std::move(last_.solver); }
  /// As static_response.
  /// @param tolerance of the unbalanced force over the size of loads and reactions
  StaticResponse to(const Positions& load_change, const Positions& displacement, double tolerance);

 private:
  Model& model_;
  const StaticOptions& options_;
  LastSolve last_;
  Tangent tangent_;
};

}  // namespace elastin
