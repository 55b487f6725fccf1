// Numbers of cells in mesh files.

#include <catch2/catch.hpp>

#include "elastin/core/base/error.h"
#include "elastin/mesh/mesh_file.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::mesh;
using Catch::Matchers::Contains;

namespace {

/// Two tetrahedra and a triangle between them, with `k` of 5, 7 and 9 and a direction each.
const std::string kVtk =
    "# vtk DataFile Version 3.0\ntwo\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"
    "0 0 0\n4 0 0\n0 4 0\n0 0 4\n4 4 4\nCELLS 3 14\n4 0 1 2 3\n3 1 2 3\n4 1 2 3 4\nCELL_TYPES 3\n10\n5\n10\n";
const std::string kVtkData =
    "POINT_DATA 5\nSCALARS p float\nLOOKUP_TABLE default\n1 2 3 4 5\n"
    "CELL_DATA 3\nSCALARS k float\nLOOKUP_TABLE default\n5 9 7\nVECTORS a double\n1 0 0\n0 0 0\n0 1 0\n"
    "FIELD FieldData 1\nn 2 3 int\n1 2 0 0 3 4\n";

const std::string kVtu =
    "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"><UnstructuredGrid>"
    "<Piece NumberOfPoints=\"5\" NumberOfCells=\"3\"><CellData>"
    "<DataArray Name=\"k\" type=\"Int32\" format=\"ascii\">5 9 7</DataArray>"
    "<DataArray Name=\"a\" type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">1 0 0 0 0 0 0 1 0</DataArray>"
    "</CellData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">"
    "0 0 0 4 0 0 0 4 0 0 0 4 4 4 4</DataArray></Points><Cells>"
    "<DataArray Name=\"connectivity\" type=\"Int32\" format=\"ascii\">0 1 2 3 1 2 3 1 2 3 4</DataArray>"
    "<DataArray Name=\"offsets\" type=\"Int32\" format=\"ascii\">4 7 11</DataArray>"
    "<DataArray Name=\"types\" type=\"UInt8\" format=\"ascii\">10 5 10</DataArray>"
    "</Cells></Piece></UnstructuredGrid></VTKFile>";

const std::string kMshData =
    "$ElementData\n1\n\"k\"\n1\n0\n3\n0\n1\n2\n12 7\n10 5\n$EndElementData\n"
    "$NodeData\n1\n\"p\"\n1\n0\n3\n0\n1\n1\n1 5\n$EndNodeData\n"
    "$ElementData\n2\n\"a\"\n\"scheme\"\n1\n0\n3\n0\n3\n3\n10 1 0 0\n11 0 0 0\n12 0 1 0\n$EndElementData\n";
const std::string kMsh22 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 4 0 0\n3 0 4 0\n4 0 0 4\n5 4 4 4\n$EndNodes\n"
    "$Elements\n3\n10 4 2 0 1 1 2 3 4\n11 2 2 0 1 2 3 4\n12 4 2 0 1 2 3 4 5\n$EndElements\n";
const std::string kMsh41 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 5 1 5\n3 1 0 5\n1\n2\n3\n4\n5\n0 0 0\n4 0 0\n0 4 0\n0 0 4\n4 4 4\n"
    "$EndNodes\n$Elements\n2 3 10 12\n3 1 4 2\n10 1 2 3 4\n12 2 3 4 5\n2 1 2 1\n11 2 3 4\n$EndElements\n";

CellData read(const std::string& file, const std::string& text, const std::string& name) {
  const TemporaryFolder folder;
  return load_cell_data(folder.write(file, text), name);
}

}  // namespace

TEST_CASE("numbers of cells, of every format that has them", "[mesh]") {
  struct File {
    const char* name;
    std::string text;
  };
  for (const File& file : {File{"a.vtk", kVtk + kVtkData}, File{"a.vtu", kVtu}, File{"a.msh", kMsh22 + kMshData},
                           File{"b.msh", kMsh41 + kMshData}}) {
    INFO(file.name << file.text);
    const CellData k = read(file.name, file.text, "k"), a = read(file.name, file.text, "a");
    REQUIRE(k.values.rows() == 1);
    REQUIRE(k.values.cols() == 2);  // of the tetrahedra alone
    REQUIRE(a.values.rows() == 3);
    for (int cell = 0; cell < 2; ++cell) {  // in any order: each by where it is
      const bool first = k.middles(0, cell) < 1.5;
      CHECK(k.values(0, cell) == (first ? 5 : 7));
      CHECK((k.middles.col(cell) - (first ? Vector3(1, 1, 1) : Vector3(2, 2, 2))).norm() < 1e-12);
      const bool first_of_a = a.middles(0, cell) < 1.5;
      CHECK(a.values.col(cell) == Vector3(first_of_a, !first_of_a, 0));
    }
  }
  CHECK(read("a.vtk", kVtk + kVtkData, "n").values.col(1) == Eigen::Vector2d(3, 4));
}

TEST_CASE("data of cells that are not there or do not fit are refused", "[mesh]") {
  CHECK_THROWS_WITH(read("a.vtk", kVtk + kVtkData, "kk"), Contains("has no data 'kk' of its cells; allowed: a, k, n"));
  CHECK_THROWS_WITH(read("a.vtk", kVtk + kVtkData, "p"), Contains("has no data 'p'"));
  CHECK_THROWS_WITH(read("a.vtk", kVtk, "k"), Contains("has no data of its cells"));
  CHECK_THROWS_WITH(read("a.vtk", kVtk + "CELL_DATA 2\nSCALARS k float\nLOOKUP_TABLE default\n5 9\n", "k"),
                    Contains("data of 2 cells, but there are 3"));
  CHECK_THROWS_WITH(read("a.vtk", kVtk + "CELL_DATA 3\nSCALARS k float\nLOOKUP_TABLE default\n5 nan 9\n", "k"),
                    Contains("a cell's value"));
  CHECK_THROWS_WITH(read("a.msh", kMsh22 + "$ElementData\n1\n\"k\"\n0\n3\n0\n1\n1\n99 7\n$EndElementData\n", "k"),
                    Contains("data of a cell that $Elements does not have"));
  CHECK_THROWS_WITH(read("a.stl", "", "k"), Contains("data of cells are read from .msh, .vtk and .vtu"));
}
