#include "config/formula.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>
#include <string_view>
#include <vector>

#include "core/base/unit_table.h"
#include "elastin/core/base/text.h"

namespace elastin::config {
namespace {

using Value = FormulaValue;

std::string name_of(const Dimension& unit) { return unit == dimension::none ? "a plain number" : si_unit(unit); }

Dimension power_of(const Dimension& unit, int power) {
  return {unit.length * power, unit.mass * power, unit.time * power};
}

Value times(const Value& a, const Value& b) {
  return {a.number * b.number,
          {a.unit.length + b.unit.length, a.unit.mass + b.unit.mass, a.unit.time + b.unit.time},
          a.angle != b.angle};
}

Value power(const Value& base, int exponent) {
  return {std::pow(base.number, exponent), power_of(base.unit, exponent), base.angle && exponent == 1};
}

/// Gives the value of a name; throws if the name is unknown.
using Names = std::function<Value(const std::string&)>;

/// Brackets, signs and exponents inside each other, through the formulas of the values that a formula names: each takes
/// some of the stack.
constexpr int kDeepestFormula = 200;

const FormulaLanguage kOfScenes;

/// Reads a formula from left to right. `depth` counts how deep the reader is. Throws InputError.
class Formula {
 public:
  /// All must outlive it.
  Formula(std::string_view text, const Names& names, int& depth, const FormulaLanguage& language = kOfScenes)
      : text_(text), names_(names), depth_(depth), language_(language) {}

  Value value() {
    const Value value = any_value();
    if (!std::isfinite(value.number)) fail("its result is no finite number");
    return value;
  }

  Value any_value() {
    const Value value = sum();
    skip();
    if (const std::string_view left = text_.substr(at_); !left.empty())
      fail("'" + std::string(left) + "' is not expected there" +
           (left == "K" ? "; temperatures are plain numbers, in kelvin: leave it out" : ""));
    return value;
  }

  /// Whether all of it is one unit: "kPa", "m1", "mm²".
  bool is_unit() { return unit_here() && at_ == text_.size(); }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    constexpr std::size_t most = 200;
    throw InputError("the formula '" +
                     std::string(text_.substr(std::min(text_.find_first_not_of(' '), text_.size()), most)) +
                     (text_.size() > most ? "…" : "") + "': " + message);
  }
  void skip() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }
  bool stands(char sign) {
    skip();
    return at_ < text_.size() && text_[at_] == sign;
  }
  bool take(char sign) {
    if (!stands(sign)) return false;
    ++at_;
    return true;
  }

  Value sum() {
    Value value = product();
    for (;;) {
      const bool plus = take('+');
      if (!plus && !take('-')) return value;
      const Value other = product();
      if (other.unit != value.unit)
        fail((plus ? "adds " : "subtracts ") + name_of(other.unit) + (plus ? " to " : " from ") + name_of(value.unit));
      value.number += plus ? other.number : -other.number;
      value.angle = value.angle || other.angle;
    }
  }

  Value product() {
    Value value = signed_power();
    for (;;) {
      if (take('*')) {
        value = times(value, signed_power());
      } else if (take('/')) {
        const Value other = signed_power();
        value = times(value, {1 / other.number, power_of(other.unit, -1), other.angle});
      } else {
        return value;
      }
    }
  }

  Value signed_power() {
    struct Level {
      int& depth;
      ~Level() { --depth; }
    } const level{++depth_};
    if (depth_ > kDeepestFormula)
      fail("brackets, signs, exponents and named values stand more than " + std::to_string(kDeepestFormula) +
           " deep in each other");
    Value value;
    if (take('-')) {
      value = signed_power();
      value.number = -value.number;
    } else if (take('+')) {
      value = signed_power();
    } else {
      value = primary();
      while (take('^')) value = raised(value, language_.powers_from_left && !stands('-') ? primary() : signed_power());
    }
    return value;
  }

  Value raised(const Value& base, const Value& exponent) const {
    if (exponent.unit != dimension::none) fail("an exponent is a plain number");
    if (base.unit == dimension::none) return {std::pow(base.number, exponent.number), {}, false};
    if (exponent.number != std::round(exponent.number) || std::abs(exponent.number) > 9)
      fail("the exponent of a value with a unit is a whole number up to 9");
    return power(base, static_cast<int>(exponent.number));
  }

  Value primary() {
    skip();
    if (take('(')) {
      const Value value = sum();
      if (!take(')')) fail("a bracket is not closed");
      return value;
    }
    double number = 0;
    const auto [end, problem] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
    if (problem == std::errc() && at_ < text_.size() && text_[at_] != '-') {
      at_ = static_cast<std::size_t>(end - text_.data());
      Value value{number, {}, false};
      if (const auto unit = inverse_unit_here()) value = times(value, *unit);
      while (const auto unit = unit_here()) value = times(value, *unit);
      return value;
    }
    const std::size_t before = at_;
    const std::string name = word();
    if (name.empty())
      fail(at_ < text_.size() ? "'" + std::string(text_.substr(at_)) + "' is not expected there" : "it has no end");
    if (take('(')) return function(name);
    if (name == "pi") return {std::numbers::pi, {}, false};
    at_ = before;                                     // also where blanks stand behind the name
    if (const auto unit = unit_here()) return *unit;  // "1000 kg/m3"
    at_ = before + name.size();
    return names_(name);
  }

  /// Letters, digits behind them, and letters beyond ASCII.
  std::string word() {
    skip();
    const std::size_t first = at_;
    const auto letter = [](char sign) {
      return (sign >= 'a' && sign <= 'z') || (sign >= 'A' && sign <= 'Z') || sign == '_' || sign == '%' ||
             (sign & 0x80);
    };
    while (at_ < text_.size() && (letter(text_[at_]) || (at_ > first && text_[at_] >= '0' && text_[at_] <= '9'))) ++at_;
    return std::string(text_.substr(first, at_ - first));
  }

  /// "mm", "m3", "s^2": a unit that stands here, if one does.
  std::optional<Value> unit_here() {
    if (!language_.units) return std::nullopt;
    const std::size_t before = at_;
    std::string name = word();
    int exponent = 1;
    while (name.size() > 1 && name.back() >= '1' && name.back() <= '9' && !find_unit(name)) {
      exponent = name.back() - '0';
      name.pop_back();
    }
    for (const auto& [sign, raised] : {std::pair<std::string_view, int>{"²", 2}, {"³", 3}})
      if (name.ends_with(sign)) name.resize(name.size() - sign.size()), exponent = raised;
    const auto unit = find_unit(name);
    if (!unit) {
      at_ = before;
      return std::nullopt;
    }
    const Value value{unit->first, unit->second,
                      name == "deg" || name == "rad" || name == "°" || name.starts_with("degree")};
    const std::size_t behind = at_;
    if (exponent == 1 && take('^')) {
      const auto [end, problem] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), exponent);
      if (problem == std::errc() && exponent != 0 && std::abs(exponent) <= 9)
        at_ = static_cast<std::size_t>(end - text_.data());
      else
        at_ = behind, exponent = 1;
    }
    return power(value, exponent);
  }

  /// "1/s" behind a number and a blank, as values without a formula have it.
  std::optional<Value> inverse_unit_here() {
    const std::size_t before = at_;
    skip();
    if (language_.units && at_ > before && text_.substr(at_).starts_with("1/")) {
      at_ += 2;
      if (const auto unit = unit_here()) return power(*unit, -1);
    }
    at_ = before;
    return std::nullopt;
  }

  Value function(const std::string& name) {
    std::vector<Value> of{sum()};
    while (take(',')) of.push_back(sum());
    if (!take(')')) fail("a bracket is not closed");
    const Value& first = of.front();
    if (name == "min" || name == "max") {
      const auto below = [](const Value& a, const Value& b) { return a.number < b.number; };
      for (const Value& value : of)
        if (value.unit != first.unit) fail(name + " compares " + name_of(first.unit) + " with " + name_of(value.unit));
      return name == "min" ? *std::min_element(of.begin(), of.end(), below)
                           : *std::max_element(of.begin(), of.end(), below);
    }
    if (of.size() > 1) fail(name + " has one argument");
    if (name == "abs") return {std::abs(first.number), first.unit, first.angle};
    if (name == "sqrt") {
      const Dimension& unit = first.unit;
      if (unit.length % 2 || unit.mass % 2 || unit.time % 2) fail("no unit is the square root of " + name_of(unit));
      return {std::sqrt(first.number), {unit.length / 2, unit.mass / 2, unit.time / 2}, false};
    }
    using Plain = std::map<std::string, double (*)(double)>;
    static const Plain of_angles{{"sin", [](double x) { return std::sin(x); }},
                                 {"cos", [](double x) { return std::cos(x); }},
                                 {"tan", [](double x) { return std::tan(x); }}};
    static const Plain of_numbers{{"round", [](double x) { return std::round(x); }},
                                  {"floor", [](double x) { return std::floor(x); }},
                                  {"ceil", [](double x) { return std::ceil(x); }},
                                  {"exp", [](double x) { return std::exp(x); }},
                                  {"log", [](double x) { return std::log(x); }}};
    const Plain& functions = language_.functions.contains(name) ? language_.functions
                             : of_angles.contains(name)         ? of_angles
                                                                : of_numbers;
    const auto found = functions.find(name);
    if (found == functions.end()) {
      std::vector<std::string> known{"sqrt", "abs", "min", "max"};
      for (const Plain* some : {&language_.functions, &of_numbers, &of_angles})
        for (const auto& [own, unused] : *some) known.push_back(own);
      fail("there is no function '" + name + "'" + suggestion(name, known));
    }
    if (first.unit != dimension::none) fail(name + " needs a plain number, and this is " + name_of(first.unit));
    return {found->second(first.number), {}, false};
  }

  std::string_view text_;
  const Names& names_;
  int& depth_;
  const FormulaLanguage& language_;
  std::size_t at_ = 0;
};

/// Whether a formula would take a name for a unit: "kPa", and "m1" and "N2" too, the powers of units.
bool reads_as_unit(const std::string& name) {
  int depth = 0;
  return Formula(name, {}, depth).is_unit();
}

/// The section `values`: each is worked out once, when it is first needed.
class NamedValues {
 public:
  using Locate = std::function<SourceLocation(const YAML::Node&)>;
  NamedValues(const YAML::Node& map, Locate locate) : map_(map), locate_(std::move(locate)) {
    if (!map_.IsDefined()) return;
    if (!map_.IsMap())
      throw InputError(locate_(map_), "values: expected a map of names, for example values: {side: 30 mm}");
    for (const auto& entry : map_) {
      const std::string& name = entry.first.Scalar();
      names_.push_back(name);
      const bool word =
          !name.empty() && name.find_first_of(" +-*/^(),.") == std::string::npos && !(name[0] >= '0' && name[0] <= '9');
      if (!word || name == "pi" || reads_as_unit(name))
        throw InputError(locate_(entry.first),
                         "values: '" + name + "' " +
                             (word ? name == "pi" ? "is a number already" : "is a unit" : "is no name") +
                             "; call it otherwise, for example side_length");
    }
  }

  Value of(const std::string& name) {
    if (const auto known = known_.find(name); known != known_.end()) return known->second;
    const YAML::Node node = map_.IsDefined() ? std::as_const(map_)[name] : YAML::Node(YAML::NodeType::Undefined);
    if (!node.IsDefined())
      throw InputError(
          "there is no value '" + name + "'" +
          (names_.empty() ? "; name it in the section values: {" + name + ": …}" : suggestion(name, names_)));
    if (!under_way_.insert(name).second) throw InputError("the value '" + name + "' is made of itself");
    if (!node.IsScalar())
      throw InputError(locate_(node), "values." + name + ": expected a number with its unit, or a formula");
    std::string text = node.Scalar();
    if (text.starts_with('=')) text.erase(0, 1);
    const Names names = [this](const std::string& other) { return of(other); };
    try {
      known_[name] = Formula(text, names, depth_).value();
    } catch (const InputError& error) {
      if (error.has_location()) throw;
      throw InputError(locate_(node), "values." + name + ": " + error.what());
    }
    under_way_.erase(name);
    return known_[name];
  }
  const std::vector<std::string>& names() const { return names_; }
  const FormulaValues& known() const { return known_; }

 private:
  YAML::Node map_;
  Locate locate_;
  std::vector<std::string> names_;
  FormulaValues known_;
  std::set<std::string> under_way_;
  int depth_ = 0;  ///< of the formula that is read, with those that named it
};

/// As parse_quantity reads it; a whole number has no point.
std::string text_of(const Value& value) {
  std::string text = number(value.number, 15);
  if (value.unit == dimension::none) return value.angle ? text + " rad" : text;
  for (const auto& [name, power] : {std::pair{"kg", value.unit.mass}, {"m", value.unit.length}, {"s", value.unit.time}})
    if (power != 0) text += std::string(" ") + name + (power == 1 ? "" : "^" + std::to_string(power));
  return text;
}

/// Whether a key is one of those whose formulas are of the place, so that their numbers are known only there.
bool is_of_place(const std::string& key) { return key.find("fields.") != std::string::npos; }

void put_in(YAML::Node node, NamedValues& values, const NamedValues::Locate& locate, const std::string& key) {
  if (node.IsScalar()) {
    const std::string& tag = node.Tag();
    if (is_of_place(key) || !node.Scalar().starts_with('=') || tag == "!" ||
        (tag.starts_with('\001') && tag.ends_with('!')))
      return;
    const Names names = [&values](const std::string& name) { return values.of(name); };
    try {
      int depth = 0;
      node = text_of(Formula(node.Scalar().substr(1), names, depth).value());
    } catch (const InputError& error) {
      if (error.has_location()) throw;
      throw InputError(locate(node), key + ": " + error.what());
    }
    return;
  }
  for (auto entry : node)
    if (node.IsSequence())
      put_in(entry, values, locate, key);
    else
      put_in(entry.second, values, locate, key.empty() ? entry.first.Scalar() : key + "." + entry.first.Scalar());
}

}  // namespace

FormulaValues put_in_formulas(const YAML::Node& root,
                              const std::function<SourceLocation(const YAML::Node&)>& location_of) {
  NamedValues values(root["values"], location_of);
  for (const std::string& name : values.names()) values.of(name);  // a wrong one is reported even if it is not used
  for (const auto& entry : root)
    if (entry.first.Scalar() != "values") put_in(entry.second, values, location_of, entry.first.Scalar());
  return values.known();
}

FormulaValue formula_value(const std::string& text, const Names& value_of, const FormulaLanguage& language) {
  int depth = 0;
  return Formula(text, value_of, depth, language).any_value();
}

FormulaValue formula_at(const std::string& text, const Vector3& place, const Dimension& of_place,
                        const FormulaValues& values) {
  const Names names = [&](const std::string& name) -> Value {
    for (int axis = 0; axis < 3; ++axis)
      if (name == std::string(1, static_cast<char>('x' + axis))) return {place[axis], of_place, false};
    if (const auto found = values.find(name); found != values.end()) return found->second;
    std::vector<std::string> known{"x", "y", "z"};
    for (const auto& [own, value] : values) known.push_back(own);
    throw InputError("the formula '" + text + "': there is no value '" + name + "'" + suggestion(name, known));
  };
  return formula_value(text, names);
}

}  // namespace elastin::config
