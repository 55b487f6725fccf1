#pragma once
#include <string>
#include <vector>

#include "lab/report/ranking.h"
#include "lab/report/records.h"
#include "lab/report/table.h"

namespace elastin::lab {

Tone tone_of_error(double error);

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

/// What was expected of the runs, and what came.
Table verdicts_table(const std::vector<Record>& records);

/// "take lattice: E +0.001 %, Poisson's ratio 0.2500 (target: …), 3 ms".
std::string advice_text(const Ranking& ranking, bool colours);

/// The runs in the folder of an earlier `compare --out` or `run --out`. Throws InputError: folder and what is missing.
std::vector<Record> load_baseline(const std::string& folder);

/// Each run that the earlier ones have too (scene, strategy, threads, what a study changes): its main measures then and
/// now, how much they changed relatively, and both times. No rows where there is nothing in common.
Table change_table(const std::vector<Record>& records, const std::vector<Record>& baseline);

}  // namespace elastin::lab
