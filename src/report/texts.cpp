#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/ranking.h"
#include "report/table.h"

namespace elastin {
namespace {

/// An error of E up to here is fit for use.
constexpr double kNear = 0.05;

Tone tone_of_error(double error) {
  const double size = std::abs(error);
  return size <= 1e-3 ? Tone::good : size <= kNear ? Tone::plain : size <= 0.25 ? Tone::poor : Tone::bad;
}

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
    if (!verdict->expectation.outcome.empty()) {
      table.add({{verdict->strategy},
                 {"outcome"},
                 {verdict->expectation.outcome},
                 {""},
                 {""},
                 {verdict->holds ? "holds" : "FAILS", verdict->holds ? Tone::good : Tone::bad},
                 {verdict->expectation.source, Tone::faint}});
      continue;
    }
    const MeasureInfo& info = find_measure(verdict->expectation.measure);
    const bool missing = !std::isfinite(verdict->measured);
    const Tone tone = !verdict->judged ? Tone::faint : verdict->holds ? Tone::good : Tone::bad;
    table.add({{verdict->strategy},
               {verdict->expectation.measure},
               {readable(verdict->expectation.value, info, 6), Tone::plain, true},
               {missing ? "none" : readable(verdict->measured, info, 6), Tone::plain, true},
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

/// A measure's value; small ratios with digits that tell them from nothing.
std::string value_text(double value, const MeasureInfo& info, int digits = 5) {
  const bool tiny = info.unit == dimension::none && std::abs(value) > 1e-14 && std::abs(value) < 0.1;
  return tiny ? fmt::format("{:.5g}", value) : readable(value, info, digits);
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

/// Columns of one main measure: its value, its error against the material's own where there is one (a ratio's shows in
/// the value; of the second and third modulus it says enough), and against a reference.
struct MeasureColumns {
  const MeasureInfo& info;
  bool value, error, reference;
};

std::vector<MeasureColumns> columns_of(const std::vector<Record>& records) {
  const auto any = [&](const auto& has) { return std::any_of(records.begin(), records.end(), has); };
  const bool failed = !any(solved);
  std::vector<MeasureColumns> columns;
  for (const auto& [name, prescribed] : records.front().main_measures) {
    const MeasureInfo& info = find_measure(std::string(name));
    const std::string to_reference = std::string(name) + "_to_reference";
    if (!failed && !any([&](const Record& r) { return std::isfinite(r.run.measures.get(info.name)); })) continue;
    const bool error = std::isfinite(prescribed) && info.unit != dimension::none;
    const bool reference = any([&](const Record& r) { return std::isfinite(r.error(to_reference)); });
    columns.push_back({info, columns.empty() || !error || reference, error, reference});
  }
  return columns;
}

std::vector<std::string> comparison_head(const std::vector<MeasureColumns>& columns) {
  std::vector<std::string> head{"strategy"};
  for (const auto& [info, value, error, reference] : columns) {
    if (value) head.push_back(info.label() + (error ? " measured" : ""));
    if (error) head.push_back("error of " + info.label());
    if (reference) head.push_back("to reference");
  }
  for (const char* name : {"iterations", "build", "solve", ""}) head.push_back(name);
  return head;
}

std::vector<TableCell> comparison_row(const Record& record, const std::vector<MeasureColumns>& columns, bool best) {
  const Run& run = record.run;
  std::vector<TableCell> row{{run.strategy, best ? Tone::bold : run.suited ? Tone::plain : Tone::faint}};
  for (const auto& [info, value, with_error, reference] : columns) {
    const std::string shown = row.size() > 1 || solved(record) ? value_text(run.measures.get(info.name), info) : "—";
    if (value) row.push_back({shown, Tone::plain, true});
    const double error = record.error(info.name);
    if (with_error) row.push_back({percent(error), tone_of_error(error), true});
    if (reference) row.push_back({percent(record.error(std::string(info.name) + "_to_reference")), Tone::plain, true});
  }
  row.push_back(
      {run.suited ? fmt::format("{} / {}", run.newton_iterations, run.linear_iterations) : "", Tone::plain, true});
  row.push_back({run.suited ? readable_seconds(run.build_seconds) : "", Tone::plain, true});
  row.push_back({run.suited ? readable_seconds(run.solve_seconds) : "", Tone::plain, true});
  row.push_back({notes_of(record), solved(record) ? Tone::poor : run.suited ? Tone::bad : Tone::faint});
  return row;
}

/// "take lattice: E +0.001 %, Poisson's ratio 0.2500 (asked: …), 3 ms".
std::string advice_text(const Ranking& ranking, bool colours) {
  const Record* best = ranking.best;
  if (!best) return "\n  none to take: each one failed or has a warning\n";
  std::string found, goal;
  for (const std::string& name : ranking.measures) {
    const std::string label = find_measure(name).label(), comma = found.empty() ? "" : ", ";
    found += comma + label + " " + percent(best->error(ranking.error_name(name)));
    goal += comma + label;
  }
  if (ranking.by_reference) found += " to the reference";
  for (const auto& [name, prescribed] : best->main_measures) {
    const MeasureInfo& info = find_measure(std::string(name));
    const double value = best->run.measures.get(name);
    const bool modulus = info.unit != dimension::none;
    const bool told = std::find(ranking.measures.begin(), ranking.measures.end(), name) != ranking.measures.end();
    if (told || !std::isfinite(prescribed) || (modulus && !std::isfinite(value))) continue;
    found += ", " + info.label() + " " +
             (!std::isfinite(value) ? "not measured"
              : modulus             ? percent(best->error(name))
                                    : value_text(value, info));
  }
  return fmt::format("\n  {} {}: {} (asked: {}), {}\n",
                     ranking.error(*best) <= kNear ? "take" : "none is near " + goal + "; the nearest is",
                     painted(best->run.strategy, Tone::bold, colours), found, best->prescribed,
                     readable_seconds(best->run.build_seconds + best->run.solve_seconds));
}

std::string stiffness_text(const Stiffness6& stiffness, bool colours) {
  constexpr const char* directions[] = {"xx", "yy", "zz", "yz", "xz", "xy"};
  std::vector<std::string> head{"stiffness"};
  for (const char* direction : directions) head.push_back(direction);
  Table table(head);
  const double negligible = 1e-9 * stiffness.cwiseAbs().maxCoeff();
  for (int row = 0; row < 6; ++row) {
    std::vector<TableCell> cells{{directions[row]}};
    for (int column = 0; column < 6; ++column) {
      const double value = stiffness(row, column);
      const bool nothing = std::abs(value) < negligible;
      cells.push_back(
          {nothing ? "0" : readable(value, dimension::pressure), nothing ? Tone::faint : Tone::plain, true});
    }
    table.add(std::move(cells));
  }
  return "\n" + table.text(colours);
}

/// How time went: "2000 steps of 0.5 ms (ω 3600 rad/s …)".
std::string time_text(const TimeReport& time) {
  const double rate = time.simulated / time.seconds;
  std::string out = fmt::format(
      "  {}{}: {}{}, last {}{}; {:.4g} s simulated in {}, {:.3g} steps a second, {:.3g} times {} than real time\n",
      time.resumed ? "resumed, " : "", time.scheme, counted(time.steps, "step"),
      time.rejected ? fmt::format(" and {} gone again", time.rejected) : "", readable_seconds(time.last_step),
      time.critical_step > 0 && std::isfinite(time.critical_step)
          ? fmt::format(" (longest stable {}, ω_max {:.4g} rad/s)", readable_seconds(time.critical_step),
                        time.frequency)
          : "",
      time.simulated, readable_seconds(time.seconds), time.steps / time.seconds, rate < 1 ? 1 / rate : rate,
      rate < 1 ? "slower" : "faster");
  if (!time.reason.empty()) out += "  " + time.scheme + " by default: " + time.reason + "\n";
  return out;
}

/// What touches in the last state, and what it took to find.
std::string contact_text(const ContactReport& contact, const std::vector<std::string>& obstacles) {
  std::string out =
      fmt::format("  contact: {} pressed together, {} sticking, at most {} deep, {}", counted(contact.pairs, "pair"),
                  contact.sticking, readable(contact.largest_penetration, dimension::length, 3),
                  readable(contact.area, dimension::area, 4));
  for (std::size_t i = 0; i < obstacles.size(); ++i)
    if (contact.on_obstacles[i].norm() > 0)
      out += fmt::format(", {} on {}", readable(contact.on_obstacles[i].norm(), dimension::force), obstacles[i]);
  if (contact.between_pieces.norm() > 0)
    out += fmt::format(", {} between pieces", readable(contact.between_pieces.norm(), dimension::force));
  return out + fmt::format("; broad phase {}, narrow {}\n", readable_seconds(contact.broad_seconds),
                           readable_seconds(contact.narrow_seconds));
}

/// Of a run in time every tenth part of it, and what tells it apart; its file has all.
std::string curve_text(const std::vector<CurvePoint>& points, bool in_time, bool colours) {
  std::vector<const MeasureInfo*> columns;
  std::vector<std::string_view> left_out{"energy", "reaction_balance"};
  if (in_time)
    left_out.insert(left_out.end(), {"potential_energy", "dissipated_energy", "work", "momentum", "angular_momentum",
                                     "centre_way", "lateral_strain"});
  for (const auto& [name, value] : points.back().measures.all())
    if (std::find(left_out.begin(), left_out.end(), name) == left_out.end()) columns.push_back(&find_measure(name));
  std::vector<std::string> head{in_time ? "time [s]" : "load"};
  for (const MeasureInfo* info : columns) head.push_back(info->label());
  head.push_back("Newton");
  Table table(head);
  const std::size_t every = in_time ? std::max<std::size_t>(1, (points.size() - 1) / 10) : 1;
  for (std::size_t i = 0; i < points.size(); i += every) {
    const CurvePoint& point = points[i];
    std::vector<TableCell> row{{fmt::format("{:.4g}", in_time ? point.time : point.load_factor), Tone::plain, true}};
    for (const MeasureInfo* info : columns)
      row.push_back({value_text(point.measures.get(info->name), *info), Tone::plain, true});
    row.push_back({std::to_string(point.newton_iterations), Tone::plain, true});
    table.add(std::move(row));
  }
  return "\n" + table.text(colours);
}

/// "identified: E = 1.8 MPa - 2.1 MPa e + ... up to a strain of 0.8; misfit 0.4 % (52 load curves)"
std::string identified_text(const Identified& found) {
  std::string law;
  for (std::size_t k = 0; k < found.polynomial.size(); ++k) {
    const double c = found.polynomial[k];
    law += (k == 0 ? (c < 0 ? "-" : "") : c < 0 ? " - " : " + ") + readable(std::abs(c), dimension::pressure, 5);
    if (k > 0) law += k == 1 ? " e" : fmt::format(" e^{}", k);
  }
  std::string text = fmt::format("identified: E(e) = {}, up to a strain e of {:.4g}; misfit {:.3g} %, {}", law,
                                 found.up_to, 100 * found.misfit, counted(found.evaluations, "load curve"));
  if (found.standard_errors.size() == 3)
    text += fmt::format("; E {}, {}, {} at e = 0, {:.3g}, {:.3g}, standard errors {}, {}, {}",
                        readable(found.modulus(0), dimension::pressure),
                        readable(found.modulus(found.up_to / 2), dimension::pressure),
                        readable(found.modulus(found.up_to), dimension::pressure), found.up_to / 2, found.up_to,
                        readable(found.standard_errors[0], dimension::pressure, 2),
                        readable(found.standard_errors[1], dimension::pressure, 2),
                        readable(found.standard_errors[2], dimension::pressure, 2));
  return text;
}

}  // namespace

std::string comparison_text(const std::vector<Record>& records, bool colours) {
  if (records.empty()) return "";
  const std::vector<MeasureColumns> columns = columns_of(records);
  Table table(comparison_head(columns));
  const Ranking ranking = rank_strategies(records);
  for (const Record& record : records) table.add(comparison_row(record, columns, &record == ranking.best));
  std::string out = head_text(records.front(), colours) + "\n" + table.text(colours);
  std::vector<const Verdict*> verdicts;
  std::vector<std::string> remarks;
  for (const Record& record : records) {
    for (const Verdict& verdict : record.verdicts) verdicts.push_back(&verdict);
    if (!record.run.remark.empty()) remarks.push_back(record.run.strategy + ": " + record.run.remark);
    if (record.run.identified) remarks.push_back(record.run.strategy + ": " + identified_text(*record.run.identified));
  }
  out += verdicts_text(verdicts, colours);
  const auto can_rank = [](const MeasureColumns& c) { return c.error || c.reference; };
  if (records.size() > 1 && std::any_of(columns.begin(), columns.end(), can_rank)) out += advice_text(ranking, colours);
  for (const std::string& remark : remarks) out += "  " + painted("remark: " + remark, Tone::faint, colours) + "\n";
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
  if (!run.solver_reason.empty()) out += fmt::format("  solver: {}: {}\n", run.solver, run.solver_reason);
  if (run.time) out += time_text(*run.time);
  if (run.contact) out += contact_text(*run.contact, record.obstacles);
  if (run.cut_steps) out += fmt::format("  {} cut: a cell would have turned over\n", counted(run.cut_steps, "step"));
  if (run.calibration_factor != 1)
    out += fmt::format("  calibrated: spring constants times {:.6g}\n", run.calibration_factor);
  if (run.volume_modulus != 0)
    out += fmt::format("  volume term: {}\n", readable(run.volume_modulus, dimension::pressure, 6));
  if (run.identified) out += "  " + identified_text(*run.identified) + "\n";
  if (run.halved_load_steps)
    out += "  " + counted(run.halved_load_steps, "load step") + " gone in halves: a cell would have turned over\n";
  for (const std::string& note : record.notes) out += "  " + note + "\n";
  for (const std::string& warning : run.warnings)
    out += "  " + painted("warning: " + warning, Tone::poor, colours) + "\n";
  if (!run.remark.empty()) out += "  " + painted("remark: " + run.remark, Tone::poor, colours) + "\n";
  Table table({"measure", "value", "error", ""});
  for (const auto& [name, value] : run.measures.all()) {
    const MeasureInfo& info = find_measure(name);
    const double error = record.error(name);
    const std::string off = !std::isfinite(error)          ? ""
                            : info.unit == dimension::none ? fmt::format("{:+.4f}", error)
                                                           : percent(error);
    table.add({{name},
               {value_text(value, info, 6), Tone::plain, true},
               {off, tone_of_error(error), true},
               {std::string(info.text), Tone::faint}});
  }
  if (!table.empty()) out += "\n" + table.text(colours);
  if (run.measures.stiffness_matrix) out += stiffness_text(*run.measures.stiffness_matrix, colours);
  if (run.curve.size() > 1) out += curve_text(run.curve, run.time.has_value(), colours);
  std::vector<const Verdict*> verdicts;
  for (const Verdict& verdict : record.verdicts) verdicts.push_back(&verdict);
  out += verdicts_text(verdicts, colours);
  return out + "\n";
}

}  // namespace elastin
