#include <pybind11/eigen.h>

#include "elastin/core/simulation/saved_state.h"
#include "python/bind.h"

namespace elastin::python {
namespace {

template <class Result>
std::string end_text(const char* name, const Result& result) {
  return std::string("<elastin.") + name + ": " + elastin::name_of(result.outcome) +
         (result.cause.empty() ? "" : ", " + result.cause) + ">";
}

}  // namespace

std::function<void(const std::string& doing)> progress_of(const std::optional<py::function>& progress) {
  return [report = progress ? keep(*progress) : nullptr](const std::string& doing) {
    const py::gil_scoped_acquire locked;
    check_signals();
    if (report) (*report)(doing);
  };
}

void add_results(py::module_& module) {
  py::class_<StepResult>(module, "StepResult", "How a step ended; true if it went well.")
      .def_property_readonly("outcome", [](const StepResult& r) { return elastin::name_of(r.outcome); })
      .def_readonly("cause", &StepResult::cause, "Why it did not get there; the state then stayed as it was.")
      .def_readonly("substeps", &StepResult::substeps, "Into how many substeps it was divided.")
      .def_readonly("newton_iterations", &StepResult::newton_iterations)
      .def_readonly("linear_iterations", &StepResult::linear_iterations)
      .def(py::pickle(
          [](const StepResult& r) {
            return py::make_tuple(static_cast<int>(r.outcome), r.cause, r.substeps, r.newton_iterations,
                                  r.linear_iterations);
          },
          [](const py::tuple& state) {
            StepResult r;
            r.outcome = static_cast<Outcome>(state[0].cast<int>()), r.cause = state[1].cast<std::string>();
            r.substeps = state[2].cast<int>(), r.newton_iterations = state[3].cast<int>();
            r.linear_iterations = state[4].cast<int>();
            return r;
          }))
      .def("__bool__", [](const StepResult& r) { return r.outcome == Outcome::converged; })
      .def("__repr__", [](const StepResult& r) { return end_text("StepResult", r); });
  py::class_<StaticResult>(module, "StaticResult", "How the search for an equilibrium ended; true if it was found.")
      .def_property_readonly("outcome", [](const StaticResult& r) { return elastin::name_of(r.outcome); })
      .def_readonly("cause", &StaticResult::cause)
      .def_readonly("solver", &StaticResult::solver)
      .def_readonly("newton_iterations", &StaticResult::newton_iterations)
      .def_readonly("linear_iterations", &StaticResult::linear_iterations)
      .def_readonly(
          "residual", &StaticResult::residual,
          "Unbalanced force over the size of loads and reactions; where these are nothing, of the forces within the "
          "body.")
      .def_readonly("left_saddle", &StaticResult::left_saddle,
                    "Whether it went down from an equilibrium that was no minimum, as a column that buckles does.")
      .def_readonly(
          "unstable", &StaticResult::unstable,
          "Whether the equilibrium found has a direction of negative stiffness: the body does not stay there.")
      .def(py::pickle(
          [](const StaticResult& r) {
            return py::make_tuple(static_cast<int>(r.outcome), r.cause, r.solver, r.newton_iterations,
                                  r.linear_iterations, r.residual, r.left_saddle, r.unstable);
          },
          [](const py::tuple& state) {
            StaticResult r;
            r.outcome = static_cast<Outcome>(state[0].cast<int>()), r.cause = state[1].cast<std::string>();
            r.solver = state[2].cast<std::string>(), r.newton_iterations = state[3].cast<int>();
            r.linear_iterations = state[4].cast<int>(), r.residual = state[5].cast<double>();
            r.left_saddle = state[6].cast<bool>(), r.unstable = state[7].cast<bool>();
            return r;
          }))
      .def("__bool__", [](const StaticResult& r) { return r.outcome == Outcome::converged; })
      .def("__repr__", [](const StaticResult& r) { return end_text("StaticResult", r); });
  py::class_<SimulationState>(module, "SimulationState", "All that a simulation changes while it runs.")
      .def_property_readonly(
          "time", [](const SimulationState& s) { return s.state.time; }, "[s]")
      .def_property_readonly(
          "positions",
          [](const py::object& self) { return view(self.cast<const SimulationState&>().state.positions, self); },
          "[m], (n, 3).")
      .def(py::pickle(
          [](const SimulationState& s) {
            const std::vector<char> bytes = bytes_of(s);
            return py::bytes(bytes.data(), bytes.size());
          },
          [](const py::bytes& state) {
            const auto text = static_cast<std::string>(state);
            return simulation_state_of(text.data(), text.size());
          }))
      .def("__repr__", [](const SimulationState& s) {
        return "<elastin.SimulationState at " + py::str(py::float_(s.state.time)).cast<std::string>() + " s>";
      });
}

}  // namespace elastin::python
