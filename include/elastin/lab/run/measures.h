#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "elastin/core/base/units.h"
#include "elastin/core/solve/homogenisation.h"

namespace elastin::lab {

/// A number that an experiment reads off a loaded body.
struct MeasureInfo {
  std::string_view name;
  Dimension unit;
  std::string_view text;
  std::string_view symbol = {};     ///< "E", "G": how tables call it; empty = its name
  std::string_view unit_name = {};  ///< where the SI unit goes by another name here ("N m" of a torque); else empty
  /// How tables call it: "E", "tip deflection".
  std::string label() const;
  /// Its SI unit, "" for a ratio.
  std::string unit_text() const;
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
  /// Of the body as a whole; only the experiment `material` measures it.
  std::optional<Stiffness6> stiffness_matrix;

 private:
  std::vector<std::pair<std::string, double>> values_;
};

}  // namespace elastin::lab
