#include "lab/report/comparison.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>

#include "lab/report/table.h"

namespace elastin::lab {
namespace {

std::vector<std::string> measures_with(const std::vector<Record>& records, const std::string& end) {
  std::vector<std::string> names;
  for (const auto& [name, prescribed, strain] : records.front().main_measures)
    if (std::any_of(records.begin(), records.end(),
                    [&, error = std::string(name) + end](const Record& r) { return std::isfinite(r.error(error)); }))
      names.emplace_back(name);
  return names;
}

/// Leaves out measures whose reference is uncertain.
void keep_ranked(const Record& record, std::vector<std::string>& names) {
  std::erase_if(names, [&](const std::string& name) {
    return std::any_of(record.references.begin(), record.references.end(),
                       [&](const Reference& reference) { return reference.measure == name && !reference.certain(); });
  });
  // A ratio alone is no reason to recommend anything where the reference of what has a unit is uncertain.
  const auto has_unit = [&](const std::string& name) { return record.measure(name).unit != dimension::none; };
  const bool left_out =
      std::any_of(record.references.begin(), record.references.end(),
                  [&](const Reference& reference) { return has_unit(reference.measure) && !reference.certain(); });
  if (left_out && std::none_of(names.begin(), names.end(), has_unit)) names.clear();
}

/// "the computed reference of E is uncertain by 12 %"; "" where no reference is uncertain.
std::string uncertain_text(const Record& record) {
  for (const Reference& reference : record.references)
    if (!reference.certain())
      return "the " + std::string(reference.computed ? "computed " : "") + "reference of " +
             record.measure(reference.measure).label() + " is uncertain by " + percent(reference.uncertainty).substr(1);
  return "";
}

/// Poisson's ratio and its like, in thousandths.
double second_error(const Record& record, const Ranking& ranking) {
  double sum = 0;
  for (const auto& [name, prescribed, strain] : record.main_measures) {
    const bool counted = std::find(ranking.measures.begin(), ranking.measures.end(), name) != ranking.measures.end();
    if (counted || !std::isfinite(prescribed)) continue;
    const double error = record.error(name);
    sum += std::isfinite(error) ? std::round(std::abs(error) * 1000) : 1e9;
  }
  return sum;
}

/// Differences of errors below this say nothing.
double carried(const Record& a, const Record& b, const Ranking& ranking) {
  constexpr double least = 1e-5, most = 1e-3;
  double uncertainty = std::max({least, a.run.residual, b.run.residual});
  for (const Reference& reference : a.references)
    if (ranking.by_reference &&
        std::find(ranking.measures.begin(), ranking.measures.end(), reference.measure) != ranking.measures.end())
      uncertainty = std::max(uncertainty, reference.uncertainty);
  return std::min(uncertainty, most);
}

/// All that are tied with the best; of them the simplest becomes the best.
void find_ties(const std::vector<const Record*>& candidates, Ranking& ranking) {
  const Record& best = *ranking.best;
  const double error = ranking.error(best), second = second_error(best, ranking);
  std::vector<const Record*> tied;
  for (const Record* record : candidates)
    if (second_error(*record, ranking) == second &&
        std::abs(ranking.error(*record) - error) <= carried(*record, best, ranking))
      tied.push_back(record);
  std::stable_sort(tied.begin(), tied.end(),
                   [](const Record* a, const Record* b) { return a->run.order < b->run.order; });
  ranking.best = tied.front();
  ranking.tied.assign(tied.begin() + 1, tied.end());
}

/// A law's own target says nothing against another law's.
void find_rival_targets(Ranking& ranking) {
  if (ranking.by_reference) return;
  const std::string& measure = ranking.measures.front();
  std::vector<std::pair<double, const Record*>> targets;
  const auto add = [&](const Record* record) {
    if (const MainMeasure* target = record->law_target(measure)) targets.emplace_back(target->prescribed, record);
  };
  add(ranking.best);
  std::for_each(ranking.tied.begin(), ranking.tied.end(), add);
  if (targets.empty()) return;
  const auto [low, high] = std::minmax_element(targets.begin(), targets.end());
  if (high->first - low->first <= kNear * std::abs(high->first)) return;
  const MeasureInfo& info = ranking.best->measure(measure);
  const auto text = [&](const auto& target) {
    return value_text(target.first, info) + " (" + target.second->run.strategy + ")";
  };
  ranking.rival_targets = info.label() + " " + text(*low) + " to " + text(*high);
}

/// Those that a plot of error against time has to the left of the best and below it, by more than nothing.
void find_passed_over(const std::vector<Record>& records, const std::function<bool(const Record&)>& false_elsewhere,
                      Ranking& ranking) {
  const Record& best = *ranking.best;
  for (const Record& record : records) {
    const bool tied = std::find(ranking.tied.begin(), ranking.tied.end(), &record) != ranking.tied.end();
    const bool nearer = ranking.error(record) < ranking.error(best) - carried(record, best, ranking);
    if (&record == &best || tied || !solved(record) || !nearer || !(record.least_seconds() < best.least_seconds()))
      continue;
    const std::string why = !has_own_error(record)         ? "it was calibrated to the reference itself"
                            : !record.run.warnings.empty() ? "it has a warning"
                            : false_elsewhere(record)      ? "it is not near in other directions"
                            : second_error(record, ranking) > second_error(best, ranking)
                                ? "it is further off in Poisson's ratio"
                                : "";
    if (!why.empty()) ranking.passed_over.emplace_back(&record, why);
  }
}

}  // namespace

namespace {

/// Of a ratio with a computed reference the difference counts, as against the material's own.
double weight(const Record& record, const std::string& measure) {
  for (const Reference& reference : record.references)
    if (reference.measure == measure && reference.computed && record.measure(measure).unit == dimension::none)
      return std::min(1., std::abs(reference.value));
  return 1;
}

}  // namespace

bool solved(const Record& record) { return record.run.suited && record.run.outcome == Outcome::converged; }

bool has_own_error(const Record& record) { return solved(record) && !record.run.calibrated_to_reference; }

double Ranking::error(const Record& record) const {
  double largest = 0;
  for (const std::string& measure : measures) {
    const double error = std::abs(record.error(error_name(measure))) * (by_reference ? weight(record, measure) : 1);
    largest = std::max(largest, std::isfinite(error) ? error : INFINITY);
  }
  return largest;
}

Ranking rank_strategies(const std::vector<Record>& records) {
  Ranking ranking;
  ranking.measures = scattered_measures(records);
  ranking.by_scatter = !ranking.measures.empty();
  if (!ranking.by_scatter) ranking.measures = measures_with(records, "_to_reference");
  const auto with_references =
      std::find_if(records.begin(), records.end(), [](const Record& record) { return !record.references.empty(); });
  if (with_references != records.end()) keep_ranked(*with_references, ranking.measures);
  ranking.by_reference = !ranking.measures.empty();
  if (!ranking.by_reference) {
    for (const Record& record : records)
      if (ranking.no_reference.empty()) ranking.no_reference = record.no_reference;
    if (!ranking.no_reference.empty()) {
      const std::string uncertain = with_references == records.end() ? "" : uncertain_text(*with_references);
      if (!uncertain.empty()) ranking.no_reference += "; " + uncertain;
      return ranking;
    }
    ranking.measures = measures_with(records, "");
    if (ranking.measures.size() > 1) ranking.measures.resize(1);
  }
  if (ranking.measures.empty()) return ranking;
  const auto sound = [](const Record& record) { return has_own_error(record) && record.run.warnings.empty(); };
  const auto measured = [](const Record& record) { return record.directions && record.directions->measured(); };
  const auto true_elsewhere = [&](const Record& record) {
    return measured(record) && record.directions->worst() <= kNear;
  };
  const bool some_true = std::any_of(records.begin(), records.end(), [&](const Record& record) {
    return sound(record) && ranking.error(record) <= ranking.near() && true_elsewhere(record);
  });
  const auto false_elsewhere = [&](const Record& record) {
    return some_true && measured(record) && !true_elsewhere(record);
  };
  const auto fit = [&](const Record& record) { return sound(record) && !false_elsewhere(record); };
  double least = INFINITY;
  for (const Record& record : records)
    if (fit(record)) least = std::min(least, ranking.error(record));
  const auto order = [&](const Record& record) {
    return std::tuple{second_error(record, ranking), record.run.build_seconds + record.run.solve_seconds};
  };
  std::vector<const Record*> candidates;
  for (const Record& record : records)
    if (fit(record) && ranking.error(record) <= std::max(1e-3, 1.1 * least) && std::isfinite(ranking.error(record))) {
      candidates.push_back(&record);
      if (!ranking.best || order(record) < order(*ranking.best)) ranking.best = &record;
    }
  for (const Record& record : records)
    if (has_own_error(record) && !record.run.warnings.empty() && std::isfinite(ranking.error(record)) &&
        (!ranking.warned || ranking.error(record) < ranking.error(*ranking.warned)))
      ranking.warned = &record;
  if (ranking.best) find_ties(candidates, ranking);
  if (ranking.best) find_rival_targets(ranking);
  if (ranking.best) find_passed_over(records, false_elsewhere, ranking);
  return ranking;
}

}  // namespace elastin::lab
