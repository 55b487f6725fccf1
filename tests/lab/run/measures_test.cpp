#include "elastin/lab/run/measures.h"

#include <catch2/catch.hpp>
#include <map>

#include "elastin/lab/experiment/experiment_catalog.h"
#include "lab/report/records.h"
#include "lab/run/common_measures.h"
#include "lab/scene/scene.h"

using namespace elastin;
using namespace elastin::lab;

TEST_CASE("a measure has one unit and one label in all experiments, and a text in each", "[measures]") {
  std::map<std::string, const MeasureInfo*> known;
  const ExperimentCatalog experiments = built_in_experiments();
  for (const ExperimentInfo& experiment : experiments.experiments()) {
    CAPTURE(experiment.name);
    CHECK(experiment.measures.begin() != experiment.measures.end());
    for (const MeasureInfo& info : experiment.measures) {
      CAPTURE(info.name);
      CHECK_FALSE(info.text.empty());
      CHECK(common_measures().find(info.name) == nullptr);
      const MeasureInfo& first = *known.try_emplace(info.name, &info).first->second;
      CHECK(first.unit == info.unit);
      CHECK(first.label() == info.label());
      CHECK(first.unit_text() == info.unit_text());
    }
    for (const ResponseAxes& axes : experiment.measures.response)
      for (const std::string& name : {axes.x, axes.y})
        CHECK((name == "load" || name == "time" || experiment.measures.find(name)));
  }
}

TEST_CASE("a measure is known by its former name, in scenes and in records of earlier versions", "[measures]") {
  CHECK(find_measure("far_way").name == "far_displacement");
  const auto scene = load_scene(ELASTIN_SOURCE_DIR "/scenes/dynamics/shake.yaml", built_in_catalog(),
                                {"expect=[{measure: base_way, value: 1 mm, tolerance: 0.1, source: test}]"});
  CHECK(scene->expectations.front().measure == "base_displacement");
  Record record;
  record.run.measures.set("centre_way", 2);
  CHECK(record_of_json(json_line(record)).run.measures.get("centre_displacement") == 2);
  CHECK_THROWS_WITH(find_measure("far_displacment"), Catch::Contains("did you mean 'far_displacement'"));
}

TEST_CASE("a run's texts are those of its own experiment, after a journal too", "[measures]") {
  const auto scene = load_scene(ELASTIN_SOURCE_DIR "/scenes/tension/table1-a.yaml", built_in_catalog());
  const Record record = make_record(*scene, Run{});
  const Record again = record_of_json(json_line(record));
  for (const Record* one : {&record, &again}) {
    CHECK(one->measure("effective_modulus").text == "Young's modulus: secant F l0 / (A dl)");
    CHECK(one->measure(MeasureRole::stress) == "stress");
    REQUIRE(one->measures);
    CHECK(one->measures->response.front().y == "stress");
  }
  CHECK(json_line(again) == json_line(record));
}
