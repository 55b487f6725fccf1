#pragma once
#include "elastin/core/forces/load_table.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/engine.h"
#include "elastin/core/solve/integrator.h"

/// A stepper, a linear solver and a load that a program outside Elastin adds to its catalog.
namespace elastin::testing {

/// Velocity Verlet in so many equal parts.
class InParts final : public Integrator {
 public:
  InParts(int parts, const StaticOptions& newton)
      : parts_(parts), verlet_(make_integrator({.scheme = "velocity_verlet", .newton = newton})) {}
  StepResult advance(Model& model, State& state, double dt) override {
    StepResult result;
    for (int part = 0; part < parts_ && result.outcome == Outcome::converged; ++part)
      result = verlet_->advance(model, state, dt / parts_);
    return result;
  }

 private:
  int parts_;
  std::unique_ptr<Integrator> verlet_;
};

inline Stepper in_parts_row() {
  Stepper row{{"in_parts", "velocity Verlet in equal parts", "a test", {}}};
  row.parameters = {{"parts", dimension::none, 1, 100, 2, "of a step", false, ValueKind::whole}};
  row.is_explicit = true;
  row.order = 2;
  row.make = [](const ParameterValues& values, const StaticOptions& newton) {
    return std::make_unique<InParts>(static_cast<int>(values.at("parts")), newton);
  };
  return row;
}

/// A force on each of some molecules that grows with every accepted step: it remembers how many there were.
class Ratchet final : public Load {
 public:
  Ratchet(std::vector<int> molecules, const Vector3& growth) : molecules_(std::move(molecules)), growth_(growth) {}
  std::vector<HistoryBlock> history() const override { return {{"ratchet", {0}}}; }
  void add_forces(const State& state, Positions& forces) const override {
    const HistoryBlock* steps = state.find_history("ratchet");
    for (const int molecule : molecules_) forces.col(molecule) += (steps ? steps->values[0] : 0) * growth_;
  }
  void commit_step(State& state) const override { state.find_history("ratchet")->values[0] += 1; }
  bool has_energy() const override { return false; }
  bool steady() const override { return false; }

 private:
  std::vector<int> molecules_;
  Vector3 growth_;
};

inline LoadKind ratchet_row() {
  LoadKind row{{"ratchet", "a force that grows with every step", "a test", {}}};
  row.parameters = {
      {"molecules", dimension::none, 0, 1e9, 0, "on which it acts", false, ValueKind::molecules, true},
      {"growth", dimension::force, -1e9, 1e9, 0, "of the force in each step", false, ValueKind::vector, true}};
  row.add = [](Model& model, const LoadValues& values, const Material*) {
    model.add(std::make_unique<Ratchet>(values.molecules.at("molecules"), values.vectors.at("growth")));
  };
  return row;
}

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
  catalog.steppers.add(in_parts_row());
  catalog.linear_solvers.add(own_solver_row());
  catalog.loads.add(ratchet_row());
  catalog.engines.add(own_engine_row());
  return catalog;
}

}  // namespace elastin::testing
