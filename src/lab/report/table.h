#pragma once
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/base/text.h"
#include "elastin/core/base/units.h"
#include "lab/report/records.h"

namespace elastin::lab {

enum class Tone { plain, good, poor, bad, faint, bold };

struct TableCell {
  std::string text;
  Tone tone = Tone::plain;
  bool right = false;  ///< flush right, as numbers are
  /// What it is sorted by on a page; NaN = by its text.
  double value = std::numeric_limits<double>::quiet_NaN();
};

/// A number, flush right.
inline TableCell number_cell(std::string text, double value, Tone tone = Tone::plain) {
  return {std::move(text), tone, true, value};
}

/// What a page knows of a row in addition to its cells.
struct RowTraits {
  std::string series = {};   ///< what it is called in plots; empty = by its first cell
  std::string outcome = {};  ///< what it can be filtered by; empty = not at all
};

/// Rows of cells, aligned by what a terminal shows. Colours only if requested.
class Table {
 public:
  explicit Table(std::vector<std::string> head) : head_(std::move(head)) {}
  void add(std::vector<TableCell> row, RowTraits traits = {}) {
    rows_.push_back(std::move(row));
    traits_.push_back(std::move(traits));
  }
  bool empty() const { return rows_.empty(); }
  /// Leaves out rows of which no cell has this word, in either case.
  void keep_rows_with(const std::string& word);
  std::string text(bool colours, const std::string& indent = "  ") const;
  /// As HTML, sortable by its heads. `colour` of the mark before the first cell of a row, by its series; may be empty.
  std::string html(const std::function<std::string(const std::string& series)>& colour = {}) const;

 private:
  std::vector<std::string> head_;
  std::vector<std::vector<TableCell>> rows_;
  std::vector<RowTraits> traits_;
};

std::string painted(const std::string& text, Tone tone, bool colours);

/// "4.9945 kPa", "3.3333 mm": a value in SI units with a prefix that keeps it readable.
std::string readable(double value, const Dimension& dimension, int digits = 5);
/// The same of a measure, in its own unit ("N m" of a torque).
std::string readable(double value, const MeasureInfo& measure, int digits = 5);

/// "+0.02 %" with as many digits as its size needs; "" for NaN.
std::string percent(double ratio);

/// "120 µs", "1.2 ms", "3.40 s"
std::string readable_seconds(double seconds);

/// The comparison of one scene: a row a strategy, what was expected, warnings, and the recommended strategy.
std::string comparison_text(const std::vector<Record>& records, bool colours);

/// One run in full: every measure, its curve, expectations, warnings.
std::string run_text(const Record& record, bool colours, bool whole_curve = false);

}  // namespace elastin::lab
