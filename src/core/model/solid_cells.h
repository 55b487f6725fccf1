#pragma once
#include <Eigen/SparseCore>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// A solid cell of a body with the table of its shape.
struct SolidCell {
  const CellKind* kind;
  std::vector<int> nodes;
};

/// Those of the body's blocks; without any its tetrahedra, and without these the cubes of a lattice.
std::vector<SolidCell> solid_cells_of(const Body& body);

/// Volume [m³] at these places, curved sides and all.
double volume_of(const SolidCell& cell, const Positions& positions);
/// That of all solid cells of the whole body.
double volume_of_cells(const Body& body, const Positions& positions);

/// Two cells that share a face.
struct CellBorder {
  int a, b;
  double area;  ///< of the face's corners at rest [m²]
};
std::vector<CellBorder> borders_of(const std::vector<SolidCell>& cells, const Positions& rest);

/// How much each cell counts for each of some connections: those that have both its ends, or where no cell has, one of
/// them, count alike. Connections × cells, rows sum to 1, or 0 where there is no such cell.
Eigen::SparseMatrix<double, Eigen::RowMajor> shares_of_cells(const std::vector<SolidCell>& cells,
                                                             const std::vector<std::array<int, 2>>& connections,
                                                             int molecules);

/// Changes a factor of each connection: to the mean of what it would be in each of the cells around it that laws see,
/// of blocks, tetrahedra or triangles, if requested of the cubes of a lattice as well; where there are none, to what
/// its own ends make of it.
void change_by_cells(const Body& body, VectorX& factors,
                     const std::function<void(std::span<const int> molecules, double& factor)>& change,
                     bool of_cubes = false);

}  // namespace elastin
