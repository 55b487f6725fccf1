#include "mesh/gmsh_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include "core/base/shell_word.h"
#include "elastin/core/base/error.h"
#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {
namespace {

// The MSH file format, versions 1, 2 and 4.1: Gmsh reference manual, chapter "File formats". The names say what Gmsh
// counts.
constexpr int kTetrahedron10[] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
constexpr int kHexahedron20[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15};
constexpr int kHexahedron27[] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  16, 18,
                                 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26};
constexpr CellType gmsh_cell_types[] = {
    {1, CellUse::line, 2, "line"},
    {2, CellUse::triangle, 3, "triangle"},
    {3, CellUse::face, 4, "quadrangle"},
    {4, CellUse::tetrahedron, 4, "tetrahedron"},
    {5, CellUse::cell, 8, "hexahedron", "hexahedron8"},
    {6, CellUse::cell, 6, "prism", "prism6"},
    {7, CellUse::refused, 5, "pyramid"},
    {8, CellUse::line, 3, "quadratic line"},
    {9, CellUse::cell, 6, "quadratic triangle with 6 points", "triangle6"},
    {10, CellUse::face, 9, "quadratic quadrangle with 9 points"},
    {11, CellUse::cell, 10, "quadratic tetrahedron with 10 points", "tetrahedron10", kTetrahedron10},
    {12, CellUse::cell, 27, "quadratic hexahedron with 27 points", "hexahedron27", kHexahedron27},
    {13, CellUse::refused, 18, "quadratic prism with 18 points"},
    {14, CellUse::refused, 14, "quadratic pyramid with 14 points"},
    {15, CellUse::point, 1, "point"},
    {16, CellUse::face, 8, "quadratic quadrangle with 8 points"},
    {17, CellUse::cell, 20, "quadratic hexahedron with 20 points", "hexahedron20", kHexahedron20},
    {18, CellUse::refused, 15, "quadratic prism with 15 points"},
    {19, CellUse::refused, 13, "quadratic pyramid with 13 points"},
    {20, CellUse::refused, 9, "cubic triangle with 9 points"},
    {21, CellUse::refused, 10, "cubic triangle with 10 points"},
    {26, CellUse::line, 4, "cubic line"},
    {27, CellUse::line, 5, "quartic line"},
    {28, CellUse::line, 6, "quintic line"},
    {29, CellUse::refused, 20, "cubic tetrahedron with 20 points"},
};

struct Format {
  bool is_4 = false;
  bool binary = false;
  std::endian order = std::endian::native;
};

/// Points of the mesh by the tag that the file gives them: any positive numbers, in any order.
class Tags {
 public:
  void add(long long tag, std::size_t at) { rows_.push_back({tag, static_cast<int>(rows_.size()), at}); }

  void sort(const Cursor& in) {
    const auto by_tag = [](const Row& a, const Row& b) {
      return std::pair(a.tag, a.point) < std::pair(b.tag, b.point);
    };
    if (!std::is_sorted(rows_.begin(), rows_.end(), by_tag)) std::sort(rows_.begin(), rows_.end(), by_tag);
    const auto same = [](const Row& a, const Row& b) { return a.tag == b.tag; };
    const auto twin = std::adjacent_find(rows_.begin(), rows_.end(), same);
    if (twin != rows_.end()) in.fail(twin[1].at, "point " + std::to_string(twin->tag) + " stands here a second time");
  }

  /// The point, or −1. Tags without gaps, the common case, need no search.
  int find(long long tag) const {
    if (rows_.empty() || tag < rows_.front().tag || tag > rows_.back().tag) return -1;
    const auto guess = static_cast<std::size_t>(tag - rows_.front().tag);
    if (guess < rows_.size() && rows_[guess].tag == tag) return rows_[guess].point;
    const auto found =
        std::lower_bound(rows_.begin(), rows_.end(), tag, [](const Row& row, long long t) { return row.tag < t; });
    return found->tag == tag ? found->point : -1;
  }

 private:
  struct Row {
    long long tag;
    int point;
    std::size_t at;
  };
  std::vector<Row> rows_;
};

bool read_version_is_4(Cursor& in) {
  const std::size_t begin = in.next_at();
  const double number = in.real("the version of the format");
  if (number != 2 && number != 2.1 && number != 2.2 && number != 4.1)
    in.fail(begin, "format version " + quoted(in.data().substr(begin, in.at() - begin)) +
                       " is not read; allowed: 2.2 and 4.1; convert it: gmsh -save -format msh41 -o new.msh " +
                       shell_word(in.path()));
  return number == 4.1;
}

std::endian read_byte_order(Cursor& in) {
  const std::size_t begin = in.at();
  in.begin_binary(std::endian::little);
  const long long one = in.integer("the number 1 that shows the byte order");
  in.begin_text();
  if (one != 1 && one != 1 << 24) in.fail(begin, "expected the number 1 that shows the byte order");
  return one == 1 ? std::endian::little : std::endian::big;
}

Format read_format(Cursor& in) {
  in.expect("$MeshFormat");
  Format format;
  format.is_4 = read_version_is_4(in);
  const std::size_t kind_at = in.next_at();
  const long long kind = in.integer("the file type, 0 (ASCII) or 1 (binary)");
  if (kind != 0 && kind != 1) in.fail(kind_at, "expected the file type, 0 (ASCII) or 1 (binary)");
  const std::size_t size_at = in.next_at();
  if (in.integer("the data size, 8") != 8) in.fail(size_at, "expected the data size, 8 bytes a number");
  format.binary = kind == 1;
  if (format.binary) {
    in.end_line();
    format.order = read_byte_order(in);
  }
  in.expect("$EndMeshFormat");
  return format;
}

/// After a section's name or its count: the data begin.
void begin_data(Cursor& in, const Format& format) {
  if (!format.binary) return;
  in.end_line();
  in.begin_binary(format.order);
}

void read_tag(Cursor& in, NumberType width, Tags& tags) {
  const std::size_t at = in.next_at();
  const long long tag = in.integer("a point's number", width);
  if (tag < 0) in.fail(at, "expected a point's number, from 0 to 2⁶³−1; found " + std::to_string(tag));
  tags.add(tag, at);
}

void add_point(Cursor& in, MeshBuilder& mesh) {
  Vector3 position;
  for (double& coordinate : position) coordinate = in.real("a coordinate");
  mesh.add_point(position);
}

void read_points_22(Cursor& in, const Format& format, Tags& tags, MeshBuilder& mesh) {
  const std::size_t count = in.count("the number of points");
  begin_data(in, format);
  for (std::size_t point = 0; point < count; ++point) {
    read_tag(in, int32, tags);
    add_point(in, mesh);
  }
}

void read_points_41(Cursor& in, const Format& format, Tags& tags, MeshBuilder& mesh) {
  begin_data(in, format);
  const std::size_t blocks = in.count("the number of blocks", uint64);
  const std::size_t total_at = in.next_at();
  const std::size_t total = in.count("the number of points", uint64);
  in.skip_numbers(2, uint64);  // least and greatest tag
  for (std::size_t block = 0; block < blocks; ++block) {
    const long long dimension = in.integer("the dimension of a block's entity");
    in.skip_numbers(1, int32);  // the entity's tag
    const bool parametric = in.integer("0 or 1 for parametric points") != 0;
    const std::size_t count = in.count("the number of points of a block", uint64);
    for (std::size_t point = 0; point < count; ++point) read_tag(in, uint64, tags);
    for (std::size_t point = 0; point < count; ++point) {
      add_point(in, mesh);
      if (parametric && dimension > 0) in.skip_numbers(static_cast<std::size_t>(std::min(dimension, 3LL)), float64);
    }
  }
  if (static_cast<std::size_t>(mesh.point_count()) != total)
    in.fail(total_at, "expected the number of points, but the blocks hold " + std::to_string(mesh.point_count()) +
                          ", not " + std::to_string(total));
}

/// The names of physical groups, by dimension and number; of version 4 also which of them each entity is in.
struct Groups {
  using Key = std::pair<long long, long long>;  ///< dimension, number
  std::map<Key, std::string> names;
  std::map<Key, std::vector<long long>> of_entity;
  std::map<Key, std::vector<int>> without_name;  ///< their points

  void add(MeshBuilder& mesh, long long dimension, long long number, std::span<const int> points) {
    if (const auto found = names.find({dimension, number}); found != names.end())
      mesh.add_to_set(found->second, points);
    else if (number != 0)
      without_name[{dimension, number}].insert(without_name[{dimension, number}].end(), points.begin(), points.end());
  }
  /// They go by their number; where groups of several dimensions have the same one, by "surface 1", "volume 1".
  void finish(MeshBuilder& mesh) const {
    constexpr const char* of_dimension[] = {"point ", "line ", "surface ", "volume "};
    for (const auto& [key, points] : without_name) {
      const auto same = [number = key.second](const auto& other) { return other.first.second == number; };
      const bool alone = std::count_if(without_name.begin(), without_name.end(), same) == 1;
      mesh.add_to_set((alone ? "" : of_dimension[key.first]) + std::to_string(key.second), points);
    }
  }
};

/// Each name's dimension and number; the first files of version 2 have the number alone.
void read_group_names(Cursor& in, Groups& groups) {
  const std::size_t count = in.count("the number of physical names");
  for (std::size_t i = 0; i < count; ++i) {
    const long long dimension = in.integer("the dimension of a group");
    std::optional<long long> number;
    if (in.more() && in.data()[in.at()] != '"') number = in.integer("the number of a group");
    const std::string_view rest = in.line();
    const std::size_t first = rest.find('"'), last = rest.rfind('"');
    if (first == std::string_view::npos || last == first) in.fail(in.at(), "expected a group's name in quotes");
    const std::string_view name = rest.substr(first + 1, last - first - 1);
    for (long long any = 0; any < 4 && !number; ++any) groups.names[{any, dimension}] = name;
    if (number) groups.names[{dimension, *number}] = name;
  }
}

/// Those of a mesh in parts have a section of their own, each with the entity that it is a part of.
void read_entities(Cursor& in, const Format& format, bool in_parts, Groups& groups) {
  begin_data(in, format);
  if (in_parts) {
    in.skip_numbers(1, uint64);  // the number of parts
    in.skip_numbers(2 * in.count("the number of ghost entities", uint64), int32);
  }
  std::array<std::size_t, 4> counts{};
  for (std::size_t& count : counts) count = in.count("the number of entities", uint64);
  for (long long dimension = 0; dimension < 4; ++dimension)
    for (std::size_t entity = 0; entity < counts[dimension]; ++entity) {
      const long long tag = in.integer("the number of an entity");
      if (in_parts) {
        in.skip_numbers(2, int32);  // the entity that this is a part of
        in.skip_numbers(in.count("the number of an entity's parts", uint64), int32);
      }
      in.skip_numbers(dimension == 0 ? 3 : 6, float64);  // where it lies
      const std::size_t physical = in.count("the number of groups", uint64);
      for (std::size_t i = 0; i < physical; ++i)
        groups.of_entity[{dimension, tag}].push_back(in.integer("the number of a group"));
      if (dimension > 0) in.skip_numbers(in.count("the number of bounding entities", uint64), int32);
    }
  in.begin_text();
  in.expect(in_parts ? "$EndPartitionedEntities" : "$EndEntities");
}

/// Cells by the number that the file gives them.
using CellNumbers = std::map<long long, int>;

/// Reads the corners of one cell, which started at `at`, and adds it; its points are left in `corners`.
const CellType& read_cell(Cursor& in, std::size_t at, long long name, long long code, NumberType width,
                          const Tags& tags, MeshBuilder& mesh, std::array<int, 27>& corners, CellNumbers& numbers) {
  const CellType& type = find_cell_type(gmsh_cell_types, code);
  const auto cell = [&] { return "cell " + std::to_string(name); };
  mesh.admit(type, [&] { in.fail(at, cell() + refusal(type, code)); });
  for (int corner = 0; corner < type.points; ++corner) {
    const std::size_t corner_at = in.next_at();
    const long long tag = in.integer("a point of a cell", width);
    const int point = tags.find(tag);
    if (point < 0) in.fail(corner_at, cell() + " uses point " + std::to_string(tag) + ", which $Nodes does not have");
    corners[corner] = point;
  }
  if (mesh.wanted_data()) numbers[name] = mesh.cell_count();
  const std::string problem = mesh.add_cell(type, {corners.data(), static_cast<std::size_t>(type.points)});
  if (!problem.empty()) in.fail(at, cell() + problem);
  return type;
}

void read_cells_22(Cursor& in, const Format& format, const Tags& tags, Groups& groups, MeshBuilder& mesh,
                   CellNumbers& numbers) {
  std::array<int, 27> corners{};
  const std::size_t total_at = in.next_at();
  const std::size_t total = in.count("the number of cells");
  begin_data(in, format);
  for (std::size_t read = 0; read < total;) {
    std::size_t at = in.next_at();
    long long name = format.binary ? 0 : in.integer("a cell's number");
    const long long code = in.integer("the type of a cell");
    const std::size_t same = format.binary ? in.count("the number of cells that follow") : 1;
    if (same == 0 || same > total - read)
      in.fail(total_at, "expected the number of cells, but the blocks do not add up to " + std::to_string(total));
    const std::size_t labels = in.count("the number of labels of a cell");
    for (std::size_t cell = 0; cell < same; ++cell, ++read) {
      if (format.binary) {
        at = in.at();
        name = in.integer("a cell's number");
      }
      const long long group = labels > 0 ? in.integer("the group of a cell") : 0;
      in.skip_numbers(labels > 0 ? labels - 1 : 0, int32);
      const CellType& type = read_cell(in, at, name, code, int32, tags, mesh, corners, numbers);
      groups.add(mesh, dimension_of(type), group, {corners.data(), static_cast<std::size_t>(type.points)});
    }
  }
}

void read_cells_41(Cursor& in, const Format& format, const Tags& tags, Groups& groups, MeshBuilder& mesh,
                   CellNumbers& numbers) {
  std::array<int, 27> corners{};
  begin_data(in, format);
  const std::size_t blocks = in.count("the number of blocks", uint64);
  const std::size_t total_at = in.next_at();
  const std::size_t total = in.count("the number of cells", uint64);
  in.skip_numbers(2, uint64);  // least and greatest tag
  std::size_t read = 0;
  for (std::size_t block = 0; block < blocks; ++block) {
    const long long dimension = in.integer("the dimension of a block's entity"),
                    entity = in.integer("the number of a block's entity");
    const auto own = groups.of_entity.find({dimension, entity});
    const long long code = in.integer("the type of a block's cells");
    const std::size_t count = in.count("the number of cells of a block", uint64);
    for (std::size_t cell = 0; cell < count; ++cell, ++read) {
      const std::size_t at = in.next_at();
      const long long name = in.integer("a cell's number", uint64);
      const CellType& type = read_cell(in, at, name, code, uint64, tags, mesh, corners, numbers);
      if (own == groups.of_entity.end()) continue;
      for (const long long group : own->second)
        groups.add(mesh, dimension, group, {corners.data(), static_cast<std::size_t>(type.points)});
    }
  }
  if (read != total)
    in.fail(total_at, "expected the number of cells, but the blocks hold " + std::to_string(read) + ", not " +
                          std::to_string(total));
}

/// Version 1: $NOD and $ELM, text alone.
void read_version_1(Cursor& in, MeshBuilder& mesh) {
  Tags tags;
  in.expect("$NOD");
  read_points_22(in, {}, tags, mesh);
  tags.sort(in);
  in.expect("$ENDNOD");
  in.expect("$ELM");
  std::array<int, 27> corners{};
  CellNumbers numbers;
  Groups groups;
  const std::size_t count = in.count("the number of cells");
  for (std::size_t cell = 0; cell < count; ++cell) {
    const std::size_t at = in.next_at();
    const long long name = in.integer("a cell's number"), code = in.integer("the type of a cell");
    const long long group = in.integer("the group of a cell");
    in.skip_numbers(1, int32);  // the entity
    const std::size_t nodes_at = in.next_at();
    const auto nodes = static_cast<int>(in.count("the number of a cell's points"));
    const CellType& type = find_cell_type(gmsh_cell_types, code);
    if (type.use != CellUse::refused && nodes != type.points)
      in.fail(nodes_at, "a " + std::string(type.name) + " has " + std::to_string(type.points) + " points");
    read_cell(in, at, name, code, int32, tags, mesh, corners, numbers);
    groups.add(mesh, dimension_of(type), group, {corners.data(), static_cast<std::size_t>(type.points)});
  }
  groups.finish(mesh);
  in.expect("$ENDELM");
}

/// Numbers of words and reals that say what the data are; then for each cell its number and its values.
void read_element_data(Cursor& in, const Format& format, const CellNumbers& numbers, MeshBuilder& mesh) {
  std::string name;
  const std::size_t texts = in.count("the number of texts");
  in.line();
  for (std::size_t i = 0; i < texts; ++i) {
    const std::string_view text = trimmed(in.line());
    if (i == 0) name = text.size() > 1 && text.front() == '"' ? text.substr(1, text.size() - 2) : text;
  }
  for (std::size_t left = in.count("the number of reals"); left > 0; --left) in.real("a real");
  const std::size_t integers = in.count("the number of integers");
  std::size_t components = 1, count = 0;
  for (std::size_t i = 0; i < integers; ++i) {
    const std::size_t value = in.count("an integer, no less than 0");
    if (i == 1) components = value;
    if (i == 2) count = value;
  }
  if (integers < 3 || components == 0) in.fail(in.at(), "expected 3 integers: step, values a cell, number of cells");
  const bool wanted = mesh.is_wanted(name);
  begin_data(in, format);
  std::vector<double> values(components);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = in.next_at();
    const auto cell = numbers.find(in.integer("a cell's number"));
    for (double& value : values) value = in.real("a cell's value");
    if (!wanted) continue;
    if (cell == numbers.end()) in.fail(at, "data of a cell that $Elements does not have");
    mesh.add_data(cell->second, values);
  }
  in.begin_text();
  in.expect("$EndElementData");
}

void read_all_data(Cursor& in, const Format& format, const CellNumbers& numbers, MeshBuilder& mesh) {
  while (in.more()) {
    const std::string section(in.word("$ElementData"));
    if (section == "$ElementData")
      read_element_data(in, format, numbers, mesh);
    else
      in.skip_past("$End" + section.substr(1));
  }
}

}  // namespace

void read_gmsh(Cursor in, MeshBuilder& mesh) {
  if (Cursor ahead = in; ahead.word("$MeshFormat") == "$NOD") return read_version_1(in, mesh);
  Groups groups;
  const Format format = read_format(in);
  Tags tags;
  bool have_points = false;
  while (true) {
    const std::string section(in.word(have_points ? "$Elements" : "$Nodes"));
    const std::size_t at = in.at() - section.size();
    if (section == "$Nodes" && !have_points) {
      (format.is_4 ? read_points_41 : read_points_22)(in, format, tags, mesh);
      tags.sort(in);
      have_points = true;
    } else if (section == "$Elements" && have_points) {
      CellNumbers numbers;
      (format.is_4 ? read_cells_41 : read_cells_22)(in, format, tags, groups, mesh, numbers);
      groups.finish(mesh);
      in.begin_text();
      in.expect("$EndElements");
      if (mesh.wanted_data()) read_all_data(in, format, numbers, mesh);
      return;
    } else if (section == "$PhysicalNames") {
      read_group_names(in, groups);
      in.expect("$EndPhysicalNames");
      continue;
    } else if (const bool in_parts = section == "$PartitionedEntities";
               (in_parts || section == "$Entities") && format.is_4) {
      read_entities(in, format, in_parts, groups);
      continue;
    } else if (section[0] != '$' || section == "$Nodes" || section == "$Elements") {
      in.fail(at, std::string("expected ") + (have_points ? "$Elements" : "$Nodes") + ", found " + quoted(section));
    } else {
      in.skip_past("$End" + section.substr(1));
      continue;
    }
    in.begin_text();
    in.expect("$EndNodes");
  }
}

}  // namespace elastin::mesh::format

namespace elastin::mesh {
namespace {

std::string gmsh_digits(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// Cells of one shape, as a line each.
class GmshElements {
 public:
  /// Cells of a dimension belong to an entity of that dimension, and to the physical group if it is not 0.
  void add(const format::CellType& type, std::span<const int> nodes, int group, int entity) {
    text_ += std::to_string(++count_) + " " + std::to_string(type.code) + " 2 " + std::to_string(group) + " " +
             std::to_string(entity);
    std::vector<int> in_file(nodes.begin(), nodes.end());
    for (std::size_t a = 0; a < type.order.size(); ++a) in_file[type.order[a]] = nodes[a];
    for (const int node : in_file) text_ += " " + std::to_string(node + 1);
    text_ += '\n';
  }
  std::string text() const { return "$Elements\n" + std::to_string(count_) + "\n" + text_ + "$EndElements\n"; }

 private:
  std::string text_;
  int count_ = 0;
};

const format::CellType& gmsh_type_of(std::string_view shape) {
  for (const format::CellType& type : format::gmsh_cell_types)
    if (shape == (type.use == format::CellUse::tetrahedron ? "tetrahedron4"
                  : type.use == format::CellUse::triangle  ? "triangle3"
                                                           : type.shape))
      return type;
  throw InputError("Gmsh: " + std::string(shape) + " cannot be written");
}

}  // namespace

std::string gmsh_text(const Body& body, const std::map<std::string, std::vector<int>>& groups) {
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  if (!groups.empty()) {
    text += "$PhysicalNames\n" + std::to_string(groups.size()) + "\n";
    int number = 0;
    for (const auto& [name, molecules] : groups) text += "0 " + std::to_string(++number) + " \"" + name + "\"\n";
    text += "$EndPhysicalNames\n";
  }
  text += "$Nodes\n" + std::to_string(body.size()) + "\n";
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    text += std::to_string(molecule + 1);
    for (int axis = 0; axis < 3; ++axis) text += " " + gmsh_digits(body.rest(axis, molecule));
    text += '\n';
  }
  text += "$EndNodes\n";
  GmshElements elements;
  int group = 0;
  for (const auto& [name, molecules] : groups) {
    ++group;
    for (const int molecule : molecules)
      elements.add(format::find_cell_type(format::gmsh_cell_types, 15), {&molecule, 1}, group, group);
  }
  const auto add_cells = [&](std::string_view shape, const auto& cells) {
    for (const auto& nodes : cells) elements.add(gmsh_type_of(shape), nodes, 0, 1);
  };
  for (const CellBlock& block : body.blocks)
    for (int cell = 0; cell < block.size(); ++cell)
      elements.add(gmsh_type_of(block.kind->name), block.cell(cell), 0, 1);
  if (!has_blocks(body, 3)) add_cells("tetrahedron4", body.tetrahedra);
  if (!has_blocks(body, 2)) add_cells("triangle3", body.triangles);
  if (count_cells(body) == 0)
    for (const auto& ends : body.connections.ends)
      elements.add(format::find_cell_type(format::gmsh_cell_types, 1), ends, 0, 1);
  return text + elements.text();
}

}  // namespace elastin::mesh
