#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "elastin/forces/loads.h"
#include "elastin/model/body.h"
#include "elastin/model/material.h"
#include "elastin/simulation/catalog.h"
#include "experiment/experiment.h"

namespace elastin {

/// A strategy as a scene or a command line names it: "standard", "lattice+volume", "calibrated:angles", with its
/// parameters.
struct StrategyChoice {
  std::string label;  ///< as it was named
  Strategy strategy;  ///< the rule or law itself, with its volume term if any; for calibrated:RULE the rule
  bool calibrated = false;
  ParameterValues values;
};

/// Reads "NAME" or "calibrated:RULE" ("calibrated" alone is calibrated:standard), either with "+volume" behind it.
/// Throws InputError with the nearest name.
StrategyChoice choose_strategy(const Catalog& catalog, const std::string& label);

/// The same choice with a volume term, "+volume" added to its label. Throws InputError if it cannot have one.
StrategyChoice with_volume(StrategyChoice choice);

/// Every strategy of the catalog, and every spring rule calibrated too.
std::vector<StrategyChoice> all_strategies(const Catalog& catalog);

/// What does not change from strategy to strategy.
struct Specimen {
  Body body;
  Material material;
  std::vector<std::function<std::unique_ptr<Load>(const Body&)>> loads;
};

/// One state on the way of the load.
struct CurvePoint {
  double load_factor = 0;
  Measures measures;
  int newton_iterations = 0, linear_iterations = 0;
  double residual = 0;
};

/// A state to be looked at.
struct Snapshot {
  double load_factor = 0;
  Positions positions;  ///< [m]
  VectorX densities;    ///< force density of each connection [N/m]
};

/// What came of one strategy on one specimen. Everything in SI units.
struct Run {
  std::string strategy;
  std::string solver;
  Outcome outcome = Outcome::converged;
  std::string cause;
  Measures measures;                ///< of the last converged load step
  std::vector<CurvePoint> curve;    ///< one point a converged load step
  std::vector<Snapshot> snapshots;  ///< of the start and of each point, if asked for
  VectorX constants;                ///< spring constants [N/m]; empty for laws without
  double calibration_factor = 1;    ///< what calibration has multiplied the rule's constants with
  double volume_modulus = 0;        ///< κ of the springs' volume term [Pa]; 0 without
  double build_seconds = 0, solve_seconds = 0;
  int newton_iterations = 0, linear_iterations = 0;
  double residual = 0;
  int zero_energy_modes = 0;
  std::vector<std::string> warnings;
  std::string remark;  ///< of the experiment on what its measures mean here; empty = nothing to say
  bool suited = true;  ///< false: the strategy cannot run on this body; cause says why
};

struct RunOptions {
  StaticOptions statics;
  bool keep_snapshots = false;
  std::function<void(const std::string& doing)> progress = {};  ///< called before each load step; may be empty
};

/// Gives the body what the strategy needs of it and it has not yet: its Voronoi cells. Saves run_strategy from doing so
/// for every run anew.
void prepare(Body& body, const Strategy& strategy);

/// Builds the strategy on the specimen, solves every load step and measures. Numerical trouble is an
/// outcome in the result; wrong parameters throw InputError.
Run run_strategy(const Specimen& specimen, Experiment& experiment, const StrategyChoice& choice,
                 const RunOptions& options);

}  // namespace elastin
