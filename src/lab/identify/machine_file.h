#pragma once
#include <optional>
#include <string>
#include <vector>

#include "elastin/core/base/units.h"
#include "lab/format/csv.h"

namespace elastin::lab {

/// One block of a file: names of columns and the rows below them. Numbers are written with a decimal point; texts have
/// no blanks around them. Rows may be of other lengths than the head.
struct MachineTable : Csv {
  std::vector<std::string> units;   ///< of the row below the names, one a column; empty: there is no such row
  int units_line = 0;               ///< where that row stands
  std::vector<std::size_t> clocks;  ///< columns of times as hours:minutes:seconds; in seconds here
  std::vector<int> passed;          ///< lines of words between its rows, as that of a new page
  bool preceded = false;            ///< whether lines that are neither blank nor remarks stand above it
  bool named = true;                ///< false: there are no names, and the columns are called by their numbers
};

/// What a testing machine wrote and what was recognised in it.
struct MachineFile {
  std::string encoding = "UTF-8";
  char separator = ',';              ///< ' ' stands for runs of blanks
  char decimal = '.';                ///< mark of decimals
  bool thousands = false;            ///< whether marks set thousands apart
  std::string text;                  ///< in UTF-8
  std::vector<MachineTable> tables;  ///< in the order of the file
  /// What differs from a plain CSV file, for the reader: "semicolons between the fields, decimal commas, …"; "" if
  /// nothing does.
  std::string recognised(const MachineTable& used) const;
};

/// Reads text in UTF-8, UTF-16, Windows-1252 (Latin-1) or GB 18030 (GB 2312, GBK). Lines that begin with # are remarks.
/// @param decimal '.' or ',' where the file leaves it open; 0: as recognised
/// Throws InputError: not readable, a spreadsheet or another file that is no text, nothing in it, numbers that may be
/// with decimal commas and with marks between thousands.
MachineFile load_machine_file(const std::string& path, char decimal = 0);

/// The SI value of 1 of a unit as machines write it ("sec", "mm/mm", "lbf", "N/mm²"); none if it is no unit of that
/// dimension.
std::optional<double> machine_unit(const std::string& unit, const Dimension& dimension);
/// Whether this is a unit of any dimension that columns have; a "-" is none.
bool is_machine_unit(const std::string& unit);

}  // namespace elastin::lab
