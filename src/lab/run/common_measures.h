#pragma once
#include <cmath>

#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

/// The measures of every run of an experiment: the experiment's own, then those that its kind of run adds: preload,
/// energy, contact, the history of a run in time, the identified material.
MeasureList measures_of(const Experiment& experiment);

/// Those that runs add to the experiments' own, of any kind.
const MeasureList& common_measures();

/// Whether a measure is a smooth function: no count, and no sum that is rounding alone.
bool is_smooth(const std::string& measure);

/// Whether a strain, or a length over that of the body, is more than rounding: a secant modulus needs one. A cycle
/// passes through none, and what has a rest may push where nothing strains it.
inline bool is_strained(double strain) { return std::abs(strain) > 1e-12; }

/// The largest strain of a connection, by size.
double largest_strain(const Model& model, const Positions& positions);

/// Energy, and the balance of all forces relative to `scale` [N]; of the whole body, which is `copies` times what is
/// modelled.
void add_state(const Model& model, const State& state, const StaticResult& solved, double scale, Measures& measures,
               double copies = 1);

}  // namespace elastin::lab
