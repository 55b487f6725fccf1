#pragma once
#include <string>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// Puts a body behind the parts of another, as a part with `what`'s name, rigid flag and material; what it says of
/// numbers is set here. Lists of cells go behind each other, connections proper before the sides of cells. No grid is
/// left. Strong guarantee; throws InputError if the name already exists.
void add_part(Body& whole, const Body& body, Part what);

/// The molecules of a part, its own and the shared ones, ascending.
std::vector<int> molecules_of(const Part& part);

/// Throws InputError with the nearest name and the list of what there is.
const Part& find_part(const Body& body, const std::string& name);

/// A part by itself, numbered from 0, and where its molecules and connections are in the whole. A connection whose ends
/// both belong to two parts is in both.
struct PartAlone {
  Body body;
  std::vector<int> molecules, connections;
};
PartAlone part_alone(const Body& whole, const Part& part);

/// The whole body with the cells of one part only: what cell laws of that part work on. Voronoi cells are left out.
Body with_cells_of(const Body& whole, const Part& part);

/// The body without any cells.
Body without_cells(const Body& body);

/// Result of a tie: how many molecules, and how.
struct TieReport {
  int joined = 0;       ///< were one already and are now one molecule
  int fixed = 0;        ///< fixed to a rigid part
  int tied = 0;         ///< to a position on a triangle
  double furthest = 0;  ///< by which one of these was moved there [m]
};

/// Ties two parts of a body where they are no more than `within` [m] apart:
///   * where one part is rigid, the molecules of the other that are near become its own too (Part::shared);
///   * molecules at the same position (to 1e-4 of the longest connection at them) become one molecule, shared by both:
///     the tie is exact, and adds nothing to what is solved;
///   * the other molecules on the surface of the part that has more there are moved onto the surface of the other one,
///     free of stress, and tied to it there (Body::ties), with `stiffness` [Pa] times the root of the surface [m²] that
///     a molecule stands for. Not exact: a molecule of the other part gets what its triangles' weights say.
/// Masses and radii must be set; masses of joined molecules are added up. Numbers of molecules and connections change.
/// Throws InputError on unknown names, if the parts are one or both rigid, if nothing lies within the distance, or if
/// there is no surface to tie to.
TieReport tie_parts(Body& body, const std::string& first, const std::string& second, double within, double stiffness);

}  // namespace elastin
