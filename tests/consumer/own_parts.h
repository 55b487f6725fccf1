#pragma once
#include <memory>
#include <utility>
#include <vector>

#include "elastin/core/forces/load_table.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/solve/integrator.h"

/// A stepper and a load of a program outside Elastin, as rows for its catalog.
namespace own {

/// Velocity Verlet in a number of equal substeps.
class InParts final : public elastin::Integrator {
 public:
  InParts(int substeps, const elastin::StaticOptions& newton)
      : substeps_(substeps), verlet_(elastin::make_integrator({.scheme = "velocity_verlet", .newton = newton})) {}
  elastin::StepResult advance(elastin::Model& model, elastin::State& state, double dt) override {
    elastin::StepResult result;
    for (int substep = 0; substep < substeps_ && result.outcome == elastin::Outcome::converged; ++substep)
      result = verlet_->advance(model, state, dt / substeps_);
    return result;
  }

 private:
  int substeps_;
  std::unique_ptr<elastin::Integrator> verlet_;
};

inline elastin::Stepper in_parts_row() {
  elastin::Stepper row{{"in_parts", "velocity Verlet in equal substeps", "a test", {}}};
  row.parameters = {
      {"parts", elastin::dimension::none, 1, 100, 2, "substeps of a step", false, elastin::ValueKind::whole}};
  row.is_explicit = true;
  row.order = 2;
  row.make = [](const elastin::ParameterValues& values, const elastin::StaticOptions& newton) {
    return std::make_unique<InParts>(static_cast<int>(values.at("parts")), newton);
  };
  return row;
}

/// A force on each of some molecules that grows with every accepted step; its history counts these.
class Ratchet final : public elastin::Load {
 public:
  Ratchet(std::vector<int> molecules, const elastin::Vector3& growth)
      : molecules_(std::move(molecules)), growth_(growth) {}
  std::vector<elastin::HistoryBlock> history() const override { return {{"ratchet", {0}}}; }
  void add_forces(const elastin::State& state, elastin::Positions& forces) const override {
    const elastin::HistoryBlock* steps = state.find_history("ratchet");
    for (const int molecule : molecules_) forces.col(molecule) += (steps ? steps->values[0] : 0) * growth_;
  }
  void commit_step(elastin::State& state) const override { state.find_history("ratchet")->values[0] += 1; }
  bool has_energy() const override { return false; }
  bool steady() const override { return false; }

 private:
  std::vector<int> molecules_;
  elastin::Vector3 growth_;
};

inline elastin::LoadKind ratchet_row() {
  using elastin::ValueKind;
  elastin::LoadKind row{{"ratchet", "a force that grows with every step", "a test", {}}};
  row.parameters = {
      {"molecules", elastin::dimension::none, 0, 1e9, 0, "on which it acts", false, ValueKind::molecules, true},
      {"growth", elastin::dimension::force, -1e9, 1e9, 0, "of the force in each step", false, ValueKind::vector, true}};
  row.add = [](elastin::Model& model, const elastin::LoadValues& values, const elastin::Material*) {
    model.add(std::make_unique<Ratchet>(values.molecules.at("molecules"), values.vectors.at("growth")));
  };
  return row;
}

}  // namespace own
