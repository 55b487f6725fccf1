#pragma once
#include <map>
#include <string>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin::mesh {

/// What a mesh file holds that Elastin uses.
struct Mesh {
  Positions points;     ///< in the file's own length unit; points that no kept cell uses are left out
  Cells<3> triangles;   ///< of the file; kept only where the file has no tetrahedra (else they are its boundary faces)
  Cells<4> tetrahedra;  ///< re-ordered to positive volume where the file has the mirrored order
  /// All cells, where the file has others than tetrahedra or triangles of first order; then `triangles` and
  /// `tetrahedra` are the simplices that their nodes make, as in Body.
  std::vector<CellBlock> blocks;
  /// Points, ascending, of the file's groups by name, or by number where they have none: physical groups of Gmsh, *NSET
  /// and *ELSET of Abaqus (of an instance "INSTANCE.SET" too), groups of I-DEAS, properties of Nastran.
  std::map<std::string, std::vector<int>> sets = {};
  int reoriented = 0;  ///< cells whose order was mirrored
  /// What was mended, each with its number: "12 cells that stood twice dropped", of a surface of triangles "2 triangles
  /// without area dropped".
  std::vector<std::string> repairs = {};
  std::string comment;  ///< what was left out, e.g. "12 lines, 3 points and 4 unused points left out"; empty if nothing
};

/// Reads a file of one of mesh_formats(), chosen by its ending, text or binary, packed or not. Corners of a surface at
/// the same position are one point, in single precision. Cells of the table of shapes are used; what may stand next to
/// a solid is left out: points, lines, springs, masses, quadrangles; others (pyramids, prisms of second order) are
/// refused by name, and so is a keyword that would change the mesh. Throws InputError with file:line:column and what
/// was expected: missing file, unknown ending (with the command that converts the file, where there is one) or version,
/// a truncated section, an index that names no point, a coordinate that is not finite, no triangle and no tetrahedron,
/// a flat cell (of a surface file a flat triangle is dropped).
///
/// Points and cells keep the file's order, unless there are 10 000 points or more and the numbers in a cell are several
/// times as far apart as by order_in_space: then they get that order, for passes over them would wait for the memory.
Mesh load_mesh(const std::string& path);

/// Makes one point of all that lie within `distance` (in the file's unit, > 0) of each other, the first of them, and
/// gives the number of those that this took. Throws InputError where two corners of a cell would be one.
int join_points(Mesh& mesh, double distance);

enum class MeshContent {
  surface,          ///< triangles alone
  cells,            ///< triangles, or the cells of a solid
  cells_with_data,  ///< and load_cell_data reads the file, too
};

/// The files of one ending.
struct MeshFormat {
  std::string ending;    ///< with its dot
  std::string versions;  ///< "1, 2 and 4.1"; empty where one reader reads all
  MeshContent content;
};

/// The files that load_mesh reads.
std::vector<MeshFormat> mesh_formats();

/// Whether load_mesh reads files of this ending.
bool is_mesh_file(const std::string& path);

/// Numbers that a mesh file has for its cells.
struct CellData {
  Positions middles;          ///< of the cells, the mean of their points, in the file's own length unit
  Eigen::MatrixXd values;     ///< a column a cell, a row a component
  double largest_radius = 0;  ///< of the cells, from the middle to the furthest point
};

/// Reads the data of this name of the file's solid cells, or where it has none of its triangles: from .vtu, from .vtk
/// (CELL_DATA: SCALARS, VECTORS, FIELD) and from .msh 2 and 4.1 ($ElementData; cells without a value are left out).
/// Throws InputError as load_mesh does, on data for another number of cells, and with the nearest name where the file
/// has none of that name.
CellData load_cell_data(const std::string& path, const std::string& name);

}  // namespace elastin::mesh
