#pragma once
#include <memory>
#include <utility>
#include <vector>

#include "elastin/core/forces/load_table.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/solve/stepper.h"
#include "elastin/lab/experiment/experiment_catalog.h"

/// A stepper, a load and an experiment of a program outside Elastin, as rows for its catalogs.
namespace own {

/// Velocity Verlet in a number of equal substeps.
class InParts final : public elastin::Stepper {
 public:
  InParts(int substeps, const elastin::StaticOptions& newton)
      : substeps_(substeps), verlet_(elastin::make_stepper({.method = "velocity_verlet", .newton = newton})) {}
  elastin::StepResult advance(elastin::Model& model, elastin::State& state, double dt) override {
    elastin::StepResult result;
    for (int substep = 0; substep < substeps_ && result.outcome == elastin::Outcome::converged; ++substep)
      result = verlet_->advance(model, state, dt / substeps_);
    return result;
  }

 private:
  int substeps_;
  std::unique_ptr<elastin::Stepper> verlet_;
};

inline elastin::StepperKind in_parts_row() {
  elastin::StepperKind row{{"in_parts", "velocity Verlet in equal substeps", "a test", {}}};
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

/// A body that is held at its top and stretched by its own weight along z, with a measure of its own.
class Hanging final : public elastin::lab::StaticExperiment {
 public:
  explicit Hanging(double gravity) : gravity_(gravity) {}

  static elastin::lab::MeasureList measure_list() {
    return {{{"sag", elastin::dimension::length, "by which the lowest molecules sink"}}, {{"load", "sag"}}};
  }
  std::string name() const override { return "hanging"; }
  elastin::lab::MeasureList measures() const override { return measure_list(); }
  std::vector<elastin::lab::MainMeasure> main_measures(const elastin::Material&,
                                                       const elastin::lab::Measures&) const override {
    return {{"sag"}};
  }

 protected:
  std::unique_ptr<elastin::lab::StaticRig> make_rig(elastin::Model& model) const override {
    return std::make_unique<Held>(model, gravity_);
  }

 private:
  class Held final : public elastin::lab::StaticRig {
   public:
    Held(elastin::Model& model, double gravity) {
      const elastin::Body& body = model.body();
      const double top = body.rest.row(2).maxCoeff(), reach = 1e-9 * (top - body.rest.row(2).minCoeff());
      std::vector<int> all;
      for (int molecule = 0; molecule < body.size(); ++molecule) {
        all.push_back(molecule);
        if (body.rest(2, molecule) > top - reach) model.supports.push_back({molecule});
      }
      elastin::Positions weight = elastin::Positions::Zero(3, body.size());
      weight.row(2) = -gravity * body.mass.transpose();
      auto load = std::make_unique<elastin::PointLoads>(body, all, weight);
      load_ = load.get();
      model.add(std::move(load));
    }
    void set_load(double factor) override { load_->set_factor(factor); }
    elastin::lab::Measures measure(const elastin::lab::Start& start, const elastin::State& state,
                                   const elastin::StaticOptions&, elastin::StaticResult&) const override {
      elastin::lab::Measures measures;
      measures.set("sag", (start.positions - state.positions).row(2).maxCoeff());
      return measures;
    }

   private:
    elastin::PointLoads* load_;
  };

  double gravity_;
};

inline elastin::lab::ExperimentInfo hanging_row() {
  elastin::lab::ExperimentInfo row{"hanging", "a body that its own weight stretches", "a test"};
  row.parameters = {{"gravity", elastin::dimension::acceleration, 0, 1e3, 9.81, "along -z"}};
  row.make = [](const elastin::lab::ExperimentContext&, const elastin::ParameterValues& values) {
    return std::make_unique<Hanging>(values.at("gravity"));
  };
  row.measures = Hanging::measure_list();
  return row;
}

}  // namespace own
