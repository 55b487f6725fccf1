#include <map>
#include <set>

#include "c/handles.h"
#include "core/base/named.h"

namespace elastin::c {
namespace {

using Rows = std::vector<const Descriptor*>;

template <class Row>
Rows rows_of(const Table<Row>& table) {
  Rows rows;
  for (const auto& row : table) rows.push_back(row.get());
  return rows;
}

/// All that a program may name. Strategies that only change another go by an ending of its name and are left out.
const std::map<std::string, Rows>& tables() {
  static const std::map<std::string, Rows> all = [] {
    Rows strategies;
    for (const Strategy& strategy : catalog().strategies())
      if (strategy.kind != StrategyKind::wrapper) strategies.push_back(&strategy);
    return std::map<std::string, Rows>{{"strategies", strategies},
                                       {"steppers", rows_of(catalog().steppers)},
                                       {"linear_solvers", rows_of(catalog().linear_solvers)},
                                       {"loads", rows_of(catalog().loads)},
                                       {"material_laws", rows_of(catalog().material_laws)}};
  }();
  return all;
}

const Rows& rows_named(const std::string& table) {
  const auto found = tables().find(table);
  if (found != tables().end()) return found->second;
  throw InputError("table '" + table + "' is not known" +
                   suggestion(table, names_of(tables(), [](const auto& row) { return row.first; })));
}

const Descriptor& numbered(const Rows& rows, std::size_t number) {
  if (number >= rows.size())
    throw InputError("row " + std::to_string(number) + ": there are " + std::to_string(rows.size()) + ", from 0");
  return *rows[number];
}

/// The unit's name, which lives on. Made for all at once, so that threads may ask.
const char* unit_of(const Dimension& dimension) {
  static const std::set<std::string> all = [] {
    std::set<std::string> units;
    for (const auto& [name, rows] : tables())
      for (const Descriptor* row : rows)
        for (const ParameterInfo& info : row->parameters) units.insert(si_unit(info.unit));
    return units;
  }();
  return all.find(si_unit(dimension))->c_str();
}

void put_row(const Descriptor& row, const char** name, const char** summary, std::size_t* parameter_count) {
  if (name) *name = row.name.c_str();
  if (summary) *summary = row.summary.c_str();
  if (parameter_count) *parameter_count = row.parameters.size();
}

void put_parameter(const Descriptor& row, std::size_t number, elastin_parameter* parameter) {
  if (number >= row.parameters.size())
    throw InputError("parameter " + std::to_string(number) + ": " + row.name + " has " +
                     std::to_string(row.parameters.size()) + ", from 0");
  const ParameterInfo& info = row.parameters[number];
  const elastin_parameter values{0,         info.name.c_str(), unit_of(info.unit), info.text.c_str(), info.low,
                                 info.high, info.fallback,     name_of(info.kind), info.required};
  put(values, parameter, "elastin_parameter");
}

}  // namespace
}  // namespace elastin::c

using elastin::c::given;
using elastin::c::guarded;
using elastin::c::numbered;
using elastin::c::rows_named;

extern "C" {

elastin_status elastin_row_count(const char* table, size_t* count) {
  return guarded([&] { given(count, "count") = rows_named(&given(table, "table")).size(); });
}

elastin_status elastin_row(const char* table, size_t number, const char** name, const char** summary,
                           size_t* parameter_count) {
  return guarded([&] {
    elastin::c::put_row(numbered(rows_named(&given(table, "table")), number), name, summary, parameter_count);
  });
}

elastin_status elastin_row_parameter(const char* table, size_t row, size_t number, elastin_parameter* parameter) {
  return guarded(
      [&] { elastin::c::put_parameter(numbered(rows_named(&given(table, "table")), row), number, parameter); });
}

elastin_status elastin_strategy_count(size_t* count) { return elastin_row_count("strategies", count); }

elastin_status elastin_strategy(size_t number, const char** name, const char** summary, size_t* parameter_count) {
  return elastin_row("strategies", number, name, summary, parameter_count);
}

elastin_status elastin_strategy_parameter(size_t strategy, size_t number, elastin_parameter* parameter) {
  return elastin_row_parameter("strategies", strategy, number, parameter);
}
}
