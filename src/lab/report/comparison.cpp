#include "lab/report/comparison.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/base/named.h"
#include "elastin/core/base/error.h"
#include "lab/report/records.h"

namespace elastin::lab {
namespace {

/// Columns of one main measure: its value, its error against a reference, and against the material's own value where
/// there is one (a ratio's shows in the value; of the second and third modulus it says enough); the target where it is
/// a law's at a strain, and not the one at rest that stands above the table.
struct MeasureColumns {
  const MeasureInfo& info;
  bool value, target, error, reference;
  bool apparent;  ///< of the body's shape as well, not of the material alone
  std::string label() const { return (apparent ? "apparent " : "") + info.label(); }
};

std::vector<MeasureColumns> columns_of(const std::vector<Record>& records) {
  const auto any = [&](const auto& has) { return std::any_of(records.begin(), records.end(), has); };
  const bool failed = !any(solved);
  std::vector<MeasureColumns> columns;
  for (const MainMeasure& measure : records.front().main_measures) {
    const std::string& name = measure.name;
    const double prescribed = measure.prescribed;
    const MeasureInfo& info = records.front().measure(name);
    const std::string to_reference = name + "_to_reference";
    if (!failed && !any([&](const Record& r) { return std::isfinite(r.run.measures.get(info.name)); })) continue;
    const bool error = std::isfinite(prescribed) && info.unit != dimension::none;
    const bool reference = any([&](const Record& r) { return std::isfinite(r.error(to_reference)); });
    const bool apparent = any([&](const Record& r) { return r.is_apparent(info); });
    const bool target = any([&](const Record& r) { return r.law_target(name) != nullptr; });
    columns.push_back({info, columns.empty() || !error || reference, target, error, reference, apparent});
  }
  return columns;
}

std::vector<std::string> comparison_head(const std::vector<MeasureColumns>& columns) {
  std::vector<std::string> head{"strategy"};
  for (const MeasureColumns& column : columns) {
    if (column.value) head.push_back(column.label() + (column.error ? " measured" : ""));
    if (column.reference) head.push_back(column.label() + " to reference");
    if (column.error)
      head.push_back(column.reference ? "to the material's " + column.label() : "error of " + column.label());
    if (column.target) head.push_back(column.error ? "target at strain" : "its target");
  }
  return head;
}

std::vector<TableCell> comparison_row(const Record& record, const std::vector<MeasureColumns>& columns,
                                      const std::vector<std::string>& scattered, bool best) {
  const Run& run = record.run;
  std::vector<TableCell> row{{run.strategy, best ? Tone::bold : run.suited ? Tone::plain : Tone::faint}};
  for (const auto& [info, value, with_target, with_error, reference, apparent] : columns) {
    const std::string shown = row.size() > 1 || solved(record) ? value_text(run.measures.get(info.name), info) : "—";
    if (value) row.push_back(number_cell(shown, run.measures.get(info.name)));
    const double error = record.error(info.name), off = record.error(info.name + "_to_reference");
    if (reference) row.push_back(number_cell(percent(off), std::abs(off), tone_of_error(off)));
    if (with_error)
      row.push_back(number_cell(percent(error), std::abs(error), reference ? Tone::faint : tone_of_error(error)));
    if (with_target) {
      const MainMeasure* target = record.law_target(info.name);
      row.push_back({!target      ? ""
                     : with_error ? value_text(target->prescribed, info) + " at " + strain_text(target->strain)
                                  : value_text(target->prescribed, info),
                     Tone::faint, true});
    }
  }
  for (const std::string& measure : scattered) row.push_back(scatter_cell(record, {measure}));
  row.push_back(number_cell(run.suited ? fmt::format("{} / {}", run.newton_iterations, run.linear_iterations) : "",
                            run.linear_iterations));
  for (const double seconds : {run.build_seconds, run.solve_seconds})
    row.push_back(number_cell(run.suited ? readable_seconds(seconds) : "", seconds));
  row.push_back({notes_of(record), solved(record) ? Tone::poor : run.suited ? Tone::bad : Tone::faint});
  return row;
}

}  // namespace

Tone tone_of_error(double error) {
  const double size = std::abs(error);
  return size <= 1e-3 ? Tone::good : size <= kNear ? Tone::plain : size <= 0.25 ? Tone::poor : Tone::bad;
}

Tone tone_of_scatter(double error) {
  return !(error <= 4) ? Tone::bad : error <= 1 ? Tone::good : error <= 2 ? Tone::plain : Tone::poor;
}

std::vector<std::string> scattered_measures(const std::vector<Record>& records) {
  std::vector<std::string> measures;
  for (const Record& record : records)
    for (const Reference& reference : record.references)
      if (reference.scatter > 0)
        found_or_added(
            measures, [&](const auto& m) { return m == reference.measure; }, reference.measure);
  return measures;
}

TableCell scatter_cell(const Record& record, const std::vector<std::string>& measures) {
  double largest = std::nan("");
  for (const std::string& measure : measures) largest = std::fmax(largest, record.error(measure + "_over_scatter"));
  if (solved(record) && std::isfinite(largest))
    return number_cell(fmt::format("{:.2f}", largest), largest, tone_of_scatter(largest));
  return {scattered_measures({record}).empty() ? "" : outcome_text(record.run), Tone::faint, true};
}

std::string value_text(double value, const MeasureInfo& info, int digits) {
  const bool tiny = info.unit == dimension::none && std::abs(value) > 1e-14 && std::abs(value) < 0.1;
  return tiny ? fmt::format("{:.5g}", value) : readable(value, info, digits);
}

std::string outcome_text(const Run& run) {
  std::string text = run.suited ? name_of(run.outcome) : "not suited";
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

namespace {

/// A warning without what stands in brackets or behind a semicolon.
std::string short_warning(const std::string& warning) {
  std::string first = warning.substr(0, warning.find_first_of(";("));
  first.erase(first.find_last_not_of(' ') + 1);
  return first;
}

}  // namespace

std::string notes_of(const Record& record) {
  const Run& run = record.run;
  std::string notes = solved(record) ? "" : outcome_text(run) + ": " + run.cause;
  if (run.calibrated_to_reference)
    notes +=
        fmt::format("{}calibrated to the reference by × {:.4g}", notes.empty() ? "" : "; ", run.calibration_factor);
  for (const std::string& warning : run.warnings) notes += (notes.empty() ? "" : "; ") + short_warning(warning);
  return notes;
}

bool can_rank(const std::vector<Record>& records) {
  if (records.empty()) return false;
  const std::vector<MeasureColumns> columns = columns_of(records);
  return std::any_of(columns.begin(), columns.end(),
                     [](const MeasureColumns& c) { return c.error || c.reference || c.apparent; });
}

Table comparison_table(const std::vector<Record>& records, const Ranking& ranking) {
  const std::vector<MeasureColumns> columns = columns_of(records);
  const std::vector<std::string> scattered = scattered_measures(records);
  std::vector<std::string> head = comparison_head(columns);
  for (const std::string& measure : scattered)
    head.push_back("error of " + records.front().measure(measure).label() + " / scatter");
  head.insert(head.end(), {"iterations", "build", "solve", ""});
  Table table(std::move(head));
  const auto best = [&](const Record& record) {
    return &record == ranking.best ||
           std::find(ranking.tied.begin(), ranking.tied.end(), &record) != ranking.tied.end();
  };
  for (const Record& record : records)
    table.add(comparison_row(record, columns, scattered, best(record)),
              {record.run.strategy, outcome_text(record.run)});
  return table;
}

Table verdicts_table(const std::vector<Record>& records) {
  std::vector<std::pair<const Record*, const Verdict*>> verdicts;
  for (const Record& record : records)
    for (const Verdict& verdict : record.verdicts) verdicts.emplace_back(&record, &verdict);
  Table table({"strategy", "measure", "expected", "measured", "difference", "", "source"});
  for (const auto& [record, verdict] : verdicts) {
    if (!verdict->expectation.outcome.empty()) {
      table.add({{verdict->strategy},
                 {"outcome"},
                 {verdict->expectation.outcome},
                 {""},
                 {""},
                 {verdict->passed ? "passed" : "failed", verdict->passed ? Tone::good : Tone::bad},
                 {verdict->expectation.source, Tone::faint}});
      continue;
    }
    const MeasureInfo& info = record->measure(verdict->expectation.measure);
    const bool missing = !std::isfinite(verdict->measured);
    const Tone tone = !verdict->judged ? Tone::faint : verdict->passed ? Tone::good : Tone::bad;
    table.add({{verdict->strategy},
               {verdict->expectation.measure},
               {readable(verdict->expectation.value, info, 6), Tone::plain, true},
               {missing ? "none" : readable(verdict->measured, info, 6), Tone::plain, true},
               {percent(verdict->difference), Tone::plain, true},
               {!verdict->judged  ? "not reproduced"
                : verdict->passed ? "passed"
                                  : "failed",
                tone},
               {verdict->expectation.source + (verdict->judged ? "" : ": " + verdict->expectation.not_reproduced),
                Tone::faint}});
  }
  return table;
}

namespace {

/// Errors of the recommended strategy, and of those tied with it, in other directions; "" where not requested.
std::string directions_text(const Ranking& ranking) {
  const Record& best = *ranking.best;
  if (!best.directions) return "";
  const std::string said = direction_text(*best.directions);
  std::string text = "\n    in other directions, by small strains of the surface: " + said;
  for (const Record* record : ranking.tied)
    if (const std::string of_tied = record->directions ? direction_text(*record->directions) : said; of_tied != said)
      text += "; of " + record->run.strategy + ": " + of_tied;
  const double strain = std::abs(best.run.measures.get(best.measure(MeasureRole::strain)));
  if (strain > 0) text += "; nothing was run beyond a strain of " + percent(strain).substr(1);
  return text;
}

}  // namespace

namespace {

/// "E +0.1 %, torsional stiffness -2.0 %": the errors that count.
std::string errors_text(const Ranking& ranking, const Record& record) {
  return joined(ranking.measures, [&](const std::string& name) {
    const double error = record.error(ranking.error_name(name));
    return record.measure(name).label() + " " +
           (ranking.by_scatter ? fmt::format("{:.2f} × the scatter of the specimens", error) : percent(error));
  });
}

/// Whether what has a warning comes nearer than anything without one, and nothing is recommended.
bool warned_is_nearer(const Ranking& ranking) {
  return ranking.warned && !ranking.recommends() &&
         (!ranking.best || ranking.error(*ranking.warned) < ranking.error(*ranking.best));
}

std::string warned_text(const Ranking& ranking) {
  if (!warned_is_nearer(ranking)) return "";
  return "\n    " + ranking.warned->run.strategy + " comes to " + errors_text(ranking, *ranking.warned) +
         ", with a warning: " + short_warning(ranking.warned->run.warnings.front());
}

}  // namespace

std::string advice_text(const Ranking& ranking, bool colours) {
  const Record* best = ranking.best;
  if (!ranking.no_reference.empty()) return "\n  no reference: " + ranking.no_reference + "\n";
  if (!best) return "\n  no recommendation: each strategy failed or has a warning" + warned_text(ranking) + "\n";
  if (!ranking.rival_targets.empty()) {
    std::string laws = best->run.strategy;
    for (const Record* record : ranking.tied) laws += ", " + record->run.strategy;
    return "\n  no recommendation: " + laws + " each meet their own target, " + ranking.rival_targets +
           " at this strain, and the material states E and nu alone; state its `law` or `curve`\n";
  }
  const auto label_of = [&](const std::string& name) { return best->measure(name).label(); };
  std::string found = errors_text(ranking, *best);
  if (ranking.by_reference && !ranking.by_scatter) found += " to the reference";
  for (const auto& [name, prescribed, strain] : best->main_measures) {
    const MeasureInfo& info = best->measure(name);
    const double value = best->run.measures.get(name);
    const bool modulus = info.unit != dimension::none;
    const bool counted = std::find(ranking.measures.begin(), ranking.measures.end(), name) != ranking.measures.end();
    if (counted || ranking.by_scatter || !std::isfinite(prescribed) || (modulus && !std::isfinite(value))) continue;
    found += ", " + info.label() + " " +
             (!std::isfinite(value) ? "not measured"
              : modulus             ? percent(best->error(name))
                                    : value_text(value, info));
  }
  std::string passed_over;
  for (const auto& [record, why] : ranking.passed_over)
    passed_over += "\n    not " + record->run.strategy + ", which is nearer and faster: " + why;
  std::string tied;
  for (const Record* record : ranking.tied) tied += (tied.empty() ? " (tied with " : ", ") + record->run.strategy;
  if (!tied.empty()) tied += ")";
  return fmt::format("\n  {} {}{}: {} (target: {}), {}{}{}{}\n",
                     ranking.recommends() ? "recommended:"
                                          : fmt::format("no strategy{} is near {}; the nearest is",
                                                        warned_is_nearer(ranking) ? " without a warning" : "",
                                                        joined(ranking.measures, label_of)),
                     painted(best->run.strategy, Tone::bold, colours), tied, found, best->target_text(),
                     readable_seconds(best->run.build_seconds + best->run.solve_seconds), warned_text(ranking),
                     passed_over, directions_text(ranking));
}

namespace {

/// Smaller changes are of the last digits that the solver's tolerance leaves open.
constexpr double kSame = 1e-9, kClose = 1e-3;

const Record* same_run(const std::vector<Record>& records, const Record& wanted) {
  const auto found = std::find_if(records.begin(), records.end(), [&](const Record& r) {
    return r.scene == wanted.scene && r.run.strategy == wanted.run.strategy && r.variant == wanted.variant;
  });
  return found == records.end() ? nullptr : &*found;
}

std::string outcome_change(const Record& then, const Record& now) {
  const std::string was = outcome_text(then.run), is = outcome_text(now.run);
  return was == is ? "" : was + " → " + is;
}

}  // namespace

std::vector<Record> load_baseline(const std::string& folder) {
  const std::string path = folder + "/runs.jsonl";
  std::ifstream stream(path);
  if (!stream)
    throw InputError("--baseline: " + path +
                     " cannot be read; a folder that `compare --out` or `run --out` wrote has it");
  std::vector<Record> records;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    try {
      const auto entry = nlohmann::ordered_json::parse(line, nullptr, false);  // what a journal writes
      if (!entry.is_object() || !entry.contains("run")) throw InputError("not an Elastin run record");
      Record record = record_of_json(entry["run"].dump());
      if (const Record* known = same_run(records, record))
        records[known - records.data()].add_repeat(record);
      else
        records.push_back(std::move(record));
    } catch (const InputError& error) {
      throw InputError(SourceLocation{path, number}, error.what());
    }
  }
  return records;
}

Table change_table(const std::vector<Record>& records, const std::vector<Record>& baseline) {
  Table table({"strategy", "measure", "then", "now", "change", "time then", "time now", "ratio", ""});
  for (const Record& record : records) {
    const Record* then = same_run(baseline, record);
    if (!then) continue;
    const double before = then->least_seconds(), seconds = record.least_seconds();
    for (const auto& [name, prescribed, strain] : record.main_measures) {
      const MeasureInfo& info = record.measure(name);
      const double was = then->run.measures.get(info.name), is = record.run.measures.get(info.name);
      if (!std::isfinite(was) && !std::isfinite(is) && outcome_change(*then, record).empty()) continue;
      const double change = was == is ? 0 : (is - was) / std::abs(was);
      const Tone tone = std::abs(change) <= kSame ? Tone::faint : std::abs(change) <= kClose ? Tone::plain : Tone::poor;
      table.add({{run_name(record)},
                 {info.label()},
                 number_cell(value_text(was, info), was),
                 number_cell(value_text(is, info), is),
                 number_cell(std::abs(change) <= kSame ? "none" : percent(change), std::abs(change), tone),
                 number_cell(readable_seconds(before), before),
                 number_cell(readable_seconds(seconds), seconds),
                 number_cell(before > 0 ? fmt::format("{:.2f}", seconds / before) : "", seconds / before),
                 {outcome_change(*then, record), Tone::bad}});
    }
  }
  return table;
}

}  // namespace elastin::lab
