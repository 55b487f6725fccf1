#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "elastin/core/base/text.h"
#include "lab/identify/columns.h"
#include "lab/identify/data.h"
#include "lab/run/config_names.h"

namespace elastin::lab {
namespace {

/// Names of columns in small letters, without marks.
const std::array<std::vector<std::string>, 3> kPlaces{{{"x", "x0", "x 0", "position x", "x position"},
                                                       {"y", "y0", "y 0", "position y", "y position"},
                                                       {"z", "z0", "z 0", "position z", "z position"}}};
const std::array<std::vector<std::string>, 3> kMotions{
    {{"ux", "u x", "u", "u1", "dx", "displacement x", "x displacement", "disp x"},
     {"uy", "u y", "v", "u2", "dy", "displacement y", "y displacement", "disp y"},
     {"uz", "u z", "w", "u3", "dz", "displacement z", "z displacement", "disp z"}}};
const std::vector<std::string> kDeviation{"sigma", "sigma u", "deviation", "standard deviation"};

/// The block with places and displacements.
const MachineTable& choose_table(const MachineFile& file, const DataTest& test) {
  const auto& tables = file.tables;
  if (test.block > static_cast<int>(tables.size()))
    test.fail("block: " + test.file + " has " + counted(std::ssize(tables), "block"));
  if (test.block > 0) return tables[test.block - 1];
  for (const MachineTable& table : tables)
    if (find_column(table, test, kPlaces[0], dimension::length)) return table;
  return tables.front();
}

}  // namespace

MeasuredData load_points(const DataTest& test) {
  const MachineFile file = open_data(test);
  const MachineTable& table = choose_table(file, test);
  const auto fail = [&](const std::string& message) {
    throw InputError(SourceLocation{table.path, table.head_places.front().line}, message);
  };
  std::array<std::optional<NamedColumn>, 3> places, motions;
  for (int i = 0; i < 3; ++i) {
    places[i] = find_column(table, test, kPlaces[i], dimension::length);
    motions[i] = find_column(table, test, kMotions[i], dimension::length);
  }
  if (!places[0] || !places[1]) fail("no columns 'x [mm]' and 'y [mm]' say where the points are at rest");
  if (!motions[0] && !motions[1] && !motions[2])
    fail("no column says how the points moved; one to three of: ux [mm], uy [mm], uz [mm]");
  const auto deviation = find_column(table, test, kDeviation, dimension::length);
  MeasuredData data{find_quantity("load_factor"), find_quantity("displacement"), {}, {}, {}, table.path};
  std::optional<NamedColumn> load;
  for (const std::string& name : test.kind->along) {
    const DataQuantity* quantity = find_quantity(name);
    std::string simple = name;
    std::replace(simple.begin(), simple.end(), '_', ' ');
    if (load = find_column(table, test, {simple}, quantity->unit); load) {
      data.along = quantity;
      break;
    }
  }

  struct PointReading {
    double load, moved, deviation;
    Vector3 place;
    int axis, line;
  };
  std::vector<PointReading> readings;
  int lost = 0, at_rest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; motions[axis] && row < table.rows.size(); ++row) {
      const bool counts = std::all_of(test.rows.begin(), test.rows.end(), [&](const auto& rule) {
        const auto named = find_column(table, rule.first);
        return table.text(row, named ? *named : table.column(rule.first)) == rule.second;
      });
      if (!counts) continue;
      const auto value = [&](const std::optional<NamedColumn>& column, double otherwise) {
        return column ? table.number(row, column->number) * column->factor : otherwise;
      };
      const PointReading reading{value(load, 1),
                                 value(motions[axis], NAN),
                                 value(deviation, 1),
                                 {value(places[0], NAN), value(places[1], NAN), value(places[2], NAN)},
                                 axis,
                                 table.line(row)};
      const bool placed = reading.place.head<2>().allFinite() && (!places[2] || std::isfinite(reading.place.z()));
      if (!std::isfinite(reading.moved) || !std::isfinite(reading.load) || !placed) {
        ++lost;
        continue;
      }
      if (!(reading.deviation > 0)) throw InputError(SourceLocation{table.path, reading.line}, "sigma must be above 0");
      if (reading.load == 0) {
        ++at_rest;
        continue;
      }
      readings.push_back(reading);
    }
  }
  const auto count = static_cast<Eigen::Index>(readings.size());
  if (count == 0)
    test.fail(table.path + " has no displacement of a point under load" +
              (test.rows.empty() ? "" : " among the chosen `rows`"));
  data.x.resize(count), data.y.resize(count), data.places.resize(3, count);
  if (deviation) data.deviations.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const PointReading& reading = readings[static_cast<std::size_t>(i)];
    data.x[i] = reading.load, data.y[i] = reading.moved, data.places.col(i) = reading.place;
    if (deviation) data.deviations[i] = reading.deviation;
    data.axes.push_back(reading.axis), data.lines.push_back(reading.line);
  }
  if (data.y.isZero(0)) fail("no point moved: all displacements are 0");
  if (const std::string note = file.recognised(table); !note.empty()) data.notes.push_back(note);
  if (lost > 0) data.notes.push_back(counted(lost, "displacement") + " without a number left out");
  if (at_rest > 0) data.notes.push_back(counted(at_rest, "displacement") + " without load left out");
  if (!load) data.notes.push_back("no column says at which load: all at the whole one of the scene");
  return data;
}

}  // namespace elastin::lab
