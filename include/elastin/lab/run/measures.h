#pragma once
#include <Eigen/Core>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "elastin/core/base/units.h"
#include "elastin/core/solve/homogenisation.h"

namespace elastin::lab {

/// The meaning of a measure for what is common to all experiments: preload, calibration, tables and plots.
enum class MeasureRole {
  none,
  youngs_modulus,  ///< to which rules are calibrated and by which strategies are ranked
  poissons_ratio,  ///< ranked next to it
  shear_modulus,
  modulus,  ///< any other property of the body under load: a released body has none of them
  strain,
  stress,           ///< of the stress–strain curve
  material_stress,  ///< of the material itself at the strain
  force,
  torque,        ///< of the load; under preload measured in total, too
  displacement,  ///< by the load; as force
  share,         ///< a ratio that plots show in per cent
  detail,        ///< left out of short tables of a curve
  history,       ///< left out of short tables of a run in time
};

/// Whether it is a property of the body under load, which a released body has no more.
inline bool is_property(MeasureRole role) {
  return role >= MeasureRole::youngs_modulus && role <= MeasureRole::modulus;
}

/// A number that an experiment reads off a loaded body.
struct MeasureInfo {
  std::string name;
  Dimension unit;
  std::string text;
  MeasureRole role = MeasureRole::none;
  std::string symbol = {};     ///< "E", "G": its name in tables; empty = `name`
  std::string unit_name = {};  ///< where the SI unit goes by another name here ("N m" of a torque); else empty
  std::string former = {};     ///< name in earlier versions, still read; empty: the same
  /// Its name in tables: "E", "tip deflection".
  std::string label() const;
  /// Its SI unit, "" for a ratio.
  std::string unit_text() const;
};

/// Axes of a response curve: two measures, or "load" or "time" in the place of the first.
struct ResponseAxes {
  std::string x, y;
  bool from_zero = false;    ///< whether the curve begins at 0, 0
  std::string y_title = {};  ///< where it says more than the measure's label
};

/// The measures of an experiment and the axes over which its response is drawn, the most telling first.
class MeasureList {
 public:
  MeasureList() = default;
  MeasureList(std::initializer_list<MeasureInfo> rows, std::vector<ResponseAxes> axes = {})
      : response(std::move(axes)), rows_(rows) {}
  /// Adds those rows of another list whose names are new, and its axes.
  MeasureList& add(const MeasureList& others);
  /// By its name or its former one; null without such a measure.
  const MeasureInfo* find(std::string_view name) const;
  /// Throws InputError with the nearest name.
  const MeasureInfo& at(const std::string& name) const;
  /// Name of the first with this role; "" if no measure has it.
  std::string named(MeasureRole role) const;
  auto begin() const { return rows_.begin(); }
  auto end() const { return rows_.end(); }

  std::vector<ResponseAxes> response;

 private:
  std::vector<MeasureInfo> rows_;
};

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
