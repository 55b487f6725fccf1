#include "elastin/mesh/mesh_file.h"

#include <sys/stat.h>

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <sstream>

#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"
#include "mesh/mesh_formats.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::mesh;
using format::File;
using format::load_file;
using format::read_mesh;

namespace {

/// One box of 6 tetrahedra, 1 × 2 × 0.5, by writers that are not ours: see data/make_fixtures.py.
const std::vector<std::string> fixtures = {"gmsh_22.msh",
                                           "gmsh_22_binary.msh",
                                           "gmsh_41.msh",
                                           "gmsh_41_binary.msh",
                                           "gmsh_20.vtk",
                                           "gmsh_20_binary.vtk",
                                           "meshio_42.vtk",
                                           "meshio_42_binary.vtk",
                                           "meshio_51.vtk",
                                           "meshio_51_binary.vtk",
                                           "vtk_51.vtk",
                                           "vtk_51_binary.vtk",
                                           "meshio_ascii.vtu",
                                           "meshio_base64.vtu",
                                           "meshio_zlib.vtu",
                                           "vtk_ascii.vtu",
                                           "vtk_binary.vtu",
                                           "vtk_binary_zlib.vtu",
                                           "vtk_appended_raw.vtu",
                                           "vtk_appended_raw_zlib.vtu",
                                           "vtk_appended_base64.vtu",
                                           "vtk_appended_base64_zlib.vtu"};

std::string fixture_path(const std::string& name) { return std::string(ELASTIN_TEST_DATA) + "/mesh/data/" + name; }

File fixture(const std::string& name) { return {name, load_file(fixture_path(name)).bytes}; }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

/// What the message says, or "" where the file loads.
std::string message_of(const File& file) {
  try {
    read_mesh(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool same(const Mesh& a, const Mesh& b) {
  return a.points.cols() == b.points.cols() && a.points == b.points && a.triangles == b.triangles &&
         a.tetrahedra == b.tetrahedra && a.comment == b.comment;
}

/// What every mesh that loads may be trusted for.
bool sound(const Mesh& mesh) {
  std::vector<bool> used(static_cast<std::size_t>(mesh.points.cols()), false);
  const auto use = [&](int point) {
    if (point < 0 || point >= mesh.points.cols()) return false;
    used[point] = true;
    return true;
  };
  for (const auto& cell : mesh.tetrahedra)
    if (!std::all_of(cell.begin(), cell.end(), use) || !(signed_volume(mesh.points, cell) > 0)) return false;
  for (const auto& cell : mesh.triangles)
    if (!std::all_of(cell.begin(), cell.end(), use)) return false;
  return mesh.points.allFinite() && mesh.tetrahedra.empty() != mesh.triangles.empty() &&
         std::count(used.begin(), used.end(), false) == 0;
}

// One tetrahedron of volume 1/6, small enough to see which line and column a message means.
const std::string one_22 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
    "$Elements\n1\n7 4 2 1 1 1 2 3 4\n$EndElements\n";
const std::string one_41 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    "$EndNodes\n$Elements\n1 1 7 7\n3 1 4 1\n7 1 2 3 4\n$EndElements\n";
const std::string one_30 =
    "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0  1 0 0\n0 1 0  0 0 1\n"
    "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n";
const std::string one_51 =
    "# vtk DataFile Version 5.1\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0  1 0 0\n0 1 0  0 0 1\n"
    "CELLS 2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\nCELL_TYPES 1\n10\n";
const std::string piece =
    "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\n<Points>\n<DataArray type=\"Float64\" "
    "NumberOfComponents=\"3\" format=\"ascii\">\n0 0 0 1 0 0\n0 1 0 0 0 1\n</DataArray>\n</Points>\n<Cells>\n"
    "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n0 1 2 3\n</DataArray>\n"
    "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n4\n</DataArray>\n"
    "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n10\n</DataArray>\n</Cells>\n</Piece>\n";
const std::string vtu_begin =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
    "<UnstructuredGrid>\n";
const std::string vtu_end = "</UnstructuredGrid>\n</VTKFile>\n";
const std::string one_vtu = vtu_begin + piece + vtu_end;

template <class T>
void put(std::string& bytes, std::endian order, std::initializer_list<T> values) {
  for (const T value : values) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (order != std::endian::native) std::reverse(raw, raw + sizeof(T));
    bytes.append(raw, sizeof(T));
  }
}

std::string binary_22(std::endian order) {
  std::string bytes = "$MeshFormat\n2.2 1 8\n";
  put<int>(bytes, order, {1});
  bytes += "\n$EndMeshFormat\n$Nodes\n4\n";
  for (int point = 0; point < 4; ++point) {
    put<int>(bytes, order, {point + 1});
    put<double>(bytes, order, {point == 1 ? 1. : 0., point == 2 ? 1. : 0., point == 3 ? 1. : 0.});
  }
  bytes += "\n$EndNodes\n$Elements\n1\n";
  put<int>(bytes, order, {4, 1, 2, 7, 1, 1, 1, 2, 3, 4});
  return bytes + "\n$EndElements\n";
}

std::string binary_41(std::endian order) {
  std::string bytes = "$MeshFormat\n4.1 1 8\n";
  put<int>(bytes, order, {1});
  bytes += "\n$EndMeshFormat\n$Nodes\n";
  put<std::uint64_t>(bytes, order, {1, 4, 1, 4});
  put<int>(bytes, order, {3, 1, 0});
  put<std::uint64_t>(bytes, order, {4, 1, 2, 3, 4});
  put<double>(bytes, order, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  bytes += "\n$EndNodes\n$Elements\n";
  put<std::uint64_t>(bytes, order, {1, 1, 7, 7});
  put<int>(bytes, order, {3, 1, 4});
  put<std::uint64_t>(bytes, order, {1, 7, 1, 2, 3, 4});
  return bytes + "\n$EndElements\n";
}

struct WrongFile {
  std::string name, bytes, message;  // the message's beginning
};

void check_messages(const std::vector<WrongFile>& cases) {
  for (const WrongFile& wrong : cases) {
    const std::string message = message_of({wrong.name, wrong.bytes});
    CHECK_THAT(message, Catch::Matchers::StartsWith(wrong.message));
  }
}

}  // namespace

TEST_CASE("every format and encoding gives the same box", "[mesh_file]") {
  const Mesh box = load_mesh(fixture_path("gmsh_41.msh"));
  REQUIRE(box.points.cols() == 8);
  REQUIRE(box.tetrahedra.size() == 6);
  REQUIRE(box.triangles.empty());
  REQUIRE(box.points.rowwise().maxCoeff() == Vector3(1, 2, 0.5));
  REQUIRE(box.points.rowwise().minCoeff() == Vector3(0, 0, 0));
  REQUIRE(box.comment == "12 lines, 8 points and 12 triangles left out");
  double volume = 0;
  for (const auto& cell : box.tetrahedra) volume += signed_volume(box.points, cell);
  REQUIRE(std::abs(volume - 1) < 1e-15);  // six rounded sixths
  REQUIRE(sound(box));
  for (const std::string& name : fixtures) {
    INFO(name);
    CHECK(same(load_mesh(fixture_path(name)), box));
  }
}

TEST_CASE("Gmsh 1, Nastran and I-DEAS files that Gmsh wrote give the same box", "[mesh_file]") {
  const auto sorted = [](Cells<4> cells) {
    for (auto& cell : cells) std::sort(cell.begin(), cell.end());
    std::sort(cells.begin(), cells.end());
    return cells;
  };
  const Mesh box = load_mesh(fixture_path("gmsh_41.msh"));
  for (const std::string name : {"gmsh_1.msh", "gmsh.bdf", "gmsh.unv"}) {
    INFO(name);
    const Mesh mesh = load_mesh(fixture_path(name));
    CHECK(mesh.points == box.points);
    CHECK(sorted(mesh.tetrahedra) == sorted(box.tetrahedra));
    CHECK(sound(mesh));
  }
  for (const std::string name : {"gmsh_order_2.bdf", "gmsh_order_2.unv"}) {
    INFO(name);
    const Mesh mesh = load_mesh(fixture_path(name));
    REQUIRE(mesh.blocks.size() == 1);
    const CellBlock& block = mesh.blocks[0];
    REQUIRE(block.kind->name == "tetrahedron10");
    REQUIRE(block.size() == 6);
    for (int cell = 0; cell < block.size(); ++cell)  // straight edges: their nodes lie in the middle
      for (std::size_t edge = 0; edge < 6; ++edge) {
        const auto nodes = block.cell(cell);
        const auto [i, j] = block.kind->edges[edge];
        const Vector3 ends = mesh.points.col(nodes[i]) + mesh.points.col(nodes[j]);
        CHECK((2 * mesh.points.col(nodes[edge + 4]) - ends).norm() < 1e-9);
      }
  }
}

TEST_CASE("named groups of Gmsh and Abaqus are sets of points", "[mesh_file]") {
  for (const std::string name : {"gmsh_groups_22.msh", "gmsh_groups_41.msh", "gmsh_groups_41_binary.msh"}) {
    INFO(name);
    const Mesh mesh = load_mesh(fixture_path(name));
    REQUIRE(mesh.sets.size() == 3);
    CHECK(mesh.sets.at("whole body").size() == 8);
    const std::vector<int>& base = mesh.sets.at("base");
    REQUIRE(base.size() == 4);
    for (const int point : base) CHECK(mesh.points(2, point) == 0);
    REQUIRE(mesh.sets.at("corner").size() == 1);
    CHECK(mesh.points.col(mesh.sets.at("corner")[0]) == Vector3(0, 0, 0));
  }
  const Mesh inp =
      read_mesh({"a.inp",
                 "*NODE, NSET=ALL\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT, TYPE=C3D4, ELSET=BODY\n"
                 "7,1,2,3,4\n*NSET, NSET=BASE, GENERATE\n1, 3, 1\n*NSET, NSET=TOP\n4,\n*ELSET, ELSET=E\n7\n"});
  CHECK(inp.sets.at("BASE") == std::vector{0, 1, 2});
  CHECK(inp.sets.at("TOP") == std::vector{3});
  for (const char* all : {"ALL", "BODY", "E"}) CHECK(inp.sets.at(all) == std::vector{0, 1, 2, 3});
}

TEST_CASE("Nastran files in free, small and large fields", "[mesh_file]") {
  const Mesh small =
      read_mesh({"a.bdf",
                 "SOL 101\nCEND\nBEGIN BULK\n$ a comment\nGRID    1               0.0     0.0     0.0\n"
                 "GRID    2               1.5+0   0.0     0.0\nGRID    3               0.0     2.-0    0.0\n"
                 "GRID    4               0.0     0.0     3.D0\nCTETRA  9       1       1       2       3       "
                 "4\nENDDATA\n"});
  const Mesh free = read_mesh({"a.bdf",
                               "GRID,1,,0.,0.,0.\nGRID,2,,1.5,0.,0.\nGRID,3,,0.,2.,0.\nGRID,4,,0.,0.,3.\n"
                               "CTETRA,9,1,1,2,3,4\n"});
  const Mesh large = read_mesh({"a.nas",
                                "GRID*                  1                              0.              0.*\n"
                                "*                     0.\nGRID,2,,1.5,0.,0.\nGRID,3,,0.,2.,0.\nGRID,4,,0.,0.,3.\n"
                                "CTETRA,9,1,1,2,3\n,4\n"});
  const Mesh free_large = read_mesh({"a.nas",
                                     "GRID*,1,,0.,0.,*A\n*A,0.\nGRID*,2,,1.5,0.,*\n*,0.\nGRID,3,,0.,2.,0.\n"
                                     "GRID*,4,,0.,0.\n*,3.\nCTETRA*,9,1,1,2,*B\n*B,3,4\n"});
  for (const Mesh* mesh : {&small, &free, &large, &free_large}) {
    REQUIRE(mesh->tetrahedra.size() == 1);
    CHECK(signed_volume(mesh->points, mesh->tetrahedra[0]) == Approx(1.5));
  }
}

TEST_CASE("Nastran and I-DEAS files: what is wrong is reported by line and column", "[mesh_file]") {
  const std::string nodes = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n";
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {nodes + "CTETRA,9,1,1,2,3,5\n", "a.bdf:5:18: cell 9 uses node 5, which no GRID has"},
           {nodes + "CTETRA,9,1,1,2,3\n", "a.bdf:5:8: CTETRA: expected 4 or 10 nodes, found 3"},
           {nodes + "CQUAD4,9,1,1,2,3,4\n", "a.bdf:5:8: CQUAD4 is not used; allowed: CTETRA"},
           {nodes + "CPYRA,9,1,1,2,3,4\n", "a.bdf:5:1: CPYRA is not used; allowed: CTETRA"},
           {nodes + "CTETRA,9,1,1,2,3,4\nCHEXX,10,1,1,2,3,4\n", "a.bdf:6:1: CHEXX is not used; allowed: CTETRA"},
           {nodes + "CTETRA,9,1,1,2,3,4,1,2\n,3,4,1,2,4,3,2,1\n",
            "a.bdf:6:10: cell 9: behind the 10 nodes of its CTETRA stand more: is the line of the next one missing?"},
           {nodes + "GRID,4,,0.,0.,2.\n", "a.bdf:5:6: node 4 stands here a second time"},
           {"GRID,1,,O.,0.,0.\n", "a.bdf:1:9: expected a coordinate, a finite number, found 'O.'"},
           {"GRID,1,3,0.,0.,0.\n", "a.bdf:1:8: there is no coordinate system '3'"},
           {nodes, "a.bdf: no triangles and no cells of a solid; it has 4 points"}}) {
    INFO(text);
    CHECK_THAT(message_of({"a.bdf", text}), Catch::Matchers::StartsWith(message));
  }
  const std::string points =
      "    -1\n  2411\n1 1 1 11\n0 0 0\n2 1 1 11\n1.D+00 0 0\n3 1 1 11\n0 1 0\n4 1 1 11\n0 0 1\n    -1\n";
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {points + "    -1\n  2412\n7 111 1 1 7 4\n1 2 3 5\n    -1\n",
            "a.unv:15:7: cell 7 uses node 5, which no dataset before has"},
           {points + "    -1\n  2412\n7 94 1 1 7 4\n1 2 3 4\n    -1\n",
            "a.unv:14:1: cell 7 is of descriptor 94; allowed: "},
           {points + "    -1\n  2412\n7 111 1 1 7 3\n1 2 3\n    -1\n",
            "a.unv:14:1: a tetrahedron has 4 nodes, and this one 3"},
           {points + "    -1\n  2412\n7 111 1 1 7 4\n1 2 3 4\n", "a.unv:15:8: expected -1, which ends a dataset"},
           {"2411\n", "a.unv:1:1: expected -1, which begins a dataset"}}) {
    INFO(text);
    CHECK_THAT(message_of({"a.unv", text}), Catch::Matchers::StartsWith(message));
  }
  CHECK(read_mesh({"a.unv",
                   points + "    -1\n   164\n 1 any words\n    -1\n    -1\n  2412\n7 111 1 1 7 4\n1 2 3 4\n    -1\n"})
            .tetrahedra.size() == 1);
}

TEST_CASE("one tetrahedron in every dialect gives the same mesh", "[mesh_file]") {
  const Mesh one = read_mesh({"one.msh", one_41});
  REQUIRE(one.points == (Positions(3, 4) << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1).finished());
  REQUIRE(one.tetrahedra == Cells<4>{{0, 1, 2, 3}});
  REQUIRE(one.comment.empty());
  const std::string parametric = replaced(one_41, "3 1 0 4", "2 1 1 4");
  const std::vector<File> files = {
      {"one.msh", one_22},
      {"binary little.msh", binary_22(std::endian::little)},
      {"binary big.msh", binary_22(std::endian::big)},
      {"binary little 4.msh", binary_41(std::endian::little)},
      {"binary big 4.msh", binary_41(std::endian::big)},
      {"parametric.msh",
       replaced(parametric, "0 0 0\n1 0 0\n0 1 0\n0 0 1\n", "0 0 0 .1 .2\n1 0 0 .1 .2\n0 1 0 .1 .2\n0 0 1 .1 .2\n")},
      {"other sections.msh",
       replaced(one_22, "$Nodes", "$PhysicalNames\n1\n3 1 \"tissue\"\n$EndPhysicalNames\n$Nodes")},
      {"DOS ends.MSH",
       [] {
         std::string text;
         for (const char letter : one_41) text += letter == '\n' ? std::string("\r\n") : std::string(1, letter);
         return text;
       }()},
      {"sparse tags, unordered.msh", replaced(replaced(one_41, "\n1\n2\n3\n4\n", "\n9000000000\n20\n3\n400\n"),
                                              "7 1 2 3 4", "7 9000000000 20 3 400")},
      {"mirrored.msh", replaced(one_41, "7 1 2 3 4", "7 1 2 4 3")},
      {"one.vtk", one_30},
      {"field.vtk", replaced(one_30, "POINTS", "FIELD FieldData 1\nTIME 2 1 double\n0 1.5\npoints")},
      {"cell data.vtk", one_30 + "CELL_DATA 1\nSCALARS anything int 1\n"},
      {"new.vtk", one_51},
      {"one.vtu", one_vtu},
  };
  for (const File& file : files) {
    INFO(file.path << ": " << message_of(file));
    CHECK((message_of(file).empty() && same(read_mesh(file), one)));
    CHECK(read_mesh(file).reoriented == (file.path == "mirrored.msh"));
  }
}

TEST_CASE("triangles are kept only where there are no tetrahedra", "[mesh_file]") {
  const Mesh sheet =
      read_mesh({"sheet.vtk", replaced(replaced(one_30, "1 5\n4 0 1 2 3", "1 4\n3 3 1 0"), "\n10\n", "\n5\n")});
  REQUIRE(sheet.triangles == Cells<3>{{2, 1, 0}});
  REQUIRE(sheet.points == (Positions(3, 3) << 0, 1, 0, 0, 0, 0, 0, 0, 1).finished());
  REQUIRE(sheet.comment == "1 unused point left out");
}

TEST_CASE("each piece of a vtu file counts its own points", "[mesh_file]") {
  const Mesh two = read_mesh({"two.vtu", vtu_begin + piece + replaced(piece, "0 1 0 0 0 1", "0 1 0 0 0 2") + vtu_end});
  REQUIRE(two.points.cols() == 8);
  REQUIRE(two.tetrahedra == Cells<4>{{0, 1, 2, 3}, {4, 5, 6, 7}});
  REQUIRE(two.points.col(7) == Vector3(0, 0, 2));
}

TEST_CASE("a file that can't be opened is reported by name", "[mesh_file]") {
  CHECK_THROWS_WITH(load_mesh("no/such.msh"), "no/such.msh: cannot open: No such file or directory");
  const TemporaryFolder folder;
  const std::string pipe = folder.path("pipe.msh");
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  CHECK_THROWS_WITH(load_mesh(pipe), Catch::Contains("is no regular file"));  // and does not wait for a writer
  CHECK_THROWS_WITH(load_mesh("some.vtp"), Catch::StartsWith("some.vtp: unknown ending '.vtp'; did you mean '.vtk'?"));
  CHECK_THROWS_WITH(load_mesh("some.key"), Catch::StartsWith("some.key: unknown ending '.key'; allowed: .msh"));
  CHECK_THROWS_WITH(load_mesh("dir.msh/name"), Catch::StartsWith("dir.msh/name: unknown ending ''; allowed: .msh"));
}

TEST_CASE("Gmsh files: what is wrong is reported by line and column", "[mesh_file]") {
  check_messages({
      {"a.msh", "", "a.msh:1:1: expected $MeshFormat, but the data ends here"},
      {"a.msh", "solid cube\n", "a.msh:1:1: expected $MeshFormat, found 'solid'"},
      {"a.msh", replaced(one_41, "4.1", "4.0"),
       "a.msh:2:1: format version '4.0' is not read; allowed: 2.2 and 4.1; convert it: gmsh -save -format msh41 "
       "-o new.msh a.msh"},
      {"an a.msh", replaced(one_41, "4.1", "4.0"),
       "an a.msh:2:1: format version '4.0' is not read; allowed: 2.2 and 4.1; convert it: gmsh -save -format msh41 "
       "-o new.msh 'an a.msh'"},
      {"a.msh", replaced(one_41, " 0 8", " 2 8"), "a.msh:2:5: expected the file type, 0 (ASCII) or 1 (binary)"},
      {"a.msh", replaced(one_41, " 0 8", " 0 4"), "a.msh:2:7: expected the data size, 8 bytes a number"},
      {"a.msh", replaced(one_41, "$Nodes", "$ParametricNodes"), "a.msh:4:17: expected $EndParametricNodes further on"},
      {"a.msh", replaced(one_41, "0 1 0", "0 nan 0"),
       "a.msh:13:3: expected a coordinate, a finite number; found 'nan'"},
      {"a.msh", replaced(one_41, "0 1 0", "0 1e999 0"), "a.msh:13:3: expected a coordinate, a finite number"},
      {"a.msh", replaced(one_41, "1 4 1 4", "1 99999999999 1 4"),
       "a.msh:5:3: expected the number of points, at most 1"},
      {"a.msh", replaced(one_41, "1 4 1 4", "1 5 1 4"),
       "a.msh:5:3: expected the number of points, but the blocks hold 4"},
      {"a.msh", replaced(one_41, "3 1 0 4", "3 1 0 -4"),
       "a.msh:6:7: expected the number of points of a block, at most"},
      {"a.msh", replaced(one_41, "\n2\n3\n", "\n2\n2\n"), "a.msh:9:1: point 2 stands here a second time"},
      {"a.msh", replaced(one_41, "\n2\n3\n", "\n-2\n3\n"),
       "a.msh:8:1: expected a point's number, from 0 to 2⁶³−1; found -2"},
      {"a.msh", replaced(one_41, "$EndNodes", "$EndNode"), "a.msh:15:1: expected $EndNodes, found '$EndNode'"},
      {"a.msh", replaced(one_41, "1 1 7 7", "1 2 7 7"),
       "a.msh:17:3: expected the number of cells, but the blocks hold 1"},
      {"a.msh", replaced(one_41, "7 1 2 3 4", "7 1 2 3 9"),
       "a.msh:19:9: cell 7 uses point 9, which $Nodes does not have"},
      {"a.msh", replaced(one_41, "7 1 2 3 4", "7 1 2 3 x"),
       "a.msh:19:9: expected a point of a cell, an integer; found 'x'"},
      {"a.msh", replaced(one_41, "3 1 4 1\n", "3 1 7 1\n"),
       "a.msh:19:1: cell 7 is a pyramid (type 7); allowed: triangles of 3 and 6 points, tetrahedra of 4 and 10"},
      {"a.msh", replaced(one_41, "3 1 4 1\n", "3 1 5 1\n"), "a.msh:20:1: expected a point of a cell"},
      {"a.msh", replaced(one_41, "3 1 4 1\n", "3 1 77 1\n"), "a.msh:19:1: cell 7 is a cell of unknown type (type 77)"},
      {"a.msh", replaced(one_41, "0 0 1\n", "1 1 0\n"),
       "a.msh:19:1: cell 7 is a flat tetrahedron: its volume 0 is not above 1e-12 of its longest side (1.41) cubed"},
      {"a.msh", replaced(one_41, "7 1 2 3 4", "7 1 2 3 3"), "a.msh:19:1: cell 7 is a flat tetrahedron"},
      {"a.msh", replaced(one_41, "3 1 4 1\n7 1 2 3 4", "2 1 2 1\n7 1 2 2"), "a.msh:19:1: cell 7 is a flat triangle"},
      {"a.msh", replaced(one_41, "3 1 4 1\n7 1 2 3 4", "1 1 1 1\n7 1 2"),
       "a.msh: no triangles and no cells of a solid; it has 1 line"},
      {"a.msh", one_41.substr(0, one_41.find("$Elements")), "a.msh:16:1: expected $Elements, but the data ends here"},
      {"a.msh", replaced(one_22, "\n1\n7", "\n2000000000\n7"), "a.msh:12:1: expected the number of cells, at most"},
      {"a.msh", replaced(one_22, "7 4 2", "7 4 2000000"),
       "a.msh:13:5: expected the number of labels of a cell, at most"},
      {"a.msh", replaced(one_22, "3 4\n$", "3 5\n$"), "a.msh:13:17: cell 7 uses point 5"},
      {"a.msh", replaced(one_22, "7 4 2 1 1 1 2", "7 13 2 1 1 1 2"),
       "a.msh:13:1: cell 7 is a quadratic prism with 18 points (type 13)"},
  });
}

TEST_CASE("binary files: what is wrong is reported by its byte", "[mesh_file]") {
  const std::string gmsh = binary_22(std::endian::little);
  std::string byte_order = gmsh, bad_index = gmsh, not_finite = gmsh;
  byte_order[20] = 7;
  bad_index[gmsh.find("\n$EndElements") - 4] = 9;
  const std::size_t coordinate = gmsh.find("$Nodes\n4\n") + 9 + 4;
  std::fill_n(not_finite.begin() + static_cast<std::ptrdiff_t>(coordinate), 8, '\xff');
  const auto byte = [](std::size_t at) { return "a.msh: byte " + std::to_string(at) + ": "; };
  const File vtk = fixture("vtk_51_binary.vtk");
  check_messages({
      {"a.msh", byte_order, byte(20) + "expected the number 1 that shows the byte order"},
      {"a.msh", bad_index, byte(gmsh.find("\n$EndElements") - 4) + "cell 7 uses point 9"},
      {"a.msh", not_finite, byte(coordinate) + "expected a coordinate, a finite number"},
      {"a.msh", gmsh.substr(0, coordinate + 5),
       byte(coordinate) + "expected a coordinate (8 bytes), but the data ends"},
      {"a.msh", replaced(gmsh, "$Nodes\n4\n", "$Nodes\n400000000\n"),
       byte(coordinate - 6) + "expected the number of points"},
      {"a.vtk", vtk.bytes.substr(0, 120), "a.vtk: byte 87: expected 24 coordinates, but what is left has room for 4"},
      {"a.vtk", replaced(vtk.bytes, "POINTS 8", "POINTS 9999999"), "a.vtk:5:8: expected the number of points, at most"},
  });
}

TEST_CASE("legacy VTK files: what is wrong is reported by line and column", "[mesh_file]") {
  check_messages({
      {"a.vtk", "", "a.vtk:1:1: expected #, but the data ends here"},
      {"a.vtk", replaced(one_30, "3.0", "1.0"),
       "a.vtk:1:24: format version '1.0' is not read; allowed: 2.0 to 4.2 and 5.1"},
      {"a.vtk", replaced(one_30, "3.0", "6.0"), "a.vtk:1:24: format version '6.0' is not read"},
      {"a.vtk", replaced(one_30, "ASCII", "UTF8"), "a.vtk:3:1: expected ASCII or BINARY, found 'UTF8'"},
      {"a.vtk", replaced(one_30, "UNSTRUCTURED_GRID", "POLYDATA"),
       "a.vtk:8:1: expected POINTS, POLYGONS, FIELD or METADATA; found 'CELLS'"},
      {"a.vtk", replaced(one_30, "UNSTRUCTURED_GRID", "POLDATA"),
       "a.vtk:4:9: expected UNSTRUCTURED_GRID or POLYDATA, found 'POLDATA'"},
      {"a.vtk", replaced(one_30, "POINTS 4", "POINTS 5"),
       "a.vtk:8:1: expected a coordinate, a finite number; found 'CELLS'"},
      {"a.vtk", replaced(one_30, "POINTS 4", "POINTS 50"),
       "a.vtk:5:16: expected 150 coordinates, but what is left has room"},
      {"a.vtk", replaced(one_30, "4 float", "4 int"), "a.vtk:5:10: expected a type of real numbers, float or double"},
      {"a.vtk", replaced(one_30, "  0 0 1", "  0 inf 1"),
       "a.vtk:7:10: expected a coordinate, a finite number; found 'inf'"},
      {"a.vtk", replaced(one_30, "CELLS 1 5", "CELLS 9999999999999 5"),
       "a.vtk:8:7: expected the number of cells, at most"},
      {"a.vtk", replaced(one_30, "CELLS 1 5", "CELLS 2 5"),
       "a.vtk:10:1: expected the number of points of cell 1 (counted"},
      {"a.vtk", replaced(one_30, "CELLS 1 5\n4", "CELLS 1 5\n3"),
       "a.vtk:9:9: expected the end of the list of cells: its 1"},
      {"a.vtk", replaced(one_30, "CELLS 1 5\n4", "CELLS 1 5\n-4"),
       "a.vtk:9:1: expected the number of points of cell 0"},
      {"a.vtk", replaced(one_30, "4 0 1 2 3", "4 0 1 2 4"),
       "a.vtk:9:9: cell 0 (counted from 0) uses point 4, but there are 4"},
      {"a.vtk", replaced(one_30, "\n10\n", "\n26\n"),
       "a.vtk:11:1: cell 0 (counted from 0) is a quadratic prism with 15 points (type 26); allowed: triangles"},
      {"a.vtk", replaced(one_30, "\n10\n", "\n24\n"),
       "a.vtk:9:3: cell 0 (counted from 0) is a quadratic tetrahedron with 10 points of 4 points"},
      {"a.vtk", replaced(one_30, "\n10\n", "\n5\n"), "a.vtk:9:3: cell 0 (counted from 0) is a triangle of 4 points"},
      {"a.vtk", replaced(one_30, "CELL_TYPES 1\n10", "CELL_TYPES 2\n10 10"),
       "a.vtk:11:1: expected the types of 1 cells, found 2"},
      {"a.vtk", replaced(one_30, "4 0 1 2 3", "4 0 1 2 2"), "a.vtk:9:3: cell 0 (counted from 0) is a flat tetrahedron"},
      {"a.vtk", replaced(one_30, "CELL_TYPES", "CELL_DATA"), "a.vtk:10:10: expected CELL_TYPES before this"},
      {"a.vtk", replaced(one_30, "CELLS", "POINTS"), "a.vtk:8:1: POINTS stands here a second time"},
      {"a.vtk", replaced(one_30, "CELLS", "LINES"), "a.vtk:8:1: expected POINTS, CELLS, CELL_TYPES, FIELD or METADATA"},
      {"a.vtk", replaced(one_51, "OFFSETS vtktypeint64", "OFFSETS float"), "a.vtk:9:9: expected a type of integers"},
      {"a.vtk", replaced(one_51, "\n0 4\n", "\n0 5\n"), "a.vtk:10:3: expected an offset from 0 to 4, found 5"},
      {"a.vtk", replaced(one_51, "\n0 4\n", "\n0 3\n"), "a.vtk:10:3: expected the last offset, 4"},
      {"a.vtk", replaced(one_51, "\n0 4\n", "\n1 4\n"), "a.vtk:10:1: expected the first offset, 0"},
      {"a.vtk", replaced(one_51, "0 1 2 3", "0 -1 2 3"), "a.vtk:12:3: cell 0 (counted from 0) uses point -1"},
  });
}

TEST_CASE("VTK XML files: what is wrong is reported by line and column", "[mesh_file]") {
  const std::string raw = fixture("vtk_appended_raw.vtu").bytes, base64 = fixture("vtk_binary.vtu").bytes,
                    packed = fixture("meshio_zlib.vtu").bytes;
  const std::size_t block = packed.find("eJ", packed.find("connectivity"));  // how zlib data begin, in base64
  check_messages({
      {"a.vtu", "", "a.vtu:1:1: expected XML: "},
      {"a.vtu", replaced(one_vtu, "</Points>", "</Point>"), "a.vtu:10:3: expected XML: Start-end tags mismatch"},
      {"a.vtu", one_vtu.substr(0, one_vtu.find("</Cells>")), "a.vtu:20:13: expected XML: "},
      {"a.vtu", replaced(one_vtu, "\"UnstructuredGrid\"", "\"PolyData\""),
       "a.vtu:2:2: VTKFile: expected type=UnstructuredGrid, found 'PolyData'"},
      {"a.vtu", replaced(one_vtu, "LittleEndian", "MiddleEndian"),
       "a.vtu:2:2: VTKFile: expected byte_order=LittleEndian or"},
      {"a.vtu", replaced(one_vtu, "version=\"0.1\"", "header_type=\"Int8\""),
       "a.vtu:2:2: VTKFile: expected header_type="},
      {"a.vtu", replaced(one_vtu, "version=\"0.1\"", "compressor=\"vtkLZMADataCompressor\""),
       "a.vtu:2:2: VTKFile: expected compressor=vtkZLibDataCompressor or none, found 'vtkLZMADataCompressor'"},
      {"a.vtu", vtu_begin + vtu_end, "a.vtu:3:2: UnstructuredGrid: expected <Piece> inside"},
      {"a.vtu", replaced(one_vtu, "Points=\"4\"", "Points=\"-4\""),
       "a.vtu:4:2: Piece: expected NumberOfPoints=0 to 2147483647"},
      {"a.vtu", replaced(one_vtu, "Points=\"4\"", "Points=\"2000000000\""),
       "a.vtu:6:65: expected 6000000000 coordinates"},
      {"a.vtu", replaced(one_vtu, "Points=\"4\"", "Points=\"3\""), "a.vtu:8:7: expected no more coordinates here"},
      {"a.vtu", replaced(one_vtu, "Cells=\"1\"", "Cells=\"2000000000\""),
       "a.vtu:15:55: expected 2000000000 numbers, each an offset"},
      {"a.vtu", replaced(one_vtu, "Name=\"offsets\"", "Name=\"ofsets\""),
       "a.vtu:11:2: Cells: expected <DataArray Name=\"offsets\"> inside"},
      {"a.vtu", replaced(one_vtu, "\"Int32\"", "\"Float32\""), "a.vtu:12:2: DataArray: expected type=Int8 to Int64 or"},
      {"a.vtu", replaced(one_vtu, "\"3\" format=\"ascii\"", "\"3\" format=\"hex\""),
       "a.vtu:6:2: DataArray: expected format=ascii,"},
      {"a.vtu", replaced(one_vtu, "0 1 0 0 0 1", "0 1 nan 0 0 1"), "a.vtu:8:5: expected a coordinate, a finite number"},
      {"a.vtu", replaced(one_vtu, "0 1 2 3", "0 1 2 4"),
       "a.vtu:13:7: cell 0 (counted from 0) uses point 4, but there are 4"},
      {"a.vtu", replaced(one_vtu, ">\n4\n<", ">\n5\n<"),
       "a.vtu:14:1: expected a point of a cell, but the data ends here"},
      {"a.vtu", replaced(one_vtu, ">\n4\n<", ">\n-4\n<"),
       "a.vtu:16:1: expected an offset from 0 to 2147483647, found -4"},
      {"a.vtu", replaced(one_vtu, ">\n10\n<", ">\n14\n<"),
       "a.vtu:19:1: cell 0 (counted from 0) is a pyramid (type 14)"},
      {"a.vtu", replaced(one_vtu, "\"3\" format=\"ascii\"", "\"3\" format=\"appended\" offset=\"0\""),
       "a.vtu:6:2: format=\"appended\", but there is no AppendedData"},
      {"a.vtu", replaced(raw, "offset=\"0\"", "offset=\"99999\""), "a.vtu:9:10: DataArray: expected offset=0 to 1"},
      {"a.vtu", raw.substr(0, raw.find("\n   _") + 100), "a.vtu:9:10: expected 200 bytes of data, but there are 95"},
      {"a.vtu", replaced(raw, "\"raw\"", "\"gzip\""),
       "a.vtu:18:4: AppendedData: expected encoding=base64 or raw, found 'gzip'"},
      {"a.vtu", replaced(raw, "   _", "   "), "a.vtu:19:4: AppendedData: expected '_' before the data"},
      {"a.vtu", replaced(base64, "Points=\"8\"", "Points=\"9\""),
       "a.vtu:9:10: expected an array of 216 bytes, but its header announces 192"},
      {"a.vtu", replaced(base64, "AAAAwA", "AAAAw*"), "a.vtu:10:16: expected base64 data, found '*'"},
      {"a.vtu", replaced(packed, packed.substr(block, 2), "AA"), "a.vtu:7:2: a block of zlib data does not inflate to"},
  });
}

TEST_CASE("a file that is cut off anywhere fails, or loses nothing", "[mesh_file]") {
  for (const std::string& name : fixtures) {
    const File whole = fixture(name);
    const Mesh mesh = read_mesh(whole);
    for (std::size_t length = 0; length < whole.bytes.size(); length += 5) {
      INFO(name << " cut to " << length << " bytes");
      try {
        if (!same(read_mesh({name, whole.bytes.substr(0, length)}), mesh)) FAIL("another mesh");
      } catch (const InputError& error) {
        if (!std::string_view(error.what()).starts_with(name + ":")) FAIL(error.what());
      }
    }
  }
}

TEST_CASE("a file with random damage fails with a place, or gives a sound mesh", "[mesh_file][slow]") {
  std::mt19937 random(20240501);  // the same damage on every machine: no distributions, which differ
  const auto below = [&](std::size_t limit) { return static_cast<std::size_t>(random()) % limit; };
  const std::string letters = "0123456789-.+e$<>\"=_ \n\xff" + std::string(3, '\0');
  const std::vector<std::string> words = {
      "-1", "99999999999", "-9223372036854775807", "18446744073709551615", "nan", "1e308", "==", "$Nodes"};
  int loaded = 0, refused = 0;
  std::vector<std::string> names = fixtures;
  for (const char* other : {"gmsh_1.msh", "gmsh.bdf", "gmsh.unv"}) names.push_back(other);
  for (const std::string& name : names) {
    const File whole = fixture(name);
    for (int round = 0; round < 2000; ++round) {
      File damaged = whole;
      for (std::size_t change = 0; change < 1 + below(3); ++change) {
        const std::size_t at = below(damaged.bytes.size());
        switch (below(6)) {
          case 0:
            damaged.bytes[at] ^= static_cast<char>(1 << below(8));
            break;
          case 1:
            damaged.bytes[at] = letters[below(letters.size())];
            break;
          case 2:
            damaged.bytes.insert(at, 1 + below(9), letters[below(letters.size())]);
            break;
          case 3:
            damaged.bytes.erase(at, 1 + below(20));
            break;
          case 4:
            damaged.bytes.replace(at, below(8), words[below(words.size())]);
            break;
          default:
            damaged.bytes.insert(at, damaged.bytes.substr(below(damaged.bytes.size()), 1 + below(40)));
        }
      }
      INFO(name << ", round " << round);
      try {
        if (!sound(read_mesh(damaged))) FAIL("an unsound mesh");
        ++loaded;
      } catch (const InputError& error) {
        ++refused;
        if (!std::string_view(error.what()).starts_with(name + ":")) FAIL(error.what());
      }
    }
  }
  CHECK(loaded > 100);  // else the damage is too coarse to reach the readers' insides
  CHECK(refused > 1000);
}

TEST_CASE("a large mesh that is numbered at random is numbered in space, any other as its file is", "[mesh_file]") {
  constexpr int side = 22;
  const Body block = tetrahedral_block(BlockKind::kuhn, {side, side, side}, Vector3::Ones());
  const auto text_of = [&](const std::vector<int>& number) {
    std::vector<int> at(number.size());
    for (std::size_t m = 0; m < number.size(); ++m) at[number[m]] = static_cast<int>(m);
    std::ostringstream text;
    text.precision(17);
    text << "*NODE\n";
    for (std::size_t i = 0; i < at.size(); ++i) {
      const Vector3 point = block.rest.col(at[i]);
      text << i + 1 << ", " << point[0] << ", " << point[1] << ", " << point[2] << "\n";
    }
    text << "*ELEMENT, TYPE=C3D4\n";
    int label = 0;
    for (const auto& cell : block.tetrahedra) {
      text << ++label;
      for (const int corner : cell) text << ", " << number[corner] + 1;
      text << "\n";
    }
    text << "*NSET, NSET=bottom\n";
    for (int m = 0; m < block.size(); ++m)
      if (block.rest(2, m) == 0) text << number[m] + 1 << "\n";
    return text.str();
  };
  std::vector<int> number(static_cast<std::size_t>(block.size()));
  std::iota(number.begin(), number.end(), 0);
  const Mesh ordered = format::read_mesh({"a.inp", text_of(number)});
  CHECK(ordered.points == block.rest);
  CHECK(ordered.tetrahedra == block.tetrahedra);

  std::shuffle(number.begin(), number.end(), std::mt19937(11));
  const Mesh mesh = format::read_mesh({"a.inp", text_of(number)});
  REQUIRE(mesh.tetrahedra.size() == block.tetrahedra.size());
  double volume = 0, span = 0;
  for (const auto& cell : mesh.tetrahedra) {
    const double own = signed_volume(mesh.points, cell);
    CHECK(own == Approx(std::pow(side, -3) / 6).epsilon(1e-9));
    volume += own;
    span += *std::max_element(cell.begin(), cell.end()) - *std::min_element(cell.begin(), cell.end());
  }
  CHECK(volume == Approx(1).epsilon(1e-9));
  CHECK(span / static_cast<double>(mesh.tetrahedra.size()) < 0.1 * block.size());  // at random 3/5 of them
  REQUIRE(mesh.sets.at("bottom").size() == (side + 1) * (side + 1));
  for (const int molecule : mesh.sets.at("bottom")) CHECK(mesh.points(2, molecule) == 0);
}
