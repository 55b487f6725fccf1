#include "elastin/lab/run/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/named.h"
#include "elastin/core/base/error.h"

namespace elastin::lab {

std::string MeasureInfo::label() const {
  std::string words(symbol.empty() ? name : symbol);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string MeasureInfo::unit_text() const { return unit_name.empty() ? si_unit(unit) : unit_name; }

MeasureList& MeasureList::add(const MeasureList& others) {
  for (const MeasureInfo& info : others)
    if (!find(info.name)) rows_.push_back(info);
  response.insert(response.end(), others.response.begin(), others.response.end());
  return *this;
}

const MeasureInfo* MeasureList::find(std::string_view name) const {
  for (const MeasureInfo& info : rows_)
    if (info.name == name || (!info.former.empty() && info.former == name)) return &info;
  return nullptr;
}

const MeasureInfo& MeasureList::at(const std::string& name) const {
  if (const MeasureInfo* info = find(name)) return *info;
  throw InputError("unknown measure '" + name + "'" + suggestion(name, names_of(rows_)));
}

std::string MeasureList::named(MeasureRole role) const {
  const auto info = std::find_if(rows_.begin(), rows_.end(), [&](const MeasureInfo& one) { return one.role == role; });
  return info == rows_.end() ? "" : info->name;
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

}  // namespace elastin::lab
