#pragma once
#include <string>
#include <vector>

namespace elastin::lab {

/// A table as it stands in a CSV file; quotes hold commas and line breaks. Lines before the head that begin with # are
/// remarks.
struct Csv {
  std::string path;
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
  int head_line = 1;  ///< of the file, from 1
  int line(std::size_t row) const { return head_line + 1 + static_cast<int>(row); }
  /// Number of the column; throws InputError with the nearest name.
  std::size_t column(const std::string& name) const;
  bool has(const std::string& name) const;
  /// The number that stands there; NaN where nothing does. Throws InputError naming the line.
  double number(std::size_t row, std::size_t column) const;
};

/// Throws InputError naming file and line: not readable, empty, rows of other lengths than the head.
Csv load_csv(const std::string& path);

}  // namespace elastin::lab
