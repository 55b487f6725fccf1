#pragma once
#include <string>
#include <vector>

#include "lab/report/ranking.h"
#include "lab/report/table.h"

namespace elastin::lab {

Tone tone_of_error(double error);

/// A measure's value; small ratios with digits that tell them from nothing.
std::string value_text(double value, const MeasureInfo& info, int digits = 5);

/// "limit reached", "not suited": an outcome in words.
std::string outcome_text(const Run& run);

/// What a row says beside its numbers: why there are none, and the first words of each warning.
std::string notes_of(const Record& record);

/// Whether there is anything by which strategies could be told apart: a value asked for, or a reference.
bool can_rank(const std::vector<Record>& records);

/// A row a strategy: its main measures, their errors, iterations and times.
Table comparison_table(const std::vector<Record>& records, const Ranking& ranking);

/// What was expected of the runs, and what came.
Table verdicts_table(const std::vector<Record>& records);

/// "take lattice: E +0.001 %, Poisson's ratio 0.2500 (target: …), 3 ms".
std::string advice_text(const Ranking& ranking, bool colours);

}  // namespace elastin::lab
