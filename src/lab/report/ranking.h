#pragma once
#include <string>
#include <vector>

#include "lab/report/records.h"

namespace elastin::lab {

/// An error of E up to here is fit for use.
inline constexpr double kNear = 0.05;

/// Whether the run came to its end.
bool solved(const Record& record);

/// Whether its error says something: it came to its end, and was not calibrated to the very value that it is compared
/// with.
bool has_own_error(const Record& record);

/// The recommended strategy of a comparison.
struct Ranking {
  /// What counts: every main measure with a certain reference, which solves the same problem; without one, the
  /// first with a value of the material, which is met only where the grips do not disturb. Empty: nothing to go by.
  std::vector<std::string> measures;
  bool by_reference = false;
  /// Why nothing ranks them, in words: the specimen does not show the material's values, and no reference is given.
  std::string no_reference;
  const Record* best = nullptr;     ///< points into the records; null if each one failed or has a warning
  const Record* warned = nullptr;   ///< the nearest of those that came to their end with a warning
  std::vector<const Record*> tied;  ///< others that the measures do not distinguish from the best

  /// Name of a measure's error that counts.
  std::string error_name(const std::string& measure) const { return measure + (by_reference ? "_to_reference" : ""); }
  /// The largest of the errors that count, as a size; infinite if one is missing. Of ratios that have a computed
  /// reference the difference counts.
  double error(const Record& record) const;
  /// Whether the best comes near enough to be recommended.
  bool recommends() const { return best && error(*best) <= kNear; }
};

/// The best is near enough (0.1 %, or within a tenth of the least error), with nothing to warn of; of those the nearest
/// in what else the material prescribes; then the fastest. Where one that comes near is near in every direction, those
/// that are known not to be are passed over. Where errors differ by less than the measures carry (1e-5,
/// the solver's residual, the reference's uncertainty) time does not count: they are tied, and the simplest strategy is
/// the best. What was calibrated to the reference meets it by construction and is never the best.
Ranking rank_strategies(const std::vector<Record>& records);

}  // namespace elastin::lab
