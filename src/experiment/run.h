#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "elastin/model/body.h"
#include "elastin/model/material.h"
#include "experiment/experiment.h"

namespace elastin {

/// What does not change from strategy to strategy.
struct Specimen {
  Body body;
  Material material;
  std::vector<std::function<void(Model&)>> loads;  ///< each adds one load, or damping, to a model of the body
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
  Measures measures;                     ///< of the last converged load step
  std::vector<CurvePoint> curve;         ///< one point a converged load step
  std::vector<Snapshot> snapshots;       ///< of the start and of each point, if asked for
  VectorX constants;                     ///< spring constants [N/m]; empty for laws without
  double calibration_factor = 1;         ///< what calibration has multiplied the rule's constants with
  double volume_modulus = 0;             ///< κ of the springs' volume term [Pa]; 0 without
  std::optional<Identified> identified;  ///< the material that the experiment was there to find
  double build_seconds = 0, solve_seconds = 0;
  int newton_iterations = 0, linear_iterations = 0;
  int cut_steps = 0;          ///< Newton steps that were shortened because they would have turned a cell over
  int halved_load_steps = 0;  ///< parts of the load that were gone in halves, lest a cell turn over
  double residual = 0;
  int zero_energy_modes = 0;
  std::vector<std::string> warnings;
  std::string remark;       ///< of the experiment on what its measures mean here; empty = nothing to say
  bool unstable = false;    ///< an equilibrium was found that is no minimum
  bool uses_cells = false;  ///< the strategy could not run without the body's triangles or tetrahedra
  bool suited = true;       ///< false: the strategy cannot run on this body; cause says why
};

struct RunOptions {
  StaticOptions statics;
  bool keep_snapshots = false;
  std::function<void(const std::string& doing)> progress = {};  ///< called before each load step; may be empty
};

}  // namespace elastin
