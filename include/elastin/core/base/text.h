#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace elastin {

/// A number as people write it, with at most this many digits: "0.25", "1e+06".
std::string number(double value, int digits = 6);

/// "1 molecule", "3 molecules"; a plural that is more than an s is given.
std::string counted(std::ptrdiff_t count, const std::string& singular, const std::string& plural = "");

/// "a, b and c"
std::string listed(const std::vector<std::string>& items, const std::string& before_last = "and");

}  // namespace elastin
