#include "lab/report/stepper_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "elastin/lab/run/measures.h"
#include "lab/report/page.h"
#include "lab/report/plot.h"
#include "lab/report/table.h"

namespace elastin::lab {
namespace {

/// What counts as the body's modulus, and as its motion.
constexpr double kSameModulus = 0.01, kSameMotion = 0.05;
/// Smaller errors are not drawn to scale: they are rounding.
constexpr double kLeastShown = 1e-9;

bool got_through(const StepperRow& row) { return row.suited && row.outcome == Outcome::converged; }

TableCell error_cell(double error) {
  if (!std::isfinite(error)) return number_cell("", error);
  const double size = std::abs(error);
  const std::string text = size < 1e-8 ? "0 %" : fmt::format("{:.2g} %", 100 * error);
  return number_cell(text, size, size <= kSameModulus ? Tone::good : size <= kSameMotion ? Tone::plain : Tone::poor);
}

std::string readable_value(const MeasureInfo& measure, double value) {
  return std::isfinite(value) ? readable(value, measure) : "";
}

std::string iterations_text(const StepperRow& row) {
  if (row.substeps > 0) return counted(row.substeps, "substep");
  return row.iterations > 0 ? std::to_string(row.iterations) : "converged";
}

std::string remark_of(const StepperRow& row) {
  if (!row.suited) return "unsuited: " + row.cause;
  if (row.outcome != Outcome::converged) return std::string(name_of(row.outcome)) + ": " + row.cause;
  return row.settled ? "" : "not yet at rest";
}

Table table_of(const StepperComparison& comparison) {
  std::vector<std::string> head{"stepper", "iterations", "step"};
  for (const MeasureInfo& measure : comparison.measures) head.push_back(measure.label());
  for (const char* name : {"error at rest", "of iterations", "of time", "energy", "a step", ""})
    head.emplace_back(name);
  Table table(head);
  for (const StepperRow& row : comparison.rows) {
    std::vector<TableCell> cells{{row.stepper},
                                 number_cell(iterations_text(row), row.iterations),
                                 number_cell(readable(row.step, dimension::time, 3), row.step)};
    for (std::size_t i = 0; i < comparison.measures.size(); ++i) {
      const double value = i < row.at_rest.size() ? row.at_rest[i] : NAN;
      cells.push_back(number_cell(readable_value(comparison.measures[i], value), value));
    }
    cells.push_back(error_cell(row.rest_error));
    cells.push_back(error_cell(row.iteration_error));
    cells.push_back(error_cell(row.time_error));
    cells.push_back(number_cell(std::isfinite(row.energy) ? fmt::format("{:+.2g} %", 100 * row.energy) : "", row.energy,
                                row.energy > kSameModulus ? Tone::bad : Tone::plain));
    cells.push_back(number_cell(std::isfinite(row.seconds) ? readable_seconds(row.seconds) : "", row.seconds));
    const std::string said = remark_of(row);
    cells.push_back({said, got_through(row) ? Tone::faint : Tone::bad});
    table.add(std::move(cells));
  }
  return table;
}

/// Time of one period.
double cost(const StepperComparison& comparison, const StepperRow& row) {
  return row.seconds * comparison.period / row.step;
}

std::string best_of(const StepperComparison& comparison) {
  const StepperRow* best = nullptr;
  for (const StepperRow& row : comparison.rows)
    if (got_through(row) && std::abs(row.rest_error) <= kSameModulus && row.time_error <= kSameMotion &&
        (!best || cost(comparison, row) < cost(comparison, *best)))
      best = &row;
  if (!best) return "no row is within 1 % of the equilibrium and 5 % of the motion: shorter steps or more iterations";
  return fmt::format("least time within 1 % of the equilibrium and 5 % of the motion: {}, {}{}, steps of {}: {} a step",
                     best->stepper, iterations_text(*best), best->iterations > 0 ? " iterations" : "",
                     readable(best->step, dimension::time, 3), readable_seconds(best->seconds));
}

Plot plot_of(const StepperComparison& comparison, bool at_rest) {
  Plot plot;
  plot.title = comparison.title + (at_rest ? ": error at rest against time" : ": error of the motion against time");
  plot.x = {"time of one period", "s", true};
  plot.y = {at_rest ? "error of " + comparison.measures.front().label() + " at rest"
                    : "error of the motion to the limit of short steps",
            "%", true};
  std::map<std::string, int> colours;
  for (const StepperRow& row : comparison.rows) {
    const int colour = colours.try_emplace(row.stepper, static_cast<int>(colours.size())).first->second;
    const double error = at_rest ? std::abs(row.rest_error) : row.time_error;
    if (!got_through(row) || !std::isfinite(error)) continue;
    const std::string name = fmt::format("{}, {}", row.stepper, readable(row.step, dimension::time, 3));
    series_of(plot, name, colour)
        .points.push_back({cost(comparison, row), std::max(error, kLeastShown),
                           fmt::format("{}, {}: error {:.3g} %, {} a step", name, iterations_text(row), 100 * error,
                                       readable_seconds(row.seconds))});
  }
  plot.level = at_rest ? kSameModulus : kSameMotion;
  plot.level_text = at_rest ? "1 %" : "5 %";
  return plot;
}

nlohmann::ordered_json json_of(const StepperComparison& comparison) {
  nlohmann::ordered_json out{
      {"scene", comparison.scene},     {"title", comparison.title},         {"strategy", comparison.strategy},
      {"machine", comparison.machine}, {"molecules", comparison.molecules}, {"connections", comparison.connections},
      {"cells", comparison.cells},     {"threads", comparison.threads},     {"period", comparison.period}};
  for (std::size_t i = 0; i < comparison.measures.size(); ++i)
    out["equilibrium"][comparison.measures[i].name] = comparison.equilibrium[i];
  out["rows"] = nlohmann::ordered_json::array();
  for (const StepperRow& row : comparison.rows) {
    nlohmann::ordered_json one{{"stepper", row.stepper},
                               {"iterations", row.iterations},
                               {"step", row.step},
                               {"substeps", row.substeps},
                               {"outcome", row.suited ? name_of(row.outcome) : "unsuited"},
                               {"cause", row.cause},
                               {"settled", row.settled}};
    for (std::size_t i = 0; i < comparison.measures.size() && i < row.at_rest.size(); ++i)
      one["at_rest"][comparison.measures[i].name] = row.at_rest[i];
    one["rest_error"] = row.rest_error;
    one["iteration_error"] = row.iteration_error;
    one["time_error"] = row.time_error;
    one["energy"] = row.energy;
    one["seconds_per_step"] = row.seconds;
    out["rows"].push_back(std::move(one));
  }
  return out;
}

std::string heading_of(const StepperComparison& comparison) {
  std::string text = fmt::format("{}: {} molecules, {}, period {}", comparison.scene, comparison.molecules,
                                 comparison.strategy, readable(comparison.period, dimension::time, 3));
  for (std::size_t i = 0; i < comparison.measures.size(); ++i)
    text += fmt::format(", {} {} at equilibrium", comparison.measures[i].label(),
                        readable_value(comparison.measures[i], comparison.equilibrium[i]));
  return text;
}

constexpr const char* kMeaning =
    "Error at rest: of the body that came to rest under its load by this stepper, to its equilibrium. Of iterations: "
    "of the motion after release, to the same steps solved in full. Of time: to the limit of short steps. Energy: what "
    "the motion gains or loses in one period.";

}  // namespace

std::string stepper_text(const StepperComparison& comparison, bool colours) {
  std::string text = "\n" + painted(comparison.title, Tone::bold, colours) + "\n  " + heading_of(comparison) + "\n" +
                     table_of(comparison).text(colours) + "  " + best_of(comparison) + "\n";
  for (const std::string& warning : comparison.warnings) text += "  warning: " + warning + "\n";
  return text;
}

std::string stepper_json(const std::vector<StepperComparison>& comparisons) {
  nlohmann::ordered_json out;
  out["steppers"] = nlohmann::ordered_json::array();
  for (const StepperComparison& comparison : comparisons) out["steppers"].push_back(json_of(comparison));
  return out.dump(2) + "\n";
}

std::string stepper_page(const std::vector<StepperComparison>& comparisons, const std::string& command) {
  std::string out = page_begin("Steppers", "Elastin · steppers side by side") + "</header>\n<main>\n";
  for (const StepperComparison& comparison : comparisons) {
    out += fmt::format("<article class=\"scene\"><h1>{}</h1><p class=\"faint\">{}</p>\n<p class=\"advice\">{}</p>\n",
                       escaped(comparison.title), escaped(heading_of(comparison)), escaped(best_of(comparison)));
    out += "<div class=\"pair\">";
    for (const bool at_rest : {false, true})
      if (const Plot plot = plot_of(comparison, at_rest); !plot.series.empty())
        out += figure_html(plot, at_rest ? "Error at rest against time" : "Error of the motion against time",
                           comparison.scene + (at_rest ? "-rest" : "-motion"));
    out += "</div>\n" + card_html("All rows", table_of(comparison).html() + "<p class=\"note\">" + kMeaning + "</p>") +
           "</article>\n";
  }
  return out + page_end(comparisons.empty() ? "" : comparisons.front().machine, command);
}

}  // namespace elastin::lab
