#pragma once
#include "elastin/core/shapes/simplices.h"

namespace elastin {

/// The shapes that laws run on, by their dimensions: a new shape is a header of its own and its name here.
template <CellShape... Shapes>
struct CellShapeList {
  /// Calls visit.template operator()<Shape>() for each.
  template <class Visit>
  static constexpr void for_each(Visit&& visit) {
    (visit.template operator()<Shapes>(), ...);
  }
};
using SolidShapes = CellShapeList<Tetrahedron4>;
using MembraneShapes = CellShapeList<Triangle3>;
template <int dimensions>
using ShapesOf = std::conditional_t<dimensions == 3, SolidShapes, MembraneShapes>;

/// Why a law cannot run on a body: it has no cells of these dimensions. Else "".
template <int dimensions>
std::string no_cells(const Body& body) {
  bool any = false;
  std::string names;
  ShapesOf<dimensions>::for_each([&]<class Shape>() {
    any |= !Shape::in(body).empty();
    names += (names.empty() ? "needs " : " or ") + std::string(Shape::plural);
  });
  return any ? "" : names;
}

}  // namespace elastin
