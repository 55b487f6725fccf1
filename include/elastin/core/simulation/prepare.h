#pragma once
#include <functional>
#include <vector>

#include "elastin/core/simulation/catalog.h"

namespace elastin {

/// What makes the Voronoi cells of a body's molecules: mesh::voronoi_cells of elastin::mesh; the core has none of its
/// own.
using MakeVoronoi = std::function<VoronoiCells(const Body&)>;

/// Adds to a body what it needs, and has not yet, for a strategy and its materials to work on it:
///   * the materials' density where its masses are those of an assumed one (take_density), but for a strategy by parts;
///   * pairs of molecules between which bending acts (Material::bending_rigidity > 0), as sides of cells;
///   * sides of tetrahedra and triangles that are no connections, for a cell law or a volume term;
///   * Voronoi cells (Body::voronoi, those of each soft part in Part::voronoi), for a rule or fibres that need them,
///     made by `make_voronoi`; left out where that is empty.
/// A body that has all is left as it is, bitwise; numbers of molecules and of connections proper never change. What
/// an elasticity makes for itself, as the averaged volumes of a volume term, needs no preparation. Everything is made
/// from the body's present pose. `materials`: one of the whole body, or those of its parts by Part::material.
/// Throws InputError where bending is requested of a body that cannot have it (see unsuited_for_bending), or where a
/// part's material is not among them, or where the body's lists name molecules that it does not have. Cost O(n log n).
void prepare(Body& body, const Strategy& strategy, const std::vector<Material>& materials,
             const MakeVoronoi& make_voronoi);

/// Masses of the materials' densities in place of the assumed one (Body::assumed_density), if any. A molecule that
/// several parts share goes by the part whose own it is.
void take_density(Body& body, const std::vector<Material>& materials);

/// The constants that a spring rule gives the connections of a body [N/m], which is prepared for it in a copy: what
/// other engines take. Throws InputError where the strategy is no spring rule or cannot run on the body.
VectorX spring_constants(const Strategy& strategy, Body body, const Material& material, const ParameterValues& values,
                         const MakeVoronoi& make_voronoi);

/// The second, which no strategy changes.
void prepare_bending(Body& body, const Material& material);

/// Whether a body lacks Voronoi cells that strategy or fibres need.
bool lacks_voronoi(const Body& body, const Strategy& strategy, const std::vector<Material>& materials);

}  // namespace elastin
