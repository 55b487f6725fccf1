#pragma once
#include <string>
#include <vector>

#include "core/forces/visit_support.h"
#include "core/model/visit_body.h"
#include "core/solve/rest_samples.h"
#include "elastin/core/forces/load_table.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/model/material.h"
#include "lab/experiment/tension/tension.h"

/// What a scene's body takes with it to where there are no scenes: the lab in a browser. The command writes it, and the
/// module of src/web, which is built of the same sources, reads it. See base/archive.
namespace elastin::lab {

struct Parcel {
  Body body;
  Material material;
  std::vector<Material> materials;  ///< of the body's parts
  struct Strategy {
    std::string label, name;  ///< as the scene calls it, and as a catalog does
    ParameterValues values;
  };
  std::vector<Strategy> strategies;  ///< that suit, as the scene has them first
  struct NamedLoad {
    std::string name;
    LoadValues values;
  };
  std::vector<NamedLoad> loads;   ///< of the scene, rows of the core's table
  std::vector<Support> supports;  ///< of the experiment, with its load taken off
  Positions positions;            ///< where the body begins [m]
  SampledRest rest;               ///< of the body, under the whole load; without points where it has none
  Positions own_load;             ///< of the experiment [N], 3 × n; empty where it has none
  double own_load_share = 0;      ///< of it that acts as the body begins; the page's own, not among the bytes
  TensionSetup tension;           ///< the test
  bool own_test = false;          ///< whether that is the scene's experiment
  /// Of the scene, in addition to those of its test: planes of symmetry, for example. A test of the page's own has
  /// none.
  std::vector<Support> further_supports;
  bool linear = false;       ///< small displacements
  double tolerance = 1e-10;  ///< of equilibria
  /// What the page leaves out of the scene, in words; the page's own, not among the bytes.
  std::vector<std::string> left_out;
  std::string no_test;  ///< why nothing can be pulled, "" where it can; the page's own, not among the bytes
};

inline auto members(Parcel::Strategy& strategy) { return std::tie(strategy.label, strategy.name, strategy.values); }
inline auto members(Parcel::NamedLoad& load) {
  return std::tie(load.name, load.values.numbers, load.values.vectors, load.values.molecules);
}
inline auto members(TensionSetup& setup) {
  return std::tie(setup.axis, setup.force, setup.displacement, setup.gravity, setup.fixed_grip, setup.loaded_grip,
                  setup.sharing, setup.reading, setup.cross_section, setup.density, setup.thickness, setup.gauge_length,
                  setup.grip_depth, setup.gauge, setup.fixed, setup.loaded, setup.load_steps, setup.cycle);
}
inline auto members(Parcel& parcel) {
  return std::tie(parcel.body, parcel.rest, parcel.material, parcel.materials, parcel.strategies, parcel.loads,
                  parcel.supports, parcel.positions, parcel.own_load, parcel.tension, parcel.own_test,
                  parcel.further_supports, parcel.linear, parcel.tolerance);
}

}  // namespace elastin::lab
