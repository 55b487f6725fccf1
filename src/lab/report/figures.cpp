#include "lab/report/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/named.h"
#include "elastin/core/simulation/strategy_name.h"
#include "lab/format/csv.h"

namespace elastin::lab {
namespace {

/// Smaller errors are reported, but not drawn to scale: they are the solver's tolerance, not the strategy's.
constexpr double kFoot = 1e-7;

/// The points that no other one beats in both time and error, fastest first.
PlotSeries front_of(const std::vector<PlotSeries>& series) {
  PlotSeries front{"", -1, PlotSeries::Kind::staircase, {}};
  std::vector<PlotPoint> points;
  for (const PlotSeries& one : series)
    for (const PlotPoint& point : one.points) points.push_back({point.x, point.y, ""});
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
  for (const PlotPoint& point : points)
    if (front.points.empty() || point.y < front.points.back().y) front.points.push_back(point);
  return front;
}

/// Family of a strategy, and its number in it: "calibrated:lattice+volume" is lattice, 3.
std::pair<std::string, int> family_of(const std::string& strategy) {
  const StrategyName name(strategy);
  if (name.of_membrane()) return {name.law(), kPlotShades - 1};
  return {name.rule, (name.calibrated || name.fitted ? 1 : 0) + (name.volume || name.wrinkling ? 2 : 0)};
}

bool measured(const std::vector<Record>& records, const std::string& name) {
  return std::any_of(records.begin(), records.end(), [&](const Record& record) {
    return !record.run.curve.empty() && std::isfinite(record.run.curve.back().measures.get(name));
  });
}

/// Those of the first figure, and of others that show measure over measure, by number; none beyond them.
ResponseAxes response_axes_of(const std::vector<Record>& records, std::size_t number) {
  const Record& first = records.front();
  std::vector<ResponseAxes> axes =
      first.measures ? first.measures->response : usual_response(first.run.time.has_value());
  const auto has = [&](const std::string& name) { return measured(records, name); };
  if (number > 0) {
    const ResponseAxes drawn = choose_response(axes, has);
    std::erase_if(axes, [&](const ResponseAxes& one) {
      return one.x == "load" || one.x == "time" || (one.x == drawn.x && one.y == drawn.y) || !has(one.x) || !has(one.y);
    });
    axes.erase(axes.begin(), axes.begin() + static_cast<std::ptrdiff_t>(std::min(number - 1, axes.size())));
  }
  return choose_response(axes, has);
}

/// Whether the points of a time history lie decades apart.
bool spans_decades(const std::vector<CurvePoint>& history) {
  if (history.size() < 4) return false;
  const std::size_t last = history.size() - 1;
  return history[last].time - history[last - 1].time > 100 * (history[1].time - history[0].time);
}

PlotAxis axis_of(const Record& record, const std::string& name) {
  if (name == "time") return {"time", "s"};
  if (name == "load") return {"share of the load", ""};
  const MeasureInfo& info = record.measure(name);
  const bool share = info.role == MeasureRole::strain || info.role == MeasureRole::share;
  return {info.label(), share ? "%" : info.unit_text()};
}

/// The stress of the material's own law or curve at the strains of all runs.
std::vector<PlotPoint> curve_of_material(const std::vector<Record>& records) {
  std::vector<PlotPoint> points;
  for (const Record& record : records)
    for (const CurvePoint& point : record.run.curve)
      if (const double stress = point.measures.get(record.measure(MeasureRole::material_stress)); std::isfinite(stress))
        points.push_back({point.measures.get(record.measure(MeasureRole::strain)), stress, ""});
  if (points.empty()) return points;
  points.push_back({0, 0, ""});
  std::sort(points.begin(), points.end(), [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
  return points;
}

/// Target of the material: its own curve, or without one a line through the origin.
void add_target(Plot& plot, const ResponseAxes& axes, const std::vector<Record>& records) {
  const Record& first = records.front();
  if (axes.x != first.measure(MeasureRole::strain) || axes.y != first.measure(MeasureRole::stress)) return;
  if (std::vector<PlotPoint> own = curve_of_material(records); !own.empty()) {
    plot.series.push_back({"target", -1, PlotSeries::Kind::dashed, std::move(own)});
    return;
  }
  if (first.main_measures.empty()) return;
  const auto& [name, prescribed, strain] = first.main_measures.front();
  const MeasureRole role = first.measure(name).role;
  if (first.law_target(name)) return;  // of a law that is no line
  if (!std::isfinite(prescribed) || (role != MeasureRole::youngs_modulus && role != MeasureRole::shear_modulus)) return;
  double low = 0, high = 0;  // no further than the others go in either direction
  for (const PlotSeries& series : plot.series)
    for (const PlotPoint& point : series.points) {
      low = std::min(low, std::max(point.x, point.y / prescribed));
      high = std::max(high, std::min(point.x, point.y / prescribed));
    }
  plot.series.push_back(
      {"target", -1, PlotSeries::Kind::dashed, {{low, low * prescribed, ""}, {high, high * prescribed, ""}}});
}

}  // namespace

std::vector<ResponseAxes> usual_response(bool in_time) {
  std::vector<ResponseAxes> axes;
  for (ResponseAxes one : built_in_measures().response) {
    if (in_time && one.x == "load") one.x = "time";
    if (in_time == (one.x == "time")) axes.push_back(std::move(one));
  }
  return axes;
}

ResponseAxes choose_response(const std::vector<ResponseAxes>& axes,
                             const std::function<bool(const std::string& measure)>& has) {
  const auto drawn = std::find_if(axes.begin(), axes.end(), [&](const ResponseAxes& one) {
    return (one.x == "load" || one.x == "time" || has(one.x)) && has(one.y);
  });
  return drawn == axes.end() ? ResponseAxes{} : *drawn;
}

std::vector<Peer> load_peers(const std::string& path) {
  const Csv csv = load_csv(path);
  const std::size_t name = csv.column("method"), seconds = csv.column("minimum_s"), error = csv.column("error");
  std::vector<Peer> peers;
  for (std::size_t row = 0; row < csv.rows.size(); ++row) {
    Peer peer{csv.has("scene") ? csv.rows[row][csv.column("scene")] : "", csv.rows[row][name], csv.number(row, seconds),
              csv.number(row, error)};
    if (std::isfinite(peer.seconds) && std::isfinite(peer.error)) peers.push_back(std::move(peer));
  }
  return peers;
}

std::map<std::string, int> strategy_colours(const std::vector<Record>& records) {
  std::map<std::string, int> colours, families;
  std::vector<char> taken(static_cast<std::size_t>(kPlotHues * kPlotShades), 0);
  const auto take = [&](const std::string& name, int wanted) {
    if (colours.contains(name)) return;
    std::size_t at = static_cast<std::size_t>(wanted);
    if (std::find(taken.begin(), taken.end(), 0) != taken.end())
      while (taken[at]) at = (at + 1) % taken.size();
    taken[at] = 1;
    colours[name] = static_cast<int>(at);
  };
  for (const Record& record : records) {
    const auto [family, shade] = family_of(record.run.strategy);
    const int hue = families.try_emplace(family, static_cast<int>(families.size())).first->second % kPlotHues;
    take(record.run.strategy, hue + kPlotHues * shade);
  }
  int next = 0;  // runs of a study: each another hue
  for (const StudyCurve& curve : curves_of(records)) {
    take(curve.name, next);
    next = (next + 1) % static_cast<int>(taken.size());
  }
  for (const Record& record : records)
    if (!record.variant.empty()) {
      take(run_name(record), next);
      next = (next + 1) % static_cast<int>(taken.size());
    }
  return colours;
}

Plot error_plot(const std::vector<Record>& records, const Ranking& ranking, const std::map<std::string, int>& colours,
                const std::vector<Peer>& peers) {
  Plot plot;
  if (records.empty() || ranking.measures.empty()) return plot;
  const std::string of =
      joined(ranking.measures, [&](const std::string& name) { return records.front().measure(name).label(); });
  plot.title = records.front().title + ": error of " + of + " against time";
  plot.x = {"time: build and solve", "s", true};
  plot.y = {"error of " + of + (ranking.by_reference ? ", to the reference" : ""), "%", true};
  if (ranking.by_scatter) {
    plot.y = {"error of " + of + " over the scatter", "", true};
    plot.level = 1, plot.level_text = "the scatter of the specimens";
  }
  const auto point_of = [&](double seconds, double error, const std::string& name, const std::string& more) {
    return PlotPoint{seconds, std::max(error, kFoot),
                     fmt::format("{}: error {}, {}{}", name,
                                 ranking.by_scatter ? fmt::format("{:.3g} × the scatter", error)
                                                    : fmt::format("{:.3g} %", 100 * error),
                                 readable_seconds(seconds), more)};
  };
  for (const StudyCurve& curve : curves_of(records)) {
    PlotSeries series{curve.name,
                      colours.at(curve.name),
                      curve.rows.size() > 1 ? PlotSeries::Kind::marked_line : PlotSeries::Kind::marks,
                      {}};
    for (const Record* record : curve.rows)
      if (has_own_error(*record) && std::isfinite(ranking.error(*record)))
        series.points.push_back(point_of(record->least_seconds(), ranking.error(*record), curve.name,
                                         ", " + counted(record->molecules, "molecule")));
    if (!series.points.empty()) plot.series.push_back(std::move(series));
  }
  for (const Peer& peer : peers) {
    if (!peer.scene.empty() && peer.scene != records.front().scene) continue;
    const auto greys = std::count_if(plot.series.begin(), plot.series.end(), [](auto& one) { return one.colour < 0; });
    series_of(plot, peer.name, -1 - static_cast<int>(greys))
        .points.push_back(point_of(peer.seconds, peer.error, peer.name, " (given by a file)"));
  }
  if (!plot.series.empty()) plot.series.insert(plot.series.begin(), front_of(plot.series));
  for (const Reference& reference : records.front().references)
    if (ranking.by_reference && reference.uncertainty > 0 && !(reference.uncertainty < plot.level)) {
      plot.level = reference.uncertainty;
      plot.level_text = "the reference is known to this";
    }
  return plot;
}

Plot response_plot(const std::vector<Record>& records, const std::map<std::string, int>& colours, std::size_t number) {
  Plot plot;
  const ResponseAxes response = response_axes_of(records, number);
  if (response.x.empty()) return plot;
  plot.x = axis_of(records.front(), response.x);
  plot.x.logarithmic = response.x == "time" && std::all_of(records.begin(), records.end(), [](const Record& record) {
                         return spans_decades(record.run.curve);
                       });
  plot.y = axis_of(records.front(), response.y);
  if (!response.y_title.empty()) plot.y.title = response.y_title;
  plot.title = records.front().title + ": " + plot.y.title + " over " + plot.x.title;
  std::vector<std::pair<std::string, const Record*>> drawn;  // every run, or of many that refine a body the finest
  constexpr std::size_t most_runs = 24;
  for (const StudyCurve& curve : curves_of(records))
    if (records.size() > most_runs || curve.rows.size() == 1)
      drawn.emplace_back(curve.name, curve.rows.back());
    else
      for (const Record* record : curve.rows) drawn.emplace_back(run_name(*record), record);
  for (const auto& [name, of] : drawn) {
    const Record& record = *of;
    PlotSeries series{name, colours.at(name), PlotSeries::Kind::line, {}};
    if (response.from_zero) series.points.push_back({0, 0, ""});
    for (const CurvePoint& point : record.run.curve) {
      const PlotPoint at{along(point, response.x), along(point, response.y), ""};
      if (std::isfinite(at.x) && std::isfinite(at.y)) series.points.push_back(at);
    }
    const bool short_curve = series.points.size() <= 24;
    if (short_curve) series.kind = PlotSeries::Kind::marked_line;
    if (series.points.size() > (response.from_zero ? 1u : 0u)) plot.series.push_back(std::move(series));
  }
  if (!plot.series.empty() && have_one_target(records)) add_target(plot, response, records);
  for (const Reference& reference : records.front().references)
    if (reference.along == response.x && reference.measure == response.y && !plot.series.empty()) {
      PlotSeries measured{"measured", -1, PlotSeries::Kind::marks, {}};
      PlotSeries low{"± standard deviation", -1, PlotSeries::Kind::dashed, {}}, high = low;
      high.name.clear();
      for (const auto& [at, value, deviation] : reference.points) {
        measured.points.push_back({at, value, ""});
        low.points.push_back({at, value - deviation, ""});
        high.points.push_back({at, value + deviation, ""});
      }
      plot.series.insert(plot.series.end(), {measured, low, high});
    }
  return plot;
}

}  // namespace elastin::lab
