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

std::string with_examples(std::string message, const Dimension& wanted) {
  return std::move(message) + "; write " + (wanted == dimension::none ? "a number" : "a number and its unit") +
         ", for example " + unit_examples(wanted);
}

/// Value and dimension of "kg/m^3", "N s/m", "cm2": factors joined by blanks, '*' or '·', '/' turns the next one over.
std::pair<double, Dimension> parse_unit(std::string_view text, const Dimension& wanted) {
  double factor = 1;
  Dimension dimension;
  int sign = 1;
  std::size_t at = 0;
  const auto unknown = [&](std::string_view name) {
    return InputError(with_examples("unknown unit '" + std::string(name) + "'", wanted));
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

Quantity parse_quantity(std::string_view text, const Dimension& wanted) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  const bool plus = text.starts_with('+') && !text.starts_with("+-");
  double number = 0;
  const auto [end, problem] = read_number(text.substr(plus), number);
  if (problem != std::errc() || !std::isfinite(number))
    throw InputError(with_examples("'" + std::string(text) + "' does not start with a finite number", wanted));
  std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  while (!unit.empty() && unit.front() == ' ') unit.remove_prefix(1);
  if (unit.empty()) return {number, false};
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
