#include <pybind11/eigen.h>

#include <limits>

#include "elastin/core/base/error.h"
#include "elastin/core/simulation/prepare.h"
#include "elastin/mesh/voronoi.h"
#include "python/bind.h"

namespace elastin::python {
namespace {

ParameterInfo make_parameter(const std::string& name, double fallback, double low, double high,
                             const std::string& text) {
  return {name, dimension::none, low, high, fallback, text};
}

std::string parameter_text(const ParameterInfo& info) {
  const std::string unit = si_unit(info.unit);
  return "<elastin.Parameter " + info.name + " = " + py::str(py::float_(info.fallback)).cast<std::string>() +
         (unit.empty() ? "" : " " + unit) + ">";
}

/// Calls the Python function with body, material and the parameters by name.
RuleConstants rule_of(py::function function) {
  return [kept = keep(std::move(function))](const Body& body, const Material& material, const ParameterValues& values) {
    const py::gil_scoped_acquire locked;
    py::dict parameters;
    for (const auto& [name, value] : values) parameters[name.c_str()] = value;
    const py::object constants = (*kept)(std::make_shared<Body>(body), material, **parameters);
    return numbers_from(constants, "constants");
  };
}

Strategy make_strategy(const std::string& name, py::function constants, const std::string& summary,
                       const std::string& source, std::vector<ParameterInfo> parameters,
                       const std::optional<py::function>& unsuited) {
  Strategy strategy = make_spring_rule(name, rule_of(std::move(constants)), std::move(parameters));
  strategy.summary = summary;
  strategy.source = source;
  if (unsuited)
    strategy.unsuited = [kept = keep(*unsuited)](const Body& body) {
      const py::gil_scoped_acquire locked;
      const py::object why = (*kept)(std::make_shared<Body>(body));
      return why.is_none() ? std::string() : word_of(why, "what unsuited returns");
    };
  return strategy;
}

VectorX constants_of(const Strategy& strategy, const Body& body, const Material& material,
                     const ParameterValues& parameters) {
  return interruptible([&] { return spring_constants(strategy, body, material, parameters, mesh::voronoi_cells); });
}

/// The rule that is nearest to a material on a body without cells: made for lattices, or else for any neighbours.
std::string usual_rule(const Body& body) {
  for (const char* rule : {"lattice", "patch"})
    if (built_in_catalog().find(rule).unsuited(body).empty()) return rule;
  return "standard";
}

/// By its name, as every catalog knows it; what made one's own stands in its `_made_by`.
py::tuple reduced_strategy(const py::object& self) {
  if (py::hasattr(self, "_made_by")) return self.attr("_made_by");
  static const Catalog catalog = built_in_catalog();
  const auto name = self.attr("name").cast<std::string>();
  try {
    catalog.find(name);
  } catch (const InputError&) {
    throw py::type_error("strategy '" + name +
                         "' comes out of a catalog and is one's own; pickle the object that was put there");
  }
  return py::make_tuple(py::module_::import("elastin._again").attr("strategy"), py::make_tuple(name));
}

}  // namespace

Strategy strategy_from(const py::handle& given, const Catalog& catalog) {
  if (py::isinstance<Strategy>(given)) return given.cast<Strategy>();
  if (!py::isinstance<py::str>(given))
    throw InputError("strategy: is a " + std::string(Py_TYPE(given.ptr())->tp_name) +
                     "; allowed: a name or a Strategy");
  return catalog.find(given.cast<std::string>());
}

template <class Row>
std::vector<Descriptor> rows_of(const elastin::Table<Row>& table) {
  std::vector<Descriptor> rows;
  for (const auto& row : table) rows.push_back(*row);
  return rows;
}

void add_strategies(py::module_& module) {
  py::class_<ParameterInfo>(module, "Parameter", "A value that a strategy, a stepper or a load takes, described once.")
      .def(py::init(&make_parameter), py::arg("name"), py::arg("default"), py::kw_only(),
           py::arg("low") = -std::numeric_limits<double>::infinity(),
           py::arg("high") = std::numeric_limits<double>::infinity(), py::arg("text") = "",
           "Of a strategy of one's own, in SI units; low and high are allowed, too.")
      .def_readonly("name", &ParameterInfo::name)
      .def_readonly("default", &ParameterInfo::fallback)
      .def_readonly("low", &ParameterInfo::low)
      .def_readonly("high", &ParameterInfo::high)
      .def_readonly("text", &ParameterInfo::text)
      .def_readonly("required", &ParameterInfo::required)
      .def_property_readonly(
          "kind", [](const ParameterInfo& info) { return name_of(info.kind); },
          "'number', 'whole number', 'vector', 'direction' or 'molecules'.")
      .def_property_readonly("unit", [](const ParameterInfo& info) { return si_unit(info.unit); })
      .def("__repr__", &parameter_text);
  py::class_<Descriptor, std::shared_ptr<Descriptor>>(module, "Row",
                                                      "What a stepper, a linear solver or a load says of itself.")
      .def_readonly("name", &Descriptor::name)
      .def_readonly("summary", &Descriptor::summary)
      .def_readonly("source", &Descriptor::source)
      .def_readonly("parameters", &Descriptor::parameters)
      .def("__repr__", [](const Descriptor& row) { return "<elastin.Row " + row.name + ": " + row.summary + ">"; });
  module.def(
      "steppers", [] { return rows_of(built_in_steppers()); }, "What a simulation takes as its stepper.");
  module.def(
      "linear_solvers", [] { return rows_of(built_in_linear_solvers()); },
      "What scenes name under solver.linear_solver.");
  module.def(
      "loads", [] { return rows_of(built_in_loads()); }, "What Simulation.add_load takes, and scenes under loads.");
  module.def(
      "material_laws", [] { return rows_of(built_in_catalog().material_laws); }, "What Material takes as its law.");
  module.def("_usual_rule", &usual_rule, py::arg("body"));
  module.def(
      "_strategy", [](const std::string& name) { return built_in_catalog().find(name); }, py::arg("name"));
  py::class_<Strategy>(module, "Strategy", py::dynamic_attr(),
                       "A method that gives a body's connections their stiffness.")
      .def(py::init(&make_strategy), py::arg("name"), py::arg("constants"), py::kw_only(), py::arg("summary") = "",
           py::arg("source") = "", py::arg("parameters") = std::vector<ParameterInfo>{},
           py::arg("unsuited") = py::none(),
           "A spring rule of one's own: constants(body, material, **parameters) gives the spring constants [N/m], one "
           "a connection; unsuited(body) says why it cannot run on a body, or None.")
      .def_readonly("name", &Strategy::name)
      .def_readonly("summary", &Strategy::summary)
      .def_readonly("source", &Strategy::source)
      .def_readonly("parameters", &Strategy::parameters)
      .def_property_readonly(
          "kind", [](const Strategy& strategy) { return name_of(strategy.kind); },
          "'spring rule', 'spring rule, updated', 'cell law' or 'wrapper'.")
      .def("constants", &constants_of, py::arg("body"), py::arg("material"), py::arg("parameters") = ParameterValues{},
           "The spring constants [N/m] that a spring rule gives a body, (m,).")
      .def("__reduce__", &reduced_strategy)
      .def("__repr__", [](const Strategy& s) { return "<elastin.Strategy " + s.name + ": " + s.summary + ">"; });
  module.def("_catalog", [](const py::list& own) {
    py::object catalog = py::cast(std::make_shared<Catalog>(built_in_catalog()));
    for (const py::handle strategy : own) catalog.attr("add")(strategy);
    return catalog;
  });
  py::class_<Catalog, std::shared_ptr<Catalog>>(module, "Catalog", py::dynamic_attr(),
                                                "Strategies by name: those of Elastin, and one's own.")
      .def(py::init(&built_in_catalog), "Those that come with Elastin.")
      .def(
          "add",
          [](const py::object& self, const py::object& own) {
            auto& catalog = self.cast<Catalog&>();
            if (py::isinstance<Strategy>(own))
              catalog.add(own.cast<const Strategy&>());
            else if (py::isinstance<LoadKind>(own))
              catalog.loads.add(own.cast<const LoadKind&>());
            else if (py::isinstance<StepperKind>(own))
              catalog.steppers.add(own.cast<const StepperKind&>());
            else
              throw InputError("own: is " + py::repr(own).cast<std::string>() +
                               "; allowed: a Strategy, a Load or a Stepper");
            if (!py::hasattr(self, "_own")) self.attr("_own") = py::list();
            self.attr("_own").cast<py::list>().append(own);
          },
          py::arg("own"),
          "A strategy, a load or a stepper of one's own, which scenes then may name; its name must be "
          "new.")
      .def("__reduce__",
           [](const py::object& self) {
             return py::make_tuple(py::module_::import("elastin._again").attr("catalog"),
                                   py::make_tuple(py::getattr(self, "_own", py::list())));
           })
      .def_property_readonly("names", &Catalog::names)
      .def("__getitem__", py::overload_cast<const std::string&>(&Catalog::find, py::const_), py::arg("name"),
           py::return_value_policy::copy)
      .def("__len__", [](const Catalog& catalog) { return catalog.strategies().size(); })
      .def("__iter__", [](const Catalog& catalog) { return py::iter(py::cast(catalog.strategies())); })
      .def("__repr__", [](const Catalog& c) {
        return "<elastin.Catalog: " + std::to_string(c.strategies().size()) + " strategies>";
      });
}

}  // namespace elastin::python
