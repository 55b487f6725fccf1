#pragma once
#include <array>
#include <span>
#include <vector>

#include "core/base/disjoint_sets.h"
#include "core/base/rows.h"
#include "elastin/core/model/body.h"

namespace elastin {

/// The molecules, joined by proper connections, rigid parts and ties.
DisjointSets pieces_of(const Body& body);

/// Two cells that share a side: a face of solids, an edge of triangles.
struct SharedSide {
  std::array<int, 2> cells{};
  std::array<int, 4> molecules{-1, -1, -1, -1};  ///< of the side, ascending, −1 behind them
};

/// The cells between which a body can be split: its tetrahedra, else its cubes, else its triangles.
struct Neighbours {
  explicit Neighbours(const Body& body);

  int of_each = 0;         ///< molecules of a cell; 0: there are no cells
  std::vector<int> nodes;  ///< of all cells
  VectorX volume;          ///< at rest [m³]; of triangles the area [m²]
  Rows cells_of;           ///< of each molecule, ascending
  std::vector<SharedSide> sides;

  int size() const { return of_each ? static_cast<int>(nodes.size()) / of_each : 0; }
  std::span<const int> cell(int number) const {
    return {nodes.data() + static_cast<std::ptrdiff_t>(number) * of_each, static_cast<std::size_t>(of_each)};
  }
  Vector3 middle(int number, const Positions& positions) const;
  /// Mean deformation gradient of a cell; of a triangle in its plane.
  Matrix3 deformation(int number, const Positions& rest, const Positions& positions) const;

 private:
  /// Edges that span the cell, as columns: two or three.
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> edges(int number, const Positions& positions) const;
};

}  // namespace elastin
