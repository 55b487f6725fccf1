#include <pybind11/eigen.h>

#include <algorithm>
#include <map>
#include <vector>

#include "elastin/core/simulation/simulation.h"
#include "elastin/core/solve/block_rows.h"
#include "elastin/core/solve/vibrations.h"
#include "lab/run/cell_stress.h"
#include "lab/run/contact_measures.h"
#include "python/bind.h"

namespace elastin::python {
namespace {

/// {'strain': (k, 3, 3), 'stress': (k, 3, 3)}.
py::dict arrays_of(const CellState* states, std::size_t count) {
  py::array_t<double> strain({count, std::size_t{3}, std::size_t{3}}), stress({count, std::size_t{3}, std::size_t{3}});
  for (std::size_t cell = 0; cell < count; ++cell) {  // symmetric: rows are columns
    Eigen::Map<Matrix3>(strain.mutable_data(cell, 0, 0)) = states[cell].strain;
    Eigen::Map<Matrix3>(stress.mutable_data(cell, 0, 0)) = states[cell].stress;
  }
  return py::dict(py::arg("strain") = strain, py::arg("stress") = stress);
}

py::dict cell_states(Moving& self) {
  const std::vector<CellState> found = self.in_turn(
      [](Simulation& s) { return lab::cell_states(s.body(), lab::snapshot_of(s.model(), s.state(), s.time(), 0)); });
  const Body& body = self.simulation.body();
  const lab::OwnSimplices own(body);
  std::map<std::string, std::vector<CellState>> by_shape;
  auto next = found.begin();
  const auto take = [&](const std::string& shape, std::size_t count) {
    if (count) by_shape[shape].insert(by_shape[shape].end(), next, next + static_cast<std::ptrdiff_t>(count));
    next += static_cast<std::ptrdiff_t>(count);
  };
  take("triangle3", own.triangles);
  take("tetrahedron4", own.tetrahedra);
  for (const CellBlock& block : body.blocks)
    take(std::string(block.kind->name), static_cast<std::size_t>(block.size()));
  py::dict result;
  for (const auto& [name, states] : by_shape) result[name.c_str()] = arrays_of(states.data(), states.size());
  return result;
}

template <class T>
py::array_t<T> array_from(const std::vector<T>& values) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

}  // namespace

/// The slowest vibrations about the present state.
py::tuple vibrations(Moving& self, int count) {
  if (count < 1) throw InputError("count: is " + std::to_string(count) + "; allowed: 1 or more");
  const Vibrations found = self.in_turn([&](Simulation& s) { return find_vibrations(s.model(), s.state(), count); });
  if (found.outcome != Outcome::converged) throw InputError("no vibrations of this state: " + found.cause);
  const auto shapes = static_cast<py::ssize_t>(found.shapes.size());
  py::array_t<double> array({shapes, py::ssize_t{self.simulation.body().size()}, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < shapes; ++i)
    std::copy_n(found.shapes[i].data(), found.shapes[i].size(), array.mutable_data(i, 0, 0));
  return py::make_tuple(found.frequencies, array);
}

void add_state(MovingClass& simulation) {
  simulation
      .def(
          "vibrations", &vibrations, py::arg("count") = 6,
          "The slowest free vibrations about the present state, an equilibrium, small and without damping: frequencies "
          "(k,) [Hz], 0 of a mechanism and NaN where it is unstable, and shapes (k, n, 3) of unit modal mass, sum of m "
          "|u|^2 = 1 [1/sqrt(kg)]. Supports hold; rigid motions are left out.")
      .def("cell_states", &cell_states,
           "Means over each cell now, by shape as in Body.cells: {'tetrahedron4': {'strain': (k, 3, 3), 'stress': (k, "
           "3, "
           "3)}, …}: Green and Lagrange's strain and Cauchy's stress [Pa], of triangles force over width [N/m]: "
           "those of the law in the cell; of springs the virial of its sides.")
      .def(
          "stiffness",
          [](Moving& self) {
            const BlockRows rows = self.in_turn([](Simulation& s) { return stiffness_blocks(s.model(), s.state()); });
            const py::array_t<double> data(
                {static_cast<py::ssize_t>(rows.columns.size()), py::ssize_t{3}, py::ssize_t{3}}, rows.values.data());
            return py::make_tuple(data, array_from(rows.columns), array_from(rows.starts));
          },
          "The stiffness -d(all forces)/d(positions) [N/m] now, supports not regarded: data (m, 3, 3), columns (m,) "
          "and "
          "row starts (n + 1,) of its blocks, what scipy.sparse.bsr_matrix takes; tangent() gives them as CSR.");
}

}  // namespace elastin::python
