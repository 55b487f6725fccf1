#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "lab/report/peers.h"
#include "lab/report/plot.h"
#include "lab/report/ranking.h"

namespace elastin::lab {

/// The axes of a run of an experiment that is not known.
std::vector<ResponseAxes> usual_response(bool in_time);

/// The first of these axes of which there are measures; empty ones where there are none.
ResponseAxes choose_response(const std::vector<ResponseAxes>& axes,
                             const std::function<bool(const std::string& measure)>& has);

/// The colour of each strategy, of each curve and of each run of a study, the same on a whole page. Strategies of one
/// family (calibrated:lattice, lattice+volume) have shades of one hue as far as there are; runs of a study have hues.
std::map<std::string, int> strategy_colours(const std::vector<Record>& records);

/// Error against time of one scene's records, a series a strategy or curve of a study; the best so far as a staircase.
/// Errors below 1e-7 stand at the foot. No series where nothing can be ranked.
Plot error_plot(const std::vector<Record>& records, const Ranking& ranking, const std::map<std::string, int>& colours,
                const std::vector<Peer>& peers = {});

/// The response curve of each record: the stress–strain curve, torque over angle, a deflection over load or time; of a
/// study with more than 24 runs the finest of each curve. No series where there is no such measure.
Plot response_plot(const std::vector<Record>& records, const std::map<std::string, int>& colours);

/// Of a study, each measure that counts over each key that has numbers, and its error over the same key; a series a
/// strategy and value of the keys that change by themselves. Of keys with lists (a lattice's molecules) the number of
/// molecules stands for the value. Empty where nothing is varied.
std::vector<Plot> parameter_plots(const std::vector<Record>& records, const Ranking& ranking,
                                  const std::map<std::string, int>& colours);

}  // namespace elastin::lab
