#include "lab/run/curve_numbers.h"

#include <fmt/format.h>

namespace elastin::lab {
namespace {

using Form = CurveNumbers::Form;

/// Strains with their numbers, 0 at the origin.
std::vector<StressStrain::Point> points_of(const CurveNumbers& stated) {
  std::vector<StressStrain::Point> points;
  std::size_t next = 0;
  for (const double strain : stated.strains)
    points.push_back({strain, strain == 0 && stated.form == Form::points ? 0 : stated.numbers.at(next++).value});
  return points;
}

}  // namespace

std::string quantity_text(double value, const Dimension& unit, bool plain) {
  const std::string name = plain ? "" : si_unit(unit);
  return fmt::format("{:.9g}{}{}", value, name.empty() ? "" : " ", name);
}

StressStrain CurveNumbers::curve() const {
  const auto value = [&](std::size_t number) { return numbers.at(number).value; };
  switch (form) {
    case Form::points:
      return StressStrain::through(points_of(*this));
    case Form::toe:
      return StressStrain::toe(value(0), value(1), value(2));
    case Form::two_moduli:
      return StressStrain::bilinear(value(0), value(1), strains.at(0));
    case Form::secant_polynomial: {
      std::vector<double> coefficients;
      for (const Number& number : numbers) coefficients.push_back(number.value);
      return StressStrain::secant_polynomial(coefficients, strains.at(0));
    }
    case Form::secant_table: {
      std::vector<StressStrain::SecantPoint> table;
      for (const auto& [strain, modulus] : points_of(*this)) table.push_back({strain, modulus});
      return StressStrain::secant_table(table);
    }
  }
  return {};
}

std::string CurveNumbers::yaml(bool plain) const {
  const auto text = [&](double value, const Dimension& unit) { return quantity_text(value, unit, plain); };
  std::string list, named;
  for (const Number& number : numbers) {
    list += (list.empty() ? "" : ", ") + text(number.value, number.unit);
    named += (named.empty() ? "" : ", ") + number.name + ": " + text(number.value, number.unit);
  }
  std::string pairs;
  if (form == Form::points || form == Form::secant_table)
    for (const auto& [strain, value] : points_of(*this))
      pairs += fmt::format("{}[{:.9g}, {}]", pairs.empty() ? "" : ", ", strain, text(value, dimension::pressure));
  switch (form) {
    case Form::points:
      return "curve: {points: [" + pairs + "]}";
    case Form::toe:
      return "curve: {" + named + "}";
    case Form::two_moduli:
      return fmt::format("curve: {{{}, smoothing: {:.9g}}}", named, strains.at(0));
    case Form::secant_polynomial:
      return fmt::format("secant_modulus: {{polynomial: [{}], up_to: {:.9g}}}", list, strains.at(0));
    case Form::secant_table:
      return "secant_modulus: {points: [" + pairs + "]}";
  }
  return "";
}

}  // namespace elastin::lab
