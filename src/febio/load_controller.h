#pragma once
#include <array>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "elastin/core/base/error.h"

namespace elastin::febio {

/// A number over time: a load curve through points, or a formula.                       [FEBio User's Manual, 3.17.1]
struct LoadController {
  enum class Interpolation { linear, step, smooth };
  enum class Extension { constant, extrapolate, repeat };
  Interpolation interpolation = Interpolation::linear;
  Extension extension = Extension::constant;
  std::vector<std::array<double, 2>> points = {};   ///< time and value, ascending in time, at least one
  std::function<double(double time)> formula = {};  ///< in place of the points

  /// `step` is the value of the next point; `smooth` the mean of the parabolas through three points each.
  double value(double time) const;

 private:
  double inside(double time) const;
};
using LoadControllers = std::map<int, std::shared_ptr<const LoadController>>;

/// A number that may change in time.
struct Value {
  double number = 0;
  std::shared_ptr<const LoadController> controller = nullptr;  ///< null: it does not change
  double at(double time) const { return controller ? number * controller->value(time) : number; }
};

}  // namespace elastin::febio
