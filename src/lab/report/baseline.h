#pragma once
#include <string>
#include <vector>

#include "lab/report/records.h"
#include "lab/report/table.h"

namespace elastin::lab {

/// The runs in the folder of an earlier `compare --out` or `run --out`. Throws InputError: folder and what is missing.
std::vector<Record> load_baseline(const std::string& folder);

/// Each run that the earlier ones have too (scene, strategy, threads, what a study changes): its main measures then and
/// now, how much they changed relatively, and both times. No rows where there is nothing in common.
Table change_table(const std::vector<Record>& records, const std::vector<Record>& baseline);

}  // namespace elastin::lab
