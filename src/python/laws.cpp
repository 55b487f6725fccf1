#include "elastin/core/simulation/energy_law.h"
#include "python/bind.h"

namespace elastin::python {
namespace {

using Operation = std::tuple<std::string, std::vector<int>, double, std::string>;

Strategy make_law(const std::string& name, const std::vector<Operation>& operations,
                  const std::vector<ParameterInfo>& parameters, const std::string& summary, const std::string& source,
                  int dimensions) {
  std::vector<EnergyOperation> list;
  for (const auto& [kind, of, number, parameter] : operations) list.push_back({kind, of, number, parameter});
  Strategy law = make_energy_law(name, EnergyExpression(std::move(list)), parameters, dimensions);
  law.summary = summary;
  law.source = source;
  return law;
}

}  // namespace

void add_laws(py::module_& module) {
  module.def("_energy_law", &make_law, py::arg("name"), py::arg("operations"), py::arg("parameters"),
             py::arg("summary"), py::arg("source"), py::arg("dimensions"));
  module.def("_energy_operations", [] {
    py::dict takes;
    for (const auto& [name, count] : energy_operations()) takes[name.c_str()] = count;
    return takes;
  });
}

}  // namespace elastin::python
