#pragma once
#include "elastin/core/base/types.h"
#include "lab/scene/identify.h"

namespace elastin::lab {

/// The force on a rigid indenter without friction that is pressed into a layer of any thickness, in small strains: the
/// sphere is a paraboloid near its pole, the cone's angle to the surface is small. Its integral equation is solved
/// once, over contact radii from 0 to eight thicknesses; a force is read off that.  [Lebedev & Ufliand 1958; Hayes et
/// al. 1972]
class IndentedLayer {
 public:
  /// @param size radius of sphere or flat punch [m], or the cone's half angle [rad]
  /// @param thickness [m]; infinite: a half-space [Hertz 1882; Sneddon 1965]
  /// @param poissons_ratio −1 < ν ≤ 1/2
  IndentedLayer(Indenter indenter, double size, double thickness, LayerBottom bottom, double poissons_ratio);

  /// F (1 − ν²) / E [m²] at a depth [m]; 0 where that is not above 0; NaN beyond the contact radii.
  double force(double depth) const;
  /// With a work of adhesion w over E / (1 − ν²) [m], of a sphere on a half-space: also below depth 0, where `drawn`,
  /// down to where the contact is lost.                                            [Johnson, Kendall & Roberts 1971]
  double force(double depth, double adhesion, bool drawn) const;
  /// By how much the layer is stiffer than a half-space.
  double stiffening(double depth) const { return force(depth) / half_space(depth); }

 private:
  double half_space(double depth) const;

  Indenter indenter_;
  double size_, thickness_;
  VectorX depths_, ratios_;  ///< reduced depths, ascending, and force over that on a half-space there
};

}  // namespace elastin::lab
