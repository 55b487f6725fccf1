#include "lab/study/study.h"
#include "python/bind.h"

namespace elastin::python {
using namespace lab;
namespace {

std::shared_ptr<HeldScene> hold(std::string yaml, const std::vector<std::shared_ptr<Body>>& bodies,
                                const std::vector<Material>& materials) {
  auto held = std::make_shared<HeldScene>(HeldScene{std::move(yaml)});
  held->bodies.assign(bodies.begin(), bodies.end());
  for (const Material& material : materials) held->materials.push_back(std::make_shared<Material>(material));
  return held;
}

py::dict dict_of(const SceneKey& key) {
  using py::arg;
  return py::dict(arg("name") = key.name, arg("type") = key.type, arg("unit") = key.unit, arg("range") = key.range,
                  arg("default") = key.fallback, arg("text") = key.text);
}

py::list experiments() {
  py::list rows;
  const ExperimentCatalog catalog = built_in_experiments();
  for (const ExperimentInfo& info : catalog.experiments()) {
    py::list keys;
    for (const SceneKey& key : keys_of(info)) keys.append(dict_of(key));
    rows.append(py::dict(py::arg("name") = info.name, py::arg("summary") = info.summary,
                         py::arg("source") = info.source, py::arg("in_time") = info.in_time, py::arg("keys") = keys));
  }
  return rows;
}

const char* verdict_word(CaseResult result) {
  return result == CaseResult::passed ? "passed" : result == CaseResult::failed ? "failed" : "not judged";
}

py::dict dict_of(const Verdict& verdict) {
  using py::arg;
  const Expectation& wanted = verdict.expectation;
  const bool stop = !wanted.outcome.empty();
  return py::dict(arg("measure") = wanted.measure, arg("value") = wanted.value, arg("measured") = verdict.measured,
                  arg("difference") = verdict.difference, arg("passed") = verdict.passed,
                  arg("judged") = verdict.judged, arg("source") = wanted.source,
                  arg("outcome") = stop ? wanted.outcome : "converged");
}

/// One dict a case of the scene, as `elastin verify` judges it.
py::list verify(const GivenScene& scene, const std::vector<std::string>& overrides,
                const std::shared_ptr<Catalog>& given, const std::optional<py::function>& progress) {
  const Catalog catalog = given ? *given : built_in_catalog();
  VerifyOptions options;
  options.overrides = overrides;
  options.progress = progress_of(progress);
  const std::vector<Case> cases = interruptible([&] { return verify_scene(source_of(scene), catalog, options); });
  py::list list;
  for (const Case& one : cases) {
    const Record& own = one.own;
    py::list expectations;
    for (const Verdict& verdict : own.verdicts) expectations.append(dict_of(verdict));
    py::dict measures;
    for (const auto& [name, value] : own.run.measures.all()) measures[name.c_str()] = value;
    list.append(py::dict(py::arg("scene") = own.scene, py::arg("strategy") = own.run.strategy,
                         py::arg("verdict") = verdict_word(result_of(one)), py::arg("outcome") = outcome_name(own.run),
                         py::arg("cause") = one.trouble.empty() ? own.run.cause : one.trouble,
                         py::arg("expectations") = expectations, py::arg("measures") = measures,
                         py::arg("seconds") = own.run.build_seconds + own.run.solve_seconds));
  }
  return list;
}

}  // namespace

void add_scenes(py::module_& module) {
  py::class_<HeldScene, std::shared_ptr<HeldScene>>(module, "_HeldScene")
      .def(py::init(&hold), py::arg("yaml"), py::arg("bodies"), py::arg("materials"));
  module.def("_experiments", &experiments);
  module.def("_verify", &verify, py::arg("scene"), py::arg("overrides"), py::arg("catalog"), py::arg("progress"));
  module.def("_suggestion", &suggestion, py::arg("word"), py::arg("candidates"));
}

}  // namespace elastin::python
