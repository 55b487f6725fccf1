#pragma once
#include <string>
#include <vector>

#include "lab/report/peers.h"
#include "lab/report/ranking.h"
#include "lab/report/records.h"
#include "lab/report/table.h"

namespace elastin::lab {

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

/// The same for any two values or more of cells of first order, whose order is between 1 (at singular edges) and 2:
/// where the order shown is there too, the limit is no further away than the orders 1 and 2 make it. Two extrapolations
/// that agree by chance do not make it more certain than a tenth of the last correction. Values that do not change, to
/// 1e-7, are the limit. Those that fall into no line have no order (NaN): of two the limit is in the middle of what the
/// orders 1 and 2 lead to, its uncertainty half of the difference; of more it is the last value, its uncertainty the
/// largest difference between the last three.
Extrapolation limit_of(const std::vector<std::pair<double, double>>& spacings_and_values);

/// Gives all records of a scene the strategy's own extrapolated values as references, of each main measure that it has;
/// returns what went wrong, or "".
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

}  // namespace elastin::lab
