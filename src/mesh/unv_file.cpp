#include <charconv>
#include <cmath>
#include <map>

#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {
namespace {

// The universal file format of SDRC I-DEAS: dataset 2411 has nodes, 2412 elements by their descriptor. Its cells of
// second order go round their edges, corner and middle in turn.
constexpr int kUnvTriangle6[] = {0, 2, 4, 1, 3, 5};
constexpr int kUnvTetrahedron10[] = {0, 2, 4, 9, 1, 3, 5, 6, 7, 8};
constexpr CellType unv_cell_types[] = {
    {11, CellUse::line, 2, "rod"},
    {21, CellUse::line, 2, "beam"},
    {22, CellUse::line, 3, "tapered beam"},
    {24, CellUse::line, 3, "parabolic beam"},
    {41, CellUse::triangle, 3, "plane stress triangle"},
    {42, CellUse::cell, 6, "parabolic plane stress triangle", "triangle6", kUnvTriangle6},
    {51, CellUse::triangle, 3, "plane strain triangle"},
    {74, CellUse::triangle, 3, "membrane triangle"},
    {91, CellUse::triangle, 3, "thin shell triangle"},
    {92, CellUse::cell, 6, "parabolic thin shell triangle", "triangle6", kUnvTriangle6},
    {111, CellUse::tetrahedron, 4, "tetrahedron"},
    {112, CellUse::cell, 6, "wedge", "prism6"},
    {115, CellUse::cell, 8, "brick", "hexahedron8"},
    {118, CellUse::cell, 10, "parabolic tetrahedron", "tetrahedron10", kUnvTetrahedron10},
    {136, CellUse::line, 2, "spring"},
};

class UnvReader {
 public:
  UnvReader(Cursor in, MeshBuilder& mesh) : in_(in), mesh_(mesh) {}

  void read() {
    while (in_.more()) {
      const std::size_t at = in_.next_at();
      if (in_.word("-1, which begins a dataset") != "-1") in_.fail(at, "expected -1, which begins a dataset");
      const std::string number(in_.word("the number of a dataset"));
      in_.line();
      if (number == "2411" || number == "781")
        read_nodes();
      else if (number == "2412")
        read_cells();
      else
        skip();
    }
  }

 private:
  /// Whether the dataset ends here; steps over its -1.
  bool ends() {
    Cursor ahead = in_;
    if (!ahead.more()) in_.fail(in_.at(), "expected -1, which ends a dataset");
    if (ahead.word("-1") != "-1" || ahead.line().find_first_not_of(" \t\r") != std::string_view::npos) return false;
    in_ = ahead;
    return true;
  }

  void skip() {
    while (!ends()) in_.line();
  }

  double coordinate() {
    const std::size_t at = in_.next_at();
    std::string text(in_.word("a coordinate"));
    for (char& letter : text)
      if (letter == 'D' || letter == 'd') letter = 'e';
    if (const std::size_t plus = text.find("e+"); plus != std::string::npos) text.erase(plus + 1, 1);
    double value = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
      in_.fail(at, "expected a coordinate, a finite number; found " + quoted(text));
    return value;
  }

  void read_nodes() {
    while (!ends()) {
      const std::size_t at = in_.next_at();
      const long long name = in_.integer("a node's number");
      in_.skip_numbers(3, int32);  // its systems and colour
      if (!nodes_.emplace(name, mesh_.point_count()).second)
        in_.fail(at, "node " + std::to_string(name) + " stands here a second time");
      Vector3 position;
      for (double& value : position) value = coordinate();
      mesh_.add_point(position);
    }
  }

  void read_cells() {
    while (!ends()) {
      const std::size_t at = in_.next_at();
      const long long name = in_.integer("an element's number");
      const long long code = in_.integer("the descriptor of an element");
      in_.skip_numbers(3, int32);  // physical property, material, colour
      const std::size_t count = in_.count("the number of an element's nodes");
      const CellType& type = find_cell_type(unv_cell_types, code);
      if (type.use == CellUse::refused)
        in_.fail(at, "cell " + std::to_string(name) + " is of descriptor " + std::to_string(code) +
                         "; allowed: triangles (41, 91; 42, 92), tetrahedra (111, 118), wedges (112) and bricks (115)");
      if (type.use == CellUse::line) in_.skip_numbers(3, int32);  // orientation and sections
      if (type.use != CellUse::line && count != static_cast<std::size_t>(type.points))
        in_.fail(at, "a " + std::string(type.name) + " has " + std::to_string(type.points) + " nodes, and this one " +
                         std::to_string(count));
      std::vector<int> points;
      for (std::size_t node = 0; node < count; ++node) {
        const std::size_t node_at = in_.next_at();
        const long long tag = in_.integer("a node of an element");
        const auto found = nodes_.find(tag);
        if (found == nodes_.end())
          in_.fail(node_at, "cell " + std::to_string(name) + " uses node " + std::to_string(tag) +
                                ", which no dataset before has");
        points.push_back(found->second);
      }
      const std::string problem = mesh_.add_cell(type, points);
      if (!problem.empty()) in_.fail(at, "cell " + std::to_string(name) + problem);
    }
  }

  Cursor in_;
  MeshBuilder& mesh_;
  std::map<long long, int> nodes_;
};

}  // namespace

void read_unv(Cursor in, MeshBuilder& mesh) { UnvReader(in, mesh).read(); }

}  // namespace elastin::mesh::format
