#include "core/shapes/surfaces.h"

#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// More parts along a line are an error of the scene.
constexpr int kMaxDivisions = 4000;

template <class Setup>
Key<Setup> length_key(std::string name, double Setup::*member, std::string text) {
  return key::quantity(std::move(name), member, dimension::length, std::move(text), kPositive).needed();
}

/// Parts along a line.
template <class Setup>
Key<Setup> parts_key(std::string name, int Setup::*member, std::string text,
                     std::function<double(const Setup&)> molecules) {
  return sized(key::whole(std::move(name), member, 1, kMaxDivisions, std::move(text)), molecules).needed();
}

template <bool octant>
Shape sphere_shape() {
  struct S {
    double radius = 0;
    SphereMesh mesh = octant ? SphereMesh::type_1 : SphereMesh::icosahedron;
    int divisions = 0;
  };
  std::vector<std::pair<std::string, SphereMesh>> meshes{{"type_1", SphereMesh::type_1},
                                                         {"type_2", SphereMesh::type_2}};
  if (!octant) meshes.insert(meshes.begin(), {"icosahedron", SphereMesh::icosahedron});
  const auto molecules = [](const S& setup) {
    const double each = octant ? 0.5 : setup.mesh == SphereMesh::icosahedron ? 10 : 4;
    return each * setup.divisions * setup.divisions;
  };
  const auto too_few = [](const S& setup) -> std::string {
    if (setup.mesh != SphereMesh::type_2 || setup.divisions >= 3) return "";
    return "'" + std::to_string(setup.divisions) + "' is below 3, the least of type_2";
  };
  return shape(octant ? "sphere_octant" : "sphere", octant ? ", the part of a sphere in x, y, z ≥ 0" : ", of triangles",
               Keys<S>{length_key("radius", &S::radius, "radius about the origin"),
                       key::choice("mesh", &S::mesh, std::move(meshes),
                                   "one or two triangles meet at the corners of octants in `type_1`, `type_2`"),
                       parts_key<S>("divisions", &S::divisions, "parts of an edge; at least 3 for `type_2`", molecules)
                           .refused_for(too_few)},
               [](const S& setup) {
                 const auto make = octant ? sphere_octant : sphere;
                 return make(setup.radius, setup.mesh, setup.divisions);
               });
}

Shape disc_shape() {
  struct S {
    double radius = 0;
    int rings = 0;
  };
  return shape("disc", ", of triangles",
               Keys<S>{length_key("radius", &S::radius, "radius about the origin, in the plane z = 0"),
                       parts_key<S>("rings", &S::rings, "rings of molecules around the middle one",
                                    [](const S& setup) { return 3. * setup.rings * setup.rings; })},
               [](const S& setup) { return disc(setup.radius, setup.rings); });
}

Shape sheet_shape() {
  struct S {
    std::array<double, 2> size{};
    SheetPattern pattern = SheetPattern::alternating;
    std::array<int, 2> squares{};
  };
  const auto molecules = [](const S& setup) {
    return (setup.pattern == SheetPattern::crossed ? 2. : 1.) * setup.squares[0] * setup.squares[1];
  };
  return shape(
      "sheet", ", a rectangle of triangles",
      Keys<S>{
          key::quantities("size", &S::size, dimension::length, "sides along x and y", kPositive).needed(),
          key::choice("pattern", &S::pattern,
                      {{"alternating", SheetPattern::alternating},
                       {"one_way", SheetPattern::one_way},
                       {"crossed", SheetPattern::crossed}},
                      "how squares are cut into triangles"),
          sized(key::wholes("squares", &S::squares, 1, kMaxDivisions, "squares along x and y"), molecules).needed()},
      [](const S& setup) { return rectangular_sheet(setup.size, setup.squares, setup.pattern); });
}

Shape canopy_shape() {
  struct S {
    double width = 0, span = 0;
    int squares = 0;
  };
  return shape(
      "canopy", ", a cross of two strips of triangles",
      Keys<S>{length_key("width", &S::width, "width of the strips"),
              length_key("span", &S::span, "length of the strips"),
              parts_key<S>("squares", &S::squares, "squares across the width",
                           [](const S& setup) { return setup.span / setup.width * setup.squares * setup.squares; })},
      [](const S& setup) { return cross_canopy(setup.width, setup.span, setup.squares); });
}

}  // namespace

std::vector<Shape> surface_shapes() {
  return {sphere_shape<false>(), sphere_shape<true>(), disc_shape(), sheet_shape(), canopy_shape()};
}

}  // namespace elastin::lab
