#include "elastin/lab/study/laboratory.h"

#include <pybind11/eigen.h>

#include "lab/export/formats.h"
#include "lab/run/run.h"
#include "python/bind.h"
#include "python/pickling.h"

namespace elastin::python {
using namespace lab;
namespace {

/// A laboratory as Python has it: other threads continue during a run, and runs take turns.
struct SharedLaboratory {
  Laboratory laboratory;
  std::mutex busy = {};
};

/// A result with the body that it is about.
struct Outcomes {
  LaboratoryResult result;
  std::string scene;
  std::shared_ptr<Body> body;
};

py::dict by_name(const std::vector<Measured>& list) {
  py::dict values;
  for (const Measured& one : list) values[one.name.c_str()] = one.value;
  return values;
}

py::dict by_measure(const Gradients& gradients) {
  py::dict list;
  for (const auto& [measure, slopes] : gradients) {
    py::dict by_key;
    for (const auto& [key, slope] : slopes) by_key[key.c_str()] = slope;
    list[measure.c_str()] = by_key;
  }
  return list;
}

py::list as_list(const std::vector<Stated>& stated) {
  py::list list;
  for (const auto& [strategy, measured, source] : stated)
    list.append(py::dict(py::arg("strategy") = strategy, py::arg("measure") = measured.name,
                         py::arg("value") = measured.value, py::arg("unit") = measured.unit,
                         py::arg("source") = source));
  return list;
}

/// A column a measure, NaN where a row has none.
py::dict columns_of(const LaboratoryResult& result) {
  const auto rows = static_cast<py::ssize_t>(result.curve.size());
  py::dict columns;
  const auto column = [&](const char* name) {
    if (!columns.contains(name)) {
      py::array_t<double> empty(rows);
      std::fill_n(empty.mutable_data(), rows, std::nan(""));
      columns[name] = empty;
    }
    return columns[name].cast<py::array_t<double>>().mutable_data();
  };
  for (py::ssize_t row = 0; row < rows; ++row) {
    const auto& [at, measures] = result.curve[row];
    column("at")[row] = at;
    for (const Measured& one : measures) column(one.name.c_str())[row] = one.value;
  }
  return columns;
}

/// The laboratory's body: lives as long as its views. Python cannot change a body.
std::shared_ptr<Body> body_of(const std::shared_ptr<SharedLaboratory>& shared) {
  return {shared, const_cast<Body*>(&shared->laboratory.body())};
}

/// Calls a Python function with what is being done, and ends with Ctrl-C.
RunWatch watch_of(const std::optional<py::function>& progress) {
  RunWatch watch;
  watch.stop = &stop_requested;
  watch.progress = progress_of(progress);
  return watch;
}

/// Does it in its turn, without the interpreter's lock.
template <class Do>
auto in_turn(SharedLaboratory& shared, const Do& act) {
  return interruptible([&] {
    const std::lock_guard turn(shared.busy);
    return act(shared.laboratory);
  });
}

std::shared_ptr<Outcomes> outcomes(const std::shared_ptr<SharedLaboratory>& shared, LaboratoryResult result) {
  return std::make_shared<Outcomes>(Outcomes{std::move(result), shared->laboratory.name(), body_of(shared)});
}

std::shared_ptr<Outcomes> run(const std::shared_ptr<SharedLaboratory>& shared, const std::string& strategy,
                              const std::optional<py::function>& progress, bool keep_states,
                              const std::vector<std::string>& derivatives_by) {
  RunWatch watch = watch_of(progress);
  watch.derivatives_by = derivatives_by;
  watch.keep_states = keep_states;
  return outcomes(shared, in_turn(*shared, [&](Laboratory& own) { return own.run(strategy, watch); }));
}

/// A Python function solves: it gets the request as text and gives the answer.
std::shared_ptr<Outcomes> measure(const std::shared_ptr<SharedLaboratory>& shared, const py::function& solve) {
  const auto ask = [kept = keep(solve)](const std::string& request) {
    const py::gil_scoped_acquire locked;
    return (*kept)(request).cast<std::string>();
  };
  return outcomes(shared, in_turn(*shared, [&](Laboratory& own) { return own.measure(ask); }));
}

void compute_reference(const std::shared_ptr<SharedLaboratory>& shared, const std::string& option,
                       const std::optional<py::function>& progress) {
  const RunWatch watch = watch_of(progress);
  in_turn(*shared, [&](Laboratory& own) { own.compute_reference(option, watch); });
}

std::shared_ptr<Moving> simulation(const std::shared_ptr<SharedLaboratory>& shared, const std::string& strategy,
                                   const SimulationOptions& options) {
  return in_turn(*shared, [&](Laboratory& own) { return std::make_shared<Moving>(own.simulation(strategy, options)); });
}

template <class Member>
auto part_of_result(Member member) {
  return [member](const Outcomes& self) { return self.result.*member; };
}

template <class Member>
auto array_of_result(Member member) {
  return [member](const py::object& self) { return view(self.cast<const Outcomes&>().result.*member, self); };
}

LaboratoryResults results_of(const std::vector<std::shared_ptr<Outcomes>>& outcomes) {
  LaboratoryResults results;
  for (const auto& one : outcomes) results.push_back(&one->result);
  return results;
}

const char* outcome_text(const Outcomes& self) { return self.result.suited ? name_of(self.result.outcome) : kUnsuited; }

void add_result(py::module_& module) {
  using Result = LaboratoryResult;
  py::class_<Outcomes, std::shared_ptr<Outcomes>>(module, "Result", "Result of one strategy on a scene; SI units.")
      .def_property_readonly("scene", [](const Outcomes& self) { return self.scene; })
      .def_property_readonly("strategy", part_of_result(&Result::strategy))
      .def_property_readonly("outcome", &outcome_text,
                             "'converged', or how it stopped: 'limit_reached', 'inverted', 'diverged', 'mechanism', "
                             "'interrupted'; 'unsuited': the strategy cannot run on this body.")
      .def_property_readonly("cause", part_of_result(&Result::cause), "Why it did not converge; '' if it did.")
      .def_property_readonly("good", part_of_result(&Result::good),
                             "As the command's exit code 0: no failure, and all that the scene expects holds.")
      .def_property_readonly(
          "measures", [](const Outcomes& self) { return by_name(self.result.measures); },
          "Value by name, of the last load step, or of the time history of a run.")
      .def_property_readonly(
          "units",
          [](const Outcomes& self) {
            std::map<std::string, std::string> units;
            for (const Measured& one : self.result.measures) units[one.name] = one.unit;
            return units;
          },
          "SI unit of each measure by name; '' of a ratio.")
      .def_property_readonly(
          "gradients", [](const Outcomes& self) { return by_measure(self.result.gradients); },
          "Derivatives by name of the measure and key of the scene, those of derivatives_by; SI units.")
      .def_property_readonly(
          "spreads", [](const Outcomes& self) { return by_measure(self.result.spreads); },
          "Where the scene states an uncertainty, by name of the measure its 'deviation', and by key the share of each "
          "number in the square of that.")
      .def_property_readonly("main", part_of_result(&Result::main),
                             "Names of the measures by which strategies are compared, the most telling first.")
      .def_property_readonly(
          "errors", [](const Outcomes& self) { return by_name(self.result.errors); },
          "By measure, against the material's target: relative, or the difference of a ratio; "
          "MEASURE_to_reference: relative to the scene's reference.")
      .def_property_readonly(
          "curve", [](const Outcomes& self) { return columns_of(self.result); },
          "Columns, one row a load step or frame: 'at' (part of the load, or time [s]) and every "
          "measure. pandas.DataFrame takes it as it is.")
      .def_property_readonly("positions", array_of_result(&Result::positions),
                             "Of the last state [m], (n, 3); (0, 3) where none was reached.")
      .def_property_readonly("tensions", array_of_result(&Result::tensions),
                             "Of the last state [N], one a connection, pulling is positive.")
      .def_property_readonly("stiffness", part_of_result(&Result::stiffness),
                             "6 x 6 [Pa], xx yy zz yz xz xy, of the experiment `material`; else None.")
      .def_property_readonly("warnings", part_of_result(&Result::warnings), "What makes it doubtful, a sentence each.")
      .def_property_readonly("notes", part_of_result(&Result::notes),
                             "What was chosen, left out or repaired, as the command prints it: another strategy than "
                             "the one that was named, what the grips hold, sets of a mesh.")
      .def_property_readonly("solver", part_of_result(&Result::solver))
      .def_property_readonly("newton_iterations", part_of_result(&Result::newton_iterations))
      .def_property_readonly("linear_iterations", part_of_result(&Result::linear_iterations))
      .def_property_readonly("build_seconds", part_of_result(&Result::build_seconds))
      .def_property_readonly("solve_seconds", part_of_result(&Result::solve_seconds))
      .def_property_readonly("body", [](const Outcomes& self) { return self.body; })
      .def_property_readonly("_states",
                             [](const py::object& self) {
                               py::list states;
                               for (const Result::Kept& kept : self.cast<const Outcomes&>().result.states)
                                 states.append(py::make_tuple(kept.at, view(kept.positions, self)));
                               return states;
                             })
      .def(py::pickle([](const Outcomes& self) { return py::make_tuple(packed(self.result), self.scene, self.body); },
                      [](const py::tuple& state) {
                        return std::make_shared<Outcomes>(
                            Outcomes{*unpacked<Result>(state[0].cast<py::bytes>(), "Result"),
                                     state[1].cast<std::string>(), state[2].cast<std::shared_ptr<Body>>()});
                      }));
}

}  // namespace

void add_laboratory(py::module_& module) {
  add_result(module);
  using Results = std::vector<std::shared_ptr<Outcomes>>;
  module.def("_advice", [](const Results& results) {
    const Advice advice = interruptible([&] { return advice_of(results_of(results)); });
    return py::make_tuple(advice.strategy, advice.text);
  });
  module.def("_page",
             [](const Results& results) { return interruptible([&] { return page_of(results_of(results)); }); });
  module.def("_view",
             [](const Results& results) { return interruptible([&] { return view_of(results_of(results)); }); });
  module.def("_view", [](const Body& body) { return interruptible([&] { return view_of(body); }); });
  module.def("_view", [](Moving& self) { return self.in_turn([](Simulation& s) { return view_of(s); }); });
  module.def("_export_formats", [] {
    py::dict endings;
    for (const auto& row : export_formats()) endings[row->name.c_str()] = row->ending;
    return endings;
  });
  py::class_<SharedLaboratory, std::shared_ptr<SharedLaboratory>>(module, "_Laboratory")
      .def(py::init([](const GivenScene& scene, const std::vector<std::string>& overrides,
                       const std::shared_ptr<Catalog>& catalog, const std::vector<ExperimentInfo>& experiments) {
             const Catalog chosen = catalog ? *catalog : built_in_catalog();
             ExperimentCatalog known = built_in_experiments();
             for (const ExperimentInfo& own : experiments) known.add(own);
             return interruptible([&] {
               return std::shared_ptr<SharedLaboratory>(
                   new SharedLaboratory{Laboratory(source_of(scene), overrides, chosen, known)});
             });
           }),
           py::arg("scene"), py::arg("overrides"), py::arg("catalog"), py::arg("experiments"))
      .def_property_readonly("name", [](const SharedLaboratory& self) { return self.laboratory.name(); })
      .def_property_readonly("title", [](const SharedLaboratory& self) { return self.laboratory.title(); })
      .def_property_readonly("body", &body_of)
      .def_property_readonly("material", [](const SharedLaboratory& self) { return self.laboratory.material(); })
      .def_property_readonly(
          "strategy", [](const SharedLaboratory& self) { return self.laboratory.strategy(); }, "The scene's own.")
      .def_property_readonly(
          "strategies", [](const SharedLaboratory& self) { return self.laboratory.strategies(); },
          "Those that the scene compares.")
      .def_property_readonly(
          "references", [](const SharedLaboratory& self) { return as_list(self.laboratory.references()); },
          "Values of the same problem from elsewhere: dicts of measure, value, unit, source.")
      .def_property_readonly(
          "expectations", [](const SharedLaboratory& self) { return as_list(self.laboratory.expectations()); },
          "Values that the scene says must come out: dicts as references, with the strategy.")
      .def_property_readonly("warnings", [](const SharedLaboratory& self) { return self.laboratory.warnings(); })
      .def("compute_reference", &compute_reference, py::arg("option") = "", py::kw_only(),
           py::arg("progress") = py::none(),
           "Computes the reference of the scene as the command `compare` does: what its own problem comes to on finer "
           "and finer cells. '' does it where the scene says so, 'computed' in any case, 'none' not at all. Runs "
           "after it have errors to it.")
      .def("run", &run, py::arg("strategy") = "", py::kw_only(), py::arg("progress") = py::none(),
           py::arg("keep_states") = false, py::arg("derivatives_by") = std::vector<std::string>{},
           "Runs the experiment with a strategy by name ('calibrated:angles', 'lattice+volume'); '' takes the scene's "
           "own. progress(doing) is called before each load step or frame; what it raises ends the run. keep_states: "
           "the result has the positions of each load step or frame. derivatives_by: keys of numbers of the scene, "
           "'material.youngs_modulus', by which all measures at rest are differentiated. Numerical trouble is an "
           "outcome in the result.")
      .def("_measure", &measure)
      .def("_exported",
           [](SharedLaboratory& self, const std::string& strategy) {
             return in_turn(self, [&](Laboratory& own) { return own.exported(strategy); });
           })
      .def("_export",
           [](SharedLaboratory& self, const std::string& format, const std::string& strategy) {
             std::vector<std::string> notes;
             const auto files = in_turn(self, [&](Laboratory& own) { return own.exported(format, strategy, notes); });
             return py::make_tuple(files, notes);
           })
      .def(
          "simulation",
          [](const py::object& self, const std::string& strategy, const GivenStepper& stepper, double safety,
             int max_substeps, const ParameterValues& stepper_parameters, const ParameterValues& parameters,
             const std::optional<GivenStepper>& former, const std::optional<ParameterValues>& former_parameters) {
            const GivenStepper& chosen = former ? *former : stepper;
            const ParameterValues& of_it = former_parameters ? *former_parameters : stepper_parameters;
            auto made =
                simulation(self.cast<std::shared_ptr<SharedLaboratory>>(), strategy,
                           simulation_options(built_in_catalog(), chosen, safety, max_substeps, of_it, parameters));
            const py::dict keywords(py::arg("stepper") = chosen, py::arg("safety") = safety,
                                    py::arg("max_substeps") = max_substeps, py::arg("stepper_parameters") = of_it,
                                    py::arg("parameters") = parameters);
            made->recipe =
                keep(py::make_tuple(self.attr("simulation"), py::make_tuple(strategy), keywords, py::list()));
            return made;
          },
          py::arg("strategy") = "", py::kw_only(), py::arg("stepper").none(false) = "symplectic_euler",
          py::arg("safety") = 0.8, py::arg("max_substeps") = 1000, py::arg("stepper_parameters") = ParameterValues{},
          py::arg("parameters") = ParameterValues{}, py::arg("scheme") = py::none(),
          py::arg("scheme_parameters") = py::none(),
          "The scene's body at rest, or at time 0, with its strategy, loads, damping and contact, held by its "
          "experiment and loaded in full at once, to be stepped. scheme, scheme_parameters: former names of stepper, "
          "stepper_parameters.");
}

}  // namespace elastin::python
