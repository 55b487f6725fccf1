#pragma once
#include <cstddef>
#include <string>

namespace fuzz {

/// Which ways through the program a file has taken: those that the compiler marks with -fsanitize-coverage=trace-pc;
/// without it, what the message says, numbers and quotations apart.
void share_coverage();  ///< once, before processes are started
void begin_coverage();  ///< before each file
/// Whether a way was taken that none took before.
bool new_coverage(const std::string& message);
/// Ways known so far.
std::size_t coverage();

}  // namespace fuzz
