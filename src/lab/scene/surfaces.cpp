#include "elastin/core/shapes/surfaces.h"

#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// More parts than this along a line is a slip of the pen, not a scene.
constexpr int kMaxDivisions = 4000;

Body read_sphere(Reader& reader, bool octant) {
  const double radius = read_length(reader, "radius");
  std::vector<std::pair<std::string, SphereMesh>> meshes{{"type_1", SphereMesh::type_1},
                                                         {"type_2", SphereMesh::type_2}};
  if (!octant) meshes.insert(meshes.begin(), {"icosahedron", SphereMesh::icosahedron});
  const auto mesh = reader.find("mesh");
  const SphereMesh kind = mesh ? mesh->choice(meshes) : meshes.front().second;
  const Reader parts = reader.at("divisions");
  const int divisions = parts.whole(kind == SphereMesh::type_2 ? 3 : 1, kMaxDivisions);
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

}  // namespace elastin::lab
