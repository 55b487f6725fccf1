// Meshes of hexahedra, prisms and cells of second order.

#include <catch2/catch.hpp>
#include <sstream>

#include "elastin/core/base/error.h"
#include "elastin/mesh/mesh_file.h"
#include "mesh/mesh_formats.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::mesh;
using namespace elastin::testing;
using Catch::Contains;

namespace {

Mesh read(const std::string& path, const std::string& bytes) { return format::read_mesh({path, bytes}); }

/// Gmsh's numbering, from its manual: corners as here, then the middles of these edges and faces.
struct GmshCell {
  const char* shape;
  int code;
  std::vector<std::vector<int>> middles;  ///< by the corners around them
};
const std::vector<GmshCell> kGmshCells{
    {"tetrahedron10", 11, {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {2, 3}, {1, 3}}},
    {"hexahedron8", 5, {}},
    {"prism6", 6, {}},
    {"hexahedron20",
     17,
     {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}}},
    {"hexahedron27",
     12,
     {{0, 1},
      {0, 3},
      {0, 4},
      {1, 2},
      {1, 5},
      {2, 3},
      {2, 6},
      {3, 7},
      {4, 5},
      {4, 7},
      {5, 6},
      {6, 7},
      {0, 3, 2, 1},
      {0, 1, 5, 4},
      {0, 4, 7, 3},
      {1, 2, 6, 5},
      {2, 3, 7, 6},
      {4, 5, 6, 7},
      {0, 1, 2, 3, 4, 5, 6, 7}}}};

/// A box of such cells with straight edges, in Gmsh's format 2.2.
std::string gmsh_text(const GmshCell& kind, const Body& body) {
  const CellBlock& block = body.blocks.front();
  const auto corners = static_cast<std::size_t>(block.kind->corners);
  std::ostringstream text;
  text.precision(17);
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << body.size() << "\n";
  for (int a = 0; a < body.size(); ++a) text << a + 1 << ' ' << body.rest.col(a).transpose() << "\n";
  text << "$EndNodes\n$Elements\n" << block.size() << "\n";
  for (int cell = 0; cell < block.size(); ++cell) {
    const auto nodes = block.cell(cell);
    text << cell + 1 << ' ' << kind.code << " 0";
    for (std::size_t a = 0; a < corners; ++a) text << ' ' << nodes[a] + 1;
    for (const auto& around : kind.middles) {
      Vector3 middle = Vector3::Zero();
      for (const int corner : around) middle += body.rest.col(nodes[corner]) / static_cast<double>(around.size());
      for (const int node : nodes)
        if ((body.rest.col(node) - middle).norm() < 1e-9) text << ' ' << node + 1;
    }
    text << "\n";
  }
  text << "$EndElements\n";
  return text.str();
}

double volume_of(const Mesh& mesh) {
  double sum = 0;
  for (const auto& cell : mesh.tetrahedra) sum += signed_volume(mesh.points, cell);
  return sum;
}

}  // namespace

TEST_CASE("Gmsh's cells of all shapes come in their own order", "[mesh_file]") {
  for (const GmshCell& kind : kGmshCells) {
    INFO(kind.shape);
    const Body body = cell_box(cell_kind(kind.shape), {2, 1, 2}, {0.02, 0.01, 0.03}, 0);
    const Mesh mesh = read("a.msh", gmsh_text(kind, body));
    REQUIRE(mesh.blocks.size() == 1);
    CHECK(mesh.blocks[0].kind->name == kind.shape);
    CHECK(mesh.blocks[0].nodes == body.blocks[0].nodes);
    CHECK(mesh.tetrahedra == body.tetrahedra);
    CHECK((mesh.points - body.rest).norm() < 1e-15);
  }
}

TEST_CASE("a mesh of second order that Gmsh wrote", "[mesh_file]") {
  const Mesh fine = load_mesh(ELASTIN_TEST_DATA "/mesh/data/gmsh_order_2.msh"),
             coarse = load_mesh(ELASTIN_TEST_DATA "/mesh/data/gmsh_22.msh");
  REQUIRE(fine.blocks.size() == 1);
  CHECK(fine.blocks[0].kind->name == "tetrahedron10");
  CHECK(volume_of(fine) == Approx(volume_of(coarse)).epsilon(1e-12));
  for (int cell = 0; cell < fine.blocks[0].size(); ++cell)  // straight edges: their nodes lie in the middle
    for (int a = 4; a < 10; ++a) {
      const auto nodes = fine.blocks[0].cell(cell);
      const auto [i, j] = fine.blocks[0].kind->edges[static_cast<std::size_t>(a) - 4];
      const Vector3 middle = (fine.points.col(nodes[i]) + fine.points.col(nodes[j])) / 2;
      CHECK((fine.points.col(nodes[a]) - middle).norm() < 1e-9);
    }
}

TEST_CASE("mirrored hexahedra are turned, folded ones refused", "[mesh_file]") {
  const std::string nodes =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n"
      "8 0 1 1\n$EndNodes\n$Elements\n1\n";
  const Mesh turned = read("a.msh", nodes + "1 5 0 5 6 7 8 1 2 3 4\n$EndElements\n");
  CHECK(volume_of(turned) == Approx(1));
  for (const auto& cell : turned.tetrahedra) CHECK(signed_volume(turned.points, cell) > 0);
  CHECK_THROWS_WITH(read("a.msh", nodes + "1 5 0 1 2 4 3 5 6 7 8\n$EndElements\n"),
                    Contains("a.msh:17:1: cell 1 is a flat or folded hexahedron8"));
}

TEST_CASE("Abaqus files: nodes and elements, lines that go on, what is wrong by its place", "[mesh_file]") {
  std::string text = "** made by hand\n*HEADING\na block\n*NODE, NSET=all\n";
  const Body body = cell_box(cell_kind("hexahedron20"), {1, 1, 1}, {1, 2, 3}, 0);
  std::ostringstream nodes;
  for (int a = 0; a < body.size(); ++a)
    nodes << 10 + a << ", " << body.rest(0, a) << "," << body.rest(1, a) << ", " << body.rest(2, a) << "\n";
  text += nodes.str() + "*Element, type=C3D20R, elset=e\n 1,";
  const auto cell = body.blocks[0].cell(0);
  for (std::size_t a = 0; a < 20; ++a)
    text += (a == 15 ? "\n" : " ") + std::to_string(10 + cell[a]) + (a == 19 ? "\n" : ",");
  const std::string whole = text + "*SOLID SECTION, ELSET=e\n1.\n";
  const Mesh mesh = read("a.inp", whole);
  REQUIRE(mesh.blocks.size() == 1);
  CHECK(mesh.blocks[0].nodes == body.blocks[0].nodes);
  CHECK(volume_of(mesh) == Approx(6));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string copy = whole;
    return copy.replace(copy.find(from), from.size(), to);
  };
  CHECK_THROWS_WITH(read("a.inp", changed("C3D20R", "C3D15")),
                    Contains("a.inp:25:16: element type 'C3D15' is not used"));
  CHECK_THROWS_WITH(read("a.inp", changed("10, 0,0, 0", "10, 0,zero, 0")),
                    Contains("a.inp:5:7: expected a coordinate, a finite number, found 'zero'"));
  CHECK_THROWS_WITH(read("a.inp", changed("*SOLID", "2, 10, 11\n*SOLID")),
                    Contains("cell 2 ends before its last point"));
  CHECK_THROWS_WITH(read("a.inp", changed("11, ", "10, ")), Contains("a.inp:6:1: node 10 stands here a second time"));
}

TEST_CASE("legacy VTK surfaces: POLYDATA of triangles", "[mesh_file]") {
  const std::string text =
      "# vtk DataFile Version 3.0\nsurface\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n"
      "POLYGONS 4 16\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  const Mesh mesh = read("a.vtk", text);
  CHECK(mesh.triangles.size() == 4);
  CHECK(mesh.blocks.empty());
  std::string quads = text;
  quads.replace(quads.find("POLYGONS 4 16\n3 0 2 1\n3 0 1 3\n"), 30, "POLYGONS 3 13\n4 0 2 1 3\n");
  CHECK_THROWS_WITH(read("a.vtk", quads), Contains("is a polygon"));
}
