#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "elastin/core/base/error.h"
#include "lab/report/comparison.h"
#include "lab/report/varied.h"

namespace elastin::lab {
std::optional<VariedNumber> varied_number(const std::string& text) {
  namespace d = dimension;
  for (const Dimension& unit : {d::none, d::length, d::pressure, d::force, d::time, d::density, d::acceleration,
                                d::velocity, d::stiffness, d::viscosity, d::damping, d::mass, d::area}) {
    try {
      return VariedNumber{parse_quantity(text, unit).value, unit};
    } catch (const InputError&) {  // another unit
    }
  }
  return std::nullopt;
}

std::string varied_text(const Record& record, const std::string& key) {
  for (const auto& [known, text] : record.variant)
    if (known == key) return text;
  return "";
}

std::vector<std::string> varied_keys(const std::vector<Record>& records) {
  std::vector<std::string> keys;
  for (const Record& record : records)
    for (const auto& [key, value] : record.variant)
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  return keys;
}

namespace {

/// What a study changes, as an axis: one key, or for keys with lists the number of molecules.
struct Parameter {
  std::string key;
  PlotAxis axis;
  bool counts = false;  ///< molecules stand for it
  double of(const Record& record) const {
    if (counts) return record.molecules;
    const auto value = varied_number(varied_text(record, key));
    return value ? value->number : std::nan("");
  }
};

/// Whether `other` has one value for each value of `key`: both change together.
bool follows(const std::vector<Record>& records, const std::string& other, const std::string& key) {
  std::map<std::string, std::string> known;
  return std::all_of(records.begin(), records.end(), [&](const Record& record) {
    const std::string value = varied_text(record, other);
    return known.try_emplace(varied_text(record, key), value).first->second == value;
  });
}

std::vector<Parameter> parameters_of(const std::vector<Record>& records, const std::vector<std::string>& keys) {
  std::vector<Parameter> found;
  for (const std::string& key : keys) {
    std::set<double> values;
    const auto first = varied_number(varied_text(records.front(), key));
    Parameter parameter{key, {key.substr(key.rfind('.') + 1), first ? si_unit(first->unit) : ""}, !first};
    if (parameter.counts) parameter.axis = {"molecules", "", true};
    for (const Record& record : records)
      if (std::isfinite(parameter.of(record))) values.insert(parameter.of(record));
    const bool followed = std::any_of(found.begin(), found.end(), [&](const Parameter& other) {
      return (other.counts && parameter.counts) || follows(records, key, other.key);
    });
    if (values.size() > 1 && !followed) found.push_back(parameter);
  }
  return found;
}

Plot plot_over(const std::vector<Record>& records, const Parameter& parameter, const std::vector<std::string>& keys,
               const std::map<std::string, int>& colours, const std::string& measure, const std::string& error) {
  const MeasureInfo& info = records.front().measure(measure);
  Plot plot;
  plot.x = parameter.axis;
  plot.y = {error.empty() ? info.label() : "error of " + info.label(), error.empty() ? info.unit_text() : "%"};
  plot.title = records.front().title + ": " + plot.y.title + " over " + plot.x.title;
  for (const Record& record : records) {
    const double x = parameter.of(record), y = error.empty() ? record.run.measures.get(measure) : record.error(error);
    if (!solved(record) || !std::isfinite(x) || !std::isfinite(y)) continue;
    std::string name = record.run.strategy;
    for (const std::string& key : keys)
      if (!follows(records, key, parameter.key)) name += ", " + varied_text(record, key);
    const auto colour = colours.find(name);
    series_of(plot, name, colour == colours.end() ? static_cast<int>(plot.series.size()) : colour->second)
        .points.push_back(
            {x, y,
             name + ": " + plot.x.title + " " +
                 (parameter.counts ? std::to_string(record.molecules) : varied_text(record, parameter.key)) + ", " +
                 plot.y.title + " " + (error.empty() ? value_text(y, info) : percent(y))});
  }
  for (PlotSeries& series : plot.series)
    std::stable_sort(series.points.begin(), series.points.end(),
                     [](const auto& a, const auto& b) { return a.x < b.x; });
  return plot;
}

}  // namespace

std::vector<Plot> parameter_plots(const std::vector<Record>& records, const Ranking& ranking,
                                  const std::map<std::string, int>& colours) {
  const std::vector<std::string> keys = varied_keys(records);
  std::vector<Plot> plots;
  std::vector<std::string> measures = ranking.measures;
  if (measures.empty() && !records.empty() && !records.front().main_measures.empty())
    measures.emplace_back(records.front().main_measures.front().name);
  for (const Parameter& parameter : parameters_of(records, keys))
    for (const std::string& measure : measures)
      for (const std::string& error : {std::string(), ranking.error_name(measure)}) {
        Plot plot = plot_over(records, parameter, keys, colours, measure, error);
        if (!plot.series.empty()) plots.push_back(std::move(plot));
      }
  return plots;
}

}  // namespace elastin::lab
