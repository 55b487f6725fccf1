#pragma once
#include <optional>

#include "elastin/core/model/body.h"

namespace elastin {

/// A body as a program knows it that has one in arrays of its own.
struct BodyArrays {
  Positions positions;                          ///< at rest [m], 3 × n
  std::vector<std::array<int, 2>> connections;  ///< pairs of molecules; empty: the sides of the cells
  Cells<3> triangles;
  Cells<4> tetrahedra;  ///< inverted where their volume is negative
  /// Cells of other shapes and orders; then neither triangles nor tetrahedra of their own, for they make these.
  std::vector<CellBlock> blocks = {};
  VectorX rest_lengths;           ///< [m] > 0, one a connection; empty: the distances
  VectorX masses;                 ///< [kg] > 0, one a molecule; empty: see set_matter below
  VectorX radii;                  ///< [m] > 0, one a molecule; empty: as masses
  std::optional<double> density;  ///< [kg/m³] > 0; none: that of the material that the body gets
  double thickness = 0;
  /// F_g of each cell (`blocks`, or tetrahedra, or triangles): where it is unstressed, see Rest; empty: as it is.
  std::vector<Matrix3> growth = {};
};

/// Sides of cells that are not among the connections are added as such (Connections::cell_sides). Throws InputError:
/// the array, the row, what stands there and what may.
Body make_body(const BodyArrays& arrays);

/// The shortest connection proper [m]; 0 without connections.
double shortest_connection(const Body& body);

/// Sets radii and masses where a body says nothing but a density [kg/m³]: half the shortest connection; cells lumped
/// (triangles with their `thickness` [m]), and without cells an equal share of the convex hull or, where that is
/// thinner than a molecule's radius, as of ropes and nets, of cubes as wide as the molecules. Throws InputError where
/// there is no connection to take a radius from.
void set_matter(Body& body, double density, double thickness, std::optional<double> radius = {});

}  // namespace elastin
