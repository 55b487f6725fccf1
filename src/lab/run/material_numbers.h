#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/laws/homogeneous.h"
#include "elastin/core/base/units.h"
#include "elastin/core/laws/material_law.h"
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

/// A number that can be unknown: of a material one of its law's, of a law's term ("mu_1"), of its curve ("stress_2"),
/// of its relaxation ("g_1", "tau_1"), or E or ν where these are given and not derived; in addition one of the spring
/// rule's parameters, the friction of contact, or any number of the scene, named by its key.
struct MaterialNumber {
  enum class Kind {
    law_number,
    law_term,
    curve_number,
    youngs_modulus,
    poissons_ratio,
    share,
    relaxation_time,
    rule_parameter,
    friction,
    scene_key
  };

  std::string name;
  Dimension unit;
  double low, high;  ///< admissible range, SI
  bool above_low;    ///< whether `low` itself is not admissible
  double value;      ///< SI, of the material that it was read off
  Kind kind;
  std::size_t term = 0, column = 0;
  double size = 0;  ///< what is large for it where its value may be 0; 0: its value

  bool operator==(const MaterialNumber&) const = default;
};

/// A material that is tried, with what else of a scene may be unknown.
struct Trial {
  Material material = {};
  std::optional<CurveNumbers> curve = {};  ///< by which the material's curve is stated
  ParameterValues rule = {};               ///< parameters of the spring rule that are unknown
  std::optional<double> friction = {};     ///< of contact, where it is unknown
  ParameterValues keys = {};               ///< of the scene that are unknown, SI

  Trial() = default;
  Trial(Material own) : material(std::move(own)) {}
};

/// How a trial changes with one of its numbers θ: ∂f/∂θ = Σ weights f(trials).
struct TrialChange {
  std::vector<Trial> trials;
  std::vector<double> weights;  ///< [1/unit of θ], as many
};

/// All numbers that the material has, in the order of its law's row. `row` is null where it has no law.
std::vector<MaterialNumber> material_numbers(const MaterialLaw* row, const Trial& trial);

/// The trial with other numbers. Throws InputError where the law does not admit them or is unstable at rest with them,
/// or no curve goes through them.
Trial with_numbers(const MaterialLaw* row, const Trial& trial, const std::vector<MaterialNumber>& numbers,
                   const VectorX& values);

/// How the trial changes with each number, about these values: central differences over `steps`, one-sided ones of
/// second order where a side is not admissible.
std::vector<TrialChange> trial_changes(const MaterialLaw* row, const Trial& trial,
                                       const std::vector<MaterialNumber>& numbers, const VectorX& values,
                                       const VectorX& steps);

/// Of the materials alone.
std::vector<MaterialChange> material_changes(const std::vector<TrialChange>& changes);

/// Axes of a test, a column each: 1 along the law's first direction, 2 in the plane of its first two, as far as it has
/// any.
Matrix3 axes_of_law(const MaterialLaw& row, const Material& material);

}  // namespace elastin::lab
