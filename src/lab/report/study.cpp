#include "lab/report/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "core/base/named.h"
#include "elastin/core/base/error.h"

namespace elastin::lab {
namespace {

constexpr double kGoals[] = {0.01, 0.001};

bool of_the_body(const std::string& key) { return key.starts_with("body."); }

/// h where v(h) = v₀ + c hᵖ goes through three points: the ratio of the differences gives p, which is bisected.
double shown_order(const double (&h)[3], const double (&v)[3]) {
  const double wanted = (v[1] - v[0]) / (v[2] - v[1]);  // h falls
  const auto ratio = [&](double p) {
    return (std::pow(h[1], p) - std::pow(h[0], p)) / (std::pow(h[2], p) - std::pow(h[1], p));
  };
  double low = 0.1, high = 8;
  if (!(wanted > ratio(low) && wanted < ratio(high))) return std::nan("");
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2;
    (ratio(middle) < wanted ? low : high) = middle;
  }
  return low;
}

/// The error of a measure that counts, with its sign.
double signed_error(const Record& record, const Ranking& ranking, const std::string& measure) {
  return solved(record) ? record.error(ranking.error_name(measure)) : std::nan("");
}

}  // namespace

std::string variant_text(const Record& record) {
  return joined(record.variant, [](const auto& changed) { return changed.second; });
}

std::string run_name(const Record& record) {
  return record.run.strategy + (record.variant.empty() ? "" : ", " + variant_text(record));
}

std::string reference_text(const Reference& reference, const MeasureInfo& measure) {
  std::string text = measure.label() + " " + readable(reference.value, measure, 6);
  if (reference.scatter > 0) text += fmt::format(" ± {:.2g} % (standard deviation)", 100 * reference.scatter);
  if (!reference.points.empty()) text += fmt::format(", the last of {}", counted(reference.points.size(), "point"));
  if (reference.computed) text += fmt::format(" ± {:.2g} %", 100 * reference.uncertainty);
  text += ", " + reference.source;
  if (!reference.computed) return text;
  return text + (reference.read_back ? "; read back, computed in " : "; in ") + readable_seconds(reference.seconds);
}

std::string references_text(const std::vector<Record>& records, bool colours) {
  std::string out;
  std::vector<Reference> shown;
  for (const Record& record : records)
    for (const Reference& reference : record.references) {
      Reference same = reference;
      same.read_back = false;
      if (std::find(shown.begin(), shown.end(), same) != shown.end()) continue;
      shown.push_back(same);
      out += "  reference: " + reference_text(reference, record.measure(reference.measure)) + "\n";
    }
  return out.empty() ? out : painted(out, Tone::faint, colours);
}

std::vector<StudyCurve> curves_of(const std::vector<Record>& records) {
  std::set<int> threads;
  for (const Record& record : records) threads.insert(record.threads);
  std::vector<StudyCurve> curves;
  for (const Record& record : records) {
    std::string name = record.run.strategy;
    for (const auto& [key, value] : record.variant)
      if (!of_the_body(key)) name += ", " + value;
    if (threads.size() > 1) name += ", " + counted(record.threads, "thread");
    const auto same = [&](const StudyCurve& known) { return known.name == name; };
    found_or_added(curves, same, {name, record.run.strategy, {}}).rows.push_back(&record);
  }
  for (StudyCurve& curve : curves)
    std::stable_sort(curve.rows.begin(), curve.rows.end(),
                     [](const Record* a, const Record* b) { return a->spacing > b->spacing; });
  return curves;
}

Extrapolation extrapolate(const std::vector<std::pair<double, double>>& spacings_and_values) {
  auto rows = spacings_and_values;
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  rows.erase(std::unique(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first == b.first; }),
             rows.end());
  if (rows.size() < 3)
    throw InputError("an extrapolation takes three spacings or more; here are " + std::to_string(rows.size()));
  const auto from = [&](std::size_t finest) {
    const double h[] = {rows[finest + 2].first, rows[finest + 1].first, rows[finest].first};
    const double v[] = {rows[finest + 2].second, rows[finest + 1].second, rows[finest].second};
    const double p = shown_order(h, v);
    return Extrapolation{v[2] + (v[2] - v[1]) * std::pow(h[2], p) / (std::pow(h[1], p) - std::pow(h[2], p)),
                         1.25 * std::abs(v[2] - v[1]) * std::pow(h[2], p) / (std::pow(h[1], p) - std::pow(h[2], p)), p};
  };
  Extrapolation found = from(0);
  if (!std::isfinite(found.order))
    throw InputError(
        "the three finest values do not converge with an order from 0.1 to 8: they cannot be extrapolated");
  if (rows.size() < 4) return found;
  const Extrapolation before = from(1);
  if (std::isfinite(before.order))
    found.uncertainty = std::min(found.uncertainty, std::abs(found.value - before.value));
  return found;
}

Extrapolation limit_of(const std::vector<std::pair<double, double>>& spacings_and_values) {
  constexpr double unchanged = 1e-7, least_part = 0.1, steady = 0.3, most_order = 4.3;
  auto rows = spacings_and_values;
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (rows.size() < 2) throw InputError("a limit takes two spacings or more");
  const double finest = rows[0].second, change = finest - rows[1].second, none = std::nan("");
  if (std::abs(change) <= unchanged * std::abs(finest)) return {finest, unchanged * std::abs(finest), none};
  const auto limit = [&](double order) {
    return finest + change / (std::pow(rows[1].first / rows[0].first, order) - 1);
  };
  if (rows.size() == 2) return {(limit(1) + limit(2)) / 2, std::abs(change), none};
  const double before = rows[1].second - rows[2].second;
  const auto extrapolated = [](const auto& some) {
    try {
      return std::optional(extrapolate(some));
    } catch (const InputError&) {
      return std::optional<Extrapolation>();
    }
  };
  const auto found = extrapolated(std::vector(rows.begin(), rows.begin() + 3));
  if (!found) return {finest, 1.5 * std::max({std::abs(change), std::abs(before), std::abs(change + before)}), none};
  const auto away = [&](double value) { return std::abs(found->value - value); };
  Extrapolation result = *found;
  if (found->order > 1) result.uncertainty = std::max(away(limit(1)), found->order < 2 ? away(limit(2)) : 0);
  std::optional<Extrapolation> earlier;
  if (rows.size() > 3) earlier = extrapolated(std::vector(rows.begin() + 1, rows.begin() + 4));
  const double shown_before = earlier ? earlier->order : rows.size() > 3 ? 0 : most_order;
  if (found->order > std::min(most_order, shown_before + steady))
    result.uncertainty = std::max(result.uncertainty, std::abs(before) / 2);
  if (earlier && std::abs(found->order - earlier->order) <= steady)
    result.uncertainty = std::min(result.uncertainty, 1.5 * away(earlier->value));
  else if (earlier)
    result.uncertainty = std::max(result.uncertainty, away(earlier->value));
  result.uncertainty = std::max(result.uncertainty, least_part * away(finest));
  return result;
}

namespace {

/// Whether two rows of a study show one problem, on bodies of any fineness.
bool same_problem(const Record& one, const Record& other) {
  constexpr double same = 0.05;  // of the longest side: a coarse packing does not quite fill its box
  const auto elsewhere = [](const Record& record) {
    auto changed = record.variant;
    std::erase_if(changed, [](const auto& change) { return of_the_body(change.first); });
    return changed;
  };
  if (elsewhere(one) != elsewhere(other)) return false;
  double longest = 0, off = 0;
  for (std::size_t axis = 0; axis < std::min(one.extent.size(), other.extent.size()); ++axis) {
    longest = std::max({longest, one.extent[axis], other.extent[axis]});
    off = std::max(off, std::abs(one.extent[axis] - other.extent[axis]));
  }
  return off <= same * longest;
}

/// Spacings and values of one measure; throws InputError where rows of one spacing differ: they change more than that.
std::vector<std::pair<double, double>> values_by_spacing(const std::vector<Record*>& records,
                                                         const std::string& strategy, const std::string& measure) {
  constexpr double same = 1e-9;
  std::vector<std::pair<double, double>> rows;
  for (const Record* record : records) {
    const double value = record->run.measures.get(measure);
    if (record->run.strategy != strategy || !solved(*record) || !std::isfinite(value)) continue;
    for (const auto& [spacing, other] : rows)
      if (spacing == record->spacing && std::abs(value - other) > same * std::abs(other))
        throw InputError("bodies of the same fineness differ in what the study changes, as " + variant_text(*record) +
                         " does; let it change the fineness of one body alone");
    rows.emplace_back(record->spacing, value);
  }
  return rows;
}

/// Whether all runs have the same value, as what the experiment prescribes: it shows no strategy's error.
bool is_prescribed(const std::vector<Record*>& records, const std::string& measure) {
  constexpr double same = 1e-9;
  double low = INFINITY, high = -INFINITY;
  for (const Record* record : records)
    if (const double value = record->run.measures.get(measure); solved(*record) && std::isfinite(value))
      low = std::min(low, value), high = std::max(high, value);
  return high - low <= same * std::max(std::abs(low), std::abs(high));
}

}  // namespace

std::string refer_to_own(std::vector<Record>& records, const std::string& strategy) {
  std::vector<std::vector<Record*>> problems;
  for (Record& record : records)
    found_or_added(problems, [&](const auto& own) { return same_problem(*own.front(), record); }, {})
        .push_back(&record);
  std::vector<std::string> troubles;
  for (const std::vector<Record*>& problem : problems) {
    std::vector<Reference> references;
    for (const MainMeasure& measure : problem.front()->main_measures) try {
        if (is_prescribed(problem, measure.name)) continue;
        const auto rows = values_by_spacing(problem, strategy, measure.name);
        if (rows.empty()) continue;
        const Extrapolation found = extrapolate(rows);
        references.push_back({std::string(measure.name), found.value,
                              fmt::format("own: {} extrapolated over {} spacings, order {:.2f}, ± {:.2g} %", strategy,
                                          rows.size(), found.order, 100 * found.uncertainty / std::abs(found.value)),
                              found.uncertainty / std::abs(found.value)});
      } catch (const InputError& error) {
        const std::string trouble = fmt::format("no own reference of {}: {}", measure.name, error.what());
        found_or_added(
            troubles, [&](const std::string& known) { return known == trouble; }, trouble);
      }
    if (!references.empty())
      for (Record* record : problem) set_references(*record, references);
  }
  return joined(troubles, "; ");
}

double time_to(const std::vector<std::pair<double, double>>& times_and_errors, double error) {
  double fastest = std::nan("");
  for (const auto& [time, here] : times_and_errors)
    if (here <= error && !(time >= fastest)) fastest = time;
  return fastest;
}

Table study_table(const std::vector<Record>& records, const Ranking& ranking) {
  std::vector<std::string> head{"strategy"};
  std::vector<std::string> keys;
  for (const Record& record : records)
    for (const auto& [key, value] : record.variant)
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  for (const std::string& key : keys) head.push_back(key.substr(key.rfind('.') + 1));
  head.insert(head.end(), {"molecules", "threads"});
  for (const std::string& name : ranking.measures) {
    const std::string label = records.front().measure(name).label();
    head.push_back(label);
    head.push_back(ranking.measures.size() > 1 ? "error of " + label : "error");
  }
  // A ratio has no error that ranks, but a target, which may be what the study changes. Where nothing has an error,
  // what was measured stands alone.
  std::vector<std::pair<std::string, bool>> others;  // and whether it has a target
  for (const MainMeasure& main : records.front().main_measures) {
    const auto any = [&](const auto& holds) { return std::any_of(records.begin(), records.end(), holds); };
    const bool ranks = std::find(ranking.measures.begin(), ranking.measures.end(), main.name) != ranking.measures.end();
    const bool target = any([&](const Record& record) {
      return std::isfinite(record.error(main.name)) && record.measure(main.name).unit == dimension::none;
    });
    const bool alone = ranking.measures.empty() &&
                       any([&](const Record& record) { return std::isfinite(record.run.measures.get(main.name)); });
    if (ranks || (!target && !alone)) continue;
    others.emplace_back(main.name, target);
    head.push_back(records.front().measure(main.name).label());
    if (target) head.emplace_back("its target");
  }
  head.insert(head.end(), {"iterations", "build", "solve", "least", "median", "solver", ""});
  Table table(head);
  for (const Record& record : records) {
    const Run& run = record.run;
    std::vector<TableCell> row{{run.strategy}};
    for (const std::string& key : keys) {
      const auto at =
          std::find_if(record.variant.begin(), record.variant.end(), [&](const auto& v) { return v.first == key; });
      row.push_back({at == record.variant.end() ? "" : at->second});
    }
    row.push_back(number_cell(std::to_string(record.molecules), record.molecules));
    row.push_back(number_cell(std::to_string(record.threads), record.threads));
    for (const std::string& name : ranking.measures) {
      const double error = signed_error(record, ranking, name);
      row.push_back(number_cell(readable(run.measures.get(name), record.measure(name)), run.measures.get(name)));
      row.push_back(number_cell(percent(error), std::abs(error), tone_of_error(error)));
    }
    for (const auto& [name, has_target] : others) {
      const double value = run.measures.get(name), target = value - record.error(name);
      row.push_back(number_cell(value_text(value, record.measure(name)), value));
      if (has_target) row.push_back(number_cell(value_text(target, record.measure(name)), target, Tone::faint));
    }
    row.push_back(number_cell(run.suited ? fmt::format("{} / {}", run.newton_iterations, run.linear_iterations) : "",
                              run.linear_iterations));
    for (const double seconds : {run.build_seconds, run.solve_seconds, record.least_seconds(), record.median_seconds()})
      row.push_back(number_cell(run.suited ? readable_seconds(seconds) : "", seconds));
    row.push_back({run.solver, Tone::faint});
    row.push_back({notes_of(record), solved(record) ? Tone::poor : Tone::bad});
    table.add(std::move(row), {run_name(record), outcome_text(run)});
  }
  return table;
}

namespace {

/// How long a curve's runs take to the goals; a peer's if it is another program's.
struct TimesToGoals {
  std::string name;
  bool peer;
  double goals[2];  // [s]; NaN where no run is that good
};

double order_of(double seconds) { return std::isfinite(seconds) ? seconds : INFINITY; }

TimesToGoals times_of(const std::string& name, bool peer, const std::vector<std::pair<double, double>>& points) {
  return {name, peer, {time_to(points, kGoals[0]), time_to(points, kGoals[1])}};
}

std::vector<TimesToGoals> times_of_peers(const std::vector<Peer>& peers, const std::string& scene) {
  std::map<std::string, std::vector<std::pair<double, double>>> points;
  for (const Peer& peer : peers)
    if (peer.scene.empty() || peer.scene == scene) points[peer.name].emplace_back(peer.seconds, peer.error);
  std::vector<TimesToGoals> candidates;
  for (const auto& [name, own] : points) candidates.push_back(times_of(name, true, own));
  return candidates;
}

}  // namespace

Table time_to_table(const std::vector<Record>& records, const Ranking& ranking, const std::vector<Peer>& peers) {
  std::vector<TimesToGoals> candidates;
  if (!records.empty()) candidates = times_of_peers(peers, records.front().scene);
  const bool with_ratio = !candidates.empty();
  for (const StudyCurve& curve : curves_of(records)) {
    std::vector<std::pair<double, double>> points;
    for (const Record* record : curve.rows)
      if (has_own_error(*record)) points.emplace_back(record->least_seconds(), ranking.error(*record));
    candidates.push_back(times_of(curve.name, false, points));
  }
  std::stable_sort(candidates.begin(), candidates.end(), [&](const TimesToGoals& a, const TimesToGoals& b) {
    return std::pair{order_of(a.goals[0]), order_of(a.goals[1])} <
           std::pair{order_of(b.goals[0]), order_of(b.goals[1])};
  });
  double best[2] = {INFINITY, INFINITY};
  for (const TimesToGoals& times : candidates)
    for (int goal = 0; goal < 2; ++goal)
      if (!times.peer) best[goal] = std::min(best[goal], order_of(times.goals[goal]));
  std::vector<std::string> head{"strategy"};
  for (const char* goal : {"to 1 %", "to 0.1 %"}) {
    head.push_back(goal);
    if (with_ratio) head.push_back("of Elastin's best");
  }
  Table table(head);
  for (const TimesToGoals& times : candidates) {
    std::vector<TableCell> cells{{times.name}};
    for (int goal = 0; goal < 2; ++goal) {
      const double seconds = times.goals[goal], ratio = order_of(seconds) / best[goal];
      cells.push_back(
          number_cell(std::isfinite(seconds) ? readable_seconds(seconds) : "not reached", order_of(seconds)));
      const bool both = std::isfinite(ratio) && std::isfinite(best[goal]);
      if (with_ratio) cells.push_back(number_cell(both ? fmt::format("× {:.3g}", ratio) : "", ratio));
    }
    table.add(std::move(cells));
  }
  return table;
}

std::string study_text(const std::vector<Record>& records, bool colours, const std::vector<Peer>& peers) {
  if (records.empty()) return "";
  const Ranking ranking = rank_strategies(records);
  std::string out = painted(records.front().scene, Tone::bold, colours) + "  " + records.front().title + "\n";
  if (have_one_target(records))
    out += "  " + painted("target: " + records.front().prescribed, Tone::faint, colours) + "\n";
  out += references_text(records, colours);
  out += "\n" + study_table(records, ranking).text(colours);
  if (!ranking.measures.empty()) out += "\n" + time_to_table(records, ranking, peers).text(colours);
  if (!ranking.no_reference.empty()) out += advice_text(ranking, colours);
  return out + "\n";
}

}  // namespace elastin::lab
