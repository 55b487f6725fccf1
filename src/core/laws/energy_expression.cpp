#include "elastin/core/laws/energy_expression.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/named.h"
#include "core/laws/jet3.h"
#include "core/laws/solids/components.h"
#include "elastin/core/base/dense.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/laws/volumetric.h"

namespace elastin {
namespace energy {

enum class Kind {
  number,
  parameter,
  first,
  second,
  swelling,
  add,
  subtract,
  multiply,
  divide,
  power,
  negate,
  square,
  sqrt,
  exp,
  expm1,
  log,
  log1p,
  sin,
  cos,
  sinh,
  cosh,
  tanh,
  arctan,
  absolute,
  maximum,
  minimum,
  less,
  select
};

}  // namespace energy

namespace {

using energy::Kind;

constexpr std::size_t kMost = 256;

struct Named {
  const char* name;
  Kind kind;
  int takes;
};
constexpr Named kKinds[] = {{"number", Kind::number, 0},     {"parameter", Kind::parameter, 0},
                            {"first", Kind::first, 0},       {"second", Kind::second, 0},
                            {"swelling", Kind::swelling, 0}, {"add", Kind::add, 2},
                            {"subtract", Kind::subtract, 2}, {"multiply", Kind::multiply, 2},
                            {"divide", Kind::divide, 2},     {"power", Kind::power, 2},
                            {"negate", Kind::negate, 1},     {"square", Kind::square, 1},
                            {"sqrt", Kind::sqrt, 1},         {"exp", Kind::exp, 1},
                            {"expm1", Kind::expm1, 1},       {"log", Kind::log, 1},
                            {"log1p", Kind::log1p, 1},       {"sin", Kind::sin, 1},
                            {"cos", Kind::cos, 1},           {"sinh", Kind::sinh, 1},
                            {"cosh", Kind::cosh, 1},         {"tanh", Kind::tanh, 1},
                            {"arctan", Kind::arctan, 1},     {"absolute", Kind::absolute, 1},
                            {"maximum", Kind::maximum, 2},   {"minimum", Kind::minimum, 2},
                            {"less", Kind::less, 2},         {"select", Kind::select, 3}};

const Named& named(const EnergyOperation& operation) {
  return elastin::named(kKinds, operation.kind, "unknown operation '" + operation.kind + "'");
}

Jet3 power(const Jet3& a, const Jet3& b) {
  const double x = a.value, p = b.value;
  const bool fixed = std::all_of(b.slope.begin(), b.slope.end(), [](double s) { return s == 0; });
  const double value = std::pow(x, p);
  if (fixed) {
    const double f1 = p == 0 ? 0 : p * std::pow(x, p - 1);
    return a.through(value, f1, p == 0 || p == 1 ? 0 : p * (p - 1) * std::pow(x, p - 2));
  }
  const double log_x = std::log(x), below = std::pow(x, p - 1);
  return Jet3::through(a, b, value, p * below, value * log_x, p * (p - 1) * std::pow(x, p - 2), below * (1 + p * log_x),
                       value * log_x * log_x);
}

/// Of one value.
Jet3 applied(Kind kind, const Jet3& a) {
  const double x = a.value;
  switch (kind) {
    case Kind::negate:
      return a.through(-x, -1, 0);
    case Kind::square:
      return a.through(x * x, 2 * x, 2);
    case Kind::sqrt: {
      const double root = std::sqrt(x);
      return a.through(root, 0.5 / root, -0.25 / (root * x));
    }
    case Kind::exp: {
      const double e = std::exp(x);
      return a.through(e, e, e);
    }
    case Kind::expm1: {
      const double e = std::exp(x);
      return a.through(std::expm1(x), e, e);
    }
    case Kind::log:
      return a.through(std::log(x), 1 / x, -1 / (x * x));
    case Kind::log1p: {
      const double r = 1 / (1 + x);
      return a.through(std::log1p(x), r, -r * r);
    }
    case Kind::sin:
      return a.through(std::sin(x), std::cos(x), -std::sin(x));
    case Kind::cos:
      return a.through(std::cos(x), -std::sin(x), -std::cos(x));
    case Kind::sinh:
      return a.through(std::sinh(x), std::cosh(x), std::sinh(x));
    case Kind::cosh:
      return a.through(std::cosh(x), std::sinh(x), std::cosh(x));
    case Kind::tanh: {
      const double t = std::tanh(x), f1 = 1 - t * t;
      return a.through(t, f1, -2 * t * f1);
    }
    case Kind::arctan: {
      const double f1 = 1 / (1 + x * x);
      return a.through(std::atan(x), f1, -2 * x * f1 * f1);
    }
    default:  // absolute
      return x < 0 ? a.through(-x, -1, 0) : a;
  }
}

Jet3 applied(Kind kind, const Jet3& a, const Jet3& b) {
  const double x = a.value, y = b.value;
  switch (kind) {
    case Kind::add:
      return Jet3::through(a, b, x + y, 1, 1, 0, 0, 0);
    case Kind::subtract:
      return Jet3::through(a, b, x - y, 1, -1, 0, 0, 0);
    case Kind::multiply:
      return Jet3::through(a, b, x * y, y, x, 0, 1, 0);
    case Kind::divide: {
      const double r = 1 / y, ratio = x * r;
      return Jet3::through(a, b, x / y, r, -ratio * r, 0, -r * r, 2 * ratio * r * r);
    }
    case Kind::power:
      return power(a, b);
    case Kind::maximum:
      return x < y ? b : a;
    case Kind::minimum:
      return y < x ? b : a;
    default:  // less
      return Jet3::constant(x < y ? 1 : 0);
  }
}

}  // namespace

struct EnergyExpression::Point::Step {
  energy::Kind kind;
  std::array<int, 3> of;
  double number;
};

namespace {

/// The invariants at a point, as far from rest as they are: I₁ − 3, I₂ − 3, J − 1.
struct Invariants {
  double first, second, swelling;

  Invariants(const Matrix3& A, const Dilatation& now) : first(A.trace()), swelling(now.swelling()) {
    second = 2 * first + (first * first - A.cwiseProduct(A.transpose()).sum()) / 2;
  }
};

template <class Steps>
Jet3 evaluated(const Steps& steps, const Invariants& at) {
  std::array<Jet3, kMost> results;
  std::size_t next = 0;
  for (const auto& step : steps) {
    const auto of = [&](std::size_t i) -> const Jet3& { return results[step.of[i]]; };
    Jet3& result = results[next++];
    if (step.kind == Kind::number)
      result = Jet3::constant(step.number);
    else if (step.kind == Kind::first)
      result = Jet3::variable(at.first, 0);
    else if (step.kind == Kind::second)
      result = Jet3::variable(at.second, 1);
    else if (step.kind == Kind::swelling)
      result = Jet3::variable(at.swelling, 2);
    else if (step.kind == Kind::select)
      result = of(0).value != 0 ? of(1) : of(2);
    else
      result = step.of[1] < 0 ? applied(step.kind, of(0)) : applied(step.kind, of(0), of(1));
  }
  return results[next - 1];
}

}  // namespace

std::vector<EnergyOperationInfo> energy_operations() {
  std::vector<EnergyOperationInfo> list;
  for (const Named& one : kKinds)
    if (one.takes > 0) list.push_back({one.name, one.takes});
  return list;
}

EnergyExpression::EnergyExpression(std::vector<EnergyOperation> operations) {
  if (operations.empty() || operations.size() > kMost)
    throw InputError("an energy has " + std::to_string(operations.size()) + " operations; allowed: 1 to " +
                     std::to_string(kMost));
  for (std::size_t i = 0; i < operations.size(); ++i) {
    const EnergyOperation& operation = operations[i];
    const Named& known = named(operation);
    if (operation.of.size() != static_cast<std::size_t>(known.takes))
      throw InputError("operation " + std::to_string(i) + ", " + operation.kind + ", takes " +
                       std::to_string(known.takes) + " values, and not " + std::to_string(operation.of.size()));
    for (const int of : operation.of)
      if (of < 0 || of >= static_cast<int>(i))
        throw InputError("operation " + std::to_string(i) + ", " + operation.kind + ", takes operation " +
                         std::to_string(of) + "; allowed: 0 to " + std::to_string(static_cast<int>(i) - 1));
  }
  operations_ = std::make_shared<const std::vector<EnergyOperation>>(std::move(operations));
}

std::vector<std::string> EnergyExpression::parameters() const {
  std::vector<std::string> names;
  for (const EnergyOperation& operation : *operations_)
    if (operation.kind == "parameter" && std::find(names.begin(), names.end(), operation.parameter) == names.end())
      names.push_back(operation.parameter);
  return names;
}

EnergyExpression::Point EnergyExpression::at(const std::vector<double>& values, double factor) const {
  const std::vector<std::string> names = parameters();
  std::vector<Point::Step> steps;
  for (const EnergyOperation& operation : *operations_) {
    Point::Step step{named(operation).kind, {-1, -1, -1}, operation.number};
    std::copy(operation.of.begin(), operation.of.end(), step.of.begin());
    if (step.kind == Kind::parameter) {
      const auto name = std::find(names.begin(), names.end(), operation.parameter);
      step.kind = Kind::number;
      step.number = values.at(name - names.begin());
    }
    steps.push_back(step);
  }
  Point point;
  point.steps_ = std::make_shared<const std::vector<Point::Step>>(std::move(steps));
  point.factor_ = factor;
  const Matrix3 rest = Matrix3::Zero();
  const Jet3 W = evaluated(*point.steps_, Invariants(rest, Dilatation(rest)));
  point.at_rest_ = W.value;
  const TangentModuli<3> tangent = point.tangent(rest);
  const double stress = point.stress(rest).norm(), size = tangent.norm();
  if (!std::isfinite(W.value) || !std::isfinite(size))
    throw InputError("the energy has no finite value or slope at rest, I1 = 3, I2 = 3, J = 1");
  if (stress > 1e-8 * size)
    throw InputError("the energy has a stress of " + number(point.stress(rest)(0, 0)) +
                     " Pa at rest: W must be least there, I1 = 3, I2 = 3, J = 1");
  if (!(symmetric_eigenvalues(tangent)[0] > 1e-9 * size))
    throw InputError("the energy is unstable at rest, I1 = 3, I2 = 3, J = 1: a small strain lowers it");
  return point;
}

Matrix3 EnergyExpression::Point::stress(const Matrix3& A) const {
  const Dilatation now(A);
  const Invariants at(A, now);
  const auto& [W1, W2, WJ] = evaluated(*steps_, at).slope;
  // 2 (W₁ + 2 W₂) + W_J is zero at rest.
  const Matrix3 S = 2 * ((W1 + W2 * (2 + at.first)) * Matrix3::Identity() - W2 * A) + WJ * now.J() * now.inverse;
  return S.allFinite() ? Matrix3(factor_ * S) : Matrix3(Matrix3::Zero());
}

TangentModuli<3> EnergyExpression::Point::tangent(const Matrix3& A) const {
  const Dilatation now(A);
  const Invariants at(A, now);
  const Jet3 W = evaluated(*steps_, at);
  const double J = now.J(), W2 = W.slope[1], WJ = W.slope[2];
  const Components unit = components(Matrix3::Identity()), G = components(now.inverse);
  const std::array<Components, 3> slopes{unit, (2 + at.first) * unit - components(A), J / 2 * G};
  TangentModuli<3> result = 2 * W2 * (unit * unit.transpose() - symmetric_square(Matrix3::Identity())) +
                            WJ * J * (G * G.transpose() / 2 - symmetric_square(now.inverse));
  for (std::size_t p = 0; p < 6; ++p) {
    const auto i = static_cast<std::size_t>(Jet3::pairs[p][0]), j = static_cast<std::size_t>(Jet3::pairs[p][1]);
    if (W.curvature[p] == 0) continue;
    if (i == j)
      result += 2 * W.curvature[p] * (slopes[i] * slopes[i].transpose());
    else
      result += 2 * W.curvature[p] * both_ways(slopes[i], slopes[j]);
  }
  return result.allFinite() ? TangentModuli<3>(factor_ * result) : TangentModuli<3>(TangentModuli<3>::Zero());
}

double EnergyExpression::Point::energy(const Matrix3& A) const {
  const Dilatation now(A);
  const double W = evaluated(*steps_, Invariants(A, now)).value - at_rest_;
  return now.flat || !std::isfinite(W) ? std::numeric_limits<double>::infinity() : factor_ * W;
}

}  // namespace elastin
