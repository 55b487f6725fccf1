#pragma once
#include <optional>
#include <string>

#include "lab/identify/machine_file.h"
#include "lab/scene/identify.h"

namespace elastin::lab {

const DataQuantity* find_quantity(const std::string& name);

/// A column that holds a quantity.
struct Column {
  const DataQuantity* quantity = nullptr;
  std::string name, unit;        ///< as the file, or the scene, states them
  std::optional<double> factor;  ///< that makes its numbers SI; none: no unit, or no unit of the quantity
  std::size_t number = 0;        ///< of the file's columns
  /// How sure it is what it holds: by the scene, by the quantity's own name, by a name that machines use, by such a
  /// name of a position, whose first value is subtracted.
  enum class Source { scene, own_name, machine_name, position } source = Source::scene;
  bool pressing = false;                     ///< whether its name says that it counts compression
  std::optional<HomogeneousTest> held = {};  ///< the state that its name says a modulus is of
};

struct ChosenColumns {
  Column along, up;  ///< what is prescribed; the response
};

/// The columns of this table that a test of this kind takes. Throws InputError at the head: no unit, nominal or true
/// not stated, a column that is missing, misspelt or there twice.
ChosenColumns choose_columns(const MachineTable& table, const DataTest& test);

/// The column of the other direction of a test in two: its name has a y where this one has an x, or a 2 for a 1, or the
/// reverse; none if there is no such column.
std::optional<Column> across(const MachineTable& table, Column column);

/// Names of the other columns with the quantity of one that was chosen by its name.
std::vector<std::string> passed_over(const MachineTable& table, const DataTest& test, const ChosenColumns& chosen);

/// Whether the table has columns for both, whatever their units.
bool suits(const MachineTable& table, const DataTest& test);

/// Whether the name of any of its columns is known.
bool has_meaning(const MachineTable& table);

/// The number of a column by its name, with or without its unit, or by its number from 1; none if there is no such
/// column.
std::optional<std::size_t> find_column(const MachineTable& table, const std::string& name);

/// A column by one of these names, in small letters without marks, and what makes its numbers SI: by the unit in its
/// head or in the row below; none if there is no such column. Throws InputError at the head where the unit is missing.
struct NamedColumn {
  std::size_t number;
  double factor;
};
std::optional<NamedColumn> find_column(const MachineTable& table, const DataTest& test,
                                       const std::vector<std::string>& names, const Dimension& unit);

}  // namespace elastin::lab
