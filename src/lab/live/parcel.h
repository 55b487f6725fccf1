#pragma once
#include <string>
#include <vector>

#include "core/forces/visit_support.h"
#include "core/model/visit_body.h"
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
  Positions own_load;             ///< of the experiment [N], 3 × n; empty where it has none
  double own_load_share = 0;      ///< of it that acts as the body begins; the page's own, not among the bytes
  TensionSetup tension;           ///< the test
  bool linear = false;            ///< small displacements
  double tolerance = 1e-10;       ///< of equilibria
};

template <class Archive>
void visit(Archive& archive, Parcel::Strategy& strategy) {
  archive.word(strategy.label);
  archive.word(strategy.name);
  visit(archive, strategy.values);
}

template <class Archive>
void visit(Archive& archive, Parcel::NamedLoad& load) {
  archive.word(load.name);
  visit(archive, load.values.numbers);
  visit(archive, load.values.vectors);
  visit(archive, load.values.molecules);
}

template <class Archive, class Choice>
void visit_choice(Archive& archive, Choice& choice) {
  int number = static_cast<int>(choice);
  archive.whole(number);
  choice = static_cast<Choice>(number);
}

template <class Archive>
void visit(Archive& archive, TensionSetup& setup) {
  visit(archive, setup.axis);
  visit(archive, setup.force);
  visit(archive, setup.displacement);
  visit(archive, setup.gravity);
  visit_choice(archive, setup.fixed_grip);
  visit_choice(archive, setup.loaded_grip);
  visit_choice(archive, setup.sharing);
  visit_choice(archive, setup.reading);
  for (double* value : {&setup.cross_section, &setup.thickness, &setup.gauge_length, &setup.grip_depth})
    visit(archive, *value);
  visit(archive, setup.gauge);
  visit(archive, setup.fixed);
  visit(archive, setup.loaded);
  archive.whole(setup.load_steps);
}

template <class Archive>
void visit(Archive& archive, Parcel& parcel) {
  visit(archive, parcel.body);
  visit(archive, parcel.material);
  visit(archive, parcel.materials);
  visit(archive, parcel.strategies);
  visit(archive, parcel.loads);
  visit(archive, parcel.supports);
  visit(archive, parcel.positions);
  visit(archive, parcel.own_load);
  visit(archive, parcel.tension);
  visit_choice(archive, parcel.linear);
  visit(archive, parcel.tolerance);
}

}  // namespace elastin::lab
