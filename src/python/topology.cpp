#include "elastin/core/model/topology.h"

#include <pybind11/eigen.h>

#include "elastin/core/base/error.h"
#include "elastin/core/model/parts.h"
#include "python/bind.h"

namespace elastin::python {
namespace {

/// Changes the topology; views that were requested before keep what they show.
template <class Change>
TopologyReport changed(Moving& self, const Change& change) {
  TopologyReport report = self.in_turn([&](Simulation& simulation) {
    if (self.stepping) throw InputError("an observer must not change the topology of what it observes");
    return change(simulation);
  });
  if (report.before) self.begin_generation(std::move(report.before));
  return report;
}

std::array<Vector3, 2> ends_from(const py::handle& given, const char* name) {
  const Positions ends = positions_from(given, name);
  if (ends.cols() != 2) throw InputError(std::string(name) + ": must be the two ends of the blade, (2, 3) [m]");
  return {ends.col(0), ends.col(1)};
}

py::array_t<int> numbers(const std::vector<int>& values) {
  return py::array_t<int>(static_cast<py::ssize_t>(values.size()), values.data());
}

}  // namespace

void add_topology(py::module_& module, MovingClass& simulation) {
  module.def(
      "of_parts",
      [](const std::vector<std::tuple<std::string, std::shared_ptr<Body>, int>>& parts,
         const std::vector<std::tuple<std::string, std::string, double, double>>& ties) {
        Body whole;
        for (const auto& [name, body, material] : parts) {
          Part part;
          part.name = name;
          part.rigid = material < 0;
          part.material = std::max(0, material);
          add_part(whole, *body, std::move(part));
        }
        for (const auto& [first, second, within, stiffness] : ties) tie_parts(whole, first, second, within, stiffness);
        return std::make_shared<Body>(std::move(whole));
      },
      py::arg("parts"), py::arg("ties") = py::list(),
      "A body of several parts: (name, body, number of its material from 0; below 0: bone, which stays where it is "
      "unless something moves it) each. ties: (first, second, within [m], stiffness [Pa]): where two parts are near to "
      "each other, molecules in one place become one and others are tied to the surface.");
  py::class_<TopologyReport>(module, "TopologyReport", "What a cut did; true if it changed anything.")
      .def_readonly("split_molecules", &TopologyReport::split_molecules)
      .def_readonly("removed_connections", &TopologyReport::removed_connections)
      .def_readonly("removed_cells", &TopologyReport::removed_cells)
      .def_property_readonly(
          "molecule_from", [](const TopologyReport& report) { return numbers(report.molecule_from); },
          "Of each molecule its number before, (n,); those that were split off come last.")
      .def_property_readonly(
          "connection_from", [](const TopologyReport& report) { return numbers(report.connection_from); },
          "Of each connection its number before, (m,).")
      .def("__bool__", [](const TopologyReport& report) { return report.changed; })
      .def("__repr__", [](const TopologyReport& report) {
        return "<elastin.TopologyReport: " + std::to_string(report.split_molecules) + " molecules split, " +
               std::to_string(report.removed_connections) + " connections and " + std::to_string(report.removed_cells) +
               " cells removed>";
      });
  simulation
      .def(
          "cut_plane",
          [](Moving& self, const Vector3& point, const Vector3& normal) {
            return changed(self, [&](Simulation& s) { return s.cut(CutSurface::plane(point, normal)); });
          },
          py::arg("point"), py::arg("normal"),
          "Parts the body by a plane in its present positions [m], between its cells, or between molecules where it "
          "has "
          "none. Volume and mass stay. Molecules keep their numbers; those that were split off come last. Views show "
          "what was before: request new ones. The next step takes longer.")
      .def(
          "cut_blade",
          [](Moving& self, const py::object& start, const py::object& end) {
            const auto from = ends_from(start, "start"), to = ends_from(end, "end");
            return changed(self, [&](Simulation& s) { return s.cut(CutSurface::blade(from, to)); });
          },
          py::arg("start"), py::arg("end"),
          "The same by what a straight blade sweeps: its two ends [m], (2, 3), where it starts and where it ends.")
      .def(
          "cut_triangles",
          [](Moving& self, const py::object& points, const Cells<3>& triangles) {
            const Positions corners = positions_from(points, "points");
            return changed(self, [&](Simulation& s) { return s.cut(CutSurface::triangles(corners, triangles)); });
          },
          py::arg("points"), py::arg("triangles"), "The same by triangles of points [m].")
      .def(
          "tear",
          [](Moving& self, double strain) { return changed(self, [&](Simulation& s) { return s.tear(strain); }); },
          py::arg("strain"),
          "Parts the body where it is strained above `strain`; a crack through cells grows by one molecule a call.")
      .def(
          "remove",
          [](Moving& self, const ChosenNumbers& connections, const ChosenNumbers& cells) {
            return changed(self, [&](Simulation& s) {
              const Body& body = s.body();
              const std::size_t count = !body.tetrahedra.empty() ? body.tetrahedra.size()
                                        : !body.cubes.empty()    ? body.cubes.size()
                                                                 : body.triangles.size();
              return s.remove(connections.of(body.connections.ends.size(), "connections", "connection"),
                              cells.of(count, "cells", "cell"));
            });
          },
          py::arg("connections") = py::tuple(), py::arg("cells") = py::tuple(),
          "Removes connections and cells by number or by masks, with the cells' mass; molecules that lose all are "
          "gone, and those "
          "behind them are renumbered.")
      .def_property_readonly(
          "origin",
          [](Moving& self) { return self.in_turn([](Simulation& s) { return std::vector<int>(s.origin()); }); },
          "Of each molecule its number in the body that the simulation was made of.");
}

}  // namespace elastin::python
