#pragma once
#include <vector>

#include "lab/experiment/experiment.h"
#include "lab/experiment/run.h"

namespace elastin::lab {

/// An experiment that runs through time. Made once for a body; serves every strategy on it.
class TimedExperiment : public Experiment {
 public:
  TimedExperiment* in_time() final { return this; }

  /// Brings a held model to time 0: how the body stands, what is held, and what acts from now on, by Model::drive where
  /// that changes. The result is that of the last static solve that it took, if any.
  virtual StaticResult start(Model& model, State& state, const StaticOptions& options) = 0;
  /// Reads one state on the way.
  virtual Measures read(Model& model, const State& state) = 0;
  /// Adds what the whole course says, from its rows at equal times, the first at time 0.
  virtual void read_history(const std::vector<CurvePoint>& history, Measures& measures) const = 0;

  void set_load(Model&, double) final {}
  int load_steps() const final { return 1; }
  Measures measure(Model&, const Start&, const State&, const StaticOptions&, StaticResult&) const final { return {}; }
};

}  // namespace elastin::lab
