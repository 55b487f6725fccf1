#pragma once
#include <array>
#include <string>

#include "elastin/core/model/material.h"
#include "elastin/core/solve/homogenisation.h"

namespace elastin::lab {

/// What a strategy makes of the material in every direction, not only in that of the experiment by which it is judged:
/// errors of the body's moduli at small strain against the material's E and G, relative.
struct DirectionErrors {
  std::array<double, 3> youngs{};               ///< of E along the body's x, y, z
  double least_youngs = 0, largest_youngs = 0;  ///< of E over all directions
  double least_shear = 0, largest_shear = 0;    ///< of G over all pairs of perpendicular directions
  std::string trouble;                          ///< why they were not measured; empty if they were
  bool measured() const { return trouble.empty(); }
  /// The largest of them, as a size.
  double worst() const;
};

/// From the body's stiffness matrix: 1/E(n) = S_ijkl n_i n_j n_k n_l and 1/G(n, m) = 4 S_ijkl n_i m_j n_k m_l, over
/// some thousand directions n evenly on a half sphere, at each the m that shear least and most.  [Ting 2005, eqs. 3–5]
DirectionErrors direction_errors(const Stiffness6& stiffness, const Material& material);

/// "E +0.10 %, -2.30 %, +4.00 % along x, y, z (-9.0 % to +4.0 % over all directions), G -12 % to -3.0 %: do not use it
/// in shear"; or why that is not known.
std::string direction_text(const DirectionErrors& errors);

}  // namespace elastin::lab
