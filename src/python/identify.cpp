#include "lab/identify/identify.h"

#include "python/bind.h"

namespace elastin::python {
using namespace lab;
namespace {

/// The JSON of the command, a text for each answer.
std::string identify_text(const config::SceneSource& scene, IdentifyRequest request,
                          const std::optional<py::function>& progress) {
  const auto report = progress ? keep(*progress) : nullptr;
  request.progress = [&](const std::string& doing) {
    const py::gil_scoped_acquire locked;
    check_signals();
    if (report) (*report)(doing);
  };
  const py::gil_scoped_release others_run;
  return identify_json(lab::identify(scene, built_in_catalog(), request));
}

}  // namespace

void add_identify(py::module_& module) {
  module.def(
      "_identify",
      [](const GivenScene& scene, std::vector<std::string> overrides, std::vector<std::string> data,
         std::vector<std::string> tests, const std::string& laws, const std::string& strategies,
         const std::optional<py::function>& progress) {
        IdentifyRequest request;
        request.overrides = std::move(overrides), request.data = std::move(data), request.tests = std::move(tests);
        request.laws = laws, request.strategies = strategies;
        return identify_text(source_of(scene), std::move(request), progress);
      },
      py::arg("scene"), py::arg("overrides"), py::arg("data"), py::arg("tests"), py::arg("laws"), py::arg("strategies"),
      py::arg("progress"));
}

}  // namespace elastin::python
