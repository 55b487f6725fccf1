#pragma once
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "elastin/lab/run/experiment.h"
#include "febio/constraints.h"
#include "febio/loads.h"
#include "febio/stepped_cells.h"

namespace elastin::febio {

using lab::MainMeasure;
using lab::MeasureList;
using lab::Measures;
using lab::Start;
using lab::StaticExperiment;
using lab::StaticRig;

/// A step of the analysis.
struct Step {
  bool dynamic = false;
  std::vector<double> increments;  ///< of time [s], one after the other, at least one
  Integration integration = {};
};

/// A displacement that is prescribed. Of several for one component the last that is in force counts.
struct DrivenComponent {
  int molecule, axis;
  int step = -1;  ///< in which alone it is in force, or -1: in all
  /// Its displacement [m] is Σ first · second; none: it is held where it is at rest.
  std::vector<std::pair<Value, Value>> terms = {};

  double at(double time) const {
    double sum = 0;
    for (const auto& [factor, value] : terms) sum += factor.at(time) * value.at(time);
    return sum;
  }
};

struct ExperimentSetup {
  std::vector<Step> steps;  ///< one after the other, at least one
  std::vector<DrivenComponent> driven;
  std::vector<DeadLoad> dead_loads;
  std::vector<SurfaceLoad> surface_loads;
  std::vector<LinearSpring> springs;
  std::vector<GapConstraint> gaps;
  std::vector<DilatationConstraint> dilatations;
  std::vector<VolumeConstraint> volumes;
  std::shared_ptr<Clock> clock = std::make_shared<Clock>();  ///< of the run that was set last
  std::vector<MassPair> mass;                                ///< needed where a step is dynamic

  /// Whether forces are ever those within a step.
  bool within() const {
    return std::any_of(steps.begin(), steps.end(),
                       [](const Step& step) { return step.dynamic && step.integration.alpha_force != 1; });
  }
};

/// The steps as one load path whose factor is the share of all increments: time goes with it. An increment of a dynamic
/// step is an equilibrium with inertia.
std::unique_ptr<StaticExperiment> make_experiment(const Body& body, std::shared_ptr<const ExperimentSetup> setup);

}  // namespace elastin::febio
