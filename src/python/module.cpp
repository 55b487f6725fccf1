#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/parallel/threads.h"
#ifdef ELASTIN_FEBIO
#include "elastin/febio/febio.h"
#endif
#include "elastin/openmp/openmp.h"
#include "lab/report/comparison.h"
#include "python/bind.h"

namespace elastin::python {
using namespace lab;
namespace {

/// A measure of an experiment's own, which no table of all has, is shown as others of its unit.
std::string readable_measure(const std::string& name, double value, const std::string& unit) {
  const MeasureList& known = built_in_measures();
  const MeasureInfo* info = known.find(name);
  for (auto other = known.begin(); !info && !unit.empty() && other != known.end(); ++other)
    if (other->unit_text() == unit) info = &*other;
  return info ? value_text(value, *info) : number(value) + (unit.empty() ? "" : " " + unit);
}

std::string missing_measure(const std::string& name, const std::vector<std::string>& there) {
  return "no measure '" + name + "' here" + suggestion(name, there);
}

std::vector<std::tuple<std::string, std::string, std::string>> measures() {
  std::vector<std::tuple<std::string, std::string, std::string>> list;
  for (const MeasureInfo& info : built_in_measures()) list.emplace_back(info.name, info.unit_text(), info.text);
  return list;
}

PyObject* missing_file_error = nullptr;  // of the interpreter

/// A file that is not there is FileNotFoundError too; a value of a wrong type that nothing else has named is said.
void translate(std::exception_ptr pointer) {
  try {
    std::rethrow_exception(std::move(pointer));
  } catch (const InputError& error) {
    const std::string_view text = error.what();
    if (text.find("no such file") == text.npos && text.find("No such file") == text.npos) throw;
    PyErr_SetString(missing_file_error, error.what());
  } catch (const py::cast_error&) {
    PyErr_SetString(PyExc_TypeError, "a value is of another type than is allowed here");
  }
}

}  // namespace
}  // namespace elastin::python

PYBIND11_MODULE(_elastin, module) {
  using namespace elastin::python;
  elastin::openmp::use_openmp();
#ifdef ELASTIN_FEBIO
  elastin::febio::add_scene_format();
#endif
  module.doc() = "Elastin's C++ side; import elastin instead.";
  py::register_exception<elastin::InputError>(module, "InputError", PyExc_ValueError).doc() =
      "Wrong use or wrong input: file:line:column, the key, what was given, what is allowed, the nearest name.";
  missing_file_error = PyErr_NewExceptionWithDoc(
      "elastin.MissingFileError", "A file that is not there: InputError and FileNotFoundError.",
      py::make_tuple(module.attr("InputError"), py::handle(PyExc_FileNotFoundError)).ptr(), nullptr);
  module.attr("MissingFileError") = py::reinterpret_borrow<py::object>(missing_file_error);
  py::register_exception_translator(&translate);
  module.attr("__version__") = ELASTIN_VERSION;
  module.def("set_threads", &elastin::set_threads, py::arg("threads"),
             "How many threads loops over large bodies take; 0 = one a core. Results are bitwise identical with any.");
  module.def("threads", &elastin::threads, "How many threads loops over large bodies take.");
  module.def("measures", &measures, "Every measure that an experiment can take: (name, SI unit, description).");
  module.def("_missing_measure", &missing_measure, py::arg("name"), py::arg("there"));
  module.def("readable", &readable_measure, py::arg("measure"), py::arg("value"), py::arg("unit") = "",
             "A measure's value as tables show it: '4.9945 kPa'. `unit`: of a measure that only its experiment knows.");
  module.def("percent", &elastin::lab::percent, py::arg("ratio"), "A relative error as tables show it: '+0.02 %'.");
  module.def("readable_seconds", &elastin::lab::readable_seconds, py::arg("seconds"), "'1.2 ms'.");
  add_bodies(module);
  add_surfaces(module);
  add_strategies(module);
  add_own_loads(module);
  add_own_experiments(module);
  add_simulation(module);
  add_laboratory(module);
  add_identify(module);
  add_scenes(module);
  add_laws(module);
}
