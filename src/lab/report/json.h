#pragma once
#include <string>
#include <vector>

#include "lab/report/records.h"

namespace elastin::lab {

/// The JSON of README: {"runs": [...]}, SI units. Numbers that are not finite become null.
std::string json_text(const std::vector<Record>& records);

/// One run as one line of JSON, without a line break.
std::string json_line(const Record& record);

/// The record that such a line came from, but for what JSON does not hold: constants, snapshots, and what the scene
/// says beside. Throws InputError if it is no such line.
Record record_of_json(const std::string& line);

}  // namespace elastin::lab
