#pragma once
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/base/error.h"
#include "elastin/core/base/units.h"

namespace elastin {

/// What stands behind a parameter's name.
enum class ValueKind {
  number,
  whole,      ///< a whole number
  vector,     ///< three numbers of the unit
  direction,  ///< a unit vector: "x", "-z" or three numbers
  molecules,  ///< numbers of molecules, from 0
};
const char* name_of(ValueKind kind);

/// A value that something pluggable takes: scenes, C, Python, range errors, `elastin list` and documents come from it.
struct ParameterInfo {
  std::string name;
  Dimension unit;
  /// Admissible range of each number, ends included, and the default, SI. NaN: no such number, and the text says what
  /// happens without a value.
  double low = 0, high = 0, fallback = 0;
  std::string text;        ///< what it is, in a sentence
  bool above_low = false;  ///< whether `low` itself is not admissible
  ValueKind kind = ValueKind::number;
  bool required = false;  ///< whether it must be given; numbers alone have defaults
};

/// Values by parameter name, SI units; what is not named keeps its default.
using ParameterValues = std::map<std::string, double>;

/// What every pluggable thing says of itself: a row of a table is this and what makes the thing.
struct Descriptor {
  std::string name, summary, source;
  std::vector<ParameterInfo> parameters = {};
};

/// The parameter of this name. Throws InputError, with the nearest name, where there is no such parameter, or where the
/// value is out of its range. `owner` is how messages name the thing: "strategy lattice".
const ParameterInfo& checked_parameter(const std::string& owner, const std::vector<ParameterInfo>& parameters,
                                       const std::string& name, double value);

/// A value for every number that has a default: the given ones, checked as above, and defaults.
ParameterValues complete_values(const std::string& owner, const std::vector<ParameterInfo>& parameters,
                                const ParameterValues& given);

/// Things of one kind by name, in the order in which they were added: rows that are Descriptors. Filled explicitly; a
/// program copies a built-in table and adds rows of its own. Rows live as long as anybody has chosen them.
template <class Row>
class Table {
 public:
  using Shared = std::shared_ptr<const Row>;

  /// `kind` is how messages name a row: "stepper".
  explicit Table(std::string kind) : kind_(std::move(kind)) {}

  /// Throws InputError where the name is taken. Strong guarantee.
  void add(Row row) {
    for (const Shared& other : rows_)
      if (other->name == row.name) throw InputError("there is a " + kind_ + " '" + row.name + "' already");
    rows_.push_back(std::make_shared<const Row>(std::move(row)));
  }
  /// Throws InputError with the nearest name and the list of what there is.
  const Shared& find(const std::string& name) const {
    for (const Shared& row : rows_)
      if (row->name == name) return row;
    throw InputError(kind_ + " '" + name + "' is not known here" + suggestion(name, names()));
  }
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const Shared& row : rows_) names.push_back(row->name);
    return names;
  }
  const std::string& kind() const { return kind_; }
  auto begin() const { return rows_.begin(); }
  auto end() const { return rows_.end(); }
  std::size_t size() const { return rows_.size(); }
  const Row& operator[](std::size_t number) const { return *rows_[number]; }

 private:
  std::string kind_;
  std::vector<Shared> rows_;
};

/// A row that was chosen: by its name among those that come with Elastin, or out of a table with rows of one's own. As
/// light as a pointer; never none.
template <class Row, const Table<Row>& (*built_in)()>
class Choice {
 public:
  /// Throws InputError on an unknown name.
  Choice(const char* name) : row_(built_in().find(name)) {}
  Choice(const std::string& name) : row_(built_in().find(name)) {}
  Choice(std::shared_ptr<const Row> row) : row_(std::move(row)) {}
  const Row& operator*() const { return *row_; }
  const Row* operator->() const { return row_.get(); }
  bool operator==(const Choice&) const = default;

 private:
  std::shared_ptr<const Row> row_;
};

}  // namespace elastin
