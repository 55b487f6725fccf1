#pragma once
#include <memory>
#include <string>
#include <vector>

#include "elastin/core/laws/law.h"

namespace elastin {

/// One operation on the results of earlier ones, or a value to begin with.
struct EnergyOperation {
  /// "number", "parameter"; "first" I₁ − 3, "second" I₂ − 3, "swelling" J − 1; of fibres along a "fibre" I₄ − 1 and
  /// "fibre_square" I₅ − 1; and one of energy_operations().
  std::string kind;
  std::vector<int> of = {};    ///< numbers of the operations that it takes, all before it
  double number = 0;           ///< of "number"
  std::string parameter = {};  ///< of "parameter": its name
};

/// What expressions may compute: name and how many values it takes.
struct EnergyOperationInfo {
  std::string name;
  int takes;
};
std::vector<EnergyOperationInfo> energy_operations();

/// An energy density W [J/m³] of the invariants I₁ = tr C, I₂ = ½ (I₁² − tr C²), J = √det C of the right Cauchy–Green
/// tensor, I₄ = a · C a and I₅ = a · C² a of a unit vector a at rest, and of named parameters: what a program makes of
/// a law as it runs. W is the last operation. Slopes and second slopes come by the rules of differentiation along with
/// the value [Griewank & Walther 2008, ch. 13]: exact, not differences.
class EnergyExpression {
 public:
  /// At most 256 operations. Throws InputError on an operation that is not known, or takes what is not there.
  explicit EnergyExpression(std::vector<EnergyOperation> operations);

  const std::vector<EnergyOperation>& operations() const { return *operations_; }
  /// The names of its parameters, each once.
  std::vector<std::string> parameters() const;

  /// Whether it takes I₄ or I₅.
  bool has_fibre() const;

  class Point;
  /// The law at work, times `factor`; a value for each of parameters(). Its energy is that above rest. Throws
  /// InputError where it has a stress at rest, or is unstable there.
  Point at(const std::vector<double>& values, double factor = 1, const Vector3& fibre = Vector3::UnitX()) const;

 private:
  std::shared_ptr<const std::vector<EnergyOperation>> operations_;
};

/// S = 2 (W₁ I + W₂ (I₁ I − C) + W₄ a aᵀ + W₅ (a aᵀ C + C a aᵀ)) + W_J J C⁻¹, and ∂S/∂C of it; a PointLaw<3> with an
/// energy. Flat points as NeoHookean. Where an operation has no finite value the energy is +∞, and stress and tangent
/// are zero.
class EnergyExpression::Point {
 public:
  Matrix3 stress(const Matrix3& A) const;
  TangentModuli<3> tangent(const Matrix3& A) const;
  double energy(const Matrix3& A) const;

 private:
  friend class EnergyExpression;
  struct Step;
  std::shared_ptr<const std::vector<Step>> steps_;
  double factor_ = 1, at_rest_ = 0;
  bool has_fibre_ = false;
  Vector3 fibre_;
};

}  // namespace elastin
