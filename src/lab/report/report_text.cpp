#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lab/report/comparison.h"
#include "lab/report/table.h"

namespace elastin::lab {
namespace {

std::string head_text(const Record& record, bool with_target, bool colours) {
  std::string counts = counted(record.molecules, "molecule") + ", " + counted(record.connections, "connection");
  if (record.cell_sides)
    counts += fmt::format(" (+ {})", counted(record.cell_sides, "side of cells", "sides of cells"));
  if (record.cells) counts += ", " + counted(record.cells, "cell");
  if (with_target) counts += "; target: " + record.prescribed;
  counts += "; " + counted(record.threads, "thread");
  return painted(record.scene, Tone::bold, colours) + (record.title == record.scene ? "" : "  " + record.title) +
         "\n  " + painted(counts, Tone::faint, colours) + "\n";
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
  const double seconds = std::max(time.seconds, 1e-9), rate = time.simulated / seconds;
  std::string out = fmt::format(
      "  {}{}: {}{}, last {}{}; {:.4g} s simulated in {}{}\n", time.resumed ? "resumed, " : "", time.stepper,
      counted(time.steps, "step"), time.rejected ? fmt::format(" and {} rejected", time.rejected) : "",
      readable_seconds(time.last_step),
      time.critical_step > 0 && std::isfinite(time.critical_step)
          ? fmt::format(" (longest stable {}, ω_max {:.4g} rad/s)", readable_seconds(time.critical_step),
                        time.frequency)
          : "",
      time.simulated, readable_seconds(time.seconds),
      rate > 0 ? fmt::format(", {:.3g} steps a second, {:.3g} times {} than real time", time.steps / seconds,
                             rate < 1 ? 1 / rate : rate, rate < 1 ? "slower" : "faster")
               : "");
  if (time.budget) {
    const BudgetReport& own = *time.budget;
    out += fmt::format(
        "  budget of {}: {} to {} {} a step (median {}) in {} at the median, {} at most, {:.2g} % later; they "
        "leave molecules up to {} off where a step moves them by {}\n",
        readable_seconds(own.budget), own.least, own.most, own.effort, own.median, readable_seconds(own.median_seconds),
        readable_seconds(own.longest_seconds), 100 * own.late, readable(own.iteration_error, dimension::length, 3),
        readable(own.motion, dimension::length, 3));
  }
  if (!time.reason.empty()) out += "  " + time.stepper + " by default: " + time.reason + "\n";
  return out;
}

/// What touches in the last state, and what it took to find.
std::string contact_text(const contact::ContactReport& contact, const std::vector<std::string>& obstacles) {
  std::string out =
      fmt::format("  contact: {} pressed together, {} sticking, at most {} deep, {}", counted(contact.pairs, "pair"),
                  contact.sticking, readable(contact.largest_penetration, dimension::length, 3),
                  readable(contact.area, dimension::area, 4));
  for (std::size_t i = 0; i < obstacles.size(); ++i)
    if (contact.on_obstacles[i].norm() > 0)
      out += fmt::format(", {} on {}", readable(contact.on_obstacles[i].norm(), dimension::force), obstacles[i]);
  if (contact.between_pieces.norm() > 0)
    out += fmt::format(", {} between two pieces", readable(contact.between_pieces.norm(), dimension::force));
  return out + fmt::format("; broad phase {}, narrow {}\n", readable_seconds(contact.broad_seconds),
                           readable_seconds(contact.narrow_seconds));
}

/// Of a run in time ten rows and the telling columns, unless the whole is wanted; its file has all.
std::string curve_text(const Record& record, bool whole, bool colours) {
  const std::vector<CurvePoint>& points = record.run.curve;
  const bool in_time = record.run.time.has_value();
  std::vector<const MeasureInfo*> columns;
  for (const auto& [name, value] : points.back().measures.all()) {
    const MeasureInfo& info = record.measure(name);
    const bool detail = info.role == MeasureRole::detail || (in_time && info.role == MeasureRole::history);
    if (whole || !detail) columns.push_back(&info);
  }
  std::vector<std::string> head{in_time ? "time [s]" : "load"};
  for (const MeasureInfo* info : columns) head.push_back(info->label());
  head.push_back("Newton");
  Table table(head);
  const std::size_t every = in_time && !whole ? std::max<std::size_t>(1, (points.size() - 1) / 10) : 1;
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
  const Ranking ranking = rank_strategies(records);
  std::string out = head_text(records.front(), have_one_target(records), colours) + references_text(records, colours) +
                    "\n" + comparison_table(records, ranking).text(colours);
  const Table verdicts = verdicts_table(records);
  if (!verdicts.empty()) out += "\n" + verdicts.text(colours);
  const bool advised = records.size() > 1 && can_rank(records);
  if (advised || !ranking.no_reference.empty()) out += advice_text(ranking, colours);
  if (records.front().apparent)
    for (const std::string& note : records.front().notes)
      out += "  " + painted("note: " + note, Tone::faint, colours) + "\n";
  for (const Record& record : records) {
    const Run& run = record.run;
    if (!run.remark.empty())
      out += "  " + painted("remark: " + run.strategy + ": " + run.remark, Tone::faint, colours) + "\n";
    if (run.identified)
      out += "  " + painted("remark: " + run.strategy + ": " + identified_text(*run.identified), Tone::faint, colours) +
             "\n";
  }
  return out + "\n";
}

namespace {

std::string gradients_text(const Gradients& gradients, bool colours) {
  std::vector<std::string> head{"derivative, SI"};
  for (const auto& [key, slope] : gradients.front().second) head.push_back("by " + key);
  Table table(head);
  for (const auto& [measure, slopes] : gradients) {
    std::vector<TableCell> row{{"of " + measure}};
    for (const auto& [key, slope] : slopes) row.push_back({fmt::format("{:.6g}", slope), Tone::plain, true});
    row.resize(head.size());
    table.add(std::move(row));
  }
  return "\n" + table.text(colours);
}

std::string spreads_text(const Record& record, bool colours) {
  std::vector<std::string> head{"measure", "value", "deviation"};
  for (const auto& [key, share] : record.spreads.front().second)
    if (key != "deviation") head.push_back("from " + key);
  Table table(head);
  for (const auto& [measure, parts] : record.spreads) {
    const MeasureInfo& info = record.measure(measure);
    std::vector<TableCell> row{{measure}, {value_text(record.run.measures.get(measure), info, 6), Tone::plain, true}};
    for (const auto& [key, value] : parts)
      row.push_back({key == "deviation" ? "± " + value_text(value, info, 3) : fmt::format("{:.1f} %", 100 * value),
                     Tone::plain, true});
    row.resize(head.size());
    table.add(std::move(row));
  }
  return "\n" + table.text(colours);
}

}  // namespace

std::string run_text(const Record& record, bool colours, bool whole_curve) {
  const Run& run = record.run;
  std::string out = head_text(record, true, colours);
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
  if (run.cut_steps) out += fmt::format("  {} cut: a cell would have inverted\n", counted(run.cut_steps, "step"));
  if (run.calibration_factor != 1)
    out += fmt::format("  calibrated{}: spring constants times {:.6g}\n",
                       run.calibrated_to_reference ? " to the computed reference" : "", run.calibration_factor);
  if (run.volume_modulus != 0)
    out += fmt::format("  volume term: {}\n", readable(run.volume_modulus, dimension::pressure, 6));
  if (run.identified) out += "  " + identified_text(*run.identified) + "\n";
  if (run.bisected_load_steps)
    out +=
        "  " + counted(run.bisected_load_steps, "load step") +
        " bisected: a cell would have inverted, bodies have passed through each other, or no equilibrium was found\n";
  for (const std::string& note : record.notes) out += "  " + note + "\n";
  for (const std::string& warning : run.warnings)
    out += "  " + painted("warning: " + warning, Tone::poor, colours) + "\n";
  if (!run.remark.empty()) out += "  " + painted("remark: " + run.remark, Tone::poor, colours) + "\n";
  out += references_text({record}, colours);
  std::vector<std::string> head{"measure", "value", record.references.empty() ? "error" : "to the material"};
  if (!record.references.empty()) head.push_back("to reference");
  head.emplace_back();
  Table table(head);
  for (const auto& [name, value] : run.measures.all()) {
    const MeasureInfo& info = record.measure(name);
    const double error = record.error(name);
    const std::string off = !std::isfinite(error)          ? ""
                            : info.unit == dimension::none ? fmt::format("{:+.4f}", error)
                                                           : percent(error);
    std::vector<TableCell> row{
        {name}, {value_text(value, info, 6), Tone::plain, true}, {off, tone_of_error(error), true}};
    if (!record.references.empty()) {
      const double to_reference = record.error(name + "_to_reference");
      row.push_back({percent(to_reference), tone_of_error(to_reference), true});
    }
    std::string text = (record.is_apparent(info) ? "apparent: " : "") + info.text;
    if (const MainMeasure* target = record.law_target(name))
      text += "; target " + value_text(target->prescribed, info) + " at a strain of " + strain_text(target->strain);
    row.push_back({std::move(text), Tone::faint});
    table.add(std::move(row));
  }
  if (!table.empty()) out += "\n" + table.text(colours);
  if (!record.spreads.empty()) out += spreads_text(record, colours);
  if (!run.gradients.empty()) out += gradients_text(run.gradients, colours);
  if (run.measures.stiffness_matrix) out += stiffness_text(*run.measures.stiffness_matrix, colours);
  if (run.curve.size() > 1) out += curve_text(record, whole_curve, colours);
  const Table verdicts = verdicts_table({record});
  if (!verdicts.empty()) out += "\n" + verdicts.text(colours);
  return out + "\n";
}

}  // namespace elastin::lab
