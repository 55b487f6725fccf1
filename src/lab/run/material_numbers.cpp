#include "lab/run/material_numbers.h"

#include <fmt/format.h>

#include <array>
#include <limits>

#include "core/base/named.h"
#include "elastin/core/base/error.h"

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
  const auto value_of = [&](const Number& number) { return text(number.value, number.unit); };
  const auto named = [&] {
    return joined(numbers, [&](const Number& number) { return number.name + ": " + value_of(number); });
  };
  const auto pairs = [&] {
    return joined(points_of(*this), [&](const StressStrain::Point& point) {
      return fmt::format("[{:.9g}, {}]", point.strain, text(point.stress, dimension::pressure));
    });
  };
  switch (form) {
    case Form::points:
      return "curve: {points: [" + pairs() + "]}";
    case Form::toe:
      return "curve: {" + named() + "}";
    case Form::two_moduli:
      return fmt::format("curve: {{{}, smoothing: {:.9g}}}", named(), strains.at(0));
    case Form::secant_polynomial:
      return fmt::format("secant_modulus: {{polynomial: [{}], up_to: {:.9g}}}", joined(numbers, value_of),
                         strains.at(0));
    case Form::secant_table:
      return "secant_modulus: {points: [" + pairs() + "]}";
  }
  return "";
}

namespace {

using Kind = MaterialNumber::Kind;
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

void add_law_numbers(const MaterialLaw& row, const LawConstants& constants, std::vector<MaterialNumber>& numbers) {
  for (const ParameterInfo& info : row.parameters)
    if (const auto found = constants.numbers.find(info.name); found != constants.numbers.end())
      numbers.push_back({info.name, info.unit, info.low, info.high, info.above_low, found->second, Kind::law_number});
  for (std::size_t term = 0; term < constants.terms.size(); ++term)
    for (std::size_t column = 0; column < row.columns.size(); ++column) {
      const ParameterInfo& info = row.columns[column];
      numbers.push_back({info.name + "_" + std::to_string(term + 1), info.unit, info.low, info.high, info.above_low,
                         constants.terms[term][column], Kind::law_term, term, column});
    }
}

std::optional<Trial> admissible(const MaterialLaw* row, const Trial& trial, const std::vector<MaterialNumber>& numbers,
                                const VectorX& values) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const double value = values[static_cast<Eigen::Index>(i)];
    if (value < numbers[i].low || value > numbers[i].high || (numbers[i].above_low && value == numbers[i].low))
      return std::nullopt;
  }
  try {
    return with_numbers(row, trial, numbers, values);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace

std::vector<MaterialNumber> material_numbers(const MaterialLaw* row, const Trial& trial) {
  const Material& material = trial.material;
  std::vector<MaterialNumber> numbers;
  if (!row && trial.curve)
    for (std::size_t i = 0; i < trial.curve->numbers.size(); ++i) {
      const CurveNumbers::Number& number = trial.curve->numbers[i];
      numbers.push_back(
          {number.name, number.unit, -kUnbounded, kUnbounded, false, number.value, Kind::curve_number, i});
    }
  if ((!row || row->from_moduli) && !material.curve)
    numbers.push_back(
        {"youngs_modulus", dimension::pressure, 0, kUnbounded, true, material.youngs_modulus, Kind::youngs_modulus});
  if (!row || row->from_moduli)
    numbers.push_back(
        {"poissons_ratio", dimension::none, -0.99, 0.4999, false, material.poissons_ratio, Kind::poissons_ratio});
  if (row && material.law) add_law_numbers(*row, *material.law, numbers);
  if (material.relaxation)
    for (std::size_t term = 0; term < material.relaxation->terms.size(); ++term) {
      const auto& [share, time] = material.relaxation->terms[term];
      const std::string number = std::to_string(term + 1);
      const double most = material.relaxation->instantaneous ? 1 : kUnbounded;
      numbers.push_back({"g_" + number, dimension::none, 0, most, true, share, Kind::share, term});
      numbers.push_back({"tau_" + number, dimension::time, 0, kUnbounded, true, time, Kind::relaxation_time, term});
    }
  return numbers;
}

Trial with_numbers(const MaterialLaw* row, const Trial& trial, const std::vector<MaterialNumber>& numbers,
                   const VectorX& values) {
  Trial result = trial;
  Material& material = result.material;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const MaterialNumber& number = numbers[i];
    const double value = values[static_cast<Eigen::Index>(i)];
    switch (number.kind) {
      case Kind::law_number:
        material.law->numbers[number.name] = value;
        break;
      case Kind::law_term:
        material.law->terms.at(number.term).at(number.column) = value;
        break;
      case Kind::curve_number:
        result.curve->numbers.at(number.term).value = value;
        break;
      case Kind::youngs_modulus:
        material.youngs_modulus = value;
        break;
      case Kind::poissons_ratio:
        material.poissons_ratio = value;
        break;
      case Kind::share:
        material.relaxation->terms.at(number.term).share = value;
        break;
      case Kind::relaxation_time:
        material.relaxation->terms.at(number.term).time = value;
        break;
      case Kind::rule_parameter:
        result.rule[number.name] = value;
        break;
      case Kind::friction:
        result.friction = value;
        break;
      case Kind::scene_key:
        result.keys[number.name] = value;
        break;
    }
  }
  if (result.curve) {
    material.curve = result.curve->curve();
    material.youngs_modulus = material.curve->modulus(0);
  }
  if (row && material.law) material = with_law(*row, *material.law, material);
  return result;
}

std::vector<TrialChange> trial_changes(const MaterialLaw* row, const Trial& trial,
                                       const std::vector<MaterialNumber>& numbers, const VectorX& values,
                                       const VectorX& steps) {
  // Offsets in steps, and weights: central, then to either side, all of second order.
  struct Stencil {
    std::array<double, 3> offsets, weights;
  };
  constexpr Stencil stencils[] = {
      {{1, -1, 0}, {0.5, -0.5, 0}}, {{1, 2, 0}, {2, -0.5, -1.5}}, {{-1, -2, 0}, {-2, 0.5, 1.5}}};
  std::vector<TrialChange> changes;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    TrialChange change;
    for (const Stencil& stencil : stencils) {
      change = {};
      bool all = true;
      for (std::size_t point = 0; point < 3; ++point) {
        if (stencil.weights[point] == 0) continue;
        VectorX at = values;
        at[i] += stencil.offsets[point] * steps[i];
        std::optional<Trial> other = admissible(row, trial, numbers, at);
        all &= other.has_value();
        if (!all) break;
        change.trials.push_back(std::move(*other));
        change.weights.push_back(stencil.weights[point] / steps[i]);
      }
      if (all) break;
      change = {};
    }
    changes.push_back(std::move(change));
  }
  return changes;
}

std::vector<MaterialChange> material_changes(const std::vector<TrialChange>& changes) {
  std::vector<MaterialChange> of_materials;
  for (const TrialChange& change : changes) {
    MaterialChange& own = of_materials.emplace_back();
    for (const Trial& trial : change.trials) own.materials.push_back(trial.material);
    own.weights = change.weights;
  }
  return of_materials;
}

Matrix3 axes_of_law(const MaterialLaw& row, const Material& material) {
  std::vector<Vector3> directions;
  for (const ParameterInfo& info : row.parameters)
    if (const auto found = material.law->directions.find(info.name); found != material.law->directions.end())
      directions.push_back(found->second);
  if (directions.empty()) return Matrix3::Identity();
  const Vector3 one = directions.front(), other = directions.size() > 1 ? directions[1] : one.unitOrthogonal();
  const Vector3 two = (other - one * one.dot(other)).normalized();
  return (Matrix3() << one, two, one.cross(two)).finished();
}

}  // namespace elastin::lab
