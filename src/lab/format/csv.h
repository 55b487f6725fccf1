#pragma once
#include <string>
#include <vector>

#include "elastin/core/base/error.h"

namespace elastin::lab {

/// A table as it stands in a CSV file; quotes hold commas and line breaks. Lines before the head that begin with # are
/// remarks.
struct Csv {
  std::string path;
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
  struct Place {
    int line = 1, column = 1;  ///< from 1
  };
  std::vector<Place> head_places;  ///< where each field begins
  std::vector<std::vector<Place>> places;
  int line(std::size_t row) const { return places[row].front().line; }
  SourceLocation location(const Place& place) const { return {path, place.line, place.column}; }
  /// Number of the column; throws InputError with the nearest name.
  std::size_t column(const std::string& name) const;
  bool has(const std::string& name) const;
  /// The text that stands there; "" where the row ends before this column.
  const std::string& text(std::size_t row, std::size_t column) const;
  /// The number that stands there; NaN where nothing does. Throws InputError naming line and column.
  double number(std::size_t row, std::size_t column) const;
};

/// Throws InputError naming file, line and column: not readable, empty, rows of other lengths than the head.
Csv load_csv(const std::string& path);

}  // namespace elastin::lab
