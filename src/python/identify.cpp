#include "lab/identify/identify.h"

#include "lab/report/plot.h"
#include "python/bind.h"

namespace elastin::python {
using namespace lab;
namespace {

/// The result of an identification, one answer a strategy.
struct Answers {
  std::vector<Answer> all;
  const Answer& at(std::size_t number) const { return all.at(number); }
};

Answers identified(const GivenScene& scene, const std::shared_ptr<Catalog>& catalog, IdentifyRequest request,
                   const std::optional<py::function>& progress) {
  request.progress = progress_of(progress);
  request.stop = &stop_requested;
  const Catalog known = catalog ? *catalog : built_in_catalog();
  return interruptible([&] { return Answers{lab::identify(source_of(scene), known, request)}; });
}

}  // namespace

void add_identify(py::module_& module) {
  py::class_<Answers>(module, "_Answers")
      .def("json", [](const Answers& self) { return identify_json(self.all); })
      .def("text", [](const Answers& self, std::size_t number) { return answer_text(self.at(number), false); })
      .def("figure",
           [](const Answers& self, std::size_t number) { return svg_text(fit_plot(self.at(number)), 760, true); })
      .def("points", [](const Answers& self, std::size_t number) { return points_csv(self.at(number)); })
      .def("page", [](const Answers& self) { return identify_page(self.all, ""); });
  module.def("_data_quantities", [] {
    py::dict units;
    for (const DataQuantity& quantity : data_quantities())
      units[quantity.name.c_str()] = quantity.ratio ? "" : si_unit(quantity.unit);
    return units;
  });
  module.def(
      "_identify",
      [](const GivenScene& scene, std::vector<std::string> overrides, std::vector<std::string> data,
         std::vector<std::string> tests, const std::string& laws, const std::string& strategies,
         const std::shared_ptr<Catalog>& catalog, const std::optional<py::function>& progress) {
        IdentifyRequest request;
        request.overrides = std::move(overrides), request.data = std::move(data), request.tests = std::move(tests);
        request.laws = laws, request.strategies = strategies;
        return identified(scene, catalog, std::move(request), progress);
      },
      py::arg("scene"), py::arg("overrides"), py::arg("data"), py::arg("tests"), py::arg("laws"), py::arg("strategies"),
      py::arg("catalog"), py::arg("progress"));
}

}  // namespace elastin::python
