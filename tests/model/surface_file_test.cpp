#include <bit>
#include <catch2/catch.hpp>

#include "elastin/base/error.h"
#include "elastin/forces/pressure.h"
#include "elastin/model/mesh_file.h"
#include "temporary_folder.h"

using namespace elastin;
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
      for (const float x : kPoints[static_cast<std::size_t>(corner)]) text += " " + std::to_string(x);
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
    for (const int corner : triangle) append(bytes, kPoints[static_cast<std::size_t>(corner)].data(), 12);
    bytes += std::string(2, '\0');
  }
  return bytes;
}

const char* const kObj = "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 2 3 4\nf 1 3 2\nf 1 4 3\nf 1 2 4\n";
const char* const kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n3 0 0\n0 3 0\n0 0 3\n3 1 2 3\n3 0 2 1\n3 0 3 2\n3 0 1 3\n";

}  // namespace

TEST_CASE("surfaces come from STL, OBJ and PLY with their corners joined", "[surface_file]") {
  const TemporaryFolder folder;
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>{"ascii.stl", ascii_stl()},
                                    {"binary.STL", binary_stl()},
                                    {"corner.obj", kObj},
                                    {"corner.ply", kPly}}) {
    INFO(name);
    const Mesh mesh = load_mesh(folder.write(name, bytes));
    CHECK(mesh.points.cols() == 4);
    REQUIRE(mesh.triangles.size() == 4);
    CHECK(mesh.tetrahedra.empty());
    CHECK(enclosed_volume(mesh.triangles, mesh.points, {1, 2, 3}) == Approx(4.5).epsilon(1e-12));
    CHECK(inspect_surface(mesh.triangles).rim_sides == 0);
  }
  // Polygons are cut.
  const Mesh square = load_mesh(folder.write("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"));
  CHECK(square.triangles.size() == 2);
  CHECK(square.points.cols() == 4);
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
  CHECK_THAT(refusal("short.stl", binary_stl().substr(0, 150)), Contains("short.stl: not a surface that can be read"));
  CHECK_THAT(refusal("words.ply", "nothing of the kind"), Contains("words.ply: not a surface that can be read"));
  CHECK_THAT(refusal("empty.obj", ""), Contains("empty.obj: "));
  CHECK_THAT(refusal("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 4\nf 1 2 3\n"),
             Contains("flat.obj: face 1 is a flat triangle"));
}
