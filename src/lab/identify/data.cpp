#include "lab/identify/data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "elastin/core/base/text.h"
#include "lab/identify/columns.h"
#include "lab/report/table.h"
#include "lab/run/config_names.h"

namespace elastin::lab {
namespace {

constexpr double kMostStretch = 15;   // of any material; beyond it a column is in per cent or no stretch
constexpr double kManyStrains = 1.5;  // beyond which a strain without a unit may be in per cent
constexpr Eigen::Index kManyRows = 500, kManyEquilibria = 50;  // that show the shape of any curve: more are averaged
constexpr double kNoticedZero = 0.01;  // of the range, beyond which a zero point elsewhere is named

class DataFile {
 public:
  explicit DataFile(const DataTest& test) : test_(test) {
    file_ = open_data(test);
    table_ = &choose_table();
    columns_ = choose_columns(*table_, test);
    for (std::size_t row = 0; row < table_->rows.size(); ++row)
      if (chosen(row)) rows_.push_back(row);
    if (rows_.empty() && !test.rows.empty()) fail_at_rows();
    while (!rows_.empty() && (is_behind(rows_.back()) || (rows_.size() > 1 && is_named(rows_.back()))))
      rows_.pop_back(), ++behind_;
  }

  MeasuredData read() const {
    MeasuredData data{columns_.along.quantity, columns_.up.quantity, {}, {}, {}, table_->path};
    const Dimension& unit = data.along->unit;
    const double from = test_.from ? test_.from(unit) : -INFINITY, to = test_.to ? test_.to(unit) : INFINITY;
    std::vector<double> x, y;
    std::vector<std::size_t> taken;
    for (const std::size_t row : rows_) {
      const double at = value(row, columns_.along);
      if (at < from || at > to) continue;
      check_value(row, *data.along, at);
      x.push_back(at), y.push_back(value(row, columns_.up));
      data.lines.push_back(table_->line(row)), taken.push_back(row);
    }
    data.x = Eigen::Map<const VectorX>(x.data(), static_cast<Eigen::Index>(x.size()));
    data.y = Eigen::Map<const VectorX>(y.data(), static_cast<Eigen::Index>(y.size()));
    if (data.x.size() < (test_.kind->of_scene() ? 1 : 2))
      test_.fail(data.file + " has " + counted(data.x.size(), "point") +
                 (test_.from || test_.to ? " between `from` and `to`" : "") + "; a curve needs two or more");
    note_recognised(data);
    warn_of_per_cent(data);
    warn_of_prefixes(data);
    if (test_.kind->homogeneous == HomogeneousTest::equibiaxial)
      for (const Column* column : {&columns_.along, &columns_.up}) compare_across(*column, taken, data);
    if (behind_ > 0) data.notes.push_back(counted(behind_, "row") + " behind the end of these columns left out");
    if (columns_.along.source == Column::Source::position) {
      data.notes.push_back(fmt::format("positions count from the first, {}", readable(data.x[0], unit)));
      data.x.array() -= data.x[0];
    }
    return data;
  }

  /// The name of a column that counts pulling; "": neither does.
  std::string pulling_name() const {
    for (const Column* column : {&columns_.along, &columns_.up})
      for (const char* word : {"Tensile", "tensile", "TENSILE"})
        if (column->source != Column::Source::scene && column->name.starts_with(word)) return column->name;
    return "";
  }
  bool pressing_by_name() const { return columns_.along.pressing || columns_.up.pressing; }
  /// The line above the names of the columns that speaks of compression; 0: none.
  int line_of_compression() const {
    std::size_t begin = 0;
    for (int line = 1; line < table_->head_places.front().line; ++line) {
      const std::size_t end = file_.text.find('\n', begin) + 1;
      const std::string own = file_.text.substr(begin, end - begin);
      for (const char* word : {"ompressi", "OMPRESSI", "ruckversuch", "压缩"})
        if (own.find(word) != std::string::npos) return line;
      begin = end;
    }
    return 0;
  }

 private:
  [[noreturn]] void fail_at(int line, const std::string& message) const {
    throw InputError(SourceLocation{table_->path, line}, message);
  }

  /// The block that the scene names, or else the only one that the test can take.
  const MachineTable& choose_table() const {
    const auto& tables = file_.tables;
    if (test_.block > static_cast<int>(tables.size()))
      test_.fail("block: " + test_.file + " has " + counted(std::ssize(tables), "block"));
    if (test_.block > 0) return tables[test_.block - 1];
    const MachineTable* found = nullptr;
    std::string blocks;
    int count = 0;
    for (std::size_t i = 0; i < tables.size(); ++i) {
      if (!suits(tables[i], test_)) continue;
      blocks += fmt::format("{}{} (line {}, {} rows)", count ? ", " : "", i + 1, tables[i].head_places.front().line,
                            tables[i].rows.size());
      if (++count; !found) found = &tables[i];
    }
    if (count > 1)
      throw InputError(
          SourceLocation{test_.file, found->head_places.front().line},
          "several blocks have the columns of this test: " + blocks + "; choose one, for example block: 1");
    if (found) check_behind(static_cast<std::size_t>(found - tables.data()));
    const auto longest =
        std::max_element(tables.begin(), tables.end(), [](auto& a, auto& b) { return a.rows.size() < b.rows.size(); });
    return found ? *found : *longest;
  }

  /// Asks where rows behind the block may be its own: they have as many columns, and no names that mean anything.
  void check_behind(std::size_t block) const {
    constexpr std::size_t few = 10;  // times as many rows as a table of results has
    const MachineTable& own = file_.tables[block];
    for (std::size_t i = block + 1; i < file_.tables.size(); ++i) {
      const MachineTable& other = file_.tables[i];
      if (other.head.size() != own.head.size() || few * other.rows.size() < own.rows.size() || has_meaning(other))
        continue;
      throw InputError(
          SourceLocation{test_.file, other.line(0)},
          fmt::format("{} rows from here on have as many columns as block {}, but {}: block: {} takes the {} rows "
                      "before alone; delete what stands between if the rows go on",
                      other.rows.size(), block + 1,
                      other.named ? "the names '" + other.head.front() + "' … in line " +
                                        std::to_string(other.head_places.front().line)
                                  : "no names",
                      block + 1, own.rows.size()));
    }
  }

  const std::string& text(std::size_t row, const Column& column) const { return table_->text(row, column.number); }
  bool is_empty(std::size_t row, const Column& column) const { return text(row, column).empty(); }
  /// Whether both columns have ended, where other columns of the file go on.
  bool is_behind(std::size_t row) const { return is_empty(row, columns_.along) && is_empty(row, columns_.up); }

  /// Whether a name stands in the place of a reading, as that of a mean or a largest value.
  bool is_named(std::size_t row) const {
    if (is_empty(row, columns_.along)) return false;
    const std::string& given = text(row, columns_.along);
    double number = 0;
    return std::isalpha(static_cast<unsigned char>(given.front())) &&
           std::from_chars(given.data(), given.data() + given.size(), number).ec == std::errc::invalid_argument;
  }

  bool chosen(std::size_t row) const {
    const std::size_t fields = table_->rows[row].size();
    if (fields != table_->head.size() && !is_behind(row))
      throw InputError(table_->location(table_->places[row][std::min(fields, table_->head.size()) - 1]),
                       std::to_string(fields) + " fields; the head has " + std::to_string(table_->head.size()));
    return std::all_of(test_.rows.begin(), test_.rows.end(),
                       [&](const auto& rule) { return table_->text(row, column(rule.first)) == rule.second; });
  }
  std::size_t column(const std::string& name) const {
    const auto found = find_column(*table_, name);
    return found ? *found : table_->column(name);
  }
  [[noreturn]] void fail_at_rows() const {
    const auto& [name, text] = test_.rows.back();
    std::vector<std::string> words;
    for (std::size_t row = 0; row < table_->rows.size(); ++row)
      if (const std::string& word = table_->text(row, column(name));
          std::find(words.begin(), words.end(), word) == words.end())
        words.push_back(word);
    test_.fail("rows: no row of " + table_->path + " has '" + text + "' as its " + name + suggestion(text, words));
    throw InputError(table_->path);
  }

  double value(std::size_t row, const Column& column) const {
    const std::string& given = text(row, column);
    const std::string& name = table_->head[column.number];
    if (given.empty())
      fail_at(table_->line(row), name + ": nothing stands there; leave the row out, or give its number");
    double number = NAN;
    const char *begin = given.data() + (given.front() == '+'), *end = given.data() + given.size();
    const auto [read, problem] = std::from_chars(begin, end, number);
    if (read != end || (problem != std::errc() && problem != std::errc::result_out_of_range))
      fail_at(table_->line(row), name + ": '" + given + "' is no number");
    if (!std::isfinite(number))
      fail_at(table_->line(row), name + ": '" + given + "' is no measured value; leave the row out");
    return number * *column.factor;
  }

  /// Compares a column with that of the other direction, which should be alike.
  void compare_across(const Column& column, const std::vector<std::size_t>& rows, MeasuredData& data) const {
    constexpr double alike = 0.02, noisy = 6;  // of the largest value; standard deviations
    const std::optional<Column> other = across(*table_, column);
    if (!other || !other->factor) return;
    std::vector<double> along, differences;
    std::vector<std::size_t> compared;
    double largest = 0;
    for (const std::size_t row : rows) {
      if (is_empty(row, *other)) continue;
      const double own = value(row, column);
      along.push_back(value(row, columns_.along)), differences.push_back(value(row, *other) - own),
          compared.push_back(row);
      largest = std::max(largest, std::abs(own - (column.quantity->name == "stretch" ? 1 : 0)));
    }
    if (differences.empty() || !(largest > 0)) return;
    const auto count = static_cast<Eigen::Index>(differences.size());
    VectorX from = Eigen::Map<const VectorX>(differences.data(), count);
    if (column.source == Column::Source::position) from.array() -= from[0];
    Eigen::Index farthest = 0;
    const double most = from.cwiseAbs().maxCoeff(&farthest);
    const std::string percent = fmt::format("{:.3g} %", 100 * most / largest);
    if (most <= std::max(alike * largest, noisy * noise_of(Eigen::Map<const VectorX>(along.data(), count), from)))
      return data.notes.push_back(
          fmt::format("'{}' counts, and '{}' is within {} of it", table_->head[column.number], other->name, percent));
    data.warnings.push_back(
        fmt::format("'{}' differs from '{}', by up to {} of its largest value, in line {}: kind: equibiaxial takes "
                    "both directions as "
                    "alike, and '{}' alone counts",
                    other->name, table_->head[column.number], percent,
                    table_->line(compared[static_cast<std::size_t>(farthest)]), table_->head[column.number]));
  }

  void check_value(std::size_t row, const DataQuantity& quantity, double value) const {
    const int line = table_->line(row);
    if (quantity.name == "stretch" && !(value > 0))
      fail_at(line, "stretch " + number(value) + " is impossible: it is 1 at rest; is the column nominal_strain?");
    if (quantity.name == "stretch" && value > kMostStretch)
      fail_at(line, "stretch " + number(value) + " is beyond any material: in per cent? then head it 'stretch [%]'");
    if (quantity.name == "nominal_strain" && !(value > -1))
      fail_at(line, "nominal strain " + number(value) + " is impossible: it must be above -1");
    if (quantity.name.ends_with("strain") && value > kMostStretch)
      fail_at(line, "strain " + number(value) + " is beyond any material: in per cent? then head it '" + quantity.name +
                        " [%]'; rows behind a slip are left out by `to`");
    if (quantity.name == "time" && value < 0)
      fail_at(line, "a time of " + number(value) + " s is before the test; `from` leaves such rows out");
  }

  /// Names a unit whose prefix has the wrong capital more often than not.
  void warn_of_prefixes(MeasuredData& data) const {
    struct Prefixed {
      const char *unit, *is, *other, *meant;
    };
    for (const auto& [unit, is, other, meant] :
         {Prefixed{"mPa", "millipascals", "megapascals", "MPa"}, {"MN", "meganewtons", "millinewtons", "mN"}})
      for (const Column* column : {&columns_.along, &columns_.up})
        if (column->unit == unit && column->source != Column::Source::scene)
          data.warnings.push_back(
              fmt::format("column '{0}' is taken in {1}, {2}: if {3} are meant, write columns: {{\"{0}\": '{4} "
                          "[{5}]'}}; '{4} [{2}]' "
                          "there says that they are not",
                          table_->head[column->number], is, unit, other, column->quantity->name, meant));
  }

  /// Names a strain without a unit that is as large as rubber's, or one in per cent.
  void warn_of_per_cent(MeasuredData& data) const {
    const Column& along = columns_.along;
    const std::string& name = along.quantity->name;
    const double largest = data.x.cwiseAbs().maxCoeff();
    if (!along.unit.empty() || !(name.ends_with("strain") || name == "shear") || largest <= kManyStrains) return;
    data.warnings.push_back(
        fmt::format("column '{0}' has no unit, and its largest value, {1:.4g}, is taken as a strain of {2:.4g} %: if "
                    "it is in per cent, "
                    "write columns: {{\"{0}\": '{3} [%]'}}; '{3} [-]' there says that it is not",
                    table_->head[along.number], largest, 100 * largest, name));
  }

  void note_recognised(MeasuredData& data) const {
    std::string note = file_.recognised(*table_);
    for (const Column* column : {&columns_.along, &columns_.up})
      if (column->source >= Column::Source::machine_name)
        note += fmt::format("{}'{}'{} as {}", note.empty() ? "" : ", ", column->name,
                            column->name.ends_with(']') || column->name.ends_with(')') ? "" : " [" + column->unit + "]",
                            column->quantity->name);
    if (!note.empty()) data.notes.push_back(note);
    if (const auto others = passed_over(*table_, test_, columns_); !others.empty())
      data.notes.push_back(fmt::format("passed over: '{}'", fmt::join(others, "', '")));
  }

  const DataTest& test_;
  MachineFile file_;
  const MachineTable* table_ = nullptr;
  ChosenColumns columns_;
  std::vector<std::size_t> rows_;
  int behind_ = 0;  ///< rows that are left out behind the end of both columns, or of the readings
};

double rest_of(const MeasuredData& data) { return data.along->name == "stretch" ? 1 : 0; }

void keep_rows(MeasuredData& data, Eigen::Index begin, Eigen::Index end) {
  data.x = VectorX(data.x.segment(begin, end - begin)), data.y = VectorX(data.y.segment(begin, end - begin));
  data.lines.erase(data.lines.begin() + end, data.lines.end());
  data.lines.erase(data.lines.begin(), data.lines.begin() + begin);
}

/// Depth grows into the layer, and the force there is positive: by each column's own sign, unless the scene says that
/// they stand as they are. The deep end is the one where the force is the larger; adhesion may make it larger
/// elsewhere.
void turn_into_layer(const DataTest& test, MeasuredData& data) {
  constexpr double near = 0.1;  // of the range, where an end is looked at
  const double low = data.x.minCoeff(), high = data.x.maxCoeff(), width = near * (high - low);
  const auto mean_force = [&](double from, double to) {
    double sum = 0, count = 0;
    for (Eigen::Index i = 0; i < data.x.size(); ++i)
      if (data.x[i] >= from && data.x[i] <= to) sum += data.y[i], count += 1;
    return sum / count;
  };
  const double shallow = mean_force(low, low + width), deep = mean_force(high - width, high);
  std::string turned;
  if (test.pressing.value_or(!(test.adhesion > 0))) {
    const bool backward = std::abs(shallow) > std::abs(deep);
    if (backward) data.x = -data.x, turned = data.along->name;
    if ((backward ? shallow : deep) < 0) data.y = -data.y, turned += (turned.empty() ? "" : " and ") + data.up->name;
    if (!turned.empty())
      data.notes.push_back(turned + " turned, so that depth grows into the layer and the force there is positive");
  } else if (!(test.adhesion > 0) && (data.x.array() - data.x.mean()).matrix().dot(data.y) < 0) {
    throw InputError(SourceLocation{data.file, data.lines.front()},
                     "the force falls where the depth grows: depth must grow into the layer, and a force that presses "
                     "must be positive; signs: pressing turns each column that needs it");
  }
}

/// The stress of a strain that is kept has the strain's sign; the force of an indenter is positive.
void turn_over_time(const DataTest& test, const DataFile& file, MeasuredData& data) {
  const bool positive = data.y.sum() > 0, homogeneous = !test.scene && !test.kind->layer;
  const auto turn = [&](const std::string& why) {
    data.y = -data.y;
    data.notes.push_back(why + ": " + data.up->name + " turned to " + (positive ? "negative" : "positive"));
  };
  if (test.kind->layer) {
    if (!positive) turn("the force of an indenter that presses is negative in the file");
    return;
  }
  const bool by_strain = homogeneous && test.strain < 0;
  if (positive && test.pressing.value_or(file.pressing_by_name() || by_strain))
    turn(by_strain ? "the strain is below 0" : "compression is positive in the file");
  if (homogeneous && data.y.sum() * test.strain < 0)
    throw InputError(
        SourceLocation{data.file, data.lines.front()},
        fmt::format("the {} is {}, which that of strain: {:.4g} % is not: write strain: {:.4g} %, or give "
                    "the readings the other sign",
                    data.up->name, data.y.sum() > 0 ? "positive" : "negative, or of a column that counts compression",
                    100 * test.strain, -100 * test.strain));
}

/// Positive numbers of a column that counts compression are negative strains and stresses.
void turn_signs(const DataTest& test, const DataFile& file, MeasuredData& data) {
  const bool pressing = test.pressing.value_or(test.kind->pressed || file.pressing_by_name());
  const bool positive = (data.x.array() - rest_of(data)).sum() > 0, pulls = positive && data.y.sum() > 0;
  if (const int line = file.line_of_compression();
      line > 0 && !test.pressing && !pressing && pulls && test.kind->homogeneous == HomogeneousTest::uniaxial)
    throw InputError(SourceLocation{data.file, line},
                     "the file speaks of compression and its values are positive: write kind: compression, which "
                     "takes them as compression, or signs: pulling if they pull");
  if (test.kind->layer) return turn_into_layer(test, data);
  if (!pressing) {
    const bool pulls_or_presses = test.kind->homogeneous && *test.kind->homogeneous != HomogeneousTest::shear;
    if (pulls_or_presses && !test.pressing && !positive && data.y.sum() < 0 && file.line_of_compression() == 0)
      data.notes.push_back(
          data.along->name + " and " + data.up->name +
          " are negative, and count as compression; signs: pressing turns them if the file counts pulling "
          "as negative");
    return;
  }
  if (positive && data.along->name == "stretch")
    throw InputError(SourceLocation{data.file, data.lines.front()},
                     "stretches above 1 are no compression: is the column nominal_strain?");
  std::string turned;
  if (positive || (test.pressing && !test.kind->pressed)) data.x = -data.x, turned = data.along->name;
  if (data.y.sum() > 0 || (test.pressing && !test.kind->pressed))
    data.y = -data.y, turned += (turned.empty() ? "" : " and ") + data.up->name;
  if (const std::string name = file.pulling_name(); !turned.empty() && !test.pressing && !name.empty())
    throw InputError(SourceLocation{data.file, data.lines.front()},
                     "column '" + name +
                         "' counts what pulls, and is positive: write kind: uniaxial, or signs: pressing if "
                         "the values press");
  if (!turned.empty()) data.notes.push_back("compression is positive in the file: " + turned + " turned to negative");
}

/// Rows in which a material relaxes, or recovers, at a strain that is kept are of no branch.
void leave_out_holds(MeasuredData& data) {
  const std::vector<Hold> holds = find_holds(data.x, data.y, rest_of(data), noise_of(data.x, data.y));
  Eigen::Index held = 0, kept = 0;
  std::string lines;
  for (const Hold& hold : holds) {
    held += hold.end - hold.begin;
    lines += fmt::format("{}lines {} to {}, {} by {:.0f} %", lines.empty() ? "" : "; ", data.lines[hold.begin],
                         data.lines[hold.end - 1], hold.changed < 0 ? "down" : "up", 100 * std::abs(hold.changed));
  }
  if (held == 0 || data.x.size() - held < 2) return;
  auto hold = holds.begin();
  for (Eigen::Index row = 0; row < data.x.size(); ++row) {
    if (hold != holds.end() && row >= hold->end) ++hold;
    if (hold != holds.end() && row >= hold->begin) continue;
    data.x[kept] = data.x[row], data.y[kept] = data.y[row], data.lines[kept] = data.lines[row];
    ++kept;
  }
  auto& said = 2 * held > data.x.size() ? data.warnings : data.notes;
  said.push_back(fmt::format("{} left out, where the {} is held while the {} changes: {}", counted(held, "row"),
                             data.along->name, data.up->name, lines));
  keep_rows(data, 0, kept);
}

/// One branch of a curve that goes to and fro.
void choose_branch(const DataTest& test, MeasuredData& data) {
  const std::vector<Branch> all = branches_of(data.x);
  const bool unloading = test.branch == BranchChoice::unloading;
  std::vector<Branch> chosen;
  for (const Branch& branch : all)
    if (branch.loading != unloading) chosen.push_back(branch);
  const auto count = static_cast<int>(chosen.size());
  if (test.branch == BranchChoice::only && test.cycle == 0) {
    if (all.size() == 1) return;
    throw InputError(
        SourceLocation{data.file, data.lines[all[1].begin]},
        fmt::format("{} goes back here: choose a branch by branch: loading or branch: unloading{}, or rows by "
                    "`rows`, `from` and `to`; or sort the rows, if they are of one branch",
                    data.along->name,
                    count > 1 ? fmt::format(", and one of {} cycles by cycle: 1 … {}", count, count) : ""));
  }
  const int cycle = test.cycle < 0 ? count + test.cycle : std::max(test.cycle, 1) - 1;
  if (cycle < 0 || cycle >= count)
    test.fail(
        fmt::format("cycle: {} has {} {}", data.file, count, unloading ? "unloading branches" : "loading branches"));
  const Branch& own = chosen[cycle];
  data.notes.push_back(fmt::format("{} branch {} of {}, lines {} to {}", unloading ? "unloading" : "loading", cycle + 1,
                                   count, data.lines[own.begin], data.lines[own.end - 1]));
  keep_rows(data, own.begin, own.end);
  if (data.x.size() < 2) test.fail("cycle: the branch has one point; a curve needs two or more");
}

/// Whether the first row is near rest, compared with the row that is the furthest from it.
bool is_near_rest(const MeasuredData& data, Eigen::Index* furthest = nullptr) {
  Eigen::Index row = 0;
  const VectorX e = (data.x.array() - rest_of(data)).matrix();
  const double far = e.cwiseAbs().maxCoeff(furthest ? furthest : &row);
  return std::abs(e[0]) < 0.3 * far;
}

/// Whether the rows go away from rest to one side.
bool leaves_rest(const MeasuredData& data) {
  Eigen::Index furthest = 0;
  return is_near_rest(data, &furthest) && furthest > data.x.size() / 2;
}

void cut_behind_tear(const DataTest& test, MeasuredData& data) {
  const auto tear = find_tear(data.x, data.y, data.noise);
  if (!tear) return;
  const int line = data.lines[tear->row];
  const std::string found = fmt::format("{} falls by {:.0f} % at line {}, as of a specimen that tears or slips",
                                        data.up->name, 100 * tear->lost, line);
  if (test.keep_torn) return data.warnings.push_back(found + ": these rows count, as `torn: keep` says"), void();
  data.warnings.push_back(found + fmt::format(": {} from there on are left out; torn: keep takes them",
                                              counted(data.x.size() - tear->row, "row")));
  keep_rows(data, 0, tear->row);
  if (data.x.size() < 2)
    throw InputError(SourceLocation{data.file, line}, "the specimen tears here, and fewer than two rows are before it");
}

/// "0.0253 (95 %: 0.0241 … 0.0266)", a stretch as such.
std::string range_of(const ZeroPoint& zero, const MeasuredData& data) {
  const double rest = rest_of(data);
  const auto text = [&](double value) { return readable(rest + value, data.along->unit, rest > 0 ? 5 : 3); };
  return fmt::format("{} (95 %: {} … {})", text(zero.value), text(zero.low), text(zero.high));
}

/// Counts what is prescribed from here; strains are then over the length here.
void move_zero(double zero, MeasuredData& data) {
  if (data.along->name == "nominal_strain" || data.along->name == "stretch")
    data.x = ((data.x.array() - rest_of(data) - zero) / (1 + zero) + rest_of(data)).matrix();
  else
    data.x.array() -= zero;
}

/// Whether the rows begin far from rest without a load there, as they do by the position of a crosshead.
bool begins_elsewhere(const MeasuredData& data) {
  constexpr double nothing = 0.01, noise = 0.1;  // of the largest reading: what no load is, and the most of its noise
  const double largest = data.y.cwiseAbs().maxCoeff(), scatter = 4 * noise_of(data.x, data.y);
  return !is_near_rest(data) && std::abs(data.y[0]) <= std::max(nothing * largest, std::min(scatter, noise * largest));
}

/// Counts from the first row where the scene says so, or where it looks for a zero point that no row is near; names
/// such rows where the scene says nothing.
void count_from_first(const DataTest& test, MeasuredData& data) {
  const double begin = data.x[0] - rest_of(data);
  const std::string first = readable(data.x[0], data.along->unit);
  if (!test.zero && begins_elsewhere(data)) {
    const bool known = data.along->name == "displacement" && test.length > 0;
    data.warnings.push_back(fmt::format(
        "the {} begins at {}{}, where the {} is nothing ({} of {}): if it counts from elsewhere, as the position of a "
        "crosshead does, zero: first counts from the first row, and zero: found from where the load begins",
        data.along->name, first, known ? fmt::format(", a strain of {:.3g} %", 100 * begin / test.length) : "",
        data.up->name, readable(data.y[0], data.up->unit, 3),
        readable(data.y.cwiseAbs().maxCoeff(), data.up->unit, 3)));
  } else if (test.zero == ZeroChoice::first ||
             (test.zero && test.zero != ZeroChoice::as_given && begins_elsewhere(data))) {
    move_zero(begin, data);
    data.notes.push_back(fmt::format("{} counts from the first row, {}", data.along->name, first));
  }
}

/// Moves the zero point of what is prescribed to where the load begins, or names it where it lies elsewhere.
void find_zero_point(const DataTest& test, MeasuredData& data) {
  if (test.zero == ZeroChoice::first) return;
  const bool stated = test.zero && test.zero != ZeroChoice::as_given;
  const VectorX e = (data.x.array() - rest_of(data)).matrix();
  const auto zero = test.zero == ZeroChoice::toe ? find_toe(e, data.y) : find_zero(e, data.y);
  const double range = e.maxCoeff() - e.minCoeff();
  if (!zero) {
    if (stated)
      test.fail("zero: " + data.file + " has too few rows to find where the load begins; write zero: as_given");
    return;
  }
  const std::string found = range_of(*zero, data);
  const bool longer = data.along->name == "displacement" && test.length > 0 && !test.scene;
  const std::string over_length =
      longer ? fmt::format(", where the length is {}: `length`, {}, {} {}",
                           readable(test.length + zero->value, dimension::length, 4),
                           readable(test.length, dimension::length, 4), zero->value < 0 ? "less" : "and",
                           readable(std::abs(zero->value), dimension::length, 4))
             : "";
  if (!stated) {
    const bool elsewhere = (zero->low > 0 || zero->high < 0) && std::abs(zero->value) > kNoticedZero * range;
    if (!elsewhere || !(data.noise > 0)) return;
    const bool slack = (zero->value > 0) == (e[e.size() - 1] > 0),
               certain = slack && begins_late(e, data.y, data.noise);
    const std::string where = fmt::format("the load begins at a {} of {}: ", data.along->name, found);
    if (!certain || test.zero) {
      data.warnings.push_back(where + (slack ? "slack" : "a preload") + "? zero: found counts from there");
      return;
    }
    data.warnings.push_back(where + "slack, and no curve that begins at 0 fits; it counts from there" + over_length +
                            ", which zero: found says and zero: as_given prevents; zero: first counts from the first "
                            "row, and leaves `length` as it is");
  } else {
    data.notes.push_back(data.along->name + " counts from " + found + over_length);
  }
  data.zero_half = (zero->high - zero->low) / 2;
  data.zero = zero->value;
  if (data.along->name == "nominal_strain" || data.along->name == "stretch") data.zero_half /= 1 + zero->value;
  move_zero(zero->value, data);
  const double side = e[e.size() - 1] < zero->value ? -1 : 1;
  Eigen::Index first = 0;
  while (first < e.size() && side * (e[first] - zero->value) < 0) ++first;
  if (data.x.size() - first < 2) test.fail("zero: fewer than two rows lie behind the point where the load begins");
  keep_rows(data, first, data.x.size());
}

/// Means of groups of rows that follow each other.
void average(MeasuredData& data, Eigen::Index groups) {
  const Eigen::Index count = data.x.size();
  if (count <= groups) return;
  MeasuredData means = data;
  means.x.resize(groups), means.y.resize(groups), means.lines.clear();
  for (Eigen::Index group = 0; group < groups; ++group) {
    const Eigen::Index begin = group * count / groups, size = (group + 1) * count / groups - begin;
    means.x[group] = data.x.segment(begin, size).mean(), means.y[group] = data.y.segment(begin, size).mean();
    means.lines.push_back(data.lines[begin]);
  }
  means.noise *= std::sqrt(static_cast<double>(groups) / static_cast<double>(count));
  data = std::move(means);
}

void check_points(const MeasuredData& data) {
  if (data.x.size() == 1) return;  // of a specimen
  const int first = data.lines.front();
  if ((data.x.array() == data.x[0]).all())
    throw InputError(SourceLocation{data.file, first},
                     data.along->name + " is the same in all rows; a curve needs several values");
  if ((data.y.array() == data.y[0]).all())
    throw InputError(SourceLocation{data.file, first},
                     data.up->name + " is the same in all rows; a curve needs several values");
}

void check_times(const MeasuredData& data) {
  for (Eigen::Index i = 1; i < data.x.size(); ++i)
    if (data.x[i] < data.x[i - 1])
      throw InputError(SourceLocation{data.file, data.lines[i]},
                       "time goes back: choose rows by `rows`, `from` and `to`, or sort them");
}

/// Time counts from where the strain begins to grow, by the file's clock; rows in front of that are left out.
void count_from(const DataTest& test, MeasuredData& data) {
  Eigen::Index first = 0;
  while (first < data.x.size() && data.x[first] < *test.begins) ++first;
  if (data.x.size() - first < 2)
    test.fail("begins: fewer than two rows of " + data.file + " lie behind " +
              readable(*test.begins, data.along->unit) + "; its last one is at " +
              readable(data.x[data.x.size() - 1], data.along->unit));
  keep_rows(data, first, data.x.size());
  data.x.array() -= *test.begins;
}

/// Readings in front of the strain: rows at rest are left out, and time counts from the last of them where it stands
/// far behind the beginning of the time. Warns of a load that still grows when the strain has reached its end.
void begin_with_load(const DataTest& test, MeasuredData& data) {
  constexpr double at_rest = 0.01, most = 0.1;  // of the largest reading: what rest is, and the most of its noise
  constexpr double late = 0.5;                  // of the ramp, before which a load may be as small
  constexpr double grown = 0.9;                 // of the largest reading
  const VectorX size = data.y.cwiseAbs();
  const double largest = size.maxCoeff(), least = std::max(at_rest * largest, std::min(4 * data.noise, most * largest));
  const Dimension& unit = data.along->unit;
  Eigen::Index rest = 0;
  while (size[rest] < least) ++rest;
  if (!test.begins && rest > 0 && data.x.size() - rest > 1 && data.x[rest - 1] >= late * test.ramp) {
    const double zero = data.x[rest - 1];
    keep_rows(data, rest, data.x.size());
    data.notes.push_back(counted(rest, "row") + " at rest in front of the load left out");
    if (zero > 0) {
      data.x.array() -= zero;
      data.warnings.push_back(
          fmt::format("there is no load until {}, so time counts from there; `from` chooses the rows of the test, and "
                      "`begins` says otherwise",
                      readable(zero, unit)));
    }
  }
  Eigen::Index reached = 0, peak = 0;
  while (reached + 1 < data.x.size() && data.x[reached] < test.ramp) ++reached;
  const Eigen::Index left = data.x.size() - reached;
  const double highest = data.y.cwiseAbs().tail(left).maxCoeff(&peak), first = std::abs(data.y[reached]);
  if (peak > 0 && first < grown * highest && highest - first > 6 * data.noise)
    data.warnings.push_back(fmt::format(
        "the load grows until {}, and the strain is said to be reached after {}: time counts from where the strain "
        "begins to grow, and `ramp` is the time in which it does; `from` leaves rows in front out",
        readable(data.x[reached + peak], unit), readable(test.ramp, unit)));
}

/// A test that pulls makes the material longer: else columns or signs are swapped.
void check_signs(const MeasuredData& data) {
  const double least = std::max(0.02 * data.y.cwiseAbs().maxCoeff(), 4 * data.noise);
  int wrong = 0, line = 0;
  for (Eigen::Index i = 0; i < data.y.size(); ++i) {
    if (data.x[i] * data.y[i] >= 0 || std::abs(data.y[i]) < least) continue;
    if (wrong++ == 0) line = data.lines[i];
  }
  if (2 * wrong > data.y.size())
    throw InputError(SourceLocation{data.file, line},
                     "the stress pulls where the strain presses, or the reverse, here and in " +
                         counted(wrong - 1, "other row") +
                         ": are the columns swapped, or is a strain headed as stretch? Of compression, kind: "
                         "compression takes either sign of each");
}

/// Nothing is pressed to less than no length.
/// @param given as the file has it, but for its sign
void check_length_left(const DataTest& test, const VectorX& given, const MeasuredData& data) {
  Eigen::Index row = 0;
  if (data.x.minCoeff(&row) > -1) return;
  const bool moved = data.along->name == "displacement";
  throw InputError(
      SourceLocation{data.file, data.lines[row]},
      fmt::format("{} {} is a strain of {:.4g} %{}, and it must be above -100 %: {}", data.along->name,
                  readable(given[row], data.along->unit), 100 * data.x[row],
                  moved ? " of the length, " + readable(test.length + data.zero, dimension::length) : "",
                  moved
                      ? "if it counts from elsewhere, as the position of a crosshead does, zero: first counts from the "
                        "first row"
                      : "if the column is in per cent, its name or `columns` must say '" + data.along->name + " [%]'"));
}

/// A first point without strain and stress is no information, and relative residuals cannot be over it.
void leave_out_rest(MeasuredData& data) {
  if (data.x.size() > 2 && data.x[0] == 0 && data.y[0] == 0) keep_rows(data, 1, data.x.size());
}

}  // namespace

MachineFile open_data(const DataTest& test) {
  std::error_code ignored;
  if (!std::filesystem::exists(test.file, ignored)) test.fail("file: '" + test.file + "': " + missing_file(test.file));
  return load_machine_file(test.file, test.decimal);
}

MeasuredData load_data(const DataTest& test) {
  const DataFile file(test);
  MeasuredData data = file.read();
  if (test.kind->in_time) {
    if (!test.kind->oscillates) check_times(data);  // a sweep may begin at either end
    check_points(data);
    data.noise = noise_of(data.x, data.y);
    if (!test.kind->oscillates) {
      turn_over_time(test, file, data);
      if (test.begins) count_from(test, data);
      begin_with_load(test, data);
    }
    return data;
  }
  if (!test.kind->layer) count_from_first(test, data);  // before signs are turned, which are by what is pulled
  turn_signs(test, file, data);
  leave_out_holds(data);
  choose_branch(test, data);
  check_points(data);
  data.noise = noise_of(data.x, data.y);
  const bool from_rest = test.branch != BranchChoice::unloading && leaves_rest(data);
  if (from_rest) cut_behind_tear(test, data);
  const Eigen::Index points = test.points > 0 ? test.points : test.scene ? kManyEquilibria : kManyRows;
  if (data.x.size() > points) data.notes.push_back(fmt::format("{} rows averaged to {} points", data.x.size(), points));
  average(data, std::max(points, kManyRows));
  if (from_rest && !test.kind->layer) find_zero_point(test, data);  // a layer's contact point is an unknown
  if (!from_rest && (test.zero == ZeroChoice::found || test.zero == ZeroChoice::toe))
    test.fail("zero: the rows of " + data.file +
              " do not begin near rest; choose those that do by branch, `from` and `to`, or count from the first row "
              "by zero: first");
  average(data, points);
  check_points(data);
  return data;
}

MeasuredData as_strain_and_stress(const DataTest& test, MeasuredData data) {
  const std::string along = data.along->name, up = data.up->name;
  const auto need = [&](double value, const char* key, const std::string& what) {
    if (!(value > 0)) test.fail(std::string("key '") + key + "' is missing: the data have a " + what);
    return value;
  };
  const VectorX given = data.x;
  if (along == "stretch") data.x.array() -= 1;
  if (along == "true_strain") data.x = data.x.array().unaryExpr([](double e) { return std::expm1(e); }).matrix();
  if (along == "displacement") {
    const double length = need(test.length > 0 ? test.length + data.zero : 0, "length", "displacement");
    data.x /= length, data.zero_half /= length;
  }
  if (!test.kind->in_time && test.kind->homogeneous != HomogeneousTest::shear) check_length_left(test, given, data);
  if (up == "force") data.y /= need(test.cross_section, "cross_section", "force"), data.noise /= test.cross_section;
  if (up == "true_stress") data.y = data.y.cwiseQuotient((1 + data.x.array()).matrix());
  if (!test.kind->in_time) {
    check_signs(data);
    data.along = find_quantity(test.kind->homogeneous == HomogeneousTest::shear ? "shear" : "nominal_strain");
    if (test.residuals != ResidualScale::absolute) leave_out_rest(data);
  }
  data.up = find_quantity("nominal_stress");
  return data;
}

}  // namespace elastin::lab
