#include "experiment/measures.h"

#include <cmath>
#include <limits>

#include "elastin/base/error.h"

namespace elastin {

const std::vector<MeasureInfo>& measure_list() {
  using namespace dimension;
  static const std::vector<MeasureInfo> list{
      {"effective_modulus", pressure, "secant modulus E = F l0 / (A dl) of the loaded body"},
      {"elongation", length, "dl, read as the scene says; negative in compression"},
      {"poissons_ratio", none, "- lateral strain at mid height / strain"},
      {"force", force, "F on the loaded end along the axis; negative in compression"},
      {"stress", pressure, "F / A"},
      {"strain", none, "dl / l0"},
      {"lateral_strain", none, "mean in-plane strain of the molecules at mid height"},
      {"tangent_modulus", pressure, "d stress / d strain at the last load step, from a linear solve there"},
      {"average_modulus", pressure, "mean of the secant moduli over the load steps"},
      {"curve_error", none, "largest |stress - the material's at that strain| over the largest such stress"},
      {"energy", energy, "elastic energy stored"},
      {"reaction_balance", none, "| loads + reactions | / | F |: 0 for a body in balance"}};
  return list;
}

const MeasureInfo& find_measure(const std::string& name) {
  std::vector<std::string> names;
  for (const MeasureInfo& info : measure_list()) {
    if (info.name == name) return info;
    names.emplace_back(info.name);
  }
  throw InputError("unknown measure '" + name + "'" + suggestion(name, names));
}

void Measures::set(std::string_view name, double value) {
  if (!std::isfinite(value)) return;
  for (auto& [known, old] : values_)
    if (known == name) {
      old = value;
      return;
    }
  values_.emplace_back(name, value);
}

double Measures::get(std::string_view name) const {
  for (const auto& [known, value] : values_)
    if (known == name) return value;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace elastin
