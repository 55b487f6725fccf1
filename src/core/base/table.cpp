#include "elastin/core/base/table.h"

#include <cmath>

#include "core/base/named.h"
#include "elastin/core/base/text.h"

namespace elastin {
namespace {

/// "at least 0 and at most 1 Pa"
std::string range_text(const ParameterInfo& info) {
  std::string range;
  if (std::isfinite(info.low)) range = (info.above_low ? "above " : "at least ") + number(info.low);
  if (std::isfinite(info.high)) range += (range.empty() ? "at most " : " and at most ") + number(info.high);
  if (range.empty()) range = "a finite number";
  const std::string unit = si_unit(info.unit);
  return range + (unit.empty() ? "" : " ") + unit;
}

}  // namespace

const char* name_of(ValueKind kind) {
  switch (kind) {
    case ValueKind::number:
      return "number";
    case ValueKind::whole:
      return "whole number";
    case ValueKind::vector:
      return "vector";
    case ValueKind::direction:
      return "direction";
    case ValueKind::molecules:
      return "molecules";
  }
  return "";
}

const ParameterInfo& checked_parameter(const std::string& owner, const std::vector<ParameterInfo>& parameters,
                                       const std::string& name, double value) {
  if (parameters.empty()) throw InputError("'" + name + "': " + owner + " takes no parameters");
  const ParameterInfo& info = named(parameters, name, "unknown parameter '" + name + "' of " + owner);
  const bool whole = info.kind == ValueKind::whole, low_enough = info.above_low ? value > info.low : value >= info.low;
  if (low_enough && value <= info.high && (!whole || value == std::floor(value))) return info;
  throw InputError(owner + "." + name + ": " + number(value) + " is out of range: it must be " +
                   (whole ? "whole, " : "") + range_text(info) + " (" + info.text + ")");
}

ParameterValues complete_values(const std::string& owner, const std::vector<ParameterInfo>& parameters,
                                const ParameterValues& given) {
  for (const auto& [name, value] : given) checked_parameter(owner, parameters, name, value);
  ParameterValues values = given;
  for (const ParameterInfo& info : parameters)
    if (!std::isnan(info.fallback) && (info.kind == ValueKind::number || info.kind == ValueKind::whole))
      values.try_emplace(info.name, info.fallback);
  return values;
}

}  // namespace elastin
