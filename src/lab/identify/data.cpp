#include "lab/identify/data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>

#include "elastin/core/base/text.h"
#include "elastin/core/base/units.h"
#include "lab/format/csv.h"
#include "lab/run/config_names.h"

namespace elastin::lab {
namespace {

constexpr double kMostStretch = 15;  // of any material; beyond it a column is in per cent or no stretch

const DataQuantity* find_quantity(const std::string& name) {
  for (const DataQuantity& quantity : data_quantities())
    if (quantity.name == name) return &quantity;
  return nullptr;
}

/// What a column holds: a quantity and the factor that makes its numbers SI.
struct Column {
  const DataQuantity* quantity;
  double factor;
  std::size_t number;  ///< of the file's columns
};

struct Head {
  std::string name, unit;
};

/// The SI value of 1 of this unit; none if it is no unit of that dimension.
std::optional<double> factor_of(const std::string& unit, const Dimension& dimension) {
  if (unit.empty() || unit == "-" || unit == "1")
    return dimension == dimension::none ? std::optional(1.) : std::nullopt;
  try {
    const Quantity one = parse_quantity("1 " + unit, dimension);
    return one.has_unit ? std::optional(one.value) : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

std::string trimmed(std::string text) {
  const auto blank = [](unsigned char c) { return std::isspace(c); };
  text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), blank));
  text.erase(std::find_if_not(text.rbegin(), text.rend(), blank).base(), text.end());
  return text;
}

/// "force" and "N" of "force [N]", "force (N)", "force / N", "force in N" or "force_N".
Head split(const std::string& text) {
  const std::string head = trimmed(text);
  for (const auto& [open, close] :
       {std::pair{" [", "]"}, {" (", ")"}, {" / ", ""}, {" in ", ""}, {"[", "]"}, {"(", ")"}})
    if (const std::size_t at = head.find(open); at != std::string::npos && head.ends_with(close)) {
      const std::size_t from = at + std::string(open).size();
      return {trimmed(head.substr(0, at)), trimmed(head.substr(from, head.size() - from - std::string(close).size()))};
    }
  for (const DataQuantity& quantity : data_quantities())
    if (head.starts_with(quantity.name + "_") && factor_of(head.substr(quantity.name.size() + 1), quantity.unit))
      return {quantity.name, head.substr(quantity.name.size() + 1)};
  return {head, ""};
}

std::vector<std::string> names_of(const std::vector<const DataQuantity*>& quantities) {
  std::vector<std::string> names;
  for (const DataQuantity* quantity : quantities) names.push_back(quantity->name);
  return names;
}

std::string shown(const DataQuantity& quantity) {
  const std::string examples = unit_examples(quantity.unit), unit = examples.substr(examples.find(' ') + 1);
  return quantity.ratio
             ? quantity.name
             : quantity.name + " [" + (quantity.name == "angle" ? "deg" : unit.substr(0, unit.find(','))) + "]";
}

class DataFile {
 public:
  explicit DataFile(const DataTest& test) : test_(test) {
    std::error_code ignored;
    if (!std::filesystem::exists(test.file, ignored))
      test.fail("file: '" + test.file + "': " + missing_file(test.file));
    csv_ = load_csv(test.file);
    for (std::size_t i = 0; i < csv_.head.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (trimmed(csv_.head[i]) == trimmed(csv_.head[j]))
          fail_at_head("two columns are called '" + trimmed(csv_.head[i]) + "'; give each a name of its own");
    choose_rows();
  }

  MeasuredData read() {
    const std::vector<Column> known = known_columns();
    const Column along = choose(known, test_.kind->along, "is prescribed"),
                 up = choose(known, test_.kind->up, "answers");
    MeasuredData data{along.quantity, up.quantity, {}, {}, {}, csv_.path};
    std::vector<double> x, y;
    const double from = test_.from ? test_.from(along.quantity->unit) : -INFINITY,
                 to = test_.to ? test_.to(along.quantity->unit) : INFINITY;
    for (const std::size_t row : rows_) {
      const double at = value(row, along), response = value(row, up);
      check_value(row, *along.quantity, at);
      if (at < from || at > to) continue;
      x.push_back(at), y.push_back(response);
      data.lines.push_back(csv_.line(row));
    }
    data.x = Eigen::Map<const VectorX>(x.data(), static_cast<Eigen::Index>(x.size()));
    data.y = Eigen::Map<const VectorX>(y.data(), static_cast<Eigen::Index>(y.size()));
    check_points(data);
    return data;
  }

 private:
  [[noreturn]] void fail_at_head(const std::string& message) const {
    throw InputError(SourceLocation{csv_.path, csv_.head_places.front().line}, message);
  }
  [[noreturn]] void fail_at(int line, const std::string& message) const {
    throw InputError(SourceLocation{csv_.path, line}, message);
  }

  void choose_rows() {
    for (std::size_t row = 0; row < csv_.rows.size(); ++row) {
      bool chosen = true;
      for (const auto& [column, text] : test_.rows) chosen &= trimmed(csv_.rows[row][csv_.column(column)]) == text;
      if (chosen) rows_.push_back(row);
    }
    if (!rows_.empty() || test_.rows.empty()) return;
    const auto& [column, text] = test_.rows.back();
    std::vector<std::string> words;
    for (const auto& fields : csv_.rows)
      if (const std::string& word = fields[csv_.column(column)];
          std::find(words.begin(), words.end(), word) == words.end())
        words.push_back(word);
    test_.fail("rows: no row of " + csv_.path + " has '" + text + "' as its " + column + suggestion(text, words));
  }

  /// Columns whose heads, or what the scene says of them, name a quantity with its unit.
  std::vector<Column> known_columns() const {
    std::vector<Column> known;
    for (const auto& [head, meaning] : test_.columns) {
      const auto same = [&, name = head](const std::string& other) { return trimmed(other) == name; };
      if (std::none_of(csv_.head.begin(), csv_.head.end(), same))
        test_.fail("columns: " + csv_.path + " has no column '" + head + "'" + suggestion(head, csv_.head));
    }
    for (std::size_t number = 0; number < csv_.head.size(); ++number) {
      std::string text = csv_.head[number];
      for (const auto& [head, meaning] : test_.columns)
        if (trimmed(text) == head) text = meaning;
      const Head head = split(text);
      if (head.name == "stress")
        fail_at_head("column '" + text + "': is it nominal_stress (force over section at rest) or true_stress?");
      if (head.name == "strain") fail_at_head("column '" + text + "': is it nominal_strain, true_strain or stretch?");
      const DataQuantity* quantity = find_quantity(head.name);
      if (!quantity) continue;
      const bool angle_without = quantity->name == "angle" && head.unit.empty();
      if ((!quantity->ratio && head.unit.empty()) || angle_without)
        fail_at_head("column '" + text + "' has no unit; write for example '" + shown(*quantity) + "'");
      const auto factor = factor_of(head.unit, quantity->unit);
      if (!factor)
        fail_at_head("column '" + text + "': '" + head.unit + "' is no unit of " + quantity->name +
                     "; write for example '" + shown(*quantity) + "'");
      known.push_back({quantity, *factor, number});
    }
    return known;
  }

  /// The only column with one of these quantities.
  Column choose(const std::vector<Column>& known, const std::vector<std::string>& wanted,
                const std::string& role) const {
    std::vector<Column> found;
    for (const Column& column : known)
      if (std::find(wanted.begin(), wanted.end(), column.quantity->name) != wanted.end()) found.push_back(column);
    // Of a specimen both may be loads or displacements; what stands first is prescribed.
    if (found.size() > 1 && !test_.kind->homogeneous && !test_.kind->in_time)
      return role == "answers" ? found.back() : found.front();
    if (found.size() == 1) return found.front();
    std::vector<const DataQuantity*> quantities;
    for (const std::string& name : wanted) quantities.push_back(find_quantity(name));
    std::vector<std::string> allowed;
    for (const DataQuantity* quantity : quantities) allowed.push_back(shown(*quantity));
    const std::string all = fmt::format("{}", fmt::join(allowed, ", "));
    if (found.size() > 1)
      fail_at_head("two columns say what " + role + ", " + found[0].quantity->name + " and " + found[1].quantity->name +
                   "; leave one out, or name it otherwise");
    for (const Column& column : known)
      if (known.size() > 1)
        fail_at_head("no column says what " + role + " in a test of kind " + test_.kind->name + "; '" +
                     column.quantity->name + "' does not; one of: " + all);
    for (const std::string& head : csv_.head)
      if (const std::string near = nearest_name(split(head).name, names_of(quantities)); !near.empty())
        fail_at_head("column '" + trimmed(head) + "' is not known; did you mean '" + near + "'?");
    fail_at_head("no column says what " + role + " in a test of kind " + test_.kind->name + "; one of: " + all +
                 "; or say in the scene what a head means, columns: {\"" +
                 trimmed(role == "answers" ? csv_.head.back() : csv_.head.front()) + "\": " + allowed.back() + "}");
  }

  double value(std::size_t row, const Column& column) const {
    const std::string text = trimmed(csv_.rows[row][column.number]);
    const std::string name = trimmed(csv_.head[column.number]);
    if (text.empty()) fail_at(csv_.line(row), name + ": nothing stands there; leave the row out, or give its number");
    std::size_t used = 0;
    double number = NAN;
    try {
      number = std::stod(text, &used);
    } catch (const std::exception&) {
    }
    if (used != text.size() || text.find_first_of("xX") != std::string::npos)
      fail_at(csv_.line(row), name + ": '" + text + "' is no number");
    if (!std::isfinite(number))
      fail_at(csv_.line(row), name + ": '" + text + "' is no measured value; leave the row out");
    return number * column.factor;
  }

  void check_value(std::size_t row, const DataQuantity& quantity, double value) const {
    const int line = csv_.line(row);
    if (quantity.name == "stretch" && !(value > 0))
      fail_at(line, "stretch " + number(value) + " is impossible: it is 1 at rest; is the column nominal_strain?");
    if (quantity.name == "stretch" && value > kMostStretch)
      fail_at(line, "stretch " + number(value) + " is beyond any material: in per cent? then head it 'stretch [%]'");
    if (quantity.name == "nominal_strain" && !(value > -1))
      fail_at(line, "nominal strain " + number(value) + " is impossible: it must be above -1");
    if (quantity.name.ends_with("strain") && value > kMostStretch)
      fail_at(line, "strain " + number(value) + " is beyond any material: in per cent? then head it '" + quantity.name +
                        " [%]'");
    if (quantity.name == "time" && value < 0) fail_at(line, "a time of " + number(value) + " s is before the test");
  }

  void check_points(const MeasuredData& data) const {
    const Eigen::Index count = data.x.size();
    if (count < 2)
      test_.fail(csv_.path + " has " + counted(count, "point") +
                 (test_.from || test_.to ? " between `from` and `to`" : "") + "; a curve needs two or more");
    double direction = 0;
    for (Eigen::Index i = 1; i < count; ++i) {
      const double step = data.x[i] - data.x[i - 1];
      if (direction == 0) direction = step;
      if (step * direction < 0)
        fail_at(data.lines[i], data.along->name +
                                   " goes back; give one branch, in order: sort the rows, or choose some by `rows`, "
                                   "`from` and `to`");
    }
    const int first = data.lines.front();
    if (direction == 0) fail_at(first, data.along->name + " is the same in all rows; a curve needs several values");
    if ((data.y.array() == data.y[0]).all())
      fail_at(first, data.up->name + " is the same in all rows; a curve needs several values");
  }

  const DataTest& test_;
  Csv csv_;
  std::vector<std::size_t> rows_;
};

/// A test that pulls makes the material longer: else columns or signs are swapped.
void check_signs(const MeasuredData& data) {
  double largest = 0;
  for (Eigen::Index i = 0; i < data.y.size(); ++i) largest = std::max(largest, std::abs(data.y[i]));
  int wrong = 0, line = 0;
  for (Eigen::Index i = 0; i < data.y.size(); ++i) {
    if (data.x[i] * data.y[i] >= 0 || std::abs(data.y[i]) < 0.02 * largest) continue;
    if (wrong++ == 0) line = data.lines[i];
  }
  if (2 * wrong > data.y.size())
    throw InputError(SourceLocation{data.file, line},
                     "the stress pulls where the strain presses, or the reverse, here and in " +
                         counted(wrong - 1, "other row") +
                         ": are the columns swapped, or is a strain headed as stretch?");
}

/// A first point without strain and stress is no information, and relative residuals cannot be over it.
void leave_out_rest(MeasuredData& data) {
  if (data.x.size() < 3 || data.x[0] != 0 || data.y[0] != 0) return;
  data.x = VectorX(data.x.tail(data.x.size() - 1)), data.y = VectorX(data.y.tail(data.y.size() - 1));
  data.lines.erase(data.lines.begin());
}

}  // namespace

MeasuredData load_data(const DataTest& test) { return DataFile(test).read(); }

MeasuredData as_strain_and_stress(const DataTest& test, MeasuredData data) {
  const std::string along = data.along->name, up = data.up->name;
  const auto need = [&](double value, const char* key, const std::string& what) {
    if (!(value > 0)) test.fail(std::string("key '") + key + "' is missing: the data have a " + what);
    return value;
  };
  if (along == "stretch") data.x.array() -= 1;
  if (along == "true_strain") data.x = data.x.array().unaryExpr([](double e) { return std::expm1(e); }).matrix();
  if (along == "displacement") data.x /= need(test.length, "length", "displacement");
  if (up == "force") data.y /= need(test.cross_section, "cross_section", "force");
  if (up == "true_stress") data.y = data.y.cwiseQuotient((1 + data.x.array()).matrix());
  if (!test.kind->in_time) {
    check_signs(data);
    data.along = find_quantity(test.kind->homogeneous == HomogeneousTest::shear ? "shear" : "nominal_strain");
    if (test.relative) leave_out_rest(data);
  }
  data.up = find_quantity("nominal_stress");
  return data;
}

}  // namespace elastin::lab
