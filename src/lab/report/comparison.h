#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "lab/report/plot.h"
#include "lab/report/records.h"
#include "lab/report/table.h"

namespace elastin::lab {

/// An error of E up to here is fit for use.
inline constexpr double kNear = 0.05;

/// Whether the run came to its end.
bool solved(const Record& record);

/// Whether its error says something: it came to its end, and was not calibrated to the very value that it is compared
/// with.
bool has_own_error(const Record& record);

/// The recommended strategy of a comparison.
struct Ranking {
  /// What counts: every main measure with a certain reference, which solves the same problem; without one, the
  /// first with a value of the material, which is met only where the grips do not disturb. Empty: nothing to go by.
  std::vector<std::string> measures;
  bool by_reference = false;
  /// Measured specimens with their scatter count alone, and errors are in units of it.
  bool by_scatter = false;
  /// Why nothing ranks them, in words: the specimen does not show the material's values, and no reference is given.
  std::string no_reference;
  const Record* best = nullptr;     ///< points into the records; null if each one failed or has a warning
  const Record* warned = nullptr;   ///< the nearest of those that came to their end with a warning
  std::vector<const Record*> tied;  ///< others that the measures do not distinguish from the best
  /// "E 8.75 kPa (neo_hookean) to 13.2 kPa (st_venant_kirchhoff)": where the best and those tied with it are laws that
  /// each meet their own target, of a material that states none, and the targets are further apart than what is near.
  std::string rival_targets;
  /// Those that are both nearer and faster than the best, and why they are not the best.
  std::vector<std::pair<const Record*, std::string>> passed_over;

  /// Name of a measure's error that counts.
  std::string error_name(const std::string& measure) const {
    return measure + (by_scatter ? "_over_scatter" : by_reference ? "_to_reference" : "");
  }
  /// The largest of the errors that count, as a size; infinite if one is missing. Of ratios that have a computed
  /// reference the difference counts.
  double error(const Record& record) const;
  /// Whether the best comes near enough to be recommended.
  bool recommends() const { return best && rival_targets.empty() && error(*best) <= near(); }
  /// An error up to here is fit for use.
  double near() const { return by_scatter ? 1 : kNear; }
};

/// The best is near enough (0.1 %, or within a tenth of the least error), with nothing to warn of; of those the nearest
/// in what else the material prescribes; then the fastest. Where one that comes near is near in every direction, those
/// that are known not to be are passed over. Where errors differ by less than the measures carry (1e-5,
/// the solver's residual, the reference's uncertainty) time does not count: they are tied, and the simplest strategy is
/// the best; but laws that say different things of the material are no ties. What was calibrated to the reference meets
/// it by construction and is never the best.
Ranking rank_strategies(const std::vector<Record>& records);

Tone tone_of_error(double error);
Tone tone_of_scatter(double error);

/// Of each measured reference with scatter its measure, in the order in which the records have them.
std::vector<std::string> scattered_measures(const std::vector<Record>& records);

/// "0.62": the largest error in units of the scatter, or why it does not exist; empty where the scene states no
/// scatter.
TableCell scatter_cell(const Record& record, const std::vector<std::string>& measures);

/// A measure's value; small ratios with digits that show that they are not 0.
std::string value_text(double value, const MeasureInfo& info, int digits = 5);

/// "limit reached", "not suited": an outcome in words.
std::string outcome_text(const Run& run);

/// Notes of a run: why it has no numbers, and the first words of each warning.
std::string notes_of(const Record& record);

/// Whether strategies can be ranked: by a target of the material, or a reference.
bool can_rank(const std::vector<Record>& records);

/// A row a strategy: its main measures, their errors, iterations and times.
Table comparison_table(const std::vector<Record>& records, const Ranking& ranking);

/// A row an experiment, a column a strategy: the error in units of the scatter of what was measured. No rows where no
/// scene states a scatter.
Table scatter_table(const std::vector<Record>& records);

/// What was expected of the runs, and what came.
Table verdicts_table(const std::vector<Record>& records);

/// "take lattice: E +0.001 %, Poisson's ratio 0.2500 (target: …), 3 ms".
std::string advice_text(const Ranking& ranking, bool colours);

/// The runs in the folder of an earlier `compare --out` or `run --out`. Throws InputError: folder and what is missing.
std::vector<Record> load_baseline(const std::string& folder);

/// Each run that the earlier ones have too (scene, strategy, threads, what a study changes): its main measures then and
/// now, how much they changed relatively, and both times. No rows where there is nothing in common.
Table change_table(const std::vector<Record>& records, const std::vector<Record>& baseline);

/// The rows of one scene's study that differ in the body alone: one strategy, solver and number of threads under
/// refinement, from the coarsest on.
struct StudyCurve {
  std::string name;  ///< "lattice", "lattice, pcg, 2 threads": what distinguishes it from the others
  std::string strategy;
  std::vector<const Record*> rows;
};

/// Points into the records, all of one scene.
std::vector<StudyCurve> curves_of(const std::vector<Record>& records);

/// "lattice, [5, 5, 5], pcg": a run of a study.
std::string run_name(const Record& record);

/// What a row has under the keys that the study changes: "[5, 5, 5], pcg".
std::string variant_text(const Record& record);

/// "effective_modulus 1.17567 MPa ± 0.03 %, computed: …, in 24 s": a reference in one line.
std::string reference_text(const Reference& reference, const MeasureInfo& measure);
/// A line for each reference that some record has.
std::string references_text(const std::vector<Record>& records, bool colours);

/// The value that a measure tends to as the spacing falls, by Richardson extrapolation of the three finest rows with
/// the order that they show: v(h) = v₀ + c hᵖ. Its uncertainty is 1.25 |v₀ − v(finest)|, the grid convergence index, or
/// if that is less and there are four rows, how far v₀ lies from that of the three before.
/// Throws InputError where that says nothing: fewer than three spacings, or values that do not fall into line.
///                                                                                                  [Roache 1994]
struct Extrapolation {
  double value = 0, uncertainty = 0, order = 0;
};
Extrapolation extrapolate(const std::vector<std::pair<double, double>>& spacings_and_values);

/// The same for any two values or more, with what they do not show. A singular edge, of order 1 at worst, is hidden at
/// first by smooth strain, whose errors are larger and fall sooner: an order shown by three values that is above 1 may
/// still fall to it, and the uncertainty reaches the limits of order 1 and, of orders below 2, of order 2. Where four
/// values show one order twice, within 0.3, it is 1.5 times the difference of their two limits, if that is less; where
/// the order changes, at least that difference. An order that rises, or that no cells have, is a sum that passes
/// through zero: then half of the change before counts, too. The uncertainty is never less than a tenth of the last
/// correction, for two limits may agree by chance. Values that do not change, to 1e-7, are the limit. Those that fall
/// into no line have no order (NaN): of two the limit is in the middle of what the orders 1 and 2 lead to, its
/// uncertainty their difference; of more it is the last value, its uncertainty 1.5 times the largest difference between
/// the last three.                                                            [Roache 1994; Celik et al. 2008]
Extrapolation limit_of(const std::vector<std::pair<double, double>>& spacings_and_values);

/// Gives all records of a scene the strategy's own extrapolated values as references, of each main measure that it has;
/// returns what went wrong, or "". Records whose variants differ in more than the fineness of one body, in keys of
/// another map than `body` or in the body's size, have references of their own.
std::string refer_to_own(std::vector<Record>& records, const std::string& strategy);

/// The time [s] of the fastest of the runs (time, error) that has at most this error; NaN if none has. Nothing is drawn
/// between two runs.
double time_to(const std::vector<std::pair<double, double>>& times_and_errors, double error);

/// A row a run: what was changed, what came out, its error and times.
Table study_table(const std::vector<Record>& records, const Ranking& ranking);
/// Time to 1 % and to 0.1 % of error, a row a curve, and one each of the peers of this scene with how many times the
/// best of Elastin's runs they take; the fastest in front.
Table time_to_table(const std::vector<Record>& records, const Ranking& ranking, const std::vector<Peer>& peers = {});

/// Both tables, the references, and what failed.
std::string study_text(const std::vector<Record>& records, bool colours, const std::vector<Peer>& peers = {});

/// Sizes of an error over several bodies: the middle one, the largest and where that was; NaN where none was measured.
struct ErrorSpread {
  double median = 0, worst = 0;
  std::string worst_scene;
};

/// What one strategy did on several bodies.
struct StrategySummary {
  std::string strategy;
  bool uses_cells = false;
  int bodies = 0, unsuited = 0, failed = 0;
  int mechanisms = 0;           ///< bodies that it leaves zero-energy modes
  int best_on = 0;              ///< bodies on which it is the best cell-free strategy
  ErrorSpread modulus, ratio;   ///< |error of E|, relative; |difference of Poisson's ratio|
  double solve = 0, whole = 0;  ///< medians of solve, and of build + solve, over those of `standard`; NaN without it
};

/// One body, the strategy without cells to take on it, and the spring rule (which may have a
/// volume term over cells, or constants from cells); null if none ran without mechanism or
/// instability.
struct BodySummary {
  std::string scene;
  int molecules = 0;
  Neighbours neighbours;
  bool judged = true;                           ///< false: nothing says which values the specimen should show
  bool without_cells = false, springs = false;  ///< whether a strategy of the kind was tried
  const Record *best = nullptr, *best_springs = nullptr;
};

struct Summary {
  std::vector<StrategySummary> strategies;  ///< in the order in which they first ran
  std::vector<BodySummary> bodies;          ///< in the order of the scenes
};

/// The goal of the best cell-free strategy on a body: errors of E (relative) and of Poisson's ratio.
inline constexpr double kModulusGoal = 0.01, kRatioGoal = 0.01;

/// All runs of a comparison by strategy and by body. The best cell-free strategy has the least of max(|error of E| / 1
/// %, |difference of ν| / 0.01), to a thousandth; of equals the simplest. Points into `records`.
Summary summarise(const std::vector<Record>& records);

/// The summary as two tables, then what failed.
std::string summary_text(const std::vector<Record>& records, bool colours);

/// The axes of a run of an experiment that is not known.
std::vector<ResponseAxes> usual_response(bool in_time);

/// The first of these axes that has measures; empty ones if no axis has any.
ResponseAxes choose_response(const std::vector<ResponseAxes>& axes,
                             const std::function<bool(const std::string& measure)>& has);

/// The colour of each strategy, of each curve and of each run of a study, the same on a whole page. Strategies of one
/// family (calibrated:lattice, lattice+volume) have shades of one hue as far as there are; runs of a study have hues.
std::map<std::string, int> strategy_colours(const std::vector<Record>& records);

/// Error against time of one scene's records, a series a strategy or curve of a study; the best so far as a staircase.
/// Errors below 1e-7 stand at the foot. No series where nothing can be ranked.
Plot error_plot(const std::vector<Record>& records, const Ranking& ranking, const std::map<std::string, int>& colours,
                const std::vector<Peer>& peers = {});

/// The response curve of each record: the stress–strain curve, torque over angle, a deflection over load or time; of a
/// study with more than 24 runs the finest of each curve. Further ones (number 1, 2 …) of measure over measure, as
/// force over elongation. No series where there is no such measure, or no further one.
Plot response_plot(const std::vector<Record>& records, const std::map<std::string, int>& colours,
                   std::size_t number = 0);

/// Of a study, each measure that counts over each key that has numbers, and its error over the same key; a series a
/// strategy and value of the keys that change by themselves. Of keys with lists (a lattice's molecules) the number of
/// molecules stands for the value. Empty where nothing is varied.
std::vector<Plot> parameter_plots(const std::vector<Record>& records, const Ranking& ranking,
                                  const std::map<std::string, int>& colours);

}  // namespace elastin::lab
