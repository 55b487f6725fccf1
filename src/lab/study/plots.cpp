#include "lab/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "core/base/named.h"
#include "core/laws/homogeneous.h"
#include "elastin/core/base/error.h"
#include "lab/format/csv.h"
#include "lab/report/comparison.h"
#include "lab/run/material_numbers.h"

namespace elastin::lab {
namespace {

/// "stress" of "stress [Pa]".
std::string name_of(const std::string& column) { return column.substr(0, column.find(" [")); }

/// "Pa" of "stress [Pa]"; "" without a unit.
std::string unit_of(const std::string& column) {
  const std::size_t from = column.find(" ["), to = column.rfind(']');
  if (from != std::string::npos && to != std::string::npos) return column.substr(from + 2, to - from - 2);
  return column.ends_with("_s") ? "s" : "";
}

/// The column of this name as the head has it, with its unit; "" if no column has this name.
std::string find_column(const Csv& csv, const std::string& name) {
  for (const std::string& column : csv.head)
    if (column == name || name_of(column) == name) return column;
  return "";
}

std::string column_of(const Csv& csv, const std::string& name) {
  const std::string found = find_column(csv, name);
  if (!found.empty()) return found;
  throw InputError(SourceLocation{csv.path, 1},
                   "no column '" + name + "'" + suggestion(name, names_of(csv.head, name_of)));
}

bool has_number(const Csv& csv, const std::string& column) {
  if (column.empty()) return false;
  const std::size_t at = csv.column(column);
  for (std::size_t row = 0; row < csv.rows.size(); ++row)
    if (std::isfinite(csv.number(row, at))) return true;
  return false;
}

/// The first column of numbers from `from` on that are not all the same; "" if there is no such column.
std::string first_changing(const Csv& csv, std::size_t from) {
  for (std::size_t column = from; column < csv.head.size(); ++column) {
    std::set<double> values;
    try {
      for (std::size_t row = 0; row < csv.rows.size(); ++row)
        if (std::isfinite(csv.number(row, column))) values.insert(csv.number(row, column));
    } catch (const InputError&) {  // words
      continue;
    }
    if (values.size() > 1) return csv.head[column];
  }
  return "";
}

/// The first column of errors; without any, as of a scene that nothing is prescribed for, the first measure.
std::string first_error(const Csv& csv) {
  for (const std::string& column : csv.head)
    if (column.starts_with("error ") && has_number(csv, column)) return column;
  const std::size_t after_counts = csv.has("threads") ? csv.column("threads") + 1 : 0;
  for (std::size_t column = after_counts; column < csv.head.size(); ++column)
    if (has_number(csv, csv.head[column])) return csv.head[column];
  throw InputError(SourceLocation{csv.path, 1}, "no run has a measure; choose what to draw with --x and --y");
}

/// The default columns of the two axes.
std::pair<std::string, std::string> usual_columns(const Csv& csv) {
  if (csv.has("method") && csv.has("minimum_s") && csv.has("error")) return {"minimum_s", "error"};
  if (csv.has("strategy")) return {"solve", first_error(csv)};
  const bool in_time = csv.has("time [s]");
  const ResponseAxes chosen = choose_response(
      usual_response(in_time), [&](const std::string& name) { return has_number(csv, find_column(csv, name)); });
  if (!chosen.y.empty()) return {chosen.x == "load" ? "load_factor" : chosen.x, chosen.y};
  const std::string along = first_changing(csv, 0);
  const std::string up = along.empty() ? "" : first_changing(csv, csv.column(along) + 1);
  if (!up.empty()) return {along, up};
  throw InputError(SourceLocation{csv.path, 1},
                   "no columns that are drawn by themselves; choose some with --x and --y" + suggestion("", csv.head));
}

PlotAxis axis_of(const std::string& column, const Csv& csv) {
  const bool error = column == "error" || column.starts_with("error ");
  const bool logarithmic = csv.has("method") || (csv.has("strategy") && (error || unit_of(column) == "s"));
  return {name_of(column), error ? "%" : unit_of(column), logarithmic};
}

/// The names of a row's series: "method"; "strategy", with the scene where there are several; one curve has none.
std::vector<std::string> series_names(const Csv& csv) {
  std::vector<std::string> names(csv.rows.size());
  if (!csv.has("method") && !csv.has("strategy")) return names;
  const std::size_t name = csv.column(csv.has("method") ? "method" : "strategy");
  std::set<std::string> scenes;
  for (const auto& row : csv.rows)
    if (csv.has("strategy") && csv.has("scene")) scenes.insert(row[csv.column("scene")]);
  for (std::size_t row = 0; row < names.size(); ++row)
    names[row] = (scenes.size() > 1 ? csv.rows[row][csv.column("scene")] + ", " : "") + csv.rows[row][name];
  return names;
}

}  // namespace

Plot csv_plot(const std::string& path, std::string x, std::string y) {
  const Csv csv = load_csv(path);
  if (x.empty() || y.empty()) {
    const auto [along, up] = usual_columns(csv);
    if (x.empty()) x = along;
    if (y.empty()) y = up;
  }
  const std::string x_name = column_of(csv, x), y_name = column_of(csv, y);
  const std::size_t x_column = csv.column(x_name), y_column = csv.column(y_name);
  Plot plot;
  plot.title = path.substr(path.rfind('/') + 1);
  plot.x = axis_of(x_name, csv);
  plot.y = axis_of(y_name, csv);
  const std::vector<std::string> names = series_names(csv);
  // The curve of an experiment at rest has no row of the body without its load.
  const std::vector<ResponseAxes> known = usual_response(false);
  const bool from_zero =
      csv.has("load_factor") && std::any_of(known.begin(), known.end(), [&](const ResponseAxes& one) {
        return one.from_zero && (one.x == "load" ? "load_factor" : one.x) == plot.x.title && one.y == plot.y.title;
      });
  if (from_zero && !names.empty()) series_of(plot, names.front(), 0).points.push_back({0, 0, ""});
  const auto shown = [&](std::size_t row, std::size_t column, const PlotAxis& axis) {
    const double value = csv.number(row, column);
    return axis.logarithmic ? std::abs(value) : value;
  };
  for (std::size_t row = 0; row < csv.rows.size(); ++row) {
    series_of(plot, names[row], static_cast<int>(plot.series.size()))
        .points.push_back({shown(row, x_column, plot.x), shown(row, y_column, plot.y), names[row]});
  }
  return plot;
}

namespace {

constexpr int kPoints = 60;  // to either side of rest

/// One branch of a curve away from rest, up to a stress of this size: ranges that are stable or not, one series each.
/// Returns the largest stress.
double add_branch(const MaterialLaw& law, const Material& material, HomogeneousTest test, int colour, double end,
                  double most, Plot& plot) {
  const Matrix3 axes = axes_of_law(law, material);
  PlotSeries series{"", colour, PlotSeries::Kind::line, {{0, 0, name_of(test)}}};
  double largest = 0;
  for (int i = 1; i <= kPoints; ++i) {
    const double part = static_cast<double>(i) / kPoints;
    const double amount = test == HomogeneousTest::shear ? part * end : std::expm1(part * std::log1p(end));
    const auto state = homogeneous_state(law, material, test, amount, axes);
    if (!state || std::abs(state->stress) > most) break;
    largest = std::max(largest, std::abs(state->stress));
    const auto kind = state->stable ? PlotSeries::Kind::line : PlotSeries::Kind::dashed;
    if (kind != series.kind) {
      const PlotPoint joint = series.points.back();
      plot.series.push_back(std::exchange(series, {"", colour, kind, {joint}}));
    }
    series.points.push_back({amount, state->stress, name_of(test)});
  }
  plot.series.push_back(std::move(series));
  return largest;
}

}  // namespace

Plot material_plot(const std::string& title, const MaterialLaw& law, const Material& material, double stretch) {
  Plot plot;
  plot.title = title;
  plot.x = {"nominal strain, amount of shear", "", false};
  plot.y = {"nominal stress", "Pa", false};
  int colour = 0;
  for (const HomogeneousTest test : kHomogeneousTests) {
    const std::size_t first = plot.series.size();
    const double most = add_branch(law, material, test, colour, stretch - 1, INFINITY, plot);
    if (test != HomogeneousTest::shear) add_branch(law, material, test, colour, 1 / stretch - 1, most, plot);
    plot.series[first].name = name_of(test);
    ++colour;
  }
  bool unstable = false;
  for (const PlotSeries& series : plot.series) unstable |= series.kind == PlotSeries::Kind::dashed;
  if (unstable) plot.title += "; dashed: unstable (Drucker)";
  return plot;
}

}  // namespace elastin::lab
