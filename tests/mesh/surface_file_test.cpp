#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdio>

#include "core/forces/pressure.h"
#include "elastin/core/base/error.h"
#include "elastin/mesh/mesh_file.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::mesh;
using Catch::Matchers::Contains;

namespace {

/// A corner of a cube of 3: volume 3³/6.
const std::vector<std::array<float, 3>> kPoints{{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 3}};
const Cells<3> kTriangles{{1, 2, 3}, {0, 2, 1}, {0, 3, 2}, {0, 1, 3}};

std::string ascii_stl() {
  std::string text = "solid corner\n";
  for (const auto& triangle : kTriangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int corner : triangle) {
      text += "vertex";
      for (const float x : kPoints[corner]) text += " " + std::to_string(x);
      text += "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid corner\n";
}

void append(std::string& bytes, const void* value, std::size_t size) {
  bytes.append(static_cast<const char*>(value), size);
}

std::string binary_stl() {
  static_assert(std::endian::native == std::endian::little);
  std::string bytes(80, ' ');
  const std::uint32_t count = 4;
  append(bytes, &count, 4);
  const std::array<float, 3> normal{};
  for (const auto& triangle : kTriangles) {
    append(bytes, normal.data(), 12);
    for (const int corner : triangle) append(bytes, kPoints[corner].data(), 12);
    bytes += std::string(2, '\0');
  }
  return bytes;
}

const char* const kObj = "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 2 3 4\nf 1 3 2\nf 1 4 3\nf 1 2 4\n";
const char* const kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n3 0 0\n0 3 0\n0 0 3\n3 1 2 3\n3 0 2 1\n3 0 3 2\n3 0 1 3\n";

/// Each triangle with points of its own, which differ by rounding.
std::string soup_ply() {
  std::string points, faces;
  int count = 0;
  for (const auto& triangle : kTriangles) {
    faces += "3";
    for (const int corner : triangle) {
      const auto& [x, y, z] = kPoints[static_cast<std::size_t>(corner)];
      const double off = 1e-6 * (count % 2);
      for (const double coordinate : {x + off, y - off, z + off}) points += std::to_string(coordinate) + " ";
      points += "\n";
      faces += " " + std::to_string(count++);
    }
    faces += "\n";
  }
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) +
         "\nproperty double x\nproperty double y\nproperty double z\nelement face " + std::to_string(count / 3) +
         "\nproperty list uchar int vertex_indices\nend_header\n" + points + faces;
}

/// With what a scanner adds: a comment, colours, quality, an element of its own.
std::string binary_ply(std::endian order) {
  std::string bytes =
      order == std::endian::little ? "ply\nformat binary_little_endian 1.0\n" : "ply\nformat binary_big_endian 1.0\n";
  bytes +=
      "comment a scan\nelement vertex 4\nproperty uchar red\nproperty float x\nproperty double y\nproperty short z\n"
      "element camera 1\nproperty list ushort float lens\nelement face 4\nproperty float quality\n"
      "property list uint int vertex_index\nend_header\n";
  const auto put = [&](const auto& value) {
    std::string raw(reinterpret_cast<const char*>(&value), sizeof value);
    if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
    bytes += raw;
  };
  for (const auto& [x, y, z] : kPoints) {
    put(std::uint8_t{200}), put(x), put(static_cast<double>(y)), put(static_cast<std::int16_t>(z));
  }
  put(std::uint16_t{2}), put(1.F), put(2.F);
  for (const auto& triangle : kTriangles) {
    put(0.5F), put(std::uint32_t{3});
    for (const int corner : triangle) put(corner);
  }
  return bytes;
}

}  // namespace

TEST_CASE("surfaces come from STL, OBJ and PLY with their corners joined", "[surface_file]") {
  const TemporaryFolder folder;
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>{"ascii.stl", ascii_stl()},
                                    {"binary.STL", binary_stl()},
                                    {"corner.obj", kObj},
                                    {"corner.ply", kPly},
                                    {"soup.ply", soup_ply()},
                                    {"mark.stl", "\xEF\xBB\xBF" + ascii_stl()},
                                    {"mark.obj", std::string("\xEF\xBB\xBF") + kObj},
                                    {"mark.ply", std::string("\xEF\xBB\xBF") + kPly},
                                    {"named.stl", "solid" + binary_stl().substr(5)},
                                    {"longer.stl", "solid" + binary_stl().substr(5) + std::string(2, '\0')},
                                    {"little.ply", binary_ply(std::endian::little)},
                                    {"big.ply", binary_ply(std::endian::big)}}) {
    INFO(name);
    const Mesh mesh = load_mesh(folder.write(name, bytes));
    CHECK(mesh.points.cols() == 4);
    REQUIRE(mesh.triangles.size() == 4);
    CHECK(mesh.tetrahedra.empty());
    const double off = name == "soup.ply" ? 1e-5 : 1e-12;  // its points are off by as much
    CHECK(enclosed_volume(mesh.triangles, mesh.points, {1, 2, 3}) == Approx(4.5).epsilon(off));
    CHECK(inspect_surface(mesh.triangles).rim_sides == 0);
  }
  // Polygons are cut.
  const Mesh square = load_mesh(folder.write("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"));
  CHECK(square.triangles.size() == 2);
  CHECK(square.points.cols() == 4);
}

TEST_CASE("corners that differ by rounding are one, and those further apart are not", "[surface_file]") {
  const TemporaryFolder folder;
  const auto points_with = [&](double noise) {  // each corner of each triangle somewhere else
    std::string text = "solid corner\n";
    int number = 0;
    for (const auto& triangle : kTriangles) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int corner : triangle) {
        text += "vertex";
        for (const float x : kPoints[corner]) {
          char word[32];
          std::snprintf(word, sizeof word, " %.9g", x + noise * (++number - 18) / 18.);
          text += word;
        }
        text += "\n";
      }
      text += "endloop\nendfacet\n";
    }
    const Mesh mesh = load_mesh(folder.write("noisy.stl", text + "endsolid corner\n"));
    CHECK(mesh.triangles.size() == 4);
    return mesh.points.cols();
  };
  CHECK(points_with(1e-15) == 4);
  CHECK(points_with(8e-7) == 4);  // of an extent of 3
  CHECK(points_with(1e-3) == 12);
}

TEST_CASE("strips of triangles end at -1, in binary files too", "[surface_file]") {
  const TemporaryFolder folder;
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  for (const auto& point : kPoints) append(bytes, point.data(), 12);
  const std::array<std::int32_t, 9> strips{8, 0, 2, 1, 3, -1, 0, 3, 2};  // their number first
  append(bytes, strips.data(), sizeof strips);
  const Mesh mesh = load_mesh(folder.write("strips.ply", bytes));
  CHECK(mesh.triangles == Cells<3>{{0, 2, 1}, {2, 3, 1}, {0, 3, 2}});
}

TEST_CASE("a PLY file that is broken is refused where it is", "[surface_file]") {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& from, const std::string& to) -> std::string {
    std::string text = kPly;
    text.replace(text.find(from), from.size(), to);
    try {
      load_mesh(folder.write("a.ply", text));
    } catch (const InputError& error) {
      return std::string(error.what()).substr(folder.path("").size());
    }
    return "";
  };
  CHECK(refusal("ascii", "ASCII") ==
        "a.ply:2:8: expected ascii, binary_little_endian or binary_big_endian, found 'ASCII'");
  CHECK(refusal("1.0", "2.0") == "a.ply:2:14: expected 1.0, found '2.0'");
  CHECK(refusal("property float x", "property flota x") ==
        "a.ply:4:10: expected a type of number (char to double), found 'flota'");
  CHECK_THAT(refusal("float z", "float y"), Contains("a.ply:3:1: expected a vertex with the properties x, y and z"));
  CHECK_THAT(refusal("float z", "float w"), Contains("a.ply:3:1: expected a vertex with the properties x, y and z"));
  CHECK_THAT(refusal("vertex_indices", "corners"), Contains("a.ply:7:1: expected a face with the property list"));
  CHECK_THAT(refusal("element face 4", "element face 999999999"), Contains("a.ply:7:14: expected the number of"));
  CHECK_THAT(refusal("element vertex 4", "element vertex 5"), Contains("face 1 has 1 corners; 3 or more make one"));
  CHECK_THAT(refusal("3 1 2 3", "3 1 2 4"), Contains("a.ply:14:7: face 0 uses vertex 4, but there are 4"));
  CHECK_THAT(refusal("3 1 2 3", "3 1 2 -1"), Contains("face 0 uses vertex -1"));
  CHECK(refusal("3 1 2 3", "3 1 2 2").empty());
  CHECK(load_mesh(folder.path("a.ply")).repairs == std::vector<std::string>{"1 triangle without area dropped"});
  CHECK_THAT(refusal("0 0 3", "0 0 nan"), Contains("a.ply:13:5: expected a coordinate, a finite number"));
  CHECK_THAT(refusal("3 0 1 3", "3 0 1 3 7"), Contains("expected no more numbers here"));
  CHECK_THAT(refusal("3 0 1 3", "3 0 1"), Contains("but the data ends here"));
  CHECK(load_mesh(folder.write("quad.ply",
                               "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                               "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                               "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"))
            .triangles == Cells<3>{{0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("a surface file that is broken is refused by its name", "[surface_file]") {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& name, const std::string& bytes) -> std::string {
    try {
      load_mesh(folder.write(name, bytes));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  CHECK_THAT(refusal("more.ply", binary_ply(std::endian::little) + "abc"), Contains("expected no more numbers here"));
  CHECK_THAT(refusal("short.stl", binary_stl().substr(0, 150)),
             Contains("byte 80: expected 4 triangles of 50 bytes, but what is left has room for 1"));
  CHECK_THAT(refusal("named.stl", "solid" + binary_stl().substr(5, 145)),
             Contains("byte 80: expected 4 triangles of 50 bytes, but what is left has room for 1"));
  CHECK_THAT(refusal("words.stl", "nothing of the kind"), Contains("words.stl:1:1: expected solid, or 80 bytes"));
  CHECK_THAT(refusal("open.stl", "solid a\nvertex 0 0 0\n"), Contains("expected endloop, but the data ends here"));
  CHECK_THAT(refusal("nan.stl", "solid a\nvertex 0 0 nan\n"), Contains("nan.stl:2:12: expected a coordinate"));
  CHECK_THAT(refusal("words.ply", "nothing of the kind"), Contains("words.ply:1:1: expected ply, found 'nothing'"));
  CHECK_THAT(refusal("empty.obj", ""), Contains("empty.obj: no triangles; it has 0 points"));
  CHECK_THAT(refusal("cloud.obj", "v 0 0 0\nv 1 0 0\n"), Contains("cloud.obj: no triangles; it has 2 points"));
  CHECK_THAT(refusal("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"), Contains("lines.obj: no triangles; it has 1 line"));
  CHECK_THAT(refusal("a.obj", "v 0 0 0\nf 1 2 x\n"), Contains("a.obj:2:7: expected a corner of a face"));
  CHECK_THAT(refusal("a.obj", "f 1 2 -1\n"), Contains("a.obj:1:7: expected a corner of a face"));
  CHECK_THAT(refusal("a.obj", "v 0 0 0\nf 1 2 3\nv 0 0 1\n"),
             Contains("a.obj:2:5: a face uses corner 3, but there are 2"));
  CHECK_THAT(refusal("a.obj", "v 0 0\n"), Contains("a.obj:1:1: expected v and three coordinates"));
  CHECK_THAT(refusal("a.off", "4OFF\n1 1 1\n"), Contains("a.off:1:1: expected OFF, COFF or NOFF, found '4OFF'"));
  CHECK_THAT(refusal("a.off", "OFF BINARY\n"), Contains("OFF BINARY is not read"));
  CHECK_THAT(refusal("a.off", "OFF\n353535235358 6 0\n"),
             Contains("a.off:2:1: expected the number of points, at most"));
  CHECK_THAT(refusal("a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n"),
             Contains("a.off:4:7: face 0 uses point 1, but there are 1"));
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\n";
  CHECK_THAT(refusal("flat.obj", corners + "f 1 2 3\n"), Contains("flat.obj: all of its triangles are without area"));
  // A flat one's middle corner becomes one of the neighbour across its longest side.
  const Mesh mended = load_mesh(folder.write("t.obj", corners + "f 1 2 3\nf 1 4 3\n"));
  CHECK(mended.triangles.size() == 2);
  CHECK(mended.repairs == std::vector<std::string>{"1 triangle without area dropped"});
}
