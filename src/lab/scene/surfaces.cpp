#include "elastin/core/shapes/surfaces.h"

#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// More parts than this along a line are an error of the scene.
constexpr int kMaxDivisions = 4000;

Body read_sphere(Reader& reader, bool octant) {
  const double radius = read_length(reader, "radius");
  std::vector<std::pair<std::string, SphereMesh>> meshes{{"type_1", SphereMesh::type_1},
                                                         {"type_2", SphereMesh::type_2}};
  if (!octant) meshes.insert(meshes.begin(), {"icosahedron", SphereMesh::icosahedron});
  const auto mesh = reader.find("mesh");
  const SphereMesh kind = mesh ? mesh->choice(meshes) : meshes.front().second;
  const Reader parts = reader.at("divisions");
  const int divisions = parts.whole(1, kMaxDivisions);
  if (kind == SphereMesh::type_2 && divisions < 3) parts.fail("'" + parts.text() + "' is below 3, the least of type_2");
  parts.check_size((octant ? 0.5 : kind == SphereMesh::icosahedron ? 10. : 4.) * divisions * divisions);
  reader.finish();
  return octant ? sphere_octant(radius, kind, divisions) : sphere(radius, kind, divisions);
}

Body read_sheet(Reader& reader) {
  const auto sides = reader.at("size").items(2), counts = reader.at("squares").items(2);
  const std::array size{sides[0].quantity(dimension::length, kPositive),
                        sides[1].quantity(dimension::length, kPositive)};
  const std::array squares{counts[0].whole(1, kMaxDivisions), counts[1].whole(1, kMaxDivisions)};
  const auto pattern = reader.find("pattern");
  const SheetPattern kind = pattern ? pattern->choice<SheetPattern>({{"alternating", SheetPattern::alternating},
                                                                     {"one_way", SheetPattern::one_way},
                                                                     {"crossed", SheetPattern::crossed}})
                                    : SheetPattern::alternating;
  reader.at("squares").check_size((kind == SheetPattern::crossed ? 2. : 1.) * squares[0] * squares[1]);
  reader.finish();
  return rectangular_sheet(size, squares, kind);
}

Body read_canopy(Reader& reader) {
  const double width = read_length(reader, "width"), span = read_length(reader, "span");
  const Reader across = reader.at("squares");
  const int squares = across.whole(1, kMaxDivisions);
  across.check_size(span / width * squares * squares);
  reader.finish();
  return cross_canopy(width, span, squares);
}

}  // namespace

Body read_surface(const std::string& shape, Reader reader) {
  if (shape == "sheet") return read_sheet(reader);
  if (shape == "canopy") return read_canopy(reader);
  if (shape != "disc") return read_sphere(reader, shape == "sphere_octant");
  const double radius = read_length(reader, "radius");
  const Reader parts = reader.at("rings");
  const int rings = parts.whole(1, kMaxDivisions);
  parts.check_size(3. * rings * rings);
  reader.finish();
  return disc(radius, rings);
}

std::vector<KeySection> surface_keys() {
  const auto radius = [](const char* what) { return SceneKey{"radius", "quantity", "m", "> 0", "needed", what}; };
  const SceneKey divisions{"divisions", "whole", "", "1 … 4000", "needed", "parts of an edge; at least 3 for `type_2`"};
  const char* corners = "one or two triangles meet at the corners of octants in `type_1`, `type_2`";
  return {{"body.sphere",
           "",
           "Shape `sphere`, of triangles:",
           {radius("radius about the origin"),
            {"mesh", "`icosahedron`, `type_1`, `type_2`", "", "", "`icosahedron`", corners},
            divisions}},
          {"body.sphere_octant",
           "",
           "Shape `sphere_octant`, the part of a sphere in x, y, z ≥ 0:",
           {radius("radius about the origin"), {"mesh", "`type_1`, `type_2`", "", "", "`type_1`", corners}, divisions}},
          {"body.disc",
           "",
           "Shape `disc`, of triangles:",
           {radius("radius about the origin, in the plane z = 0"),
            {"rings", "whole", "", "1 … 4000", "needed", "rings of molecules around the middle one"}}},
          {"body.sheet",
           "",
           "Shape `sheet`, a rectangle of triangles:",
           {{"size", "two quantities", "m", "> 0", "needed", "sides along x and y"},
            {"squares", "two wholes", "", "1 … 4000", "needed", "squares along x and y"},
            {"pattern", "`alternating`, `one_way`, `crossed`", "", "", "`alternating`",
             "how squares are cut into triangles"}}},
          {"body.canopy",
           "",
           "Shape `canopy`, a cross of two strips of triangles:",
           {{"width", "quantity", "m", "> 0", "needed", "width of the strips"},
            {"span", "quantity", "m", "> 0", "needed", "length of the strips"},
            {"squares", "whole", "", "1 … 4000", "needed", "squares across the width"}}}};
}

}  // namespace elastin::lab
