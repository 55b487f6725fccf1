#pragma once
#include "consumer/own_parts.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/engine.h"

/// A linear solver and an engine that a program outside Elastin adds to its catalog, with its stepper and load.
namespace elastin::testing {

/// Conjugate gradients under another name, as a solver of a host would stand behind the interface.
class OwnSolver final : public LinearSolver {
 public:
  const char* name() const override { return "own"; }
  LinearResult solve(const Tangent& tangent, const std::vector<Support>& supports, const Positions& rhs,
                     double tolerance, Positions& solution) override {
    return pcg_->solve(tangent, supports, rhs, tolerance, solution);
  }

 private:
  std::unique_ptr<LinearSolver> pcg_ = make_pcg();
};

inline LinearSolverKind own_solver_row() {
  LinearSolverKind row{{"own", "conjugate gradients of the host", "a test", {}}};
  row.make = [] { return std::make_unique<OwnSolver>(); };
  return row;
}

/// This process's own solvers behind the interface of engines, which counts how often it is asked.
class OwnEngine final : public StaticEngine {
 public:
  std::string unsuited(const Model& model) const override {
    return model.loads().empty() ? "the engine of the host wants a load" : "";
  }
  StaticResponse respond(Model& model, const Positions& at, const Positions& load_change, const Positions& displacement,
                         const StaticOptions& options) override {
    ++calls;
    return static_response(model, at, load_change, displacement, plain(options));
  }
  StaticResult balance(Model& model, State& state, const StaticOptions& options) override {
    ++calls;
    StaticResult result = solve_static(model, state, plain(options));
    result.reactions *= reactions_times;
    return result;
  }
  static inline int calls = 0;
  static inline double reactions_times = 1;  ///< what it makes of them: others than 1 balance no load

 private:
  static StaticOptions plain(StaticOptions options) {
    options.engine = nullptr;
    return options;
  }
};

inline StaticEngineKind own_engine_row() {
  return {{"own", "the solvers of this process behind the interface of engines", "a test"},
          [] { return std::make_shared<OwnEngine>(); },
          ""};
}

inline Catalog catalog_with_own_rows() {
  Catalog catalog = built_in_catalog();
  catalog.steppers.add(own::in_parts_row());
  catalog.linear_solvers.add(own_solver_row());
  catalog.loads.add(own::ratchet_row());
  catalog.engines.add(own_engine_row());
  return catalog;
}

}  // namespace elastin::testing
