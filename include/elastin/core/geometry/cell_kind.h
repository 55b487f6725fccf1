#pragma once
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "elastin/core/base/types.h"

namespace elastin {

/// A row of the table of cell shapes: an isoparametric cell as data. Nodes are numbered as in VTK and Abaqus: corners,
/// then the middles of edges, of faces, of the cell. N_a are the shape functions, 1 at node a and 0 at the others.
struct CellKind {
  std::string_view name, plural;
  int dimensions;  ///< 2 or 3
  int nodes, corners;
  int order;                  ///< of the polynomials that its functions hold completely, 1 or 2
  Eigen::MatrixXd reference;  ///< ξ of the nodes, a column each
  /// Where integrals are taken: ξ, a column each, and weights ω.
  Eigen::MatrixXd points;
  VectorX weights;
  /// N_a there, a column a point; ∂N_a/∂ξ there, a dimensions × nodes matrix a point.
  Eigen::MatrixXd values;
  std::vector<Eigen::MatrixXd> slopes;
  /// How many functions the pressure has where the volume is kept by a pressure of its own: 1 constant in the cell, 4
  /// linear (1, ξ, η, ζ).
  int pressures;
  /// Nodes of each face, outward, in the order of its own kind; of a cell of two dimensions none.
  std::vector<std::vector<int>> faces;
  std::vector<const CellKind*> face_kinds;
  /// The tetrahedra (triangles) of first order that its nodes make: for what works on corners alone. Where two cells
  /// meet theirs do too, if the cell's own numbers decide: see simplices_of.
  std::vector<std::vector<std::vector<int>>> polyhedra;  ///< each by its faces of 3 or 4 nodes, outward
  std::vector<std::array<int, 2>> edges;                 ///< of corners
  int vtk;                                               ///< its number in VTK's files

  VectorX (*functions)(const VectorX& at);
  Eigen::MatrixXd (*function_slopes)(const VectorX& at);
};

/// All rows: triangle3, triangle6, quadrilateral4, 8 and 9, tetrahedron4 and 10, prism6, hexahedron8, 20 and 27.
std::span<const CellKind> cell_kinds();
/// Throws InputError with the nearest name.
const CellKind& cell_kind(std::string_view name);

/// The simplices that the nodes of a cell make, by the cell's own numbers of its nodes, in turn as `numbers` (of all,
/// distinct) say: two cells that share a face cut it alike. Tetrahedra of 4 nodes, or triangles of 3.
std::vector<std::vector<int>> simplices_of(const CellKind& kind, std::span<const int> numbers);

/// The eight hexahedra that the nodes of a hexahedron27 make, each by its own numbers in a hexahedron8's order.
std::vector<std::vector<int>> hexahedra_of_27();

}  // namespace elastin
