#pragma once
#include <array>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "elastin/core/base/error.h"
#include "elastin/mesh/mesh_file.h"
#include "mesh/text_file.h"

namespace elastin::mesh::format {

/// What a kind of cell is good for; `cell` is one of the table of shapes (CellKind), a `face` is left out next to the
/// cells of a solid, and refused without them.
enum class CellUse { point, line, face, triangle, tetrahedron, cell, refused };

/// A kind of cell by the number that a file format gives it.
struct CellType {
  int code;
  CellUse use;
  int points;  ///< 0 = any number
  const char* name;
  const char* shape = "";           ///< its name in the table of shapes
  std::span<const int> order = {};  ///< where the file has each of the shape's nodes; empty = in the same order
};

/// Where `types` has the code, if it can with as many points; a refused type with the name "cell of unknown type"
/// otherwise.
const CellType& find_cell_type(std::span<const CellType> types, long long code, std::size_t points = 0);

/// How many dimensions a cell has by its use.
int dimension_of(const CellType& type);

/// " is a …; allowed: …", for cells that Elastin does not use.
std::string refusal(const CellType& type, long long code);

/// How far apart corners of a surface are still one [m]: programs write each triangle by itself, and what they compute
/// twice differs by rounding.
/// @param used 1 of the corners that count; empty: all of them do
double reach_of_place(const std::vector<Vector3>& corners, const std::vector<char>& used = {});

/// Collects points and cells, and makes the mesh of them.
class MeshBuilder {
 public:
  /// @param surface of triangles alone, of which flat ones are dropped in finish()
  explicit MeshBuilder(bool surface = false) : surface_(surface) {}
  int point_count() const { return static_cast<int>(points_.size()); }
  void add_point(const Vector3& point) { points_.push_back(point); }
  /// How far a point lies from the middle between two others.
  double distance_from_middle(int point, int a, int b) const {
    return (points_[point] - (points_[a] + points_[b]) / 2).norm();
  }
  /// The first point within this distance [m] of the position; adds one there if there is none. Of one mesh it is
  /// always the same distance, see reach_of_place.
  int point_at(const Vector3& position, double within);
  /// Calls `fail`, which throws, for a cell that is refused; for a face in finish(), where there is no solid.
  template <class Fail>
  void admit(const CellType& type, const Fail& fail) {
    if (type.use == CellUse::refused) fail();
    if (type.use != CellUse::face || without_solid_) return;
    try {
      fail();
    } catch (const InputError& error) {
      without_solid_ = error;
    }
  }
  /// Names what is left out, for the mesh's comment; of 0 without a number.
  void leave_out(const std::string& what, std::size_t count = 1) { left_out_[what] += count; }
  /// Takes a cell that is admitted, its points less than point_count() and in the file's order. Returns what is
  /// wrong with it (" is a flat triangle: …"), or "".
  std::string add_cell(const CellType& type, std::span<const int> points);
  std::string add_triangle(const std::array<int, 3>& corners);
  /// Cuts a polygon into triangles, a concave one where the cut lies inside. Fewer than three corners are left out.
  std::string add_polygon(std::span<const int> corners);
  /// Puts points into a named group.
  void add_to_set(const std::string& name, std::span<const int> points) {
    sets_[name].insert(points.begin(), points.end());
  }
  /// Cells that were added, of any use.
  int cell_count() const { return static_cast<int>(places_.size()); }
  /// The name of the cells' data that the readers keep; null: none are wanted.
  void want_data(const std::string& name) { wanted_ = name; }
  const std::string* wanted_data() const { return wanted_ ? &*wanted_ : nullptr; }
  /// Notes data of this name, and returns whether they are wanted.
  bool is_wanted(const std::string& name) {
    data_names_.insert(name);
    return wanted_ && *wanted_ == name;
  }
  /// The next numbers of the data, those of cell `cell`, counted as they were added. Each cell has as many.
  void add_data(int cell, std::span<const double> values);
  /// Throws InputError where there are no data of the wanted name for any cell.
  CellData finish_data(const std::string& path) const;
  /// Leaves out what is not used. Throws InputError where there are neither tetrahedra nor triangles.
  Mesh finish(const std::string& path) const;

 private:
  std::string add_tetrahedron(std::array<int, 4> corners);
  std::string add_block_cell(const CellType& type, std::span<const int> points);

  bool surface_;
  std::vector<Vector3> points_;
  std::map<std::array<long, 3>, std::vector<int>> boxes_;  ///< of point_at
  Cells<3> triangles_;
  Cells<4> tetrahedra_;
  std::vector<CellBlock> blocks_;
  std::map<std::string, std::set<int>> sets_;
  struct Place {
    Vector3 middle;
    double radius;  ///< from there to its furthest point
    int dimensions;
  };
  std::vector<Place> places_;  ///< of all cells
  std::optional<std::string> wanted_;
  std::set<std::string> data_names_;
  std::vector<int> with_data_;  ///< cells
  std::vector<double> data_;    ///< theirs, one cell after the other
  std::map<std::string, std::size_t> left_out_;
  std::optional<InputError> without_solid_;
  int reoriented_ = 0;
};

/// Cells as VTK stores them: cell c has `count[c]` corners from place `first[c]` of `corners` on.
struct VtkCells {
  Integers corners;
  std::vector<std::size_t> first;
  std::vector<std::size_t> count;
  Integers types;
};

/// Adds the next cell's range of corners, which ends at `offsets[number]`; `size` is the number of all corners.
void add_range(const Integers& offsets, std::size_t number, std::size_t size, std::vector<std::size_t>& first,
               std::vector<std::size_t>& count);

/// Keeps `components` numbers of this type for each of the cells from `first_cell` on.
void read_data(Cursor& in, NumberType type, std::size_t components, int first_cell, std::size_t cells,
               MeshBuilder& mesh);

/// Adds the cells, whose corners count from the mesh's point `first_point` on.
void add_vtk_cells(const VtkCells& cells, int first_point, MeshBuilder& mesh);

/// VTK's XML, which also stands in files named .vtk.
void read_vtu(Cursor in, MeshBuilder& mesh);

/// load_mesh for a file that is in memory already; the format goes by the path's ending.
Mesh read_mesh(const File& file);

}  // namespace elastin::mesh::format
