#include "lab/report/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "elastin/core/simulation/strategy_name.h"
#include "lab/report/table.h"

namespace elastin::lab {
namespace {

/// From here on a molecule has connections enough to be judged by the goal.
constexpr double kEnoughNeighbours = 12;

/// Against the material's value, or where the specimen does not show that, against the reference; of a Poisson's ratio
/// the difference.
double error_of(const Record& record, MeasureRole role) {
  const std::string measure = record.measure(role);
  if (record.no_reference.empty()) return record.error(measure);
  for (const Reference& reference : record.references)
    if (reference.measure == measure && reference.certain())
      return record.error(measure + "_to_reference") *
             (record.measure(measure).unit == dimension::none ? reference.value : 1);
  return std::nan("");
}

bool judged(const Record& record) {
  return record.no_reference.empty() || std::isfinite(error_of(record, MeasureRole::youngs_modulus));
}

/// Solved, by a body that stands for itself: no mechanism, no negative constant, a minimum of the energy, some modulus.
bool sound(const Record& record) {
  const Run& run = record.run;
  return solved(record) && run.zero_energy_modes == 0 && !run.unstable &&
         record.error(record.measure(MeasureRole::youngs_modulus)) > -0.99 &&
         (run.constants.size() == 0 || run.constants.minCoeff() >= 0);
}

double whole_seconds(const Run& run) { return run.build_seconds + run.solve_seconds; }

ErrorSpread spread_of(const std::vector<const Record*>& runs, MeasureRole measure) {
  ErrorSpread spread{std::nan(""), std::nan(""), ""};
  std::vector<double> sizes;
  for (const Record* record : runs) {
    const double size = std::abs(error_of(*record, measure));
    if (!std::isfinite(size)) continue;
    sizes.push_back(size);
    if (!(size <= spread.worst)) spread.worst = size, spread.worst_scene = record->scene;
  }
  spread.median = median(std::move(sizes));
  return spread;
}

/// How far a run is from the goals, the further of the two; a body that shows no Poisson's ratio is judged by E alone.
double distance_from_goal(const Record& record) {
  const double modulus = std::abs(error_of(record, MeasureRole::youngs_modulus)) / kModulusGoal;
  return std::fmax(modulus, std::abs(error_of(record, MeasureRole::poissons_ratio)) / kRatioGoal);
}

bool within_goal(const Record& record) { return distance_from_goal(record) <= 1; }

const Record* best_of(const std::vector<const Record*>& runs, const std::function<bool(const Run&)>& counts) {
  const auto rank = [](const Record& record) {
    return std::pair{std::round(1000 * distance_from_goal(record)), record.run.order};
  };
  const Record* best = nullptr;
  for (const Record* record : runs)
    if (sound(*record) && judged(*record) && counts(record->run) && std::isfinite(distance_from_goal(*record)) &&
        (!best || rank(*record) < rank(*best)))
      best = record;
  return best;
}

/// Runs in groups of one key, in the order in which the keys first come.
template <class Key>
std::vector<std::vector<const Record*>> grouped(const std::vector<Record>& records, const Key& key) {
  std::vector<std::vector<const Record*>> groups;
  for (const Record& record : records) {
    const auto same = [&](const auto& other) { return key(*other.front()) == key(record); };
    found_or_added(groups, same, {}).push_back(&record);
  }
  return groups;
}

StrategySummary summary_of(const std::vector<const Record*>& runs, const std::vector<Record>& all) {
  StrategySummary summary;
  summary.strategy = runs.front()->run.strategy;
  std::vector<const Record*> good;
  std::vector<double> solve, whole;
  for (const Record* record : runs) {
    ++summary.bodies;
    summary.unsuited += !record->run.suited;
    summary.failed += record->run.suited && !solved(*record);
    summary.mechanisms += record->run.zero_energy_modes > 0;
    summary.uses_cells |= record->run.uses_cells;
    if (!solved(*record)) continue;
    if (judged(*record)) good.push_back(record);
    const auto standard = std::find_if(all.begin(), all.end(), [&](const Record& other) {
      return other.path == record->path && other.run.strategy == "standard" && solved(other);
    });
    if (standard == all.end()) continue;
    solve.push_back(record->run.solve_seconds / standard->run.solve_seconds);
    whole.push_back(whole_seconds(record->run) / whole_seconds(standard->run));
  }
  summary.modulus = spread_of(good, MeasureRole::youngs_modulus);
  summary.ratio = spread_of(good, MeasureRole::poissons_ratio);
  summary.solve = median(std::move(solve));
  summary.whole = median(std::move(whole));
  return summary;
}

std::string size_text(double size) {
  const std::string text = percent(size);
  return text.starts_with('+') ? text.substr(1) : text;
}

std::string number_text(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "";
}

std::string count_text(int count) { return count ? std::to_string(count) : ""; }

Tone tone_of(double error, double goal) {
  return !(error <= 25 * goal) ? Tone::bad : error <= goal ? Tone::good : error <= 5 * goal ? Tone::plain : Tone::poor;
}

std::string strategies_text(const Summary& summary, bool colours) {
  Table table({"strategy", "ran", "unsuited", "failed", "|error of E|", "worst", "on", "|nu - target|", "worst", "on",
               "solve", "with build", "mechanisms", "best on"});
  std::string nowhere;
  for (const StrategySummary& row : summary.strategies) {
    if (row.unsuited == row.bodies) {
      nowhere += (nowhere.empty() ? "  suited to none of these bodies: " : ", ") + row.strategy;
      continue;
    }
    const int ran = row.bodies - row.unsuited - row.failed;
    table.add({{row.strategy + (row.uses_cells ? " *" : ""), ran ? Tone::plain : Tone::faint},
               {fmt::format("{} of {}", ran, row.bodies), Tone::plain, true},
               {count_text(row.unsuited), Tone::faint, true},
               {count_text(row.failed), Tone::bad, true},
               {size_text(row.modulus.median), tone_of(row.modulus.median, kModulusGoal), true},
               {size_text(row.modulus.worst), tone_of(row.modulus.worst, kModulusGoal), true},
               {row.modulus.worst_scene, Tone::faint},
               {number_text(row.ratio.median, "{:.4f}"), tone_of(row.ratio.median, kRatioGoal), true},
               {number_text(row.ratio.worst, "{:.4f}"), tone_of(row.ratio.worst, kRatioGoal), true},
               {row.ratio.worst_scene, Tone::faint},
               {number_text(row.solve, "{:.2f}"), Tone::plain, true},
               {number_text(row.whole, "{:.2f}"), Tone::plain, true},
               {count_text(row.mechanisms), Tone::poor, true},
               {count_text(row.best_on), Tone::bold, true}});
  }
  if (!nowhere.empty()) nowhere += '\n';
  return table.text(colours) +
         painted(
             nowhere +
                 "  errors: median and worst over the bodies on which it ran; solve: median of its time over that of "
                 "standard; * needs cells; best on: bodies on which it is the best without cells\n",
             Tone::faint, colours);
}

/// Name and errors of the strategy to take: three cells.
void add_best(const Record* best, bool judged, bool tried, std::vector<TableCell>& row) {
  if (!judged || !tried) {
    row.insert(row.end(), {{tried ? "no reference" : "none was run", Tone::faint}, {""}, {""}});
    return;
  }
  const double modulus = best ? error_of(*best, MeasureRole::youngs_modulus) : std::nan("");
  const double ratio = best ? error_of(*best, MeasureRole::poissons_ratio) : std::nan("");
  row.push_back({best ? best->run.strategy : "none that is stable", best ? Tone::bold : Tone::bad});
  row.push_back({percent(modulus), tone_of(std::abs(modulus), kModulusGoal), true});
  row.push_back({number_text(ratio, "{:+.4f}"), tone_of(std::abs(ratio), kRatioGoal), true});
}

TableCell goal_cell(const Record* best, bool enough) {
  const bool good = best && within_goal(*best);
  return {good ? "within" : "no", good ? Tone::good : enough ? Tone::bad : Tone::poor};
}

std::string bodies_text(const Summary& summary, bool colours) {
  Table table({"body", "molecules", "neighbours inside", "least", "best without cells", "error of E", "nu - target",
               "1 %, 0.01", "best springs", "error of E", "nu - target", "1 %, 0.01"});
  int judged_bodies = 0, met = 0, met_by_springs = 0;
  for (const BodySummary& body : summary.bodies) {
    const bool enough = body.judged && body.neighbours.mean >= kEnoughNeighbours;
    judged_bodies += enough;
    met += enough && body.best && within_goal(*body.best);
    met_by_springs += enough && body.best_springs && within_goal(*body.best_springs);
    const Tone tone = enough ? Tone::plain : Tone::faint;
    std::vector<TableCell> row{{body.scene},
                               {std::to_string(body.molecules), Tone::plain, true},
                               {fmt::format("{:.1f}", body.neighbours.mean), tone, true},
                               {std::to_string(body.neighbours.least), tone, true}};
    const TableCell none{""};
    add_best(body.best, body.judged, body.without_cells, row);
    row.push_back(body.judged && body.without_cells ? goal_cell(body.best, enough) : none);
    add_best(body.best_springs, body.judged, body.springs, row);
    row.push_back(body.judged && body.springs ? goal_cell(body.best_springs, enough) : none);
    table.add(std::move(row));
  }
  return table.text(colours) + fmt::format(
                                   "\n  within 1 % of E and 0.01 of nu, of the {} with {:.0f} neighbours or more: {} "
                                   "without cells, {} by any "
                                   "springs (some with a volume term over cells)\n",
                                   counted(judged_bodies, "body", "bodies"), kEnoughNeighbours, met, met_by_springs);
}

/// Errors of the calibrated runs that have the target E, in other directions than the calibrated one.
std::string elsewhere_text(const std::vector<const Record*>& runs) {
  std::vector<double> errors;
  const Record* worst = nullptr;
  for (const Record* record : runs) {
    if (!record->directions || !record->directions->measured()) continue;
    errors.push_back(record->directions->worst());
    if (!worst || errors.back() > worst->directions->worst()) worst = record;
  }
  if (!worst) return "";
  return fmt::format("  calibrated, in other directions: E and G off by {} (median of {}), {} at worst ({} on {})\n",
                     size_text(median(errors)), counted(static_cast<int>(errors.size()), "run"),
                     size_text(worst->directions->worst()), worst->run.strategy, worst->scene);
}

/// Number of calibrated runs that have the target E.
std::string calibrated_text(const std::vector<Record>& records) {
  constexpr double goal = 1e-3;
  int runs = 0, met = 0;
  std::string others;
  std::vector<const Record*> good;
  for (const Record& record : records) {
    const double error = error_of(record, MeasureRole::youngs_modulus);
    if (!StrategyName(record.run.strategy).calibrated || !solved(record) || !std::isfinite(error)) continue;
    ++runs;
    met += std::abs(error) <= goal;
    if (std::abs(error) <= goal) good.push_back(&record);
    if (!(std::abs(error) <= goal))
      others += fmt::format("; {} on {}: {}", record.run.strategy, record.scene, percent(error));
  }
  return runs ? fmt::format("  calibrated within 0.1 % of E: {} of {} runs{}\n", met, runs, others) +
                    elsewhere_text(good)
              : "";
}

/// Each run and expectation that failed, a line each.
std::string failures_text(const std::vector<Record>& records, bool colours) {
  int met = 0, judged = 0;
  std::string out;
  for (const Record& record : records) {
    const std::string run = "  " + record.scene + ", " + record.run.strategy + ": ";
    if (record.run.suited && !solved(record) && !record.stopped_as_expected()) {
      std::string outcome = name_of(record.run.outcome);
      std::replace(outcome.begin(), outcome.end(), '_', ' ');
      out += painted(run + outcome + ": " + record.run.cause, Tone::bad, colours) + "\n";
    }
    for (const Verdict& verdict : record.verdicts) {
      judged += verdict.judged;
      met += verdict.judged && verdict.passed;
      if (verdict.judged && !verdict.passed)
        out += painted(run + (verdict.expectation.outcome.empty()
                                  ? verdict.expectation.measure + " " + percent(verdict.difference) + " from expected"
                                  : "expected to stop as " + verdict.expectation.outcome + ": \"" +
                                        verdict.expectation.cause + "\""),
                       Tone::bad, colours) +
               "\n";
    }
  }
  if (judged) out += fmt::format("  {} of {} expectations hold\n", met, judged);
  return out;
}

}  // namespace

Summary summarise(const std::vector<Record>& records) {
  Summary summary;
  for (const auto& runs : grouped(records, [](const Record& record) { return record.run.strategy; }))
    summary.strategies.push_back(summary_of(runs, records));
  for (const auto& runs : grouped(records, [](const Record& record) { return record.path; })) {
    const Record& first = *runs.front();
    const auto any = [&](const auto& counts) {
      return std::any_of(runs.begin(), runs.end(), [&](const Record* record) { return counts(*record); });
    };
    const auto without_cells = [](const Run& run) { return !run.uses_cells; };
    const auto of_springs = [](const Run& run) { return run.constants.size() > 0; };
    summary.bodies.push_back(
        {first.scene, first.molecules, first.neighbours, any([](const Record& record) {
           return judged(record) && (std::isfinite(error_of(record, MeasureRole::youngs_modulus)) || !solved(record));
         }),
         any([&](const Record& record) { return without_cells(record.run); }),
         any([&](const Record& record) { return without_cells(record.run) || of_springs(record.run); }),
         best_of(runs, without_cells), best_of(runs, of_springs)});
    for (StrategySummary& row : summary.strategies)
      if (const Record* best = summary.bodies.back().best) row.best_on += row.strategy == best->run.strategy;
  }
  return summary;
}

Table scatter_table(const std::vector<Record>& records) {
  const std::vector<std::string> measures = scattered_measures(records);
  if (measures.empty()) return Table({"experiment"});
  auto strategies = grouped(records, [](const Record& record) { return record.run.strategy; });
  std::stable_sort(strategies.begin(), strategies.end(), [](auto& a, auto& b) { return a.size() > b.size(); });
  std::vector<std::string> head{"experiment", "nearest", "its error"};
  for (const auto& runs : strategies) head.push_back(runs.front()->run.strategy);
  Table table(head);
  for (const auto& runs : grouped(records, [](const Record& record) { return record.path; })) {
    if (scattered_measures({*runs.front()}).empty()) continue;
    std::vector<TableCell> cells;
    TableCell nearest{"none"}, least;
    for (std::size_t column = 3; column < head.size(); ++column) {
      const auto run =
          std::find_if(runs.begin(), runs.end(), [&](const Record* r) { return r->run.strategy == head[column]; });
      cells.push_back(run == runs.end() ? TableCell{} : scatter_cell(**run, measures));
      if (std::isfinite(cells.back().value) && !(cells.back().value >= least.value))
        nearest = {head[column]}, least = cells.back();
    }
    cells.insert(cells.begin(), {{runs.front()->scene}, nearest, least});
    table.add(std::move(cells));
  }
  return table;
}

std::string summary_text(const std::vector<Record>& records, bool colours) {
  if (records.empty()) return "";
  const Summary summary = summarise(records);
  // Bodies are ranked by their modulus; what runs in time, or is a membrane, has none.
  const bool moduli = std::any_of(records.begin(), records.end(), [](const Record& record) {
    return std::isfinite(record.error(record.measure(MeasureRole::youngs_modulus)));
  });
  std::string scattered;
  if (const Table table = scatter_table(records); !table.empty())
    scattered = "  error over the scatter of the measured specimens\n\n" + table.text(colours) + "\n";
  return painted("Summary", Tone::bold, colours) + "  " +
         counted(static_cast<int>(summary.bodies.size()), "body", "bodies") + "\n\n" +
         strategies_text(summary, colours) + "\n" + (moduli ? bodies_text(summary, colours) : "") + scattered +
         calibrated_text(records) + failures_text(records, colours) + "\n";
}

}  // namespace elastin::lab
