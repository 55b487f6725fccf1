#pragma once
#include <optional>
#include <string>
#include <vector>

#include "elastin/core/base/units.h"
#include "lab/report/records.h"

namespace elastin::lab {

/// The keys that a study changes, in the order in which they first come.
std::vector<std::string> varied_keys(const std::vector<Record>& records);

/// What a record has under one of them; "" where it has nothing.
std::string varied_text(const Record& record, const std::string& key);

/// A number of whatever unit it has.
struct VariedNumber {
  double number = 0;  ///< SI
  Dimension unit;
};

/// Of "10 kPa"; none of what is no number.
std::optional<VariedNumber> varied_number(const std::string& text);

}  // namespace elastin::lab
