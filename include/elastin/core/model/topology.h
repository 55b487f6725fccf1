#pragma once
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// What a blade goes through: a plane, or triangles.
class CutSurface {
 public:
  /// The whole plane through a point [m]. Throws InputError where the normal has no direction.
  static CutSurface plane(const Vector3& point, const Vector3& normal);
  /// What a straight blade sweeps whose two ends go straight from one position to another [m]: two triangles.
  static CutSurface blade(const std::array<Vector3, 2>& from, const std::array<Vector3, 2>& to);
  /// Triangles [m]. Throws InputError on a corner that is not among the points, or a position that is not finite.
  static CutSurface triangles(const Positions& points, const Cells<3>& triangles);

  /// Whether the straight line between two positions [m] goes through it. A position on the surface counts to the side
  /// to which the normal points.
  bool crosses(const Vector3& from, const Vector3& to) const;

 private:
  struct Triangle {
    Vector3 corner, first, second, normal;  ///< two sides from the corner
    Vector3 low, high;                      ///< its box
  };
  struct Plane {
    Vector3 point, normal;
  };
  void add(const Vector3& a, const Vector3& b, const Vector3& c);
  std::optional<Plane> plane_;
  std::vector<Triangle> triangles_;
};

/// A body whose topology has changed, and where everything in it comes from. What is left has its rest, its masses and
/// its volume as before: a molecule that is split shares its mass out by the rest volumes of the cells that each part
/// keeps, a connection its stiffness.
struct ChangedBody {
  Body body;
  /// Of each molecule its number before. Those that stay keep their order, and their numbers unless one before them is
  /// gone; those that were split off come last.
  std::vector<int> molecule_from;
  std::vector<double> molecule_share;    ///< of the mass that it had, 0 … 1
  std::vector<int> connection_from;      ///< of each connection its number before
  std::vector<double> connection_share;  ///< of the stiffness that it had, 0 … 1
  int split_molecules = 0, removed_connections = 0, removed_cells = 0;
  bool changed = false;
};

/// Parts a body where the surface goes through it in its present positions [m]. A body with cells (tetrahedra, else
/// cubes, else triangles) is split between cells, where the line between the middles of two neighbours crosses the
/// surface: no cell is lost, the volume stays as it is, and the new surface follows sides of cells. A molecule is split
/// where its cells no longer hang together by sides. Connections of no cell are removed where they cross the surface,
/// so that a body without cells is split between its molecules. A cut that ends within the body leaves its tip whole.
/// Throws InputError on bodies of several parts, and on cells of other shapes or of second order. Cost O(n).
ChangedBody cut(const Body& body, const Positions& positions, const CutSurface& surface);

/// Parts a body where it is strained above `strain` > 0 at its present positions [m]. Without cells: removes
/// connections that are longer than (1 + strain) times their rest. With cells: at each molecule where the largest
/// principal stretch (of the mean deformation gradient of its cells) is above 1 + strain and above that of its
/// neighbours, the cells on both sides of the plane across that stretch are split: a crack grows by one molecule a
/// call.                                                                                    [O'Brien & Hodgins 1999]
ChangedBody tear(const Body& body, const Positions& positions, double strain);

/// The body without these connections and cells (tetrahedra, else cubes, else triangles, by number). What mass the
/// cells had goes with them; a molecule that has lost all that it belonged to is gone. A connection goes with its last
/// cell; one that is a side of cells that stay cannot be removed: InputError, as on numbers out of range.
ChangedBody without(const Body& body, const std::vector<int>& connections, const std::vector<int>& cells);

}  // namespace elastin
