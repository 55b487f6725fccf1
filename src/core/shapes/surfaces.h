#pragma once
#include <array>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// Bodies of triangles. They have positions, connections and triangles, all oriented alike: the normal (x1 −
/// x0) × (x2 − x0) points outwards, or along +z; radius and mass are set by set_matter or by the caller.

/// How a sphere is covered with triangles: each side of a regular solid in `divisions` parts, pushed out radially.
enum class SphereMesh {
  icosahedron,  ///< 20 n² triangles, the most even
  type_1,       ///< octahedron, 8 n²; one triangle of an octant meets each of its corners
  type_2        ///< the same with the side across each corner turned: two triangles of an octant meet there; n ≥ 3
};

/// A sphere of `radius` [m] about the origin. Throws InputError if there are too few divisions.
Body sphere(double radius, SphereMesh mesh, int divisions);

/// Its part in x, y, z ≥ 0, with molecules exactly in these planes; mesh type_1 or type_2. Mirrored it is the sphere.
Body sphere_octant(double radius, SphereMesh mesh, int divisions);

/// A disc of `radius` [m] in the plane z = 0 about the origin: `rings` ≥ 1 rings of molecules around the middle one,
/// six more in each, 6 n² triangles.
Body disc(double radius, int rings);

/// How each square of a sheet is cut: all along one diagonal, along one and the other in turn, or by both (a molecule
/// in the middle).
enum class SheetPattern { one_way, alternating, crossed };

/// A sheet of size[0] × size[1] [m] in x, y ≥ 0, z = 0, of squares[0] × squares[1] ≥ 1 squares.
Body rectangular_sheet(const std::array<double, 2>& size, const std::array<int, 2>& squares, SheetPattern pattern);

/// A cross in the plane z = 0 about the origin, as of a cross-type parachute: two strips of `width` × `span` [m] that
/// share their middle; `squared_lengths` across the width, as many along the arms as keep them nearly square, cut in
/// alternation.
Body cross_canopy(double width, double span, int squares);

/// Where a canopy is hung up.
enum class HungFrom {
  ends,  ///< the molecules at the body's ends in x and y: of a cross, those at the tips of its arms
  rim,   ///< all molecules on sides of one triangle alone
};

/// Hangs a load of `mass` [kg] at `position` [m] by cables of EA = `stiffness` [N] to each of these molecules, as long
/// as the distance. The load is the body's last molecule. Masses and radii must be set. Throws InputError where a
/// molecule lies at that position.
void hang_load(Body& body, HungFrom from, const Vector3& position, double stiffness, double mass, double radius);

/// ½ (x1 − x0) × (x2 − x0) [m²].
Vector3 area_vector(const Positions& positions, const std::array<int, 3>& triangle);

/// Triangles whose area is not above 1e-12 L² of their longest side L.
std::vector<int> flat_triangles(const Body& body, const Positions& positions);

}  // namespace elastin
