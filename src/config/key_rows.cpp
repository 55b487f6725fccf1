#include "config/key_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "elastin/core/base/units.h"

namespace elastin::config {

std::string number_text(double value) {
  const bool whole = value == std::floor(value) && std::abs(value) < 1e9;
  const std::string text = whole ? fmt::format("{:.0f}", value) : fmt::format("{:g}", value);
  return text.starts_with('-') ? "−" + text.substr(1) : text;
}

std::string direction_text(const Vector3& direction) {
  const char* names[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis)
    for (const int sign : {1, -1})
      if (direction == sign * Vector3::Unit(axis)) return std::string(sign < 0 ? "`-" : "`") + names[axis] + "`";
  return fmt::format("[{:g}, {:g}, {:g}]", direction.x(), direction.y(), direction.z());
}

std::string vector_text(const Vector3& vector) {
  if (vector == Vector3::Constant(vector.x())) return number_text(vector.x());
  return "[" + number_text(vector.x()) + ", " + number_text(vector.y()) + ", " + number_text(vector.z()) + "]";
}

std::string range_text(double low, double high, bool above_low) {
  if (!std::isfinite(low) && !std::isfinite(high)) return "";
  if (!std::isfinite(high)) return (above_low ? "> " : "≥ ") + number_text(low);
  if (!std::isfinite(low)) return "≤ " + number_text(high);
  return (above_low ? "> " : "") + number_text(low) + " … " + number_text(high);
}

std::string words_text(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "`" : ", `") + name + "`";
  return text;
}

SceneKey key_of(const ParameterInfo& info, const std::string& owner) {
  SceneKey key{owner + info.name, "", si_unit(info.unit), "", info.required ? "needed" : "none", info.text};
  switch (info.kind) {
    case ValueKind::number:
      key.type = info.unit == dimension::none ? "number" : "quantity";
      key.range = range_text(info.low, info.high, info.above_low);
      break;
    case ValueKind::whole:
      key.type = "whole";
      key.range = range_text(info.low, info.high, false);
      break;
    case ValueKind::vector:
      key.type = "vector";
      break;
    case ValueKind::direction:
      key.type = "direction";
      break;
    case ValueKind::molecules:
      key.type = "list of molecules, or [pick](#picked-molecules)";
      key.range = "0 … last molecule";
      break;
  }
  if (!std::isnan(info.fallback)) key.fallback = number_text(info.fallback);
  return key;
}

std::vector<std::string> owners_of(const std::string& key, const std::vector<KeySection>& sections) {
  std::vector<std::string> owners;
  for (const KeySection& section : sections) {
    const bool has =
        std::any_of(section.keys.begin(), section.keys.end(), [&](const SceneKey& own) { return own.name == key; });
    if (!has) continue;
    const std::string owner = section.path.starts_with("experiment.") ? "experiment"
                              : section.path.empty()                  ? "the scene"
                                                                      : section.path;
    if (std::find(owners.begin(), owners.end(), owner) == owners.end()) owners.push_back(owner);
  }
  if (owners.size() > 3) owners.resize(3);
  return owners;
}

}  // namespace elastin::config
