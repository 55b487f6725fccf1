#include "elastin/core/base/units.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "core/base/unit_table.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

struct Unit {
  std::string_view name;
  double factor;
  Dimension dimension;
  bool prefixed;
};

constexpr std::array kUnits{Unit{"m", 1, dimension::length, true},
                            Unit{"g", 1e-3, dimension::mass, true},
                            Unit{"s", 1, dimension::time, true},
                            Unit{"N", 1, dimension::force, true},
                            Unit{"Pa", 1, dimension::pressure, true},
                            Unit{"bar", 1e5, dimension::pressure, true},
                            Unit{"J", 1, dimension::energy, true},
                            Unit{"l", 1e-3, dimension::volume, true},
                            Unit{"t", 1e3, dimension::mass, false},
                            Unit{"Hz", 1, {0, 0, -1}, true},
                            Unit{"min", 60, dimension::time, false},
                            Unit{"mmHg", 133.322387415, dimension::pressure, false},
                            Unit{"rad", 1, dimension::none, false},
                            Unit{"deg", std::numbers::pi / 180, dimension::none, false},
                            Unit{"degree", std::numbers::pi / 180, dimension::none, false},
                            Unit{"degrees", std::numbers::pi / 180, dimension::none, false},
                            Unit{"°", std::numbers::pi / 180, dimension::none, false},
                            Unit{"%", 1e-2, dimension::none, false}};
constexpr std::array<std::pair<std::string_view, double>, 11> kPrefixes{{{"n", 1e-9},
                                                                         {"u", 1e-6},
                                                                         {"µ", 1e-6},
                                                                         {"μ", 1e-6},
                                                                         {"m", 1e-3},
                                                                         {"c", 1e-2},
                                                                         {"d", 1e-1},
                                                                         {"h", 1e2},
                                                                         {"k", 1e3},
                                                                         {"M", 1e6},
                                                                         {"G", 1e9}}};

}  // namespace

/// A unit's factor and dimension; names without prefix come first, so that "m" is metre and "min" minute.
std::optional<std::pair<double, Dimension>> find_unit(std::string_view name) {
  for (const Unit& unit : kUnits)
    if (unit.name == name) return std::pair{unit.factor, unit.dimension};
  for (const Unit& unit : kUnits)
    if (unit.prefixed)
      for (const auto& [prefix, factor] : kPrefixes)
        if (name.size() == prefix.size() + unit.name.size() && name.starts_with(prefix) && name.ends_with(unit.name))
          return std::pair{factor * unit.factor, unit.dimension};
  return std::nullopt;
}

namespace {

/// What is written out in words.
constexpr std::array<std::pair<std::string_view, std::string_view>, 13> kUnitWords{{{"metre", "m"},
                                                                                    {"meter", "m"},
                                                                                    {"gramme", "g"},
                                                                                    {"gram", "g"},
                                                                                    {"second", "s"},
                                                                                    {"sec", "s"},
                                                                                    {"newton", "N"},
                                                                                    {"pascal", "Pa"},
                                                                                    {"joule", "J"},
                                                                                    {"litre", "l"},
                                                                                    {"liter", "l"},
                                                                                    {"hertz", "Hz"},
                                                                                    {"minute", "min"}}};
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kPrefixWords{{{"nano", "n"},
                                                                                     {"micro", "u"},
                                                                                     {"milli", "m"},
                                                                                     {"centi", "c"},
                                                                                     {"hecto", "h"},
                                                                                     {"kilo", "k"},
                                                                                     {"mega", "M"},
                                                                                     {"giga", "G"}}};
/// Units that are not read, with what one of them is.
constexpr std::array<std::pair<std::string_view, std::string_view>, 13> kForeignUnits{{{"psi", "6.8948 kPa"},
                                                                                       {"ksi", "6.8948 MPa"},
                                                                                       {"atm", "101.325 kPa"},
                                                                                       {"Torr", "133.32 Pa"},
                                                                                       {"cmH2O", "98.067 Pa"},
                                                                                       {"in", "25.4 mm"},
                                                                                       {"inch", "25.4 mm"},
                                                                                       {"ft", "0.3048 m"},
                                                                                       {"lb", "0.45359 kg"},
                                                                                       {"lbf", "4.4482 N"},
                                                                                       {"kgf", "9.8067 N"},
                                                                                       {"dyn", "10 uN"},
                                                                                       {"h", "3600 s"}}};

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& letter : lower)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return lower;
}

/// "kPa" of "kilopascals"; "" for an unknown word.
std::string abbreviated(std::string_view name) {
  std::string word = lower_case(name);
  if (word.size() > 3 && word.ends_with('s')) word.pop_back();
  for (const auto& [unit, symbol] : kUnitWords) {
    if (!word.ends_with(unit)) continue;
    const std::string_view before = std::string_view(word).substr(0, word.size() - unit.size());
    if (before.empty()) return std::string(symbol);
    for (const auto& [prefix, letter] : kPrefixWords)
      if (before == prefix) return std::string(letter) + std::string(symbol);
  }
  return "";
}

/// The unit with other capitals that has the wanted dimension; "" where no unit has it. Of several, the one of k, M, G.
std::string with_other_capitals(std::string_view name, const Dimension& wanted) {
  std::string found;
  for (const Unit& unit : kUnits) {
    if (unit.dimension != wanted) continue;
    if (lower_case(unit.name) == lower_case(name)) found = unit.name;
    for (const auto& [prefix, factor] : kPrefixes)
      if (unit.prefixed && lower_case(std::string(prefix) + std::string(unit.name)) == lower_case(name))
        found = std::string(prefix) + std::string(unit.name);
  }
  return found;
}

/// "; did you mean 'kPa'?" or what the unit is in others; "" where nothing is known of it.
std::string hint_of_unit(std::string_view name, const Dimension& wanted) {
  for (const auto& [foreign, is] : kForeignUnits)
    if (foreign == name) return "; 1 " + std::string(foreign) + " is " + std::string(is);
  std::string meant = abbreviated(name);
  if (meant.empty()) meant = with_other_capitals(name, wanted);
  while (meant.empty() && !name.empty() && (name.back() == '.' || name.back() == ',' || name.back() == ';')) {
    name.remove_suffix(1);
    if (find_unit(name)) meant = name;
  }
  return meant.empty() ? "" : "; did you mean '" + meant + "'?";
}

bool is_digit(char letter) { return letter >= '0' && letter <= '9'; }

/// A number that was written as other programs and languages do: with a decimal comma, marks between thousands, a power
/// of ten, a sum of several. What it should be, or "".
std::string hint_of_number(std::string_view text) {
  const std::size_t begin = text.find_first_of("0123456789");
  if (begin == std::string_view::npos) return "";
  if (begin > 0 && text.find_first_of("<>~=") < begin)
    return "write the number alone: " + std::string(text.substr(begin));
  std::size_t end = begin;  // of the digits, points and marks
  std::string digits;
  int commas = 0, points = 0, marks = 0;
  const auto digits_from = [&](std::size_t at) {
    return std::min(text.find_first_not_of("0123456789", at), text.size()) - at;
  };
  for (; end < text.size(); ++end) {
    const char letter = text[end];
    const std::size_t next = digits_from(end + 1);
    const bool mark = (letter == ' ' || letter == '\'' || letter == '_') && next == 3;  // between thousands
    if (!is_digit(letter) && !mark && !((letter == ',' || letter == '.') && next > 0)) break;
    if (!mark) digits += letter;
    marks += mark, commas += letter == ',', points += letter == '.';
  }
  const std::string rest(text.substr(end)), sign(text.substr(0, begin));
  const auto without = [](std::string from, char mark) {
    std::erase(from, mark);
    return from;
  };
  if (commas == 1 && points == 0 && marks == 0) {
    std::string point = digits;
    point[point.find(',')] = '.';
    const bool thousands = digits.size() - digits.find(',') == 4 && digits.find(',') < 4;
    return "a decimal point is needed where a comma stands: write " + sign + point + rest +
           (thousands ? ", or " + sign + without(digits, ',') + rest + " if thousands are meant" : "");
  }
  if (commas + marks > 0) return "thousands are not set apart: write " + sign + without(digits, ',') + rest;
  for (const char* power : {"*10^", " * 10^", "x10^", " x 10^", "·10^", " · 10^", "×10^", " × 10^", "*10**", " 10^"})
    if (rest.starts_with(power)) {
      std::string exponent = rest.substr(std::string_view(power).size());
      if (exponent.starts_with('+')) exponent.erase(0, 1);
      return "write " + sign + digits + "e" + exponent;
    }
  if (rest.size() > 1 && (rest[0] == '/' || rest[0] == '*') && is_digit(rest[1])) {
    const std::size_t unit = std::min(rest.find_first_not_of("0123456789.", 1), rest.size());
    return "a formula begins with =: write = " + sign + digits + rest.substr(unit) + " " + rest[0] + " " +
           rest.substr(1, unit - 1);
  }
  if (rest.starts_with(" - ") || rest.starts_with(" to ") || rest.starts_with("..") || rest.starts_with(" ± ") ||
      rest.starts_with(" +- ") || rest.starts_with("±"))
    return "one number is needed, not a range";
  if (const std::size_t bracket = rest.find(" ("); bracket != std::string::npos)
    return "what is said about a value is a comment: write " + sign + digits + rest.substr(0, bracket) + "  #" +
           rest.substr(bracket);
  return "";
}

std::string with_examples(const std::string& message, const Dimension& wanted) {
  return message + (message.ends_with('?') ? " Write " : "; write ") +
         (wanted == dimension::none ? "a number" : "a number and its unit") + ", for example " + unit_examples(wanted);
}

/// Value and dimension of "kg/m^3", "N s/m", "cm2": factors joined by blanks, '*' or '·', '/' turns the next one over.
std::pair<double, Dimension> parse_unit(std::string_view text, const Dimension& wanted) {
  double factor = 1;
  Dimension dimension;
  int sign = 1;
  std::size_t at = 0;
  const auto unknown = [&](std::string_view name) {
    return InputError(with_examples("unknown unit '" + std::string(name) + "'" + hint_of_unit(name, wanted), wanted));
  };
  while (at < text.size()) {
    if (text[at] == ' ' || text[at] == '*' || text.substr(at, 2) == "·") {
      at += text[at] == ' ' || text[at] == '*' ? 1 : 2;
      continue;
    }
    if (text[at] == '/') {
      if (sign < 0) throw unknown(text);
      sign = -1;
      ++at;
      continue;
    }
    const std::size_t end = std::min({text.find_first_of(" */^0123456789-", at), text.find("·", at), text.size()});
    std::string_view name = text.substr(at, end - at);
    at = end;
    int power = 1;
    for (const auto& [superscript, value] : {std::pair<std::string_view, int>{"²", 2}, {"³", 3}})
      if (name.ends_with(superscript)) {
        name.remove_suffix(superscript.size());
        power = value;
      }
    if (at < text.size() && text[at] == '^') ++at;
    const auto [rest, problem] = std::from_chars(text.data() + at, text.data() + text.size(), power);
    if (problem == std::errc()) at = static_cast<std::size_t>(rest - text.data());
    if (name.empty() && power == 1 && sign > 0 && text.substr(at).starts_with('/')) continue;  // "1/s"
    const auto unit = find_unit(name);
    if (!unit || power == 0 || std::abs(power) > 9) throw unknown(name.empty() ? text : name);
    factor *= std::pow(unit->first, sign * power);
    dimension.length += sign * power * unit->second.length;
    dimension.mass += sign * power * unit->second.mass;
    dimension.time += sign * power * unit->second.time;
    sign = 1;
  }
  if (sign < 0) throw unknown(text);
  return {factor, dimension};
}

/// std::from_chars of a decimal number.
std::from_chars_result read_number(std::string_view text, double& number) {
#ifdef __cpp_lib_to_chars
  return std::from_chars(text.data(), text.data() + text.size(), number);
#else  // libc++ before version 20 has it of whole numbers alone
  const std::string copy(text.substr(0, text.find_first_not_of("0123456789+-.eE")));
  char* end = nullptr;
  number = std::strtod(copy.c_str(), &end);
  const bool any = end != copy.c_str();
  return {text.data() + (end - copy.c_str()), any ? std::errc() : std::errc::invalid_argument};
#endif
}

}  // namespace

namespace {

/// Blanks of other widths and the minus sign of printed text stand for those of a keyboard.
std::string with_plain_signs(std::string text) {
  for (const auto& [sign, plain] : {std::pair<std::string_view, std::string_view>{"\u00a0", " "},
                                    {"\u202f", " "},
                                    {"\u2009", " "},
                                    {"\u2212", "-"}})
    for (std::size_t at = 0; (at = text.find(sign, at)) != std::string::npos;) text.replace(at, sign.size(), plain);
  return text;
}

}  // namespace

Quantity parse_quantity(std::string_view given, const Dimension& wanted) {
  const std::string plain = with_plain_signs(std::string(given));
  std::string_view text = plain;
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  const bool plus = text.starts_with('+') && !text.starts_with("+-");
  double number = 0;
  const auto [end, problem] = read_number(text.substr(plus), number);
  const std::string hint = hint_of_number(text);
  const auto refuse = [&](const std::string& message) {
    return InputError(with_examples(message + (hint.empty() ? "" : "; " + hint), wanted));
  };
  if (problem != std::errc() || !std::isfinite(number))
    throw refuse("'" + std::string(text) + "' does not start with a finite number");
  std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  while (!unit.empty() && unit.front() == ' ') unit.remove_prefix(1);
  if (unit.empty()) return {number, false};
  if (!hint.empty()) throw refuse("'" + std::string(text) + "' is not one number and its unit");
  const auto [factor, dimension] = parse_unit(unit, wanted);
  if (dimension != wanted)
    throw InputError(with_examples("'" + std::string(unit) + "' cannot be converted to " +
                                       (wanted == dimension::none ? "a plain number" : si_unit(wanted)),
                                   wanted));
  if (!std::isfinite(number * factor))
    throw InputError(with_examples("'" + std::string(text) + "' is too large a number", wanted));
  return {number * factor, true};
}

std::string si_unit(const Dimension& wanted) {
  for (const auto& [dimension, name] : {std::pair{dimension::force, "N"},
                                        {dimension::pressure, "Pa"},
                                        {dimension::stiffness, "N/m"},
                                        {dimension::damping, "N s/m"},
                                        {dimension::viscosity, "Pa s"},
                                        {dimension::energy, "J"},
                                        {Dimension{-2, 1, -2}, "Pa/m"}})
    if (dimension == wanted) return name;
  std::string above, below;
  for (const auto& [name, power] : {std::pair{"kg", wanted.mass}, {"m", wanted.length}, {"s", wanted.time}}) {
    if (power == 0) continue;
    std::string& side = power > 0 ? above : below;
    side += (side.empty() ? "" : " ") + std::string(name) +
            (std::abs(power) > 1 ? "^" + std::to_string(std::abs(power)) : "");
  }
  return below.empty() ? above : (above.empty() ? "1" : above) + "/" + below;
}

std::string unit_examples(const Dimension& wanted) {
  for (const auto& [dimension, examples] : {std::pair{dimension::none, "0.3, 20 %, 30 deg"},
                                            {dimension::length, "15 mm, 2 cm, 0.1 m"},
                                            {dimension::area, "9 cm2, 1 m^2"},
                                            {dimension::mass, "5 g, 0.1 kg"},
                                            {dimension::time, "2 ms, 1 s"},
                                            {dimension::force, "1 N, 5 kN"},
                                            {dimension::pressure, "5 kPa, 1.2 MPa"},
                                            {dimension::density, "1000 kg/m3, 1.1 g/cm3"},
                                            {dimension::acceleration, "9.81 m/s2"},
                                            {dimension::stiffness, "200 N/m"},
                                            {dimension::damping, "0.1 N s/m"},
                                            {dimension::viscosity, "1 mPa s"}})
    if (dimension == wanted) return examples;
  return "1 " + si_unit(wanted);
}

}  // namespace elastin
