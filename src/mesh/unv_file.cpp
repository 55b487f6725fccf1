#include <map>

#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {
namespace {

// The universal file format of SDRC I-DEAS: dataset 2411 has nodes, 2412 elements by their descriptor, 2467 and its
// forerunners groups of them. Its cells of second order go round their edges, corner and middle in turn.
constexpr int kUnvTriangle6[] = {0, 2, 4, 1, 3, 5};
constexpr int kUnvTetrahedron10[] = {0, 2, 4, 9, 1, 3, 5, 6, 7, 8};
constexpr CellType unv_cell_types[] = {
    {11, CellUse::line, 2, "rod"},
    {21, CellUse::line, 2, "beam"},
    {22, CellUse::line, 3, "tapered beam"},
    {24, CellUse::line, 3, "parabolic beam"},
    {41, CellUse::triangle, 3, "plane stress triangle"},
    {42, CellUse::cell, 6, "parabolic plane stress triangle", "triangle6", kUnvTriangle6},
    {44, CellUse::face, 4, "plane stress quadrilateral"},
    {45, CellUse::face, 8, "parabolic plane stress quadrilateral"},
    {51, CellUse::triangle, 3, "plane strain triangle"},
    {54, CellUse::face, 4, "plane strain quadrilateral"},
    {71, CellUse::face, 4, "membrane quadrilateral"},
    {74, CellUse::triangle, 3, "membrane triangle"},
    {91, CellUse::triangle, 3, "thin shell triangle"},
    {92, CellUse::cell, 6, "parabolic thin shell triangle", "triangle6", kUnvTriangle6},
    {94, CellUse::face, 4, "thin shell quadrilateral"},
    {95, CellUse::face, 8, "parabolic thin shell quadrilateral"},
    {111, CellUse::tetrahedron, 4, "tetrahedron"},
    {112, CellUse::cell, 6, "wedge", "prism6"},
    {115, CellUse::cell, 8, "brick", "hexahedron8"},
    {118, CellUse::cell, 10, "parabolic tetrahedron", "tetrahedron10", kUnvTetrahedron10},
    {136, CellUse::point, 2, "spring"},
    {161, CellUse::point, 1, "lumped mass"},
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
      else if (number == "2435" || number == "2452" || number == "2467" || number == "2477")
        read_groups(2);
      else if (number == "2429" || number == "2430" || number == "2432")
        read_groups(0);
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
    const std::string_view text = in_.word("a coordinate");
    if (const auto value = fortran_real(text)) return *value;
    in_.fail(at, "expected a coordinate, a finite number; found " + quoted(text));
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
      mesh_.admit(type, [&] {
        in_.fail(at, "cell " + std::to_string(name) + " is of descriptor " + std::to_string(code) +
                         "; allowed: triangles (41, 91; 42, 92), tetrahedra (111, 118), wedges (112) and bricks (115)");
      });
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
      cells_[name] = std::move(points);
    }
  }

  /// Groups of nodes and elements: a number, six others, the count of members; a name; the members, each its kind, its
  /// number and `others` numbers more. A group without a name goes by its number.
  void read_groups(std::size_t others) {
    while (!ends()) {
      const long long number = in_.integer("a group's number");
      in_.skip_numbers(6, int32);
      const std::size_t count = in_.count("the number of a group's members");
      in_.line();
      const std::string_view given = trimmed(in_.line());
      const std::string name = given.empty() ? std::to_string(number) : std::string(given);
      std::size_t missing = 0;
      for (std::size_t member = 0; member < count; ++member) {
        const long long kind = in_.integer("the kind of a member, 7 (node) or 8 (element)");
        const long long tag = in_.integer("a member's number");
        in_.skip_numbers(others, int32);
        const auto node = nodes_.find(tag);
        const auto cell = cells_.find(tag);
        if (kind == 7 && node != nodes_.end())
          mesh_.add_to_set(name, {&node->second, 1});
        else if (kind == 8 && cell != cells_.end())
          mesh_.add_to_set(name, cell->second);
        else
          ++missing;
      }
      if (missing > 0) mesh_.leave_out("missing group member", missing);
    }
  }

  Cursor in_;
  MeshBuilder& mesh_;
  std::map<long long, int> nodes_;
  std::map<long long, std::vector<int>> cells_;
};

}  // namespace

void read_unv(Cursor in, MeshBuilder& mesh) { UnvReader(in, mesh).read(); }

}  // namespace elastin::mesh::format
