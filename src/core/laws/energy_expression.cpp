#include "elastin/core/laws/energy_expression.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/dense.h"
#include "core/base/named.h"
#include "core/laws/jet3.h"
#include "core/laws/solids/components.h"
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
  fibre,
  fibre_square,
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
constexpr Named kKinds[] = {{"number", Kind::number, 0},
                            {"parameter", Kind::parameter, 0},
                            {"first", Kind::first, 0},
                            {"second", Kind::second, 0},
                            {"swelling", Kind::swelling, 0},
                            {"fibre", Kind::fibre, 0},
                            {"fibre_square", Kind::fibre_square, 0},
                            {"add", Kind::add, 2},
                            {"subtract", Kind::subtract, 2},
                            {"multiply", Kind::multiply, 2},
                            {"divide", Kind::divide, 2},
                            {"power", Kind::power, 2},
                            {"negate", Kind::negate, 1},
                            {"square", Kind::square, 1},
                            {"sqrt", Kind::sqrt, 1},
                            {"exp", Kind::exp, 1},
                            {"expm1", Kind::expm1, 1},
                            {"log", Kind::log, 1},
                            {"log1p", Kind::log1p, 1},
                            {"sin", Kind::sin, 1},
                            {"cos", Kind::cos, 1},
                            {"sinh", Kind::sinh, 1},
                            {"cosh", Kind::cosh, 1},
                            {"tanh", Kind::tanh, 1},
                            {"arctan", Kind::arctan, 1},
                            {"absolute", Kind::absolute, 1},
                            {"maximum", Kind::maximum, 2},
                            {"minimum", Kind::minimum, 2},
                            {"less", Kind::less, 2},
                            {"select", Kind::select, 3}};

const Named& named(const EnergyOperation& operation) {
  return elastin::named(kKinds, operation.kind, "unknown operation '" + operation.kind + "'");
}

template <class Jet>
Jet power(const Jet& a, const Jet& b) {
  const double x = a.value, p = b.value;
  const bool fixed = std::all_of(b.slope.begin(), b.slope.end(), [](double s) { return s == 0; });
  const double value = std::pow(x, p);
  if (fixed) {
    const double f1 = p == 0 ? 0 : p * std::pow(x, p - 1);
    return a.through(value, f1, p == 0 || p == 1 ? 0 : p * (p - 1) * std::pow(x, p - 2));
  }
  const double log_x = std::log(x), below = std::pow(x, p - 1);
  return Jet::through(a, b, value, p * below, value * log_x, p * (p - 1) * std::pow(x, p - 2), below * (1 + p * log_x),
                      value * log_x * log_x);
}

/// Of one value.
template <class Jet>
Jet applied(Kind kind, const Jet& a) {
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

template <class Jet>
Jet applied(Kind kind, const Jet& a, const Jet& b) {
  const double x = a.value, y = b.value;
  switch (kind) {
    case Kind::add:
      return Jet::through(a, b, x + y, 1, 1, 0, 0, 0);
    case Kind::subtract:
      return Jet::through(a, b, x - y, 1, -1, 0, 0, 0);
    case Kind::multiply:
      return Jet::through(a, b, x * y, y, x, 0, 1, 0);
    case Kind::divide: {
      const double r = 1 / y, ratio = x * r;
      return Jet::through(a, b, x / y, r, -ratio * r, 0, -r * r, 2 * ratio * r * r);
    }
    case Kind::power:
      return power(a, b);
    case Kind::maximum:
      return x < y ? b : a;
    case Kind::minimum:
      return y < x ? b : a;
    default:  // less
      return Jet::constant(x < y ? 1 : 0);
  }
}

}  // namespace

struct EnergyExpression::Point::Step {
  energy::Kind kind;
  std::array<int, 3> of;
  double number;
};

namespace {

/// The invariants at a point, as far from rest as they are: I₁ − 3, I₂ − 3, J − 1, I₄ − 1, I₅ − 1.
std::array<double, 5> invariants(const Matrix3& A, const Dilatation& now, const Vector3& fibre) {
  const double first = A.trace();
  const Vector3 along = A * fibre;
  const double stretched = fibre.dot(along);
  return {first, 2 * first + (first * first - A.cwiseProduct(A.transpose()).sum()) / 2, now.swelling(), stretched,
          2 * stretched + along.squaredNorm()};
}

template <class Jet, class Steps>
Jet evaluated(const Steps& steps, const std::array<double, 5>& at) {
  std::array<Jet, kMost> results;
  std::size_t next = 0;
  for (const auto& step : steps) {
    const auto of = [&](std::size_t i) -> const Jet& { return results[step.of[i]]; };
    Jet& result = results[next++];
    const auto invariant = static_cast<std::size_t>(step.kind) - static_cast<std::size_t>(Kind::first);
    if (step.kind == Kind::number)
      result = Jet::constant(step.number);
    else if (invariant < std::tuple_size_v<decltype(Jet::slope)>)
      result = Jet::variable(at[invariant], invariant);
    else if (step.kind == Kind::select)
      result = of(0).value != 0 ? of(1) : of(2);
    else
      result = step.of[1] < 0 ? applied(step.kind, of(0)) : applied(step.kind, of(0), of(1));
  }
  return results[next - 1];
}

/// ∂(a · C² a)/∂C = a (C a)ᵀ + C a aᵀ, and what of a strain makes it change, the same of each unit strain.
Components square_slope(const Vector3& fibre, const Matrix3& A) {
  return 2 * symmetric_product(fibre, fibre + A * fibre);
}
TangentModuli<3> square_curvature(const Vector3& fibre) {
  TangentModuli<3> result;
  for (int column = 0; column < 6; ++column) {
    const auto [k, l] = kComponents[column];
    Matrix3 unit = Matrix3::Zero();
    unit(k, l) = unit(l, k) = k == l ? 1 : 0.5;
    result.col(column) = 2 * symmetric_product(fibre, unit * fibre);
  }
  return result;
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

bool EnergyExpression::has_fibre() const {
  return std::any_of(operations_->begin(), operations_->end(), [](const EnergyOperation& operation) {
    return operation.kind == "fibre" || operation.kind == "fibre_square";
  });
}

EnergyExpression::Point EnergyExpression::at(const std::vector<double>& values, double factor,
                                             const Vector3& fibre) const {
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
  point.has_fibre_ = has_fibre(), point.fibre_ = fibre;
  const Matrix3 rest = Matrix3::Zero();
  const double W = point.energy(rest) / factor;
  point.at_rest_ = W;
  const TangentModuli<3> tangent = point.tangent(rest);
  const Matrix3 at_rest = point.stress(rest);
  const double size = tangent.norm();
  const std::string where = point.has_fibre_ ? "I1 = 3, I2 = 3, J = 1, I4 = 1, I5 = 1" : "I1 = 3, I2 = 3, J = 1";
  if (!std::isfinite(W) || !std::isfinite(size))
    throw InputError("the energy has no finite value or slope at rest, " + where);
  if (at_rest.norm() > 1e-8 * size)
    throw InputError("the energy has a stress of " + number(point.has_fibre_ ? at_rest.norm() : at_rest(0, 0)) +
                     " Pa at rest: W must be least there, " + where);
  if (!(symmetric_eigenvalues(tangent)[0] > 1e-9 * size))
    throw InputError("the energy is unstable at rest, " + where + ": a small strain lowers it");
  return point;
}

Matrix3 EnergyExpression::Point::stress(const Matrix3& A) const {
  const Dilatation now(A);
  const auto at = invariants(A, now, fibre_);
  const auto of_slopes = [&](double W1, double W2, double WJ) {
    // 2 (W₁ + 2 W₂) + W_J is zero at rest.
    return Matrix3(2 * ((W1 + W2 * (2 + at[0])) * Matrix3::Identity() - W2 * A) + WJ * now.J() * now.inverse);
  };
  Matrix3 S;
  if (has_fibre_) {
    const auto& [W1, W2, WJ, W4, W5] = evaluated<JetOf<5>>(*steps_, at).slope;
    S = of_slopes(W1, W2, WJ) + 2 * W4 * fibre_ * fibre_.transpose() + 2 * W5 * tensor(square_slope(fibre_, A));
  } else {
    const auto& [W1, W2, WJ] = evaluated<Jet3>(*steps_, at).slope;
    S = of_slopes(W1, W2, WJ);
  }
  return S.allFinite() ? Matrix3(factor_ * S) : Matrix3(Matrix3::Zero());
}

TangentModuli<3> EnergyExpression::Point::tangent(const Matrix3& A) const {
  const Dilatation now(A);
  const auto at = invariants(A, now, fibre_);
  const double J = now.J();
  const Components unit = components(Matrix3::Identity()), G = components(now.inverse);
  std::array<Components, 5> slopes{unit, (2 + at[0]) * unit - components(A), J / 2 * G, Components::Zero(),
                                   Components::Zero()};
  const auto of_jet = [&]<class Jet>(const Jet& W) -> TangentModuli<3> {
    const double W2 = W.slope[1], WJ = W.slope[2];
    TangentModuli<3> result = 2 * W2 * (unit * unit.transpose() - symmetric_square(Matrix3::Identity())) +
                              WJ * J * (G * G.transpose() / 2 - symmetric_square(now.inverse));
    for (std::size_t p = 0; p < Jet::kPairs; ++p) {
      const auto [i, j] = Jet::pairs[p];
      if (W.curvature[p] == 0) continue;
      if (i == j)
        result += 2 * W.curvature[p] * (slopes[i] * slopes[i].transpose());
      else
        result += 2 * W.curvature[p] * both_ways(slopes[i], slopes[j]);
    }
    return result;
  };
  TangentModuli<3> result;
  if (has_fibre_) {
    slopes[3] = symmetric_product(fibre_, fibre_), slopes[4] = square_slope(fibre_, A);
    const JetOf<5> W = evaluated<JetOf<5>>(*steps_, at);
    result = of_jet(W) + 2 * W.slope[4] * square_curvature(fibre_);
  } else {
    result = of_jet(evaluated<Jet3>(*steps_, at));
  }
  return result.allFinite() ? TangentModuli<3>(factor_ * result) : TangentModuli<3>(TangentModuli<3>::Zero());
}

double EnergyExpression::Point::energy(const Matrix3& A) const {
  const Dilatation now(A);
  const auto at = invariants(A, now, fibre_);
  const double W =
      (has_fibre_ ? evaluated<JetOf<5>>(*steps_, at).value : evaluated<Jet3>(*steps_, at).value) - at_rest_;
  return now.flat || !std::isfinite(W) ? std::numeric_limits<double>::infinity() : factor_ * W;
}

}  // namespace elastin
