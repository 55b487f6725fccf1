#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "report/table.h"

namespace elastin {
namespace {

Tone tone_of_error(double error) {
  const double size = std::abs(error);
  return size <= 1e-3 ? Tone::good : size <= 0.05 ? Tone::plain : size <= 0.25 ? Tone::poor : Tone::bad;
}

double error_of(const Record& record, const std::string& name) {
  for (const auto& [known, value] : record.errors)
    if (known == name) return value;
  return std::nan("");
}

bool solved(const Record& record) { return record.run.suited && record.run.outcome == Outcome::converged; }

std::string head_text(const Record& record, bool colours) {
  std::string counts = fmt::format("{} molecules, {} connections", record.molecules, record.connections);
  if (record.cells) counts += fmt::format(", {} cells", record.cells);
  return painted(record.scene, Tone::bold, colours) + "  " + (record.title == record.scene ? "" : record.title) + "\n" +
         painted(fmt::format("  {}; asked: {}; {} thread{}", counts, record.prescribed, record.threads,
                             record.threads == 1 ? "" : "s"),
                 Tone::faint, colours) +
         "\n";
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

std::string notes_of(const Run& run) {
  std::string notes = run.outcome != Outcome::converged ? std::string(name_of(run.outcome)) + ": " + run.cause : "";
  for (const std::string& warning : run.warnings) notes += (notes.empty() ? "" : "; ") + warning;
  return notes;
}

/// The strategy to take: near enough to E (0.1 %, or the best there is), no mechanism; then the nearest Poisson's
/// ratio; then the fastest.
const Record* best_of(const std::vector<Record>& records) {
  double least = INFINITY;
  for (const Record& record : records)
    if (solved(record) && record.run.zero_energy_modes == 0)
      least = std::min(least, std::abs(error_of(record, "effective_modulus")));
  const Record* best = nullptr;
  const auto rank = [](const Record& record) {
    const double nu = error_of(record, "poissons_ratio");
    return std::tuple{std::isfinite(nu) ? std::round(std::abs(nu) * 1000) : 1e9,
                      record.run.build_seconds + record.run.solve_seconds};
  };
  for (const Record& record : records) {
    if (!solved(record) || record.run.zero_energy_modes > 0) continue;
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
    if (!run.suited) {
      table.add({{run.strategy, Tone::faint}, {"—", Tone::faint, true}, {run.cause, Tone::faint}});
      continue;
    }
    const double error = error_of(record, "effective_modulus");
    std::vector<TableCell> row{
        {run.strategy, &record == best ? Tone::bold : Tone::plain},
        {solved(record) ? readable(run.measures.get("effective_modulus"), dimension::pressure) : "—", Tone::plain,
         true},
        {percent(error), tone_of_error(error), true},
        {readable(run.measures.get("poissons_ratio"), dimension::none), Tone::plain, true},
        {readable(run.measures.get("elongation"), dimension::length), Tone::plain, true},
        {fmt::format("{} / {}", run.newton_iterations, run.linear_iterations), Tone::plain, true},
        {readable_seconds(run.build_seconds), Tone::plain, true},
        {readable_seconds(run.solve_seconds), Tone::plain, true},
        {notes_of(run), solved(record) ? Tone::poor : Tone::bad}};
    if (referenced)
      row.insert(row.begin() + 3, {percent(error_of(record, "effective_modulus_to_reference")), Tone::plain, true});
    table.add(std::move(row));
  }
  std::string out = head_text(records.front(), colours) + "\n" + table.text(colours);
  std::vector<const Verdict*> verdicts;
  for (const Record& record : records)
    for (const Verdict& verdict : record.verdicts) verdicts.push_back(&verdict);
  out += verdicts_text(verdicts, colours);
  if (best && records.size() > 1)
    out += fmt::format("\n  take {}: E {}, Poisson's ratio {} (asked: {}), {}\n",
                       painted(best->run.strategy, Tone::bold, colours), percent(error_of(*best, "effective_modulus")),
                       std::isfinite(best->run.measures.get("poissons_ratio"))
                           ? readable(best->run.measures.get("poissons_ratio"), dimension::none)
                           : "not measured",
                       best->prescribed, readable_seconds(best->run.build_seconds + best->run.solve_seconds));
  return out + "\n";
}

std::string run_text(const Record& record, bool colours) {
  const Run& run = record.run;
  std::string out = head_text(record, colours);
  out += fmt::format("  {}: {}{}, {} Newton and {} linear iterations, residual {:.1e}, built in {}, solved in {}\n\n",
                     run.strategy, run.suited ? name_of(run.outcome) : "cannot run here: " + run.cause,
                     run.solver.empty() ? "" : " by " + run.solver, run.newton_iterations, run.linear_iterations,
                     run.residual, readable_seconds(run.build_seconds), readable_seconds(run.solve_seconds));
  Table table({"measure", "value", "error", ""});
  for (const auto& [name, value] : run.measures.all()) {
    const MeasureInfo& info = find_measure(name);
    const double error = error_of(record, name);
    const std::string off = !std::isfinite(error)      ? ""
                            : name == "poissons_ratio" ? fmt::format("{:+.4f}", error)
                                                       : percent(error);
    const bool tiny = info.unit == dimension::none && value != 0 && std::abs(value) < 0.001;
    table.add({{name},
               {tiny ? fmt::format("{:.4e}", value) : readable(value, info.unit, 6), Tone::plain, true},
               {off, tone_of_error(error), true},
               {std::string(info.text), Tone::faint}});
  }
  if (!table.empty()) out += table.text(colours);
  if (run.curve.size() > 1) {
    Table curve({"load", "force", "elongation", "strain", "stress", "E secant", "Newton"});
    for (const CurvePoint& point : run.curve)
      curve.add({{fmt::format("{:.4g}", point.load_factor), Tone::plain, true},
                 {readable(point.measures.get("force"), dimension::force), Tone::plain, true},
                 {readable(point.measures.get("elongation"), dimension::length), Tone::plain, true},
                 {percent(point.measures.get("strain")), Tone::plain, true},
                 {readable(point.measures.get("stress"), dimension::pressure), Tone::plain, true},
                 {readable(point.measures.get("effective_modulus"), dimension::pressure), Tone::plain, true},
                 {std::to_string(point.newton_iterations), Tone::plain, true}});
    out += "\n" + curve.text(colours);
  }
  std::vector<const Verdict*> verdicts;
  for (const Verdict& verdict : record.verdicts) verdicts.push_back(&verdict);
  out += verdicts_text(verdicts, colours);
  if (!run.cause.empty() && run.suited)
    out += "\n  " + painted(std::string(name_of(run.outcome)) + ": " + run.cause, Tone::bad, colours) + "\n";
  for (const std::string& warning : run.warnings)
    out += "  " + painted("warning: " + warning, Tone::poor, colours) + "\n";
  return out + "\n";
}

}  // namespace elastin
