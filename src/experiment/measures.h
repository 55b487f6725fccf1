#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "elastin/base/units.h"

namespace elastin {

/// A number that an experiment reads off a loaded body.
struct MeasureInfo {
  std::string_view name;
  Dimension unit;
  std::string_view text;
};

/// Every measure there is: the one list behind scenes' expectations, files and docs.
const std::vector<MeasureInfo>& measure_list();
/// Throws InputError with the nearest name.
const MeasureInfo& find_measure(const std::string& name);

/// Measures of one state, in the order in which they were taken; SI units. Only finite ones are kept.
class Measures {
 public:
  void set(std::string_view name, double value);
  /// NaN if it was not taken.
  double get(std::string_view name) const;
  const std::vector<std::pair<std::string, double>>& all() const { return values_; }

 private:
  std::vector<std::pair<std::string, double>> values_;
};

}  // namespace elastin
