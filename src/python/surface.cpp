#include "elastin/core/model/embedded_surface.h"

#include <span>

#include "python/bind.h"

namespace elastin::python {
namespace {

EmbeddedSurface surface_from(const Body& body, const py::object& points, const py::object& triangles) {
  Cells<3> cells;
  for (const auto& row : entry_of<std::vector<std::array<int, 3>>>(triangles, "triangles", "three numbers each"))
    cells.push_back(row);
  const Positions at = positions_from(points, "points");
  return interruptible([&] { return EmbeddedSurface(body, at, std::move(cells)); });
}

py::tuple drawn(const EmbeddedSurface& surface, const py::object& positions) {
  const Positions at = positions_from(positions, "positions");
  const py::ssize_t count = surface.size();
  py::array_t<float> points({count, py::ssize_t{3}}), normals({count, py::ssize_t{3}});
  const auto numbers = static_cast<std::size_t>(3 * count);
  const std::span places(points.mutable_data(), numbers), outward(normals.mutable_data(), numbers);
  interruptible([&] { surface.draw(at, places, outward); });
  return py::make_tuple(points, normals);
}

}  // namespace

void add_surfaces(py::module_& module) {
  py::class_<EmbeddedSurface, std::shared_ptr<EmbeddedSurface>>(
      module, "Surface",
      "A surface that is drawn with a body and takes no part in its mechanics, as fine as a picture wants it: each "
      "point "
      "moves with the solid cell, or the lattice's cube, that holds it at rest or is nearest.")
      .def(py::init(&surface_from), py::arg("body"), py::arg("points"), py::arg("triangles"),
           "points (n, 3) [m] in the body's shape at rest; triangles (k, 3) of their numbers, counter-clockwise seen "
           "from "
           "outside.")
      .def("draw", &drawn, py::arg("positions"),
           "Where the points are when the molecules are at `positions` (m, 3) [m], and the unit normals there: two "
           "arrays "
           "(n, 3) in single precision, as graphics take them.")
      .def_property_readonly("farthest", &EmbeddedSurface::farthest,
                             "How far the point that is furthest from all cells lies outside of them [m], about.")
      .def("__len__", &EmbeddedSurface::size);
}

}  // namespace elastin::python
