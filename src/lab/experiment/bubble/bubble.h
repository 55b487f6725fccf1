#pragma once
#include <optional>
#include <vector>

#include "elastin/lab/run/experiment.h"

namespace elastin::lab {

/// A flat disc, held fast at its rim and blown up by a pressure on one side.
struct BubbleSetup {
  std::vector<double> pressures;  ///< [Pa], one a load step, ascending from above 0
  std::vector<double> heights;    ///< [m] measured at them; empty = nothing measured
  /// The material's secant modulus is to be found from the heights: a polynomial of this degree …
  std::optional<int> identify_degree = {};
  double identify_up_to = 0;  ///< … up to this strain; 0 = one and a half times what the cap formulae say
};

/// Measures by [TP, eqs 18–25] from height h and pressure p, as if the bubble were a spherical cap over the rim's
/// radius a: radius of the cap R = (a² + h²)/(2h), stretch λ = arc over chord = (R/a) arcsin(a/R), strain λ − 1 (eq 24
/// with its sign mended), true stress p R/(2 t λ⁻²) of a membrane that keeps its volume. And what the membrane itself
/// has at the pole, fitted to molecules and triangles around it: its radius of curvature, stretch and nominal stress.
/// Throws InputError if the body is no flat, round disc of triangles.
std::unique_ptr<StaticExperiment> make_bubble(const Body& body, const BubbleSetup& setup, const Material& material);

}  // namespace elastin::lab
