#pragma once
#include <string>
#include <vector>

#include "elastin/core/base/units.h"
#include "elastin/core/model/stress_strain.h"

namespace elastin::lab {

/// The numbers by which a stress–strain curve is stated, so that they can be others.
struct CurveNumbers {
  enum class Form {
    points,             ///< stress at strains
    toe,                ///< toe_strain, toe_modulus, modulus
    two_moduli,         ///< tension and compression, joined over one strain
    secant_polynomial,  ///< c_0, c_1 … of E(ε), up to one strain
    secant_table,       ///< E at strains
  };
  struct Number {
    std::string name;
    Dimension unit;
    double value;  ///< SI
  };

  Form form = Form::points;
  std::vector<double> strains;  ///< that stay: of the points, the origin among them, of the table, or the one strain
  std::vector<Number> numbers;  ///< one a point but the origin, one a row of the table, or those named above

  /// Throws InputError where no curve goes through these numbers.
  StressStrain curve() const;
  /// As a material of a scene states it: "curve: {points: …}".
  /// @param plain without units
  std::string yaml(bool plain) const;
};

/// "1500 Pa", or "1500" where plain: a value as scenes state it.
std::string quantity_text(double value, const Dimension& unit, bool plain);

}  // namespace elastin::lab
