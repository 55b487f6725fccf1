#pragma once
#include <string>
#include <vector>

#include "lab/report/records.h"

namespace elastin::lab {

/// The JSON of README: {"runs": [...]}, SI units. Numbers that are not finite become null.
std::string json_text(const std::vector<Record>& records);

/// Another form of a record's line, or another meaning of a number in it, takes another version.
inline constexpr int kRecordVersion = 1;

/// One run as one line of JSON, without a line break: what json_text has of it, and what else the record holds.
std::string json_line(const Record& record);

/// The record that such a line came from, equal but for its states and spring constants, the forces and pressures of
/// contact on each molecule, and numbers that were not finite, which are NaN. Throws InputError if it is no such line.
Record record_of_json(const std::string& line);

/// What two records of the same run disagree about: "measures/effective_modulus: 5000.1 and 5000.2", the first of them;
/// "" if they agree. Times, threads and the scene's path do not count.
std::string disagreement(const Record& one, const Record& other);

}  // namespace elastin::lab
