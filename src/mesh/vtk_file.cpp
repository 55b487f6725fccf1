#include <optional>
#include <utility>

#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {
namespace {

// The cell types of VTK: vtkCellType.h. Some have rows for several numbers of points.
constexpr int kVoxel[] = {0, 1, 3, 2, 4, 5, 7, 6};
constexpr CellType cell_types[] = {
    {0, CellUse::point, 0, "empty cell"},
    {1, CellUse::point, 0, "point"},
    {2, CellUse::point, 0, "vertex"},
    {3, CellUse::line, 0, "line"},
    {4, CellUse::line, 0, "polyline"},
    {5, CellUse::triangle, 3, "triangle"},
    {6, CellUse::refused, 0, "triangle strip"},
    {7, CellUse::refused, 0, "polygon"},
    {8, CellUse::face, 4, "pixel"},
    {9, CellUse::face, 4, "quadrangle"},
    {10, CellUse::tetrahedron, 4, "tetrahedron"},
    {11, CellUse::cell, 8, "voxel", "hexahedron8", kVoxel},
    {12, CellUse::cell, 8, "hexahedron", "hexahedron8"},
    {13, CellUse::cell, 6, "prism", "prism6"},
    {14, CellUse::refused, 5, "pyramid"},
    {21, CellUse::line, 0, "quadratic line"},
    {22, CellUse::cell, 6, "quadratic triangle with 6 points", "triangle6"},
    {23, CellUse::face, 8, "quadratic quadrangle with 8 points"},
    {24, CellUse::cell, 10, "quadratic tetrahedron with 10 points", "tetrahedron10"},
    {25, CellUse::cell, 20, "quadratic hexahedron with 20 points", "hexahedron20"},
    {26, CellUse::refused, 15, "quadratic prism with 15 points"},
    {27, CellUse::refused, 13, "quadratic pyramid with 13 points"},
    {28, CellUse::face, 9, "quadratic quadrangle with 9 points"},
    {29, CellUse::cell, 27, "quadratic hexahedron with 27 points", "hexahedron27"},
    {34, CellUse::refused, 7, "quadratic triangle with 7 points"},
    {35, CellUse::line, 0, "cubic line"},
    {42, CellUse::refused, 0, "polyhedron"},
    {68, CellUse::line, 0, "Lagrange line"},
    {69, CellUse::refused, 0, "Lagrange triangle of an order above 2"},
    {69, CellUse::triangle, 3, "Lagrange triangle"},
    {69, CellUse::cell, 6, "Lagrange triangle", "triangle6"},
    {70, CellUse::refused, 0, "Lagrange quadrangle of an order above 2"},
    {70, CellUse::face, 4, "Lagrange quadrangle"},
    {70, CellUse::face, 9, "Lagrange quadrangle"},
    {71, CellUse::refused, 0, "Lagrange tetrahedron of an order above 2"},
    {71, CellUse::tetrahedron, 4, "Lagrange tetrahedron"},
    {71, CellUse::cell, 10, "Lagrange tetrahedron", "tetrahedron10"},
    {72, CellUse::refused, 0, "Lagrange hexahedron of an order above 2"},
    {72, CellUse::cell, 8, "Lagrange hexahedron", "hexahedron8"},
    {72, CellUse::cell, 27, "Lagrange hexahedron", "hexahedron27"},
    {73, CellUse::refused, 0, "Lagrange prism of an order above 1"},
    {73, CellUse::cell, 6, "Lagrange prism", "prism6"},
    {75, CellUse::line, 0, "Bezier line"},
    {76, CellUse::refused, 0, "Bezier triangle"},
    {78, CellUse::refused, 0, "Bezier tetrahedron"},
};

/// The types of numbers in legacy files; vtkIdType is written as int. [vtkDataReader::ReadArray]
std::optional<NumberType> number_type(std::string_view name) {
  static constexpr std::pair<const char*, NumberType> types[] = {{"char", {NumberType::signed_integer, 1}},
                                                                 {"unsigned_char", {NumberType::unsigned_integer, 1}},
                                                                 {"short", {NumberType::signed_integer, 2}},
                                                                 {"unsigned_short", {NumberType::unsigned_integer, 2}},
                                                                 {"int", {NumberType::signed_integer, 4}},
                                                                 {"unsigned_int", {NumberType::unsigned_integer, 4}},
                                                                 {"long", {NumberType::signed_integer, 8}},
                                                                 {"unsigned_long", {NumberType::unsigned_integer, 8}},
                                                                 {"vtktypeint64", {NumberType::signed_integer, 8}},
                                                                 {"vtktypeuint64", {NumberType::unsigned_integer, 8}},
                                                                 {"vtktypeint32", {NumberType::signed_integer, 4}},
                                                                 {"vtktypeuint32", {NumberType::unsigned_integer, 4}},
                                                                 {"vtkidtype", {NumberType::signed_integer, 4}},
                                                                 {"float", {NumberType::real, 4}},
                                                                 {"double", {NumberType::real, 8}}};
  for (const auto& [known, type] : types)
    if (name == known) return type;
  return std::nullopt;
}

class LegacyReader {
 public:
  LegacyReader(Cursor in, MeshBuilder& mesh) : in_(in), mesh_(mesh) {}
  void read();

 private:
  void read_header();
  bool read_section();
  void read_points();
  void read_cells();
  void read_cells_with_counts(std::size_t count, std::size_t size);
  void read_cells_with_offsets(std::size_t count, std::size_t size);
  void read_cell_types();
  void read_field(std::optional<std::size_t> cells);
  void read_attributes();
  void read_numbers(const std::string& name, NumberType type, std::size_t components, std::size_t tuples,
                    bool of_cells);
  void skip_metadata();
  NumberType read_any_type();
  NumberType read_type(NumberType::Kind kind);
  void begin_data();
  void once(bool there, const std::string& section, std::size_t at);

  Cursor in_;
  MeshBuilder& mesh_;
  bool binary_ = false;
  bool offsets_ = false;   // of format 5.1
  bool polygons_ = false;  // a surface: POLYGONS without CELL_TYPES
  bool have_points_ = false;
  std::optional<Integers> corners_, types_;
  std::vector<std::size_t> first_, count_;
};

void LegacyReader::read_header() {
  for (const char* part : {"#", "vtk", "DataFile", "Version"}) in_.expect(part);
  const std::size_t version_at = in_.next_at();
  const double version = in_.real("the version of the format");
  offsets_ = version == 5.1;
  if (!offsets_ && !(version >= 2.0 && version <= 4.2))
    in_.fail(version_at, "format version " + quoted(in_.data().substr(version_at, in_.at() - version_at)) +
                             " is not read; allowed: 2.0 to 4.2 and 5.1");
  in_.end_line();
  in_.line();  // the title
  const std::string encoding = upper_case(in_.word("ASCII or BINARY"));
  binary_ = encoding == "BINARY";
  if (!binary_ && encoding != "ASCII")
    in_.fail(in_.at() - encoding.size(), "expected ASCII or BINARY, found " + quoted(encoding));
  in_.expect("DATASET");
  const std::string kind = upper_case(in_.word("UNSTRUCTURED_GRID"));
  polygons_ = kind == "POLYDATA";
  if (!polygons_ && kind != "UNSTRUCTURED_GRID")
    in_.fail(in_.at() - kind.size(), "expected UNSTRUCTURED_GRID or POLYDATA, found " + quoted(kind) +
                                         "; save the mesh as an unstructured grid of tetrahedra or triangles");
}

/// Binary data start behind the end of the line, big-endian whatever the machine.
void LegacyReader::begin_data() {
  if (!binary_) return;
  in_.end_line();
  in_.begin_binary(std::endian::big);
}

NumberType LegacyReader::read_type(NumberType::Kind kind) {
  const std::string_view name = in_.word("a type of numbers");
  const std::optional<NumberType> type = number_type(name);
  const bool real = kind == NumberType::real;
  if (!type || (type->kind == NumberType::real) != real)
    in_.fail(in_.at() - name.size(), std::string("expected a type of ") +
                                         (real ? "real numbers, float or double" : "integers, such as vtktypeint64") +
                                         "; found " + quoted(name));
  return *type;
}

void LegacyReader::read_points() {
  const std::size_t count = in_.count("the number of points");
  const NumberType type = read_type(NumberType::real);
  begin_data();
  in_.require_numbers(3 * count, "coordinates", type);
  for (std::size_t point = 0; point < count; ++point) {
    Vector3 position;
    for (double& coordinate : position) coordinate = in_.real("a coordinate", type);
    mesh_.add_point(position);
  }
  have_points_ = true;
}

void LegacyReader::read_cells() {
  const std::size_t count = in_.count("the number of cells");
  const std::size_t size = in_.count("the size of the list of cells");
  if (offsets_)
    read_cells_with_offsets(count, size);
  else
    read_cells_with_counts(count, size);
}

/// Format 2.0 to 4.2: each cell's number of points, then its points.
void LegacyReader::read_cells_with_counts(std::size_t count, std::size_t size) {
  begin_data();
  corners_ = in_.integers(size, "a number of the list of cells", int32);
  std::size_t next = 0;
  for (std::size_t cell = 0; cell < count; ++cell) {
    const long long points = next < size ? corners_->values[next] : 0;
    if (next >= size || points < 0 || static_cast<std::size_t>(points) > size - next - 1)
      corners_->fail(next, "expected the number of points of cell " + std::to_string(cell) +
                               " (counted from 0), within the list's " + std::to_string(size) + " numbers");
    first_.push_back(next + 1);
    count_.push_back(points);
    next += points + 1;
  }
  if (next != size)
    corners_->fail(next, "expected the end of the list of cells: its " + std::to_string(count) + " cells take " +
                             std::to_string(next) + " numbers, not " + std::to_string(size));
}

/// Format 5.1: where each cell starts in the list of points; one more than there are cells.
void LegacyReader::read_cells_with_offsets(std::size_t count, std::size_t size) {
  in_.expect("OFFSETS");
  const NumberType offset_type = read_type(NumberType::signed_integer);
  begin_data();
  const Integers offsets = in_.integers(count, "an offset", offset_type);
  in_.begin_text();
  in_.expect("CONNECTIVITY");
  const NumberType corner_type = read_type(NumberType::signed_integer);
  begin_data();
  corners_ = in_.integers(size, "a point of a cell", corner_type);
  if (count > 0 && offsets.values[0] != 0) offsets.fail(0, "expected the first offset, 0");
  for (std::size_t cell = 0; cell + 1 < count; ++cell) add_range(offsets, cell + 1, size, first_, count_);
  if (count > 0 && static_cast<std::size_t>(offsets.values[count - 1]) != size)
    offsets.fail(count - 1, "expected the last offset, " + std::to_string(size));
}

void LegacyReader::read_cell_types() {
  const std::size_t count = in_.count("the number of cells");
  begin_data();
  types_ = in_.integers(count, "the type of a cell", int32);
}

/// The name of a type of numbers of any kind.
NumberType LegacyReader::read_any_type() {
  const std::string_view name = in_.word("a type of numbers");
  const std::optional<NumberType> type = number_type(name);
  if (!type) in_.fail(in_.at() - name.size(), "an array of type " + quoted(name) + " is not read; leave it out");
  return *type;
}

/// The numbers of an array; of cells they are kept if they are wanted.
void LegacyReader::read_numbers(const std::string& name, NumberType type, std::size_t components, std::size_t tuples,
                                bool of_cells) {
  begin_data();
  if (of_cells && mesh_.is_wanted(name))
    read_data(in_, type, components, mesh_.cell_count() - static_cast<int>(tuples), tuples, mesh_);
  else
    in_.skip_numbers(components * tuples, type);
  in_.begin_text();
}

/// FIELD name arrays, each: name components tuples type, then its numbers.
void LegacyReader::read_field(std::optional<std::size_t> cells) {
  in_.word("the name of the field");
  const std::size_t arrays = in_.count("the number of arrays");
  for (std::size_t array = 0; array < arrays; ++array) {
    const std::string name(in_.word("the name of an array"));
    const std::size_t components = in_.count("the number of components");
    const std::size_t tuples_at = in_.next_at();
    const std::size_t tuples = in_.count("the number of tuples");
    if (cells && tuples != *cells) in_.fail(tuples_at, "expected values of " + std::to_string(*cells) + " cells");
    read_numbers(name, read_any_type(), components, tuples, cells.has_value());
  }
}

/// CELL_DATA and POINT_DATA, up to the end of the file.
void LegacyReader::read_attributes() {
  std::optional<std::size_t> cells;
  std::size_t tuples = 0;
  while (in_.more()) {
    const std::string kind = upper_case(in_.word("CELL_DATA"));
    const std::size_t at = in_.at() - kind.size();
    if (kind == "CELL_DATA" || kind == "POINT_DATA") {
      tuples = in_.count("the number of values");
      cells = kind == "CELL_DATA" ? std::optional(tuples) : std::nullopt;
      if (cells && tuples != first_.size())
        in_.fail(at, "data of " + std::to_string(tuples) + " cells, but there are " + std::to_string(first_.size()));
    } else if (kind == "FIELD") {
      read_field(cells);
    } else if (kind == "METADATA") {
      skip_metadata();
    } else if (kind == "SCALARS") {
      const std::string name(in_.word("the name of the values"));
      const NumberType type = read_any_type();
      const std::string_view rest = trimmed(in_.line());
      if (rest.size() > 1 || (rest.size() == 1 && (rest[0] < '1' || rest[0] > '4')))
        in_.fail(in_.at() - 1, "expected the number of values a cell, 1 to 4; found " + quoted(rest));
      in_.expect("LOOKUP_TABLE");
      in_.word("the name of a table");
      read_numbers(name, type, rest.empty() ? 1 : rest[0] - '0', tuples, cells.has_value());
    } else if (kind == "VECTORS" || kind == "NORMALS" || kind == "TENSORS") {
      const std::string name(in_.word("the name of the values"));
      read_numbers(name, read_any_type(), kind == "TENSORS" ? 9 : 3, tuples, cells.has_value());
    } else {
      in_.fail(at, "expected SCALARS, VECTORS, NORMALS, TENSORS or FIELD; found " + quoted(kind));
    }
  }
}

void LegacyReader::skip_metadata() {  // up to an empty line
  in_.line();
  while (in_.left() > 0 && !in_.line().empty()) continue;
}

void LegacyReader::once(bool there, const std::string& section, std::size_t at) {
  if (there) in_.fail(at, section + " stands here a second time");
}

/// False where the cells' and points' own data begin.
bool LegacyReader::read_section() {
  const char* cells = polygons_ ? "POLYGONS" : "CELLS";
  const std::string name = upper_case(in_.word(!have_points_ ? "POINTS" : !corners_ ? cells : "CELL_TYPES"));
  const std::size_t at = in_.at() - name.size();
  if (name == "CELL_DATA" || name == "POINT_DATA") return false;
  if (name == "POINTS") {
    once(have_points_, name, at);
    read_points();
  } else if (name == cells) {
    once(corners_.has_value(), name, at);
    const Cursor before = in_;
    read_cells();
    if (polygons_) {
      types_ = Integers{before, int32, {}};
      for (const std::size_t count : count_) types_->values.push_back(count == 3 ? 5 : 7);
    }
  } else if (name == "CELL_TYPES" && !polygons_) {
    once(types_.has_value(), name, at);
    read_cell_types();
  } else if (name == "FIELD") {
    read_field(std::nullopt);
  } else if (name == "METADATA") {
    skip_metadata();
  } else {
    in_.fail(at, std::string("expected POINTS, ") + (polygons_ ? "POLYGONS" : "CELLS, CELL_TYPES") +
                     ", FIELD or METADATA; found " + quoted(name));
  }
  in_.begin_text();
  return true;
}

void LegacyReader::read() {
  read_header();
  Cursor before_data = in_;
  while (!(have_points_ && corners_ && types_ && !in_.more()) && read_section()) before_data = in_;
  if (!have_points_ || !corners_ || !types_)
    in_.fail(in_.at(), std::string("expected ") +
                           (!have_points_ ? "POINTS"
                            : !corners_   ? (polygons_ ? "POLYGONS" : "CELLS")
                                          : "CELL_TYPES") +
                           " before this");
  const VtkCells cells{std::move(*corners_), first_, std::move(count_), std::move(*types_)};
  add_vtk_cells(cells, 0, mesh_);
  if (!mesh_.wanted_data()) return;
  in_ = before_data;
  read_attributes();
}

}  // namespace

void add_range(const Integers& offsets, std::size_t number, std::size_t size, std::vector<std::size_t>& first,
               std::vector<std::size_t>& count) {
  const long long begin = first.empty() ? 0 : static_cast<long long>(first.back() + count.back());
  const long long end = offsets.values[number];
  if (end < begin || static_cast<unsigned long long>(end) > size)
    offsets.fail(number, "expected an offset from " + std::to_string(begin) + " to " + std::to_string(size) +
                             ", found " + std::to_string(end));
  first.push_back(begin);
  count.push_back(end - begin);
}

void add_vtk_cells(const VtkCells& cells, int first_point, MeshBuilder& mesh) {
  if (cells.types.size() != cells.first.size())
    cells.types.fail(0, "expected the types of " + std::to_string(cells.first.size()) + " cells, found " +
                            std::to_string(cells.types.size()));
  const int points = mesh.point_count() - first_point;
  for (std::size_t cell = 0; cell < cells.first.size(); ++cell) {
    const auto name = [&] { return "cell " + std::to_string(cell) + " (counted from 0)"; };
    const long long code = cells.types.values[cell];
    const CellType& type = find_cell_type(cell_types, code, cells.count[cell]);
    mesh.admit(type, [&] { cells.types.fail(cell, name() + refusal(type, code)); });
    const std::size_t first = cells.first[cell];
    if (type.points > 0 && cells.count[cell] != static_cast<std::size_t>(type.points))
      cells.corners.fail(first, name() + " is a " + type.name + " of " + std::to_string(cells.count[cell]) + " points");
    std::vector<int> corners;
    for (std::size_t corner = 0; corner < cells.count[cell]; ++corner) {
      const long long point = cells.corners.values[first + corner];
      if (point < 0 || point >= points)
        cells.corners.fail(first + corner, name() + " uses point " + std::to_string(point) + ", but there are " +
                                               std::to_string(points) + " points, counted from 0");
      corners.push_back(first_point + static_cast<int>(point));
    }
    // Before VTK 9 the middles of two edges had changed places; where they lie says which it is.
    if (code == 72 && corners.size() == 27) {
      const auto off = [&](int middle, int a, int b) {
        return mesh.distance_from_middle(corners[middle], corners[a], corners[b]);
      };
      if (off(19, 2, 6) + off(18, 3, 7) < off(18, 2, 6) + off(19, 3, 7)) std::swap(corners[18], corners[19]);
    }
    const std::string problem = mesh.add_cell(type, corners);
    if (!problem.empty()) cells.corners.fail(first, name() + problem);
  }
}

void read_vtk(Cursor in, MeshBuilder& mesh) {
  if (Cursor ahead = in; ahead.more() && ahead.data()[ahead.at()] == '<') return read_vtu(in, mesh);
  LegacyReader(in, mesh).read();
}

}  // namespace elastin::mesh::format
