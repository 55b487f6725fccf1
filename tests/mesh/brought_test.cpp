#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "elastin/core/base/error.h"
#include "elastin/core/geometry/cell_kind.h"
#include "elastin/core/model/surface.h"
#include "elastin/core/shapes/arrays.h"
#include "mesh/mesh_formats.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::mesh;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

std::string brought(const std::string& name) { return std::string(ELASTIN_TEST_DATA) + "/mesh/data/brought/" + name; }

std::size_t solids(const Mesh& mesh) {
  std::size_t count = mesh.blocks.empty() ? mesh.tetrahedra.size() : 0;
  for (const CellBlock& block : mesh.blocks) count += static_cast<std::size_t>(block.size());
  return count;
}

double volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& cell : mesh.tetrahedra) sum += signed_volume(mesh.points, cell);
  return sum;
}

Mesh inp(const std::string& text) { return format::read_mesh({"a.inp", text}); }

std::string answer(const format::File& file) {
  try {
    format::read_mesh(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

const std::string kNodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n";
const std::string kTissue = "*ELEMENT, TYPE=C3D4, ELSET=TISSUE\n7,1,2,3,4\n";
const std::string kPart = "*PART, NAME=P\n" + kNodes + kTissue + "*NSET, NSET=TOP\n4\n*END PART\n*ASSEMBLY, NAME=A\n";

}  // namespace

TEST_CASE("points at a seam are merged where that is requested", "[brought]") {
  Mesh mesh = load_mesh(brought("inp_seam.inp"));
  mesh.sets = {{"FACE", {1, 3, 5, 7, 8, 10, 12, 14}}};
  CHECK(join_points(mesh, 1e-9) == 4);
  CHECK(mesh.points.cols() == 12);
  CHECK(volume(mesh) == Approx(2).epsilon(1e-14));
  CHECK(mesh.sets.at("FACE") == std::vector<int>{1, 3, 5, 7});
  CHECK(mesh.blocks.at(0).nodes == std::vector<int>{0, 1, 3, 2, 4, 5, 7, 6, 1, 8, 9, 3, 5, 10, 11, 7});
  CHECK(join_points(mesh, 1e-9) == 0);
  CHECK_THROWS_WITH(join_points(mesh, 1.5), Contains("two corners of a cell"));
  // A chain of points, each near the next one alone.
  Mesh chain;
  chain.points.resize(3, 5);
  chain.points << 3, 0, 2, 1, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0;
  CHECK(join_points(chain, 1.1) == 3);
  CHECK(chain.points.row(0) == Eigen::RowVector2d(3, 9));
}

TEST_CASE("cells on both sides of a seam that is joined are cut along the same diagonals", "[brought]") {
  // Two cubes side by side; the numbers of the second one's points run the other way.
  TemporaryFolder folder;
  std::ostringstream text;
  text << "*NODE\n";
  const Positions cube = cell_kind("hexahedron8").reference;
  for (int i = 0; i < 8; ++i) text << i + 1 << "," << cube(0, i) << "," << cube(1, i) << "," << cube(2, i) << "\n";
  for (int i = 7; i >= 0; --i)
    text << 16 - i << "," << cube(0, i) + 2 << "," << cube(1, i) << "," << cube(2, i) << "\n";
  text << "*ELEMENT, TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n2,16,15,14,13,12,11,10,9\n";
  Mesh mesh = load_mesh(folder.write("seam.inp", text.str()));
  CHECK(join_points(mesh, 1e-9) == 4);
  CHECK(volume(mesh) == Approx(16).epsilon(1e-14));
  BodyArrays arrays;
  arrays.positions = mesh.points;
  arrays.tetrahedra = mesh.tetrahedra;
  CHECK(surface_of(make_body(arrays)).size() == 20);
}

TEST_CASE("meshes of other programs: cells, points, volume, sets and what is left out", "[brought]") {
  struct Expected {
    const char* file;
    std::size_t cells, points;
    double volume;
    std::map<std::string, std::size_t> sets;  ///< some of them, with how many points they have
    const char* comment = "";
  };
  // Bars of three unit cubes with 16 points, of two with 12.
  for (const Expected& expected : std::vector<Expected>{
           {"inp_elset_of_elsets.inp", 3, 16, 3, {{"FIRST", 8}, {"BOTH", 12}}},
           {"inp_fortran.inp", 3, 16, 3, {}},
           {"inp_input.inp", 3, 16, 3, {}},
           {"inp_instance_moved.inp", 3, 16, 3, {{"LEFT", 4}, {"RIGHT", 4}}},
           {"inp_instance_twice.inp", 6, 32, 6, {{"LEFT", 4}, {"RIGHT", 4}}},
           {"inp_keyword_continued.inp", 3, 16, 3, {{"BAR", 16}, {"LEFT", 4}, {"NALL", 16}}},
           {"inp_left_out_zero.inp", 2, 12, 2, {{"ALL", 12}}},
           {"inp_names.inp", 3, 16, 3, {{"soft tissue", 16}, {"left end", 4}, {"Right-End", 4}}},
           {"inp_network.inp", 3, 16, 3, {{"PIPE", 2}, {"WALL", 16}}, "2 D elements and 1 unused point left out"},
           {"inp_rigid_plate.inp", 3, 16, 3, {{"LEFT", 4}}, "1 R3D4 element and 4 unused points left out"},
           {"inp_set_first.inp", 3, 16, 3, {{"LEFT", 4}}},
           {"inp_set_of_sets.inp", 3, 16, 3, {{"LEFT", 4}, {"LEFT_MIXED", 3}}},
           {"inp_shell_skin.inp", 3, 16, 3, {{"SKIN", 6}}, "2 M3D4R elements left out"},
           {"inp_springs.inp", 2, 12, 2, {{"THREADS", 2}}, "1 MASS element and 1 SPRINGA element left out"},
           {"inp_two_parts.inp", 6, 32, 6, {}},
           {"msh_groups_without_names.msh", 3, 16, 3, {{"3", 16}}},
           {"msh_hexa_with_end_faces.msh", 3, 16, 3, {{"left", 4}, {"right", 4}}, "2 quadrangles left out"},
           {"msh_version_2.msh", 3, 16, 3, {{"bar", 16}}},
           {"msh_first_names_of_2.msh", 3, 16, 3, {{"bar", 16}, {"left", 4}}, "1 quadrangle left out"},
           {"bdf_systems.bdf", 3, 16, 3, {{"4", 16}}},
           {"bdf_include_tabs.bdf", 3, 16, 3, {{"4", 16}, {"5", 4}}, "1 quadrangle left out"},
           {"vtk_of_xml.vtk", 3, 16, 3, {}},
           {"unv_groups.unv", 2, 5, 0.5, {{"BASE", 3}}},
           {"vtk_hexa_with_end_face.vtk", 3, 16, 3, {}, "1 quadrangle left out"},
           {"vtk_voxels.vtk", 3, 16, 3, {}},
           {"vtu_lagrange_hexahedra.vtu", 2, 12, 2, {}}}) {
    INFO(expected.file);
    const Mesh mesh = load_mesh(brought(expected.file));
    CHECK(solids(mesh) == expected.cells);
    CHECK(mesh.points.cols() == static_cast<Eigen::Index>(expected.points));
    CHECK(volume(mesh) == Approx(expected.volume).epsilon(1e-12));
    for (const auto& [name, size] : expected.sets) {
      INFO(name);
      REQUIRE(mesh.sets.contains(name));
      CHECK(mesh.sets.at(name).size() == size);
    }
    CHECK(mesh.comment == expected.comment);
  }
  CHECK(load_mesh(brought("inp_instance_moved.inp")).points.row(0).minCoeff() == 10);
  CHECK(load_mesh(brought("inp_instance_twice.inp")).points.row(0).maxCoeff() == 6);
  CHECK(load_mesh(brought("inp_two_parts.inp")).points.row(2).maxCoeff() == 2);
  CHECK_THROWS_WITH(load_mesh(brought("inp_elgen.inp")), Contains("inp_elgen.inp:20:1: *ELGEN is not read"));
  CHECK_THROWS_WITH(load_mesh(brought("vtu_lagrange_tetrahedra.vtu")),  // its third cell lies in a plane
                    Contains("vtu_lagrange_tetrahedra.vtu:5:83: cell 2 (counted from 0) is a flat tetrahedron"));
}

TEST_CASE("surfaces of other programs: what they enclose", "[brought]") {
  struct Expected {
    const char* file;
    std::size_t triangles;
    double volume;  ///< [mm³]
  };
  for (const Expected& expected : std::vector<Expected>{{"surf_quads.off", 12, 1000},
                                                        {"surf_no_texture.obj", 12, 1000},
                                                        {"surf_strips.ply", 12, 1000},
                                                        {"surf_concave.obj", 20, 750}}) {
    INFO(expected.file);
    const Mesh mesh = load_mesh(brought(expected.file));
    CHECK(mesh.triangles.size() == expected.triangles);
    double sum = 0, area = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vector3 from = mesh.points.col(a), normal = (mesh.points.col(b) - from).cross(mesh.points.col(c) - from);
      sum += from.dot(normal) / 6, area += normal.norm() / 2;
    }
    CHECK(sum == Approx(expected.volume).epsilon(1e-12));
    CHECK(area == Approx(expected.volume == 1000 ? 600 : 2 * 75 + 40 * 10).epsilon(1e-12));  // no triangle overlaps
  }
}

TEST_CASE("Nastran files: what is included, and where it is wrong", "[brought]") {
  const TemporaryFolder folder;
  folder.write("nodes.inc", "GRID,1,,0.,0.,x\n");
  const auto refusal = [&](const std::string& text) -> std::string {
    try {
      load_mesh(folder.write("a.bdf", text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  CHECK_THAT(refusal("INCLUDE 'nodes.inc'\n"), Contains("nodes.inc:1:15: expected a coordinate"));
  CHECK_THAT(refusal("$ nothing\ninclude no.inc\n"), Contains("a.bdf:2:9: ") && Contains("no.inc: cannot open"));
  CHECK_THAT(refusal("include 'a.bdf'\n"), Contains("do they include each other?"));
  CHECK_THAT(refusal("GRID\n"), Contains("a.bdf:1:1: GRID: expected a node's number"));
  // A node without coordinates stands at the origin.
  const std::string cell = "GRID,2,,1.\nGRID,3,,,1.\nGRID,4,,,,1.\nCTETRA,9,1,1,2,3,4\n";
  CHECK(volume(load_mesh(folder.write("b.bdf", "GRID,1\n" + cell))) == Approx(1 / 6.));
}

TEST_CASE("Nastran files: nodes in coordinate systems of their own", "[brought]") {
  // System 7 turns x to y to z to x, about (1, 2, 3); 8 is a cylinder in it, 9 a sphere in the basic system.
  const std::string systems =
      "CORD2C,8,7,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\nCORD2R,7,,1.,2.,3.,2.,2.,3.,\n,1.,3.,3.\n"
      "CORD2S,9,0,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\n";
  const std::string cell = "CTETRA,9,5,1,2,3,4\n";
  const auto points = [&](const std::string& nodes) {
    return format::read_mesh({"a.bdf", nodes + systems + cell}).points;
  };
  const Positions found = points("GRID,1,7,1.,0.,0.\nGRID,2,8,2.,90.,5.\nGRID,3,9,3.,90.,30.\nGRID,4,0,0.,0.,1.\n");
  const double half = std::sqrt(3.) / 2;
  CHECK((found - (Positions(3, 4) << 1, 6, 3 * half, 0, 3, 2, 1.5, 0, 3, 5, 0, 1).finished()).norm() < 1e-12);
  CHECK((points("GRDSET,,7\nGRID,1,0,0.\nGRID,2,,1.,0.,0.\nGRID,3\nGRID,4,0,0.,0.,1.\n").col(1) - Vector3(1, 3, 3))
            .norm() < 1e-12);
  const auto refused = [&](const std::string& text) { return answer({"a.bdf", text + "GRID,1,3,0.,0.,0.\n" + cell}); };
  CHECK_THAT(refused(""), StartsWith("a.bdf:1:8: there is no coordinate system '3'"));
  CHECK_THAT(refused("CORD1R,3,1,2,3\n"), StartsWith("a.bdf:1:1: CORD1R is not read; allowed: CORD2R"));
  CHECK_THAT(refused("CORD2R,3,3,0.,0.,0.,0.,0.,1.,\n,1.\n"), StartsWith("a.bdf:1:1: coordinate systems refer"));
  CHECK_THAT(refused("CORD2R,3,,0.,0.,0.,0.,0.,1.,\n,0.,0.,4.\n"), Contains("its three points lie on a line"));
}

TEST_CASE("Abaqus files: instances are displaced and turned, and have sets of their own", "[brought]") {
  const Mesh turned = inp(kPart + "*INSTANCE, NAME=I, PART=p\n1, 2, 3\n1, 2, 3, 1, 2, 4, 90\n*END INSTANCE\n");
  CHECK((turned.points - (Positions(3, 4) << 1, 1, 0, 1, 2, 3, 2, 2, 3, 3, 3, 4).finished()).norm() < 1e-12);
  const Mesh two = inp(kPart +
                       "*INSTANCE, NAME=I-1, PART=P\n*END INSTANCE\n*INSTANCE, NAME=I-2, PART=P\n,,5\n*END INSTANCE\n"
                       "*NSET, NSET=ENDS\nI-1.1, I-2.TOP\n*NSET, NSET=SECOND, INSTANCE=i-2\nTOP, 1\n*END ASSEMBLY\n");
  CHECK(two.sets.at("I-2.TOP") == std::vector{7});
  CHECK_FALSE(two.sets.contains("TOP"));  // it could be either
  CHECK(two.sets.at("ENDS") == std::vector{0, 7});
  CHECK(two.sets.at("SECOND") == std::vector{4, 7});
  CHECK(two.points.col(4) == Vector3(0, 0, 5));
}

TEST_CASE("Abaqus files: what a solid stands next to is named, what would change the mesh is refused", "[brought]") {
  const std::string whole = kNodes + kTissue;
  CHECK(inp("*HEADING\na bar\n" + whole + "*TIE, NAME=T\nA, B\n*MATERIAL, NAME=M\n*ELASTIC\n1, 0.3\n*STEP\n*STATIC\n")
            .comment == "the keywords *TIE, *MATERIAL, *ELASTIC and *STEP left out");
  CHECK(inp(whole + "*NSET, NSET=A, GENERATE\n1, 9, 4\n").comment == "2 missing set members left out");
  CHECK(inp(whole + "*NSET, NSET=\"left, face\"\n1, 2\n").sets.at("left, face") == std::vector{0, 1});
  const Mesh round = inp("*NODE, SYSTEM=C\n1,0,0,0\n2,2,0,0\n3,2,90,0\n4,0,0,1\n" + kTissue);
  CHECK((round.points.col(2) - Vector3(0, 2, 0)).norm() < 1e-15);
  CHECK(inp(whole + "*ELSET, ELSET=E\n7\n*NSET, NSET=N, ELSET=E\n").sets.at("N").size() == 4);
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"*NODE\n1,0,0,0\n*NGEN\n1,3\n", "a.inp:3:1: *NGEN is not read: it makes nodes; write the mesh out in full"},
           {whole + "*N COPY, CHANGE NUMBER=4\n", "a.inp:8:1: *NCOPY is not read: it copies nodes"},
           {"*NODE, SYSTEM=S\n", "a.inp:1:1: *NODE: SYSTEM=S is not read; allowed: R"},
           {kNodes + "*ELEMENT, TYPE=S4R\n1,1,2,3,4\n", "a.inp:6:16: element type 'S4R' is used next to the cells of"},
           {kNodes + "*ELEMENT, TYPE=C3D15\n", "a.inp:6:16: element type 'C3D15' is not used; allowed: C3D4"},
           {kNodes + "*ELEMENT, TYPE=C3D4\n7,1,2,\n3,5\n", "a.inp:8:3: cell 7 uses node 5, which *NODE does not have"},
           {whole + "7,1,2,3,4\n", "a.inp:8:1: element 7 stands here a second time"},
           {whole + "*ELSET, ELSET=E\nTISUE\n", "a.inp:9:1: there is no set 'TISUE'; did you mean 'TISSUE'?"},
           {whole + "*NSET, NSET=E\nE\n", "a.inp:9:1: sets contain each other"},
           {whole + "*INCLUDE, INPUT=no.txt\n", "a.inp:8:17: no.txt: cannot open"},
           {kPart + "*INSTANCE, NAME=I, PART=Q\n", "a.inp:13:25: there is no *PART 'Q' before this; allowed: P"},
           {"*ELEMENT\n", "a.inp:1:1: *ELEMENT: expected TYPE=…"}}) {
    INFO(text);
    CHECK_THAT(answer({"a.inp", text}), StartsWith(message));
  }
  const TemporaryFolder folder;
  std::ofstream(folder.path("a.inp")) << kNodes << "*INCLUDE, INPUT=\"b.txt\"\n";
  std::ofstream(folder.path("b.txt")) << "*INCLUDE, INPUT=b.txt\n";
  CHECK_THROWS_WITH(load_mesh(folder.path("a.inp")), Contains("do they include each other?"));
  std::ofstream(folder.path("b.txt")) << "5,0,0,x\n";
  CHECK_THROWS_WITH(load_mesh(folder.path("a.inp")), Contains("b.txt:1:7: expected a coordinate"));
}

TEST_CASE("VTK: Lagrange hexahedra of second order in the order of VTK 9 and the one before", "[brought]") {
  const CellKind& kind = cell_kind("hexahedron27");
  for (const bool before_9 : {false, true}) {
    std::ostringstream text;
    text << "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 27 double\n";
    for (int a = 0; a < 27; ++a) text << kind.reference.col(a).transpose() << "\n";
    text << "CELLS 1 28\n27";
    for (int a = 0; a < 27; ++a) text << " " << (before_9 && a == 18 ? 19 : before_9 && a == 19 ? 18 : a);
    const Mesh mesh = format::read_mesh({"a.vtk", text.str() + "\nCELL_TYPES 1\n72\n"});
    REQUIRE(mesh.blocks.size() == 1);
    CHECK(mesh.points == kind.reference);
    for (int a = 0; a < 27; ++a) CHECK(mesh.blocks[0].nodes[a] == a);
    CHECK_THAT(answer({"a.vtk", text.str() + "\nCELL_TYPES 1\n71\n"}), Contains("Lagrange tetrahedron of an order"));
  }
  const Mesh tetrahedron = format::read_mesh(
      {"a.vtk",
       "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 "
       "0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n71\n"});
  CHECK(tetrahedron.tetrahedra == Cells<4>{{0, 1, 2, 3}});
}

TEST_CASE("groups without names go by their numbers", "[brought]") {
  const std::string nodes = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";
  const Mesh mesh = format::read_mesh({"a.msh", "$MeshFormat\n2.1 0 8\n$EndMeshFormat\n" + nodes +
                                                    "$Elements\n4\n1 2 2 1 1 1 2 3\n2 4 2 1 1 1 2 3 4\n"
                                                    "3 2 2 8 1 1 2 4\n4 2 2 0 1 1 3 4\n$EndElements\n"});
  CHECK(mesh.sets.at("surface 1").size() == 3);
  CHECK(mesh.sets.at("volume 1").size() == 4);
  CHECK(mesh.sets.at("8") == std::vector{0, 1, 3});
  CHECK(mesh.sets.size() == 3);
  const std::string grid = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n";
  const Mesh nastran = format::read_mesh({"a.bdf", grid + "CTETRA,9,5,1,2,3,4\nCQUAD4,10,6,1,2,3,4\nRBE2,11,1,123,2,"
                                                          "3\nCBAR,12,7,1,2\nCWELD,13,7,1,,2\nCSET1,123,1,2,3,4\n"});
  CHECK(nastran.sets.at("5").size() == 4);
  CHECK(nastran.comment == "1 CBAR, 1 CWELD, 1 RBE2 and 1 quadrangle left out");
}

// The parts of a mesh that is divided, with the ghost of one, as Gmsh 4.11 writes them.
TEST_CASE("Gmsh: the parts of a divided mesh are in the groups of what they are parts of", "[brought]") {
  const Mesh mesh = format::read_mesh(
      {"a.msh",
       "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"LEFT\"\n3 2 \"SOFT\"\n$EndPhysicalNames\n"
       "$Entities\n0 0 1 1\n1 0 0 0 1 1 1 1 1 0\n1 0 0 0 1 1 1 1 2 1 1\n$EndEntities\n"
       "$PartitionedEntities\n2\n1\n9 1\n0 0 1 1\n7 2 1 2 1 2 0 0 0 1 1 1 1 1 0\n8 3 1 1 1 0 0 0 1 1 1 1 2 1 7\n"
       "$EndPartitionedEntities\n$Nodes\n1 4 1 4\n3 8 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n"
       "$Elements\n2 2 1 2\n2 7 2 1\n1 1 2 3\n3 8 4 1\n2 1 2 3 4\n$EndElements\n"});
  CHECK(mesh.sets.at("LEFT") == std::vector{0, 1, 2});
  CHECK(mesh.sets.at("SOFT").size() == 4);
}

TEST_CASE("more faces than a file of triangles announces are none that it can lose", "[brought]") {
  const std::string off = "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 1 2 3\n";
  CHECK(format::read_mesh({"a.off", off + "# the end\n\n"}).triangles.size() == 3);
  CHECK_THAT(answer({"a.off", off + "3 0 2 3\n"}), StartsWith("a.off:10:1: expected no more faces here"));
  std::string stl(84, ' ');
  stl.replace(80, 4, std::string("\1\0\0\0", 4));
  const float corners[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::string one = std::string(reinterpret_cast<const char*>(corners), sizeof corners) + std::string(2, '\0');
  CHECK(format::read_mesh({"a.stl", stl + one + "\n"}).triangles.size() == 1);
  CHECK_THAT(answer({"a.stl", stl + one + one}), Contains("but there are 1 more than 1"));
}

TEST_CASE("files that are not read are answered by the command that converts them", "[brought]") {
  CHECK_THROWS_WITH(load_mesh("out/liver.xdmf"),
                    "out/liver.xdmf: .xdmf files are not read; convert it: "
                    "meshio convert out/liver.xdmf out/liver.vtu");
  CHECK_THROWS_WITH(load_mesh("liver.MED"), Contains("gmsh -save -o liver.msh liver.MED"));
  CHECK_THROWS_WITH(load_mesh("liver.feb"), Contains("elastin export liver.feb --to gmsh --out liver.msh"));
}

TEST_CASE("a cell that stands twice is one, in the sets of both", "[brought]") {
  const std::string four = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
  const std::string msh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n" + four + "$EndNodes\n$Elements\n";
  const Mesh groups =
      format::read_mesh({"a.msh", msh + "3\n1 4 2 1 1 1 2 3 4\n2 4 2 2 1 1 2 3 4\n3 4 2 3 1 2 3 1 4\n$EndElements\n"});
  CHECK(groups.tetrahedra.size() == 1);
  for (const char* name : {"1", "2", "3"}) CHECK(groups.sets.at(name).size() == 4);
  CHECK(groups.repairs == std::vector<std::string>{"2 cells that stood twice dropped"});
  // Of triangles alone those that look the other way stay: surfaces that touch have them.
  const Mesh triangles =
      format::read_mesh({"a.msh", msh + "3\n1 2 2 1 1 1 2 3\n2 2 2 2 1 2 3 1\n3 2 2 2 1 1 3 2\n$EndElements\n"});
  CHECK(triangles.triangles.size() == 2);
  const Mesh nastran = format::read_mesh({"a.bdf",
                                          "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n"
                                          "CTETRA,9,5,1,2,3,4\nCTETRA,10,6,1,2,3,4\n"});
  CHECK(nastran.tetrahedra.size() == 1);
  CHECK(nastran.sets.at("6").size() == 4);
  const Mesh cubes =
      inp("*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n"
          "*ELEMENT, TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n2,1,2,3,4,5,6,7,8\n");
  CHECK(cubes.blocks.at(0).size() == 1);
  CHECK(volume(cubes) == Approx(1));
}

TEST_CASE("a byte order mark counts for nothing", "[brought]") {
  const TemporaryFolder folder;
  const std::string data = std::string(ELASTIN_TEST_DATA) + "/mesh/data/";
  for (const std::string name : {"gmsh_41.msh", "gmsh.bdf", "gmsh.unv", "meshio_42.vtk", "meshio_51_binary.vtk",
                                 "vtk_ascii.vtu", "brought/inp_fortran.inp"}) {
    INFO(name);
    std::stringstream text;
    text << "\xEF\xBB\xBF" << std::ifstream(data + name).rdbuf();
    const Mesh plain = load_mesh(data + name),
               marked = load_mesh(folder.write(name.substr(name.rfind('/') + 1), text.str()));
    CHECK(marked.points == plain.points);
    CHECK(solids(marked) == solids(plain));
  }
  // In a file that is included, too.
  folder.write("nodes.inc", "\xEF\xBB\xBF*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n");
  CHECK(solids(load_mesh(folder.write("a.inp", "*INCLUDE, INPUT=nodes.inc\n" + kTissue))) == 1);
}
