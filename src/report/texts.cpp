#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "report/table.h"

namespace elastin {
namespace {

/// An error of E up to here is fit for use.
constexpr double kNear = 0.05;

Tone tone_of_error(double error) {
  const double size = std::abs(error);
  return size <= 1e-3 ? Tone::good : size <= kNear ? Tone::plain : size <= 0.25 ? Tone::poor : Tone::bad;
}

double error_of(const Record& record, const std::string& name) {
  for (const auto& [known, value] : record.errors)
    if (known == name) return value;
  return std::nan("");
}

bool solved(const Record& record) { return record.run.suited && record.run.outcome == Outcome::converged; }

std::string head_text(const Record& record, bool colours) {
  std::string counts = counted(record.molecules, "molecule") + ", " + counted(record.connections, "connection");
  if (record.cell_sides)
    counts += fmt::format(" (+ {})", counted(record.cell_sides, "side of cells", "sides of cells"));
  if (record.cells) counts += ", " + counted(record.cells, "cell");
  counts += "; asked: " + record.prescribed + "; " + counted(record.threads, "thread");
  return painted(record.scene, Tone::bold, colours) + (record.title == record.scene ? "" : "  " + record.title) +
         "\n  " + painted(counts, Tone::faint, colours) + "\n";
}

std::string verdicts_text(const std::vector<const Verdict*>& verdicts, bool colours) {
  if (verdicts.empty()) return "";
  Table table({"strategy", "measure", "expected", "here", "difference", "", "source"});
  for (const Verdict* verdict : verdicts) {
    const Dimension unit = find_measure(verdict->expectation.measure).unit;
    const bool missing = !std::isfinite(verdict->measured);
    const Tone tone = !verdict->judged ? Tone::faint : verdict->holds ? Tone::good : Tone::bad;
    table.add({{verdict->strategy},
               {verdict->expectation.measure},
               {readable(verdict->expectation.value, unit, 6), Tone::plain, true},
               {missing ? "none" : readable(verdict->measured, unit, 6), Tone::plain, true},
               {percent(verdict->difference), Tone::plain, true},
               {!verdict->judged ? "not reproduced"
                : verdict->holds ? "holds"
                                 : "FAILS",
                tone},
               {verdict->expectation.source + (verdict->judged ? "" : ": " + verdict->expectation.not_reproduced),
                Tone::faint}});
  }
  return "\n" + table.text(colours);
}

/// "limit reached", "not suited": an outcome in words.
std::string outcome_text(const Run& run) {
  std::string text = run.suited ? name_of(run.outcome) : "not suited";
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

/// What a row says beside its numbers: why there are none, and the first words of each warning.
std::string notes_of(const Record& record) {
  const Run& run = record.run;
  std::string notes = solved(record) ? "" : outcome_text(run) + ": " + run.cause;
  for (const std::string& warning : run.warnings) {
    std::string first = warning.substr(0, warning.find_first_of(";("));
    first.erase(first.find_last_not_of(' ') + 1);
    notes += (notes.empty() ? "" : "; ") + first;
  }
  return notes;
}

/// The strategy to take: near enough to E (0.1 %, or the best there is), nothing to warn of; then the nearest Poisson's
/// ratio; then the fastest.
const Record* best_of(const std::vector<Record>& records) {
  double least = INFINITY;
  for (const Record& record : records)
    if (solved(record) && record.run.warnings.empty())
      least = std::min(least, std::abs(error_of(record, "effective_modulus")));
  const Record* best = nullptr;
  const auto rank = [](const Record& record) {
    const double nu = error_of(record, "poissons_ratio");
    return std::tuple{std::isfinite(nu) ? std::round(std::abs(nu) * 1000) : 1e9,
                      record.run.build_seconds + record.run.solve_seconds};
  };
  for (const Record& record : records) {
    if (!solved(record) || !record.run.warnings.empty()) continue;
    if (!(std::abs(error_of(record, "effective_modulus")) <= std::max(1e-3, least))) continue;
    if (!best || rank(record) < rank(*best)) best = &record;
  }
  return best;
}

}  // namespace

std::string comparison_text(const std::vector<Record>& records, bool colours) {
  if (records.empty()) return "";
  const bool referenced = std::isfinite(error_of(records.front(), "effective_modulus_to_reference"));
  std::vector<std::string> head{
      "strategy", "E measured", "error of E", "Poisson's ratio", "elongation", "iterations", "build", "solve", ""};
  if (referenced) head.insert(head.begin() + 3, "to reference");
  Table table(head);
  const Record* best = best_of(records);
  for (const Record& record : records) {
    const Run& run = record.run;
    const double error = error_of(record, "effective_modulus");
    std::vector<TableCell> row{
        {run.strategy, &record == best ? Tone::bold
                       : run.suited    ? Tone::plain
                                       : Tone::faint},
        {solved(record) ? readable(run.measures.get("effective_modulus"), dimension::pressure) : "—", Tone::plain,
         true},
        {percent(error), tone_of_error(error), true},
        {readable(run.measures.get("poissons_ratio"), dimension::none), Tone::plain, true},
        {readable(run.measures.get("elongation"), dimension::length), Tone::plain, true},
        {run.suited ? fmt::format("{} / {}", run.newton_iterations, run.linear_iterations) : "", Tone::plain, true},
        {run.suited ? readable_seconds(run.build_seconds) : "", Tone::plain, true},
        {run.suited ? readable_seconds(run.solve_seconds) : "", Tone::plain, true},
        {notes_of(record), solved(record) ? Tone::poor
                           : run.suited   ? Tone::bad
                                          : Tone::faint}};
    if (referenced)
      row.insert(row.begin() + 3, {percent(error_of(record, "effective_modulus_to_reference")), Tone::plain, true});
    table.add(std::move(row));
  }
  std::string out = head_text(records.front(), colours) + "\n" + table.text(colours);
  std::vector<const Verdict*> verdicts;
  for (const Record& record : records)
    for (const Verdict& verdict : record.verdicts) verdicts.push_back(&verdict);
  out += verdicts_text(verdicts, colours);
  if (!best && records.size() > 1) out += "\n  none to take: each one failed or has a warning\n";
  if (best && records.size() > 1) {
    const double error = error_of(*best, "effective_modulus"), nu = best->run.measures.get("poissons_ratio");
    out += fmt::format("\n  {} {}: E {}, Poisson's ratio {} (asked: {}), {}\n",
                       std::abs(error) <= kNear ? "take" : "none is near E; the nearest is",
                       painted(best->run.strategy, Tone::bold, colours), percent(error),
                       std::isfinite(nu) ? readable(nu, dimension::none) : "not measured", best->prescribed,
                       readable_seconds(best->run.build_seconds + best->run.solve_seconds));
  }
  return out + "\n";
}

std::string run_text(const Record& record, bool colours) {
  const Run& run = record.run;
  std::string out = head_text(record, colours);
  out += fmt::format(
      "  {}: {}\n", run.strategy,
      solved(record) ? outcome_text(run) : painted(outcome_text(run) + ": " + run.cause, Tone::bad, colours));
  if (!run.solver.empty())
    out += fmt::format("  {}, {}, {} linear, residual {:.1e}, built in {}, solved in {}\n", run.solver,
                       counted(run.newton_iterations, "Newton iteration"), run.linear_iterations, run.residual,
                       readable_seconds(run.build_seconds), readable_seconds(run.solve_seconds));
  if (run.calibration_factor != 1)
    out += fmt::format("  calibrated: spring constants times {:.6g}\n", run.calibration_factor);
  if (run.volume_modulus != 0)
    out += fmt::format("  volume term: {}\n", readable(run.volume_modulus, dimension::pressure, 6));
  for (const std::string& warning : run.warnings)
    out += "  " + painted("warning: " + warning, Tone::poor, colours) + "\n";
  Table table({"measure", "value", "error", ""});
  for (const auto& [name, value] : run.measures.all()) {
    const MeasureInfo& info = find_measure(name);
    const double error = error_of(record, name);
    const std::string off = !std::isfinite(error)      ? ""
                            : name == "poissons_ratio" ? fmt::format("{:+.4f}", error)
                                                       : percent(error);
    const bool tiny = info.unit == dimension::none && std::abs(value) > 1e-14 && std::abs(value) < 0.1;
    table.add({{name},
               {tiny ? fmt::format("{:.5g}", value) : readable(value, info.unit, 6), Tone::plain, true},
               {off, tone_of_error(error), true},
               {std::string(info.text), Tone::faint}});
  }
  if (!table.empty()) out += "\n" + table.text(colours);
  if (run.curve.size() > 1) {
    Table curve({"load", "force", "elongation", "strain", "stress", "E secant", "Newton"});
    for (const CurvePoint& point : run.curve)
      curve.add({{fmt::format("{:.4g}", point.load_factor), Tone::plain, true},
                 {readable(point.measures.get("force"), dimension::force), Tone::plain, true},
                 {readable(point.measures.get("elongation"), dimension::length), Tone::plain, true},
                 {fmt::format("{:.5g} %", 100 * point.measures.get("strain")), Tone::plain, true},
                 {readable(point.measures.get("stress"), dimension::pressure), Tone::plain, true},
                 {readable(point.measures.get("effective_modulus"), dimension::pressure), Tone::plain, true},
                 {std::to_string(point.newton_iterations), Tone::plain, true}});
    out += "\n" + curve.text(colours);
  }
  std::vector<const Verdict*> verdicts;
  for (const Verdict& verdict : record.verdicts) verdicts.push_back(&verdict);
  out += verdicts_text(verdicts, colours);
  return out + "\n";
}

}  // namespace elastin
