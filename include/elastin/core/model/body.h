#pragma once
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/geometry/cell_kind.h"
#include "elastin/core/geometry/cells.h"

namespace elastin {

/// Pairs of molecules joined by an elastic link, and the length at which each is unstressed.
struct Connections {
  std::vector<std::array<int, 2>> ends;
  std::vector<double> rest_length;  ///< [m], > 0, one a connection
  /// Number of the last ones, which are sides of cells and nothing else: cells that were put over a body need them for
  /// their force densities. Only laws and rules that work on cells give them stiffness; see add_cell_sides.
  int cell_sides = 0;
  int size() const { return static_cast<int>(ends.size()); }
  /// Connections that are more than sides of cells; they come first.
  int proper() const { return size() - cell_sides; }
};

/// A connection that is a cable, whatever the strategy: it resists lengthening alone, by EA [N] a strain.
struct Cable {
  int connection = 0;
  double stiffness = 0;  ///< EA [N], > 0
};

/// The part of the body's convex hull that is nearest to each molecule, as far as spring rules use it. Made by
/// voronoi_cells (elastin/mesh/voronoi.h), which is not part of elastin::core.
struct VoronoiCells {
  std::string problem;  ///< why there are no such connections, in words for a user; then the rest is empty
  VectorX face_area;  ///< [m²], one a connection proper: the face between its molecules' cells; 0 if they don't touch
  VectorX volume;     ///< [m³], one a molecule; they sum to the hull's
  Positions surface_area;  ///< outward area vector of each molecule's cell on the hull [m²]
};

/// Where a body's part has its cells in one of the body's lists.
struct CellRange {
  int first = 0, count = 0;
};

/// Cells of one shape out of the table of shapes, each by the numbers of its nodes.
struct CellBlock {
  const CellKind* kind = nullptr;
  std::vector<int> nodes;  ///< of all cells, kind->nodes each
  VectorX stiffness;       ///< how many times as stiff as the material each cell is; empty = all alike
  int size() const { return static_cast<int>(nodes.size()) / kind->nodes; }
  std::span<const int> cell(int number) const {
    const auto of_each = static_cast<std::size_t>(kind->nodes);
    return {nodes.data() + static_cast<std::size_t>(number) * of_each, of_each};
  }
};

/// A named part of a body that was put together from several; see elastin/core/model/parts.h.
struct Part {
  std::string name;
  int first = 0, count = 0;  ///< molecules of its own: first … first + count − 1
  /// Molecules of other parts that ties have made its own too, ascending: one and the same molecule in both where they
  /// met, or one that is fixed to this part where it is rigid.
  std::vector<int> shared;
  bool rigid = false;    ///< bone: its molecules, the shared ones too, never move against each other
  int material = 0;      ///< number in the list of materials that belongs to the body
  double thickness = 0;  ///< [m] of its triangles; 0: that of the whole body
  CellRange triangles, tetrahedra, cubes;
  CellRange blocks;                     ///< of Body::blocks; every block belongs to one part
  std::optional<VoronoiCells> voronoi;  ///< of the part alone; as Body::voronoi
};

/// A molecule that is tied to a position on a triangle of another part, Σ weight · corner, where it lies at rest.
struct Tie {
  int molecule = 0;
  std::array<int, 3> corners{};
  std::array<double, 3> weights{};  ///< ≥ 0, they sum to 1
  double stiffness = 0;             ///< [N/m], > 0; see elastin/core/forces/ties.h
};

/// Molecules of lower numbers and their weights (sum 1), as the shape functions of a cell have them where another lies.
using MoleculeBetween = std::vector<std::pair<int, double>>;

struct Share;
struct Rest;

/// A piece of tissue: molecules (spheres) joined by connections, at rest. Never changes during a run.
struct Body {
  Positions rest;  ///< places of the molecules, unstressed [m]
  VectorX mass;    ///< [kg], one a molecule
  VectorX radius;  ///< [m], one a molecule
  /// Density [kg/m³] that the masses were made of for want of a stated one, until a material's replaces it (see
  /// prepare); 0 where masses or a density were stated.
  double assumed_density = 0;
  Connections connections;
  Cells<3> triangles;
  std::vector<Cable> cables;  ///< in addition to what the strategy does with its connections
  Cells<4> tetrahedra;        ///< positively oriented: (x1−x0)·((x2−x0)×(x3−x0)) > 0
  /// Cells of all other shapes, and of second order. Where a body has any, all its cells of that dimension are among
  /// them; laws of cells work on them, and `tetrahedra` (`triangles`) are the simplices that their nodes make, for what
  /// works on corners: spring rules, surfaces, pictures. See set_simplices.
  std::vector<CellBlock> blocks;
  /// The cubes of a simple cubic lattice, each by its eight molecules; only such lattices have them.
  Cells<8> cubes;
  /// Molecules along x, y, z where they are numbered as a grid, x + nx (y + ny z), wherever they lie. Passes over
  /// springs between neighbours on it need no list of connections.
  std::optional<std::array<int, 3>> grid;
  /// How many times as stiff as the material each connection and cell is; empty = all alike. See set_region.
  VectorX connection_stiffness, cell_stiffness;
  std::optional<VoronoiCells> voronoi;  ///< only where a strategy needs them (Strategy::needs_voronoi)
  std::vector<Part> parts;              ///< in the order of their molecules; empty = the body is one whole
  std::vector<Tie> ties;                ///< between parts whose molecules do not meet
  /// Of a body whose cells were refined, or made of second order, what each of its last molecules lies between.
  /// What holds an end of the body holds those of them that lie between others that it holds. Empty of other bodies.
  std::vector<MoleculeBetween> between;
  /// Points that what the body stands for reaches to [m], where its cells stand out over that, as boxes do over the
  /// voxels that fill them in part: an end to a depth is counted from these. Empty where the molecules say it.
  Positions outline;
  /// Where the body is unstressed, if not at rest: see elastin/core/model/rest.h.
  std::shared_ptr<const Rest> unstressed;
  /// Where the body is one process's share of a whole that several have among them; see elastin/core/model/share.h.
  std::shared_ptr<const Share> share;
  int size() const { return static_cast<int>(rest.cols()); }
};

/// Every pair of molecules at most `reach` [m] apart, ascending (first, second), with its present length as rest
/// length. Cost O(n) for bodies of even density (grid of buckets). Throws InputError beyond 1000 neighbours a molecule.
Connections connections_within(const Positions& positions, double reach);

/// The edges of the body's cells, each once, ascending, with its present length as rest length.
Connections connections_of_cells(const Positions& positions, const Cells<3>& triangles, const Cells<4>& tetrahedra);

/// Makes the present length of each connection its rest length.
void set_present_lengths(Body& body);

/// The two molecules of each side of each tetrahedron, each once, ascending.
std::vector<std::array<int, 2>> sides_of(const Cells<4>& tetrahedra);

/// Makes connections of those of the pairs that are not connected yet, as sides of cells only
/// (Connections::cell_sides); those come last, ascending, with their present length as rest length.
void add_cell_sides(Body& body, const std::vector<std::array<int, 2>>& sides);

/// The body with its connections proper alone: what a rule sees that does not work on cells.
Body without_cell_sides(const Body& body);

/// Makes what lies in a box (its faces included) `stiffness` times as stiff as the material, and its molecules `mass`
/// times as heavy: connections and cells by their middles. Of boxes that overlap the last counts.
/// Returns how many connections and cells it has made so.
std::size_t set_region(Body& body, const Vector3& low, const Vector3& high, double stiffness, double mass);

/// Whether a connection or cell is not as stiff as the material.
bool has_other_stiffness(const Body& body);

/// Lumped masses [kg]: a quarter of each tetrahedron's mass, a third of each triangle's (thickness t [m]) to its
/// molecules.
VectorX lumped_mass(const Positions& positions, const Cells<3>& triangles, const Cells<4>& tetrahedra, double density,
                    double thickness);

/// Signed volume of a tetrahedron [m³], positive when corners 1, 2, 3 turn counter-clockwise seen from corner 0's far
/// side.
double signed_volume(const Positions& positions, const std::array<int, 4>& tetrahedron);

/// Which of solid_cells are flat or inverted at these positions: the volume is not above 1e-12 L³ of their longest side
/// L, in a block at one of their quadrature points.
std::vector<int> flat_or_inverted_cells(const Body& body, const Positions& positions);
/// "cell 3 is flat or inverted", "cells 3, 7 are …": the first ten by number, how many others, and of how many.
std::string flat_or_inverted_text(const std::vector<int>& cells, std::size_t of);

/// Whether laws of solids (3) or of membranes (2) work on blocks of the body.
bool has_blocks(const Body& body, int dimensions);

/// Sets `tetrahedra` and `triangles` to the simplices that the nodes of the blocks make, and the connections to their
/// sides. Cells that share a face are cut alike there.
void set_simplices(Body& body);

/// Cells of all blocks.
std::size_t cells_in_blocks(const Body& body);

/// Cells of the body: those of its blocks, and triangles and tetrahedra of a dimension that has no blocks.
std::size_t count_cells(const Body& body);

/// Cells of three dimensions: those of the blocks, counted through, or the tetrahedra.
std::size_t solid_cells(const Body& body);

/// Volumes [m³] (areas [m²] times `thickness` [m]) of the molecules, positive on every shape: each cell's by the share
/// of ∫ N_a² of its nodes.                                                     [Hinton, Rock & Zienkiewicz 1976]
VectorX lumped_volumes(const Body& body, double thickness);

/// What is wrong or odd with a body as a graph of its connections proper, in words a user can act on.
struct BodyFindings {
  int pieces = 0;                            ///< connected parts, isolated molecules included
  std::vector<int> piece_of;                 ///< the part each molecule belongs to, parts numbered by first molecule
  std::vector<int> isolated_molecules;       ///< molecules without any connection
  std::vector<int> zero_length_connections;  ///< rest length below 1e-12 of the body's size
  std::vector<int> duplicate_connections;    ///< the second and later ones of a pair
  std::vector<int> flat_or_inverted_cells;   ///< at rest
};
BodyFindings inspect(const Body& body);

}  // namespace elastin
