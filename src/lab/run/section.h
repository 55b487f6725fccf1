#pragma once
#include <optional>

#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"

namespace elastin::lab {

/// The cross-section that a body offers to a load along an axis.
struct Section {
  double area = 0;  ///< mean over the length [m²]; 0 where the molecules span none
  double variation =
      0;  ///< largest difference of a slab's section from the mean, over the mean; 0 if there are too few
  bool of_hull = false;  ///< the body has no cells that fill it: the area is that of its molecules' convex hull
  /// Whether the section is the same all along the axis, as far as it can be measured.
  bool prism() const { return variation <= (of_hull ? 0.1 : 0.05); }
};

/// The section between the heights `from` and `to` [m] along the unit axis, from < to. Volume over length of what fills
/// the body: its tetrahedra, else its cubes, else its triangles times `thickness` [m] or that of their part. Where some
/// molecule belongs to no such cell it is the hull of the molecules seen along the axis. The variation is that of ten
/// slabs, or, for the hull, of slabs at least two mean connections thick.
Section find_section(const Body& body, const Vector3& axis, double from, double to, double thickness);

/// ∫ y yᵀ dA [m⁴] about the middle of the section of a prism with this area [m²], as the cells of solids have it,
/// curved ones as they are; y in the plane. None of a body that none fill.
std::optional<Eigen::Matrix2d> second_moments_of_cells(const Body& body, const Eigen::Matrix<double, 3, 2>& plane,
                                                       double area);

/// The section of a wall: a body of triangles alone, by its middle surface and thickness.
struct WallSection {
  Section section;
  Eigen::Matrix2d second_moment = Eigen::Matrix2d::Zero();  ///< ∫ y yᵀ dA about its middle, y in the plane [m⁴]
  double torsion = 0;  ///< J = ∫ h² dA [m⁴] of a tube, h the distance of the wall's line from the middle
  enum class Kind { strip, tube, other } kind = Kind::other;  ///< a straight line; a closed circle of one thickness
};

/// None of a body that other cells fill, or not all of which is triangles; see find_section. `plane` spans the section.
std::optional<WallSection> wall_section(const Body& body, const Vector3& axis, const Eigen::Matrix<double, 3, 2>& plane,
                                        double from, double to, double thickness);

/// The mean over the area of a surface whose parts may have a thickness of their own [m]; `thickness` of the others.
double mean_thickness(const Body& body, double thickness);

/// G = E / (2 (1 + ν)) [Pa].
double shear_modulus(const Material& material);
/// K = E / (3 (1 − 2ν)) [Pa].
double bulk_modulus(const Material& material);
/// Why a material with the same E, G and K in all directions, in tension and in compression, is not what it is at rest
/// and up to a strain, or "".
std::string no_isotropic_moduli(const Material& material, double strain = 0);

/// Torsion constant J [m⁴] of a rectangle, T = G J θ/l, of a bar whose ends are free to warp.
/// J = a b³ (1/3 − 64 b/(π⁵ a) Σ tanh(nπa/2b)/n⁵), n odd.                                [Timoshenko & Goodier, §109]
double torsion_constant(double a, double b);

}  // namespace elastin::lab
