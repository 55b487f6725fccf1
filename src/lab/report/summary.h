#pragma once
#include <string>
#include <vector>

#include "lab/report/records.h"

namespace elastin::lab {

/// Sizes of an error over several bodies: the middle one, the largest and where that was; NaN where none was measured.
struct ErrorSpread {
  double median = 0, worst = 0;
  std::string worst_scene;
};

/// What one strategy did on several bodies.
struct StrategySummary {
  std::string strategy;
  bool uses_cells = false;
  int bodies = 0, unsuited = 0, failed = 0;
  int mechanisms = 0;           ///< bodies that it leaves zero-energy modes
  int best_on = 0;              ///< bodies on which it is the best cell-free strategy
  ErrorSpread modulus, ratio;   ///< |error of E|, relative; |difference of Poisson's ratio|
  double solve = 0, whole = 0;  ///< medians of solve, and of build + solve, over those of `standard`; NaN without it
};

/// One body, the strategy without cells to take on it, and the spring rule (which may have a
/// volume term over cells, or constants from cells); null if none ran without mechanism or
/// instability.
struct BodySummary {
  std::string scene;
  int molecules = 0;
  Neighbours neighbours;
  bool judged = true;  ///< false: the specimen does not show the material's values, and there is no reference
  const Record *best = nullptr, *best_springs = nullptr;
};

struct Summary {
  std::vector<StrategySummary> strategies;  ///< in the order in which they first ran
  std::vector<BodySummary> bodies;          ///< in the order of the scenes
};

/// The goal of the best cell-free strategy on a body: errors of E (relative) and of Poisson's ratio.
inline constexpr double kModulusGoal = 0.01, kRatioGoal = 0.01;

/// All runs of a comparison by strategy and by body. The best cell-free strategy has the least of max(|error of E| / 1
/// %, |difference of ν| / 0.01), to a thousandth; of equals the simplest. Points into `records`.
Summary summarise(const std::vector<Record>& records);

/// The summary as two tables, then what failed.
std::string summary_text(const std::vector<Record>& records, bool colours);

}  // namespace elastin::lab
