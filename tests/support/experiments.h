#pragma once
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/shapes.h"
#include "lab/run/specimen.h"

namespace elastin::testing {
using namespace lab;

/// A block of tetrahedra, `cubes` along each side, inner and face molecules jittered by 15 % of a cube.
inline Specimen jittered_specimen(BlockKind kind, double poissons_ratio, double E = 1e4, int cubes = 3,
                                  double side = 0.1) {
  Specimen specimen;
  specimen.material = {.youngs_modulus = E, .poissons_ratio = poissons_ratio};
  specimen.body = tetrahedral_block(kind, {cubes, cubes, cubes}, {side, side, side});
  add_jitter(specimen.body, 0.15 * side / cubes, 6);
  set_matter(specimen.body, 0.1 * side / cubes, 1000, 0, 0);
  return specimen;
}

/// The unit cube of body-centred tetrahedra that the references are given for: E = 1e5 Pa, nu = 0.3.
inline Specimen reference_cube(int cubes) {
  Specimen specimen;
  specimen.material = {.youngs_modulus = 1e5, .poissons_ratio = 0.3};
  specimen.body = tetrahedral_block(BlockKind::body_centred, {cubes, cubes, cubes}, {1, 1, 1});
  set_matter(specimen.body, 0.25 / cubes, 1000, 0, 0);
  return specimen;
}

/// For bodies just large enough for threads: several that wait for a busy machine cost more than they give.
struct OneThread {
  OneThread() { set_threads(1); }
  ~OneThread() { set_threads(0); }
};

/// A run that must converge.
inline Run solve(const Specimen& specimen, const Experiment& experiment, const std::string& strategy,
                 const StaticOptions& statics = {}) {
  static const Catalog catalog = built_in_catalog();
  Run run = run_strategy(specimen, experiment, choose_strategy(catalog, strategy), {.statics = statics});
  INFO(strategy << ": " << run.cause);
  REQUIRE(run.suited);
  REQUIRE(run.outcome == Outcome::converged);
  return run;
}

/// A value at three spacings, each half of the last.
using Refinement = std::array<double, 3>;

/// p of value = limit + c hᵖ.
inline double order_of(const Refinement& v) { return std::log2((v[1] - v[0]) / (v[2] - v[1])); }
/// The limit, with the order that the three show.                                                        [Aitken 1926]
inline double limit_of(const Refinement& v) {
  return v[2] - std::pow(v[2] - v[1], 2) / ((v[2] - v[1]) - (v[1] - v[0]));
}
/// The limit of two values of order 2.                                                               [Richardson 1911]
inline double second_order_limit(double coarse, double fine) { return (4 * fine - coarse) / 3; }

/// Lamé's constants.
inline double lame_lambda(const Material& m) {
  return m.youngs_modulus * m.poissons_ratio / ((1 + m.poissons_ratio) * (1 - 2 * m.poissons_ratio));
}
inline double lame_mu(const Material& m) { return m.youngs_modulus / (2 * (1 + m.poissons_ratio)); }

}  // namespace elastin::testing
