#include "lab/identify/columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

namespace elastin::lab {
namespace {

using Source = Column::Source;

/// Names that machines give to columns, small letters, without what stands in brackets.
struct MachineNames {
  const char *quantity, *names;
  bool pressing = false, position = false;
  bool shear = false;                        ///< of tests in shear alone, where a stress is nominal and true alike
  std::optional<HomogeneousTest> held = {};  ///< of a modulus: the state that it is of
};
/// Of frequencies that are 2 π periods a time.
constexpr const char* kAngularFrequency =
    "angular frequency|ang frequency|angular freq|ang freq|kreisfrequenz|pulsation|角频率|omega|ω";
constexpr std::array kMachineNames{
    MachineNames{"time",
                 "elapsed time|test time|running time|total time|time elapsed|zeit|prüfzeit|testzeit|temps|时间"},
    MachineNames{
        "displacement",
        "disp|extension|elongation|stroke|crosshead|crosshead displacement|crosshead extension|axial disp|axial "
        "displacement|tensile extension|tensile displacement|xdisplacement|x displacement|actuator displacement|"
        "distance|extensometer|extensometer displacement|extensometer extension|corrected displacement|corrected "
        "extension|standardweg|weg|traversenweg|verschiebung|verlängerung|déplacement|allongement|位移|伸长|变形|行程"},
    MachineNames{"displacement",
                 "depth|indentation|indentation depth|tip position|vertical tip position|tip sample separation"},
    MachineNames{"displacement", "compressive extension|compressive displacement|stauchweg", true},
    MachineNames{"displacement", "position|z position|axial position|crosshead position", false, true},
    MachineNames{
        "force",
        "load|axial force|axial load|tensile load|tensile force|standardkraft|kraft|prüfkraft|xforce|x force|fz|"
        "charge|力|载荷|负荷|试验力|荷重|試験力"},
    MachineNames{"force", "compressive load|compressive force|druckkraft", true},
    MachineNames{"nominal_strain", "tensile strain|engineering strain|eng strain|工程应变"},
    MachineNames{"nominal_strain", "compressive strain|stauchung", true},
    MachineNames{
        "nominal_stress",
        "tensile stress|engineering stress|eng stress|first piola-kirchhoff stress|first piola kirchhoff stress|"
        "1st piola-kirchhoff stress|1st piola kirchhoff stress|first pk stress|1st pk stress|pk1 stress|pk1|"
        "工程应力"},
    MachineNames{"nominal_stress", "compressive stress|druckspannung", true},
    MachineNames{"true_strain", "logarithmic strain|hencky strain|真应变"},
    MachineNames{"true_stress", "cauchy stress|cauchy|真应力"},
    MachineNames{"stretch",
                 "stretch ratio|principal stretch|axial stretch|extension ratio|lambda|lambda1|λ|λ1|streckung"},
    MachineNames{"frequency", "freq|f|frequenz|fréquence|频率"}, MachineNames{"frequency", kAngularFrequency},
    MachineNames{"storage_modulus", "speichermodul|module de conservation|储能模量"},
    MachineNames{"storage_modulus", "e'|e′", false, false, false, HomogeneousTest::uniaxial},
    MachineNames{"storage_modulus", "g'|g′", false, false, false, HomogeneousTest::shear},
    MachineNames{"loss_modulus", "verlustmodul|module de perte|损耗模量"},
    MachineNames{"loss_modulus", "e''|e\"|e″", false, false, false, HomogeneousTest::uniaxial},
    MachineNames{"loss_modulus", "g''|g\"|g″", false, false, false, HomogeneousTest::shear},
    MachineNames{"loss_tangent", "tan delta|tan|tan δ|loss factor|verlustfaktor|损耗因子"},
    MachineNames{"torque", "axial torque|drehmoment|扭矩"},
    MachineNames{"angle", "rotation|twist|rotary position|drehwinkel|转角"}, MachineNames{"pressure", "druck"},
    MachineNames{"shear", "shear strain|amount of shear|scherung|gleitung|schubverzerrung|剪切应变", false, false,
                 true},
    MachineNames{"nominal_stress", "shear stress|schubspannung|剪切应力|剪应力", false, false, true},
    // Nominal or true: not stated.
    MachineNames{"stress", "spannung|contrainte|应力|応力"}, MachineNames{"strain", "dehnung|déformation|应变"}};

/// Small letters, blanks for underscores, and nothing in brackets.
std::string simplified(const std::string& name) {
  std::string simple;
  int depth = 0;
  for (const char c : name) {
    if (c == '(' || c == '[') ++depth;
    if (depth == 0) simple += c == '_' || c == '.' ? ' ' : c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (c == ')' || c == ']') --depth;
  }
  std::string single;
  for (const char c : simple)
    if (c != ' ' || (!single.empty() && single.back() != ' ')) single += c;
  if (single.ends_with(' ')) single.pop_back();
  return single;
}

/// Whether a name is one of "this|that".
bool is_among(const std::string& name, const char* names) {
  return !name.empty() && ("|" + std::string(names) + "|").find("|" + name + "|") != std::string::npos;
}

struct Meaning {
  std::string quantity;
  Source source;
  bool pressing = false, shear = false;
  std::optional<HomogeneousTest> held = {};
};

std::optional<Meaning> meaning_of(const std::string& name) {
  const std::string simple = simplified(name);
  const auto is_own = [&](const char* own) { return simple == own; };
  for (const DataQuantity& quantity : data_quantities())
    if (simple == simplified(quantity.name))
      return Meaning{quantity.name, name == quantity.name ? Source::own_name : Source::machine_name};
  if (is_own("stress") || is_own("strain")) return Meaning{simple, Source::own_name};
  for (const MachineNames& row : kMachineNames)
    if (is_among(simple, row.names))
      return Meaning{row.quantity, row.position ? Source::position : Source::machine_name, row.pressing, row.shear,
                     row.held};
  return std::nullopt;
}

struct Head {
  std::string name, unit;
};

/// "force" and "N" of "force [N]", "force (N)", "force, N", "force / N", "force in N", "force_N" or "force N"; "force"
/// of "force_x", which has no unit.
Head split(const std::string& head) {
  for (const auto& [open, close] : {std::pair{" [", "]"}, {" (", ")"}, {"[", "]"}, {"(", ")"}})
    if (const std::size_t at = head.rfind(open); at != std::string::npos && at > 0 && head.ends_with(close)) {
      const std::size_t from = at + std::string_view(open).size();
      const Head parts{head.substr(0, at), head.substr(from, head.size() - from - 1)};
      return parts;
    }
  if (meaning_of(head)) return {head, ""};
  for (const char* mark : {", ", " / ", " in ", "/", "_", " "})
    if (const std::size_t at = head.rfind(mark); at != std::string::npos && meaning_of(head.substr(0, at))) {
      const std::string behind = head.substr(at + std::string_view(mark).size());
      return {head.substr(0, at), is_among(behind, "x|y|z|X|Y|Z") ? "" : behind};
    }
  return {head, ""};
}

/// "stress" of "stress_x", "stress y" or "stress 1".
std::string without_direction(const std::string& name) {
  const bool has_one = name.size() > 2 && std::string_view("xyXY12").find(name.back()) != std::string_view::npos &&
                       std::string_view("_ ").find(name[name.size() - 2]) != std::string_view::npos;
  return has_one ? name.substr(0, name.size() - 2) : name;
}

/// The name with a y where this one has an x, or a 2 for a 1, or the reverse.
std::optional<std::size_t> find_across(const std::vector<std::string>& heads, std::size_t number) {
  for (const std::string pair : {"xy", "XY", "12"})
    for (std::size_t at = 0; (at = heads[number].find_first_of(pair, at)) != std::string::npos; ++at) {
      std::string other = heads[number];
      other[at] = pair[other[at] == pair[0]];
      const auto found = std::find(heads.begin(), heads.end(), other);
      if (found != heads.end()) return static_cast<std::size_t>(found - heads.begin());
    }
  return std::nullopt;
}

/// Whether a frequency of this name is 2 π periods a time.
bool is_angular(const std::string& name) { return is_among(simplified(split(name).name), kAngularFrequency); }

/// What makes numbers with this unit SI. An angular frequency is stated by its unit, else by its name.
std::optional<double> factor_of(const std::string& unit, const DataQuantity& quantity, const std::string& name) {
  std::optional<double> factor = machine_unit(unit, quantity.unit);
  if (quantity.name == "frequency" && factor &&
      (unit.starts_with("rad") || (is_angular(name) && !unit.ends_with("Hz"))))
    *factor /= 2 * std::numbers::pi;
  return factor;
}

std::string unit_below(const MachineTable& table, std::size_t number) {
  return number < table.units.size() ? table.units[number] : "";
}

/// Refuses a row below the names whose unit is another than that in the name.
/// @param factor, below of either
void check_unit_below(const MachineTable& table, std::size_t number, const std::string& unit, double factor,
                      std::optional<double> below, const std::string& quantity) {
  const std::string other = unit_below(table, number);
  if (other.empty() || other == "-" || (below ? std::abs(*below - factor) <= 1e-9 * factor : !is_machine_unit(other)))
    return;
  const std::string& head = table.head[number];
  throw InputError(SourceLocation{table.path, table.units_line},
                   "column '" + head + "': the unit '" + other + "' here is another than '" + unit +
                       "' in its name; state the one that counts: columns: {\"" + head + "\": '" + quantity + " [" +
                       (below ? unit + "]' or '" + quantity + " [" + other : unit) + "]'}");
}

std::string shown(const DataQuantity& quantity) {
  const std::string examples = unit_examples(quantity.unit), unit = examples.substr(examples.find(' ') + 1);
  return quantity.ratio
             ? quantity.name
             : quantity.name + " [" + (quantity.name == "angle" ? "deg" : unit.substr(0, unit.find(','))) + "]";
}

class TableColumns {
 public:
  TableColumns(const MachineTable& table, const DataTest& test) : table_(table), test_(test) {
    for (std::size_t number = 0; number < table.head.size(); ++number) add(number);
  }

  /// @param taken a column that serves something else; none: −1
  std::vector<Column> candidates(const std::vector<std::string>& wanted, std::ptrdiff_t taken = -1) const {
    std::vector<Column> found;
    for (const Column& column : known_)
      if (std::ssize(known_) > 1 && static_cast<std::ptrdiff_t>(column.number) == taken)
        continue;
      else if (std::find(wanted.begin(), wanted.end(), column.quantity->name) != wanted.end())
        found.push_back(column);
    if (found.empty()) return found;
    const auto best =
        std::min_element(found.begin(), found.end(), [](auto& a, auto& b) { return a.source < b.source; });
    const Source source = best->source;
    std::erase_if(found, [&](const Column& column) { return column.source != source; });
    if (source >= Source::machine_name) prefer(found, wanted);
    return found;
  }

  /// The only column with one of these quantities.
  Column choose(const std::vector<std::string>& wanted, const std::string& role, std::ptrdiff_t taken = -1) const {
    const std::vector<Column> found = candidates(wanted, taken);
    // Of a specimen both may be loads or displacements; what stands first is prescribed.
    const bool of_specimen = test_.kind->of_scene();
    if (found.size() == 2 && in_two_directions())
      if (const auto other = across(table_, found[0]); other && other->number == found[1].number) {
        const Column& first = found[0].name < found[1].name ? found[0] : found[1];
        check_unit(first);
        return first;
      }
    if (found.size() == 1 || (found.size() > 1 && of_specimen)) {
      const Column& column = found.size() > 1 && role == "answers" ? found.back() : found.front();
      check_unit(column);
      return column;
    }
    if (found.size() > 1)
      fail((found[0].name == found[1].name
                ? "two columns are called '" + found[0].name + "'"
                : "two columns say what " + role + ", " + found[0].name + " and " + found[1].name) +
           "; state the one that counts, by its number: " + hint(std::to_string(found[0].number + 1), found[0]));
    std::vector<std::string> allowed;
    for (const std::string& name : wanted) allowed.push_back(shown(*find_quantity(name)));
    for (const auto& [head, quantity] : unsaid_)
      if ((role == "answers") == (quantity == "stress"))
        fail("column '" + head + "': is it " +
             (quantity == "stress" ? "nominal_stress (force over section at rest) or true_stress"
                                   : "nominal_strain, true_strain or stretch") +
             "? State it: columns: {\"" + head + "\": 'nominal_" + quantity +
             unit_behind(head, find_quantity("nominal_" + quantity)->unit) + "'}");
    const std::string all = fmt::format("{}", fmt::join(allowed, ", "));
    if (test_.kind->in_time && !test_.kind->layer && !sheared_.empty())
      fail("column '" + sheared_.front() + "' is of a test in shear, and this one has held: " + name_of(test_.held) +
           "; write held: shear");
    const auto spare = std::find_if(known_.begin(), known_.end(), [&](const Column& column) {
      const std::vector<std::string>& others = role == "answers" ? test_.kind->along : test_.kind->up;
      return std::find(others.begin(), others.end(), column.quantity->name) == others.end();
    });
    if (known_.size() > 1 && spare != known_.end())
      fail("no column says what " + role + " in a test of kind " + test_.kind->name + "; '" + spare->name +
           "' does not; one of: " + all);
    std::vector<std::string> unknown;
    for (std::size_t number = 0; number < table_.head.size(); ++number)
      if (std::none_of(known_.begin(), known_.end(), [&](const Column& column) { return column.number == number; }))
        unknown.push_back(table_.head[number]);
    for (const std::string& head : unknown)
      if (const std::string near = nearest_name(split(head).name, wanted); !near.empty())
        fail("column '" + head + "' is not known; did you mean '" + near + "'?");
    const std::vector<std::string>& heads = unknown.empty() ? table_.head : unknown;
    std::size_t number = role == "answers" ? heads.size() - 1 : 0;
    if (const auto other = find_across(heads, number); other && in_two_directions() && heads[*other] < heads[number])
      number = *other;
    const std::string& head = heads[number];
    fail("no column says what " + role + " in a test of kind " + test_.kind->name + "; one of: " + all +
         "; or state what a name means, columns: {\"" + head + "\": " + likely(head, wanted) + "}");
  }

  const std::vector<Column>& known() const { return known_; }

 private:
  /// Those of these quantities that have the unit of a column, with that unit; else all of them: 'a' or 'b'.
  std::string likely(const std::string& head, const std::vector<std::string>& wanted) const {
    std::vector<std::string> fitting, all;
    for (const std::string& name : wanted) {
      const DataQuantity& quantity = *find_quantity(name);
      all.push_back(shown(quantity));
      if (const std::string behind = unit_behind(head, quantity.unit); !behind.empty())
        fitting.push_back(name + behind);
    }
    return fmt::format("'{}'", fmt::join(fitting.empty() ? all : fitting, "' or '"));
  }

  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(SourceLocation{table_.path, table_.head_places.front().line},
                     table_.named ? message : "there are no names of columns above the numbers; " + message);
  }

  void add(std::size_t number) {
    std::string text = table_.head[number];
    bool stated = false;
    for (const auto& [head, meaning] : test_.columns)
      if (find_column(table_, head) == number) text = meaning, stated = true;
    Head head = split(text);
    if (std::find(table_.clocks.begin(), table_.clocks.end(), number) != table_.clocks.end()) head.unit = "s";
    auto meaning = meaning_of(head.name);
    if (!meaning && in_two_directions()) meaning = meaning_of(without_direction(head.name));
    if (!meaning) {
      if (stated) test_.fail("columns: '" + text + "' is no quantity with its unit, such as 'force [N]'");
      return;
    }
    if (meaning->shear && !in_shear()) return sheared_.push_back(table_.head[number]);
    const DataQuantity* quantity = find_quantity(meaning->quantity);
    if (!quantity) return unsaid_.emplace_back(table_.head[number], meaning->quantity), void();
    Column column{quantity, stated ? text : table_.head[number],      head.unit,         {},
                  number,   stated ? Source::scene : meaning->source, meaning->pressing, meaning->held};
    const std::string below = unit_below(table_, number);
    if (!below.empty() && (column.unit.empty() || !machine_unit(column.unit, quantity->unit))) column.unit = below;
    if (!column.unit.empty() || (quantity->ratio && quantity->name != "angle"))
      column.factor = factor_of(column.unit, *quantity, head.name);
    known_.push_back(std::move(column));
  }

  /// Of what a machine writes, that which the test can use: displacement and force where the scene states what makes
  /// strain and stress of them, or of a specimen; else strain and stress.
  void prefer(std::vector<Column>& found, const std::vector<std::string>& wanted) const {
    const auto keep = [&](const auto& condition) {
      if (std::any_of(found.begin(), found.end(), condition))
        std::erase_if(found, [&](auto& c) { return !condition(c); });
    };
    if (!test_.kind->of_scene() && !test_.kind->layer) {
      keep([&](const Column& column) { return (column.quantity->name == "displacement") == (test_.length > 0); });
      keep([&](const Column& column) { return (column.quantity->name == "force") == (test_.cross_section > 0); });
    } else {
      for (const std::string& name : wanted)
        if (std::any_of(found.begin(), found.end(), [&](auto& column) { return column.quantity->name == name; }))
          return std::erase_if(found, [&](auto& column) { return column.quantity->name != name; }), void();
    }
  }

  void check_unit(const Column& column) const {
    if (column.factor) {
      if (column.source != Source::scene && !column.unit.empty())
        check_unit_below(table_, column.number, column.unit, *column.factor,
                         factor_of(unit_below(table_, column.number), *column.quantity, column.name),
                         column.quantity->name);
      return;
    }
    // Periods a second would be another meaning of what the column's name says.
    const std::string own =
        column.quantity->name == "frequency" && is_angular(column.name) ? "frequency [rad/s]"
        : !column.unit.empty() && machine_unit(column.unit + "f", column.quantity->unit)  // the weight of g, kg or lb
            ? column.quantity->name + " [" + column.unit + "f]"
            : shown(*column.quantity);
    if (column.unit.empty())
      fail("column '" + column.name + "' has no unit; write for example '" + own + "'" +
           (column.source == Source::own_name ? "" : ", columns: {\"" + column.name + "\": '" + own + "'}"));
    fail("column '" + column.name + "': '" + column.unit + "' is no unit of " + column.quantity->name +
         "; write for example '" + own + "'");
  }

  bool in_two_directions() const { return test_.kind->homogeneous == HomogeneousTest::equibiaxial; }

  bool in_shear() const {
    const auto& kind = *test_.kind;
    return kind.homogeneous == HomogeneousTest::shear || kind.of_scene() || test_.scene ||
           (kind.in_time && !kind.layer && test_.held == HomogeneousTest::shear);
  }

  static std::string hint(const std::string& head, const Column& column) {
    return "columns: {\"" + head + "\": '" + column.quantity->name +
           (column.unit.empty() || !column.factor ? "" : " [" + column.unit + "]") + "'}";
  }

  /// " [unit]" of a column, if it is one of such a quantity.
  std::string unit_behind(const std::string& head, const Dimension& dimension) const {
    std::string unit = split(head).unit;
    if (const auto number = find_column(table_, head); unit.empty() && number) unit = unit_below(table_, *number);
    return unit.empty() || !machine_unit(unit, dimension) ? "" : " [" + unit + "]";
  }

  const MachineTable& table_;
  const DataTest& test_;
  std::vector<Column> known_;
  std::vector<std::string> sheared_;                         ///< of tests in shear alone, which this one is not
  std::vector<std::pair<std::string, std::string>> unsaid_;  ///< strains and stresses, nominal or true
};

}  // namespace

const DataQuantity* find_quantity(const std::string& name) {
  for (const DataQuantity& quantity : data_quantities())
    if (quantity.name == name) return &quantity;
  return nullptr;
}

std::optional<std::size_t> find_column(const MachineTable& table, const std::string& name) {
  for (const bool whole : {true, false})
    for (std::size_t i = 0; i < table.head.size(); ++i)
      if ((whole ? table.head[i] : split(table.head[i]).name) == name) return i;
  for (std::size_t i = 0; i < table.head.size(); ++i)
    if (std::to_string(i + 1) == name) return i;
  return std::nullopt;
}

std::optional<NamedColumn> find_column(const MachineTable& table, const DataTest& test,
                                       const std::vector<std::string>& names, const Dimension& unit) {
  for (std::size_t i = 0; i < table.head.size(); ++i) {
    std::string text = table.head[i];
    for (const auto& [head, meaning] : test.columns)
      if (find_column(table, head) == i) text = meaning;
    const Head head = split(text);
    if (std::find(names.begin(), names.end(), simplified(head.name)) == names.end()) continue;
    const std::string below = unit_below(table, i), &own = head.unit.empty() ? below : head.unit;
    if (own.empty() && unit == dimension::none) return NamedColumn{i, 1};
    const auto factor = machine_unit(own, unit);
    if (!factor)
      throw InputError(SourceLocation{table.path, table.head_places.front().line},
                       "column '" + table.head[i] + "' " +
                           (own.empty() ? "has no unit" : ": '" + own + "' is no unit of it") +
                           "; write for example '" + head.name + " [" +
                           (unit == dimension::length ? "mm" : unit_examples(unit).substr(2)) + "]'");
    if (text == table.head[i]) check_unit_below(table, i, own, *factor, machine_unit(below, unit), head.name);
    return NamedColumn{i, *factor};
  }
  return std::nullopt;
}

std::optional<Column> across(const MachineTable& table, Column column) {
  const std::string below = unit_below(table, column.number);
  const auto other = find_across(table.head, column.number);
  if (!other) return std::nullopt;
  column.number = *other, column.name = table.head[*other];
  if (const std::string unit = unit_below(table, column.number); unit != below)
    column.unit = unit, column.factor = machine_unit(unit, column.quantity->unit);
  return column;
}

bool suits(const MachineTable& table, const DataTest& test) {
  const TableColumns columns(table, test);
  return !columns.candidates(test.kind->along).empty() && !columns.candidates(test.kind->up).empty();
}

bool has_meaning(const MachineTable& table) {
  return std::any_of(table.head.begin(), table.head.end(),
                     [](const std::string& head) { return meaning_of(split(head).name).has_value(); });
}

std::vector<std::string> passed_over(const MachineTable& table, const DataTest& test, const ChosenColumns& chosen) {
  const TableColumns columns(table, test);
  std::vector<std::string> names;
  for (const Column* column : {&chosen.along, &chosen.up})
    for (const Column& other : columns.known()) {
      const bool same = other.quantity == column->quantity && column->source != Source::scene;
      const bool own = other.number == chosen.along.number || other.number == chosen.up.number ||
                       find_across(table.head, column->number) == other.number;
      if (same && !own) names.push_back(other.name);
    }
  return names;
}

ChosenColumns choose_columns(const MachineTable& table, const DataTest& test) {
  for (const auto& [head, meaning] : test.columns)
    if (!find_column(table, head))
      test.fail("columns: " + table.path + " has no column '" + head + "'" + suggestion(head, table.head));
  const TableColumns columns(table, test);
  const Column along = columns.choose(test.kind->along, "is prescribed"), up = columns.choose(test.kind->up, "answers");
  if (up.source != Source::scene && up.held && *up.held != test.held)
    throw InputError(SourceLocation{table.path, table.head_places.front().line},
                     "column '" + up.name + "' has the name of a modulus in a " + name_of(*up.held) +
                         " test, and this one has held: " + name_of(test.held) + "; write held: " + name_of(*up.held) +
                         ", or, if the name is wrong, columns: {\"" + up.name + "\": '" + up.quantity->name + " [" +
                         up.unit + "]'}");
  return {along.number == up.number
              ? columns.choose(test.kind->along, "is prescribed", static_cast<std::ptrdiff_t>(up.number))
              : along,
          up};
}

}  // namespace elastin::lab
