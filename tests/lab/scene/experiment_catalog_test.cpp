// The table of experiments: its rows are true, and a program adds its own.

#include "elastin/lab/experiment/experiment_catalog.h"

#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "elastin/core/base/error.h"
#include "elastin/lab/study/laboratory.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

const std::string kBody =
    "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 3], size: [10 mm, 10 mm, 30 mm]}}\n"
    "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\n"
    "stiffness: neo_hookean\n";

/// Keys without which a kind is refused before its unknown keys are.
const std::map<std::string, std::string> kNeeded{
    {"tension", ""},
    {"compression", ""},
    {"biaxial", "strain: 1 %"},
    {"planar", "strain: 1 %"},
    {"shear", "direction: x"},
    {"torsion", "angle: 1 deg"},
    {"hydrostatic", "strain: 1 %"},
    {"bending", "direction: x, axis: z"},
    {"inflation", ""},
    {"material", ""},
    {"bubble", "pressure: 1 kPa"},
    {"indentation", "indenter: ball"},
    {"press", ""},
    {"sliding", ""},
    {"loads", ""},
    {"motion", "fixture: {kind: tension, axis: z, force: 1 mN}"},
    {"release", "fixture: {kind: tension, axis: z, force: 1 mN}"},
    {"creep", "fixture: {kind: tension, axis: z, force: 1 mN}"},
    {"relaxation", "fixture: {kind: tension, axis: z, displacement: 1 mm}, ramp: 1 s"},
    {"cyclic", "fixture: {kind: tension, axis: z, displacement: 1 mm}, frequency: 1 Hz"},
    {"shake", "amplitude: 1 mm, frequency: 1 Hz"},
    {"drop", ""},
    {"parachute", ""},
    {"vibration", ""}};

/// The keys that a scene's message names as allowed where one is unknown.
std::set<std::string> allowed_keys(const std::string& kind) {
  const TemporaryFolder folder;
  const std::string needed = kNeeded.at(kind);
  std::string message;
  try {
    load_scene(folder.write("slip.yaml", kBody + "experiment: {kind: " + kind + ", qqqqqqqqqqqqqqq: 1" +
                                             (needed.empty() ? "" : ", " + needed) + "}\n"),
               built_in_catalog());
  } catch (const InputError& error) {
    message = error.what();
  }
  INFO(message);
  const std::string before = "unknown key 'qqqqqqqqqqqqqqq'; allowed: ";
  const std::size_t at = message.find(before);
  REQUIRE(at != std::string::npos);
  std::istringstream list(message.substr(at + before.size()));
  std::set<std::string> keys;
  for (std::string key; list >> key;) keys.insert(key.ends_with(',') ? key.substr(0, key.size() - 1) : key);
  return keys;
}

/// A host's own: the lower end fixed, the upper one pulled away.
class Pull final : public StaticExperiment {
 public:
  Pull(const Body& body, double displacement) : body_(body), displacement_(displacement) {}
  std::string name() const override { return "pull"; }
  MeasureList measures() const override {
    return {{{"force", dimension::force, "pull on the upper end", MeasureRole::force},
             {"grip_work", dimension::energy, "half of force times displacement"}},
            {{"load", "force", true}}};
  }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;
  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override { return {{"force"}}; }

 private:
  friend class PullRig;
  const Body& body_;
  double displacement_;
};

class PullRig final : public StaticRig {
 public:
  PullRig(const Pull& pull, Model& model) : pull_(pull), model_(model) {
    const auto height = pull.body_.rest.row(2);
    for (int molecule = 0; molecule < pull.body_.size(); ++molecule)
      if (height[molecule] == height.minCoeff() || height[molecule] == height.maxCoeff())
        model.supports.push_back({molecule});
  }
  void set_load(double factor) override {
    for (Support& support : model_.supports)
      if (is_upper(support)) support.displacement.z() = factor * pull_.displacement_;
  }
  Measures measure(const Start&, const State&, const StaticOptions&, StaticResult& solved) const override {
    double force = 0;
    for (std::size_t i = 0; i < model_.supports.size(); ++i)
      if (is_upper(model_.supports[i])) force += solved.reactions(2, static_cast<Eigen::Index>(i));
    Measures measures;
    measures.set("force", force);
    measures.set("grip_work", force * pull_.displacement_ / 2);
    return measures;
  }

 private:
  bool is_upper(const Support& support) const {
    return pull_.body_.rest(2, support.molecule) == pull_.body_.rest.row(2).maxCoeff();
  }
  const Pull& pull_;
  Model& model_;
};

std::unique_ptr<StaticRig> Pull::make_rig(Model& model) const { return std::make_unique<PullRig>(*this, model); }

ExperimentInfo pull_info() {
  return {.name = "pull",
          .summary = "both ends fixed, one pulled away",
          .source = "",
          .parameters = {{"by", dimension::length, 0, 1, 0.001, "displacement of the upper end"}},
          .make = [](const ExperimentContext& context, const ParameterValues& values) -> std::unique_ptr<Experiment> {
            if (context.body.size() < 2) throw InputError("a single molecule cannot be pulled apart");
            return std::make_unique<Pull>(context.body, values.at("by"));
          }};
}

}  // namespace

TEST_CASE("every experiment of the table names the keys that its scenes may write", "[scene][experiment]") {
  const ExperimentCatalog catalog = built_in_experiments();
  CHECK(catalog.experiments().size() == kNeeded.size());
  for (const ExperimentInfo& info : catalog.experiments()) {
    INFO(info.name);
    CHECK_FALSE(info.summary.empty());
    std::set<std::string> keys{"kind"};
    for (const SceneKey& key : keys_of(info)) {
      CHECK_FALSE(key.text.empty());
      keys.insert(key.name.substr(0, key.name.find('.')));
    }
    CHECK(keys == allowed_keys(info.name));
  }
}

TEST_CASE("what takes time is named from the table", "[scene][experiment]") {
  const TemporaryFolder folder;
  const std::string text = kBody + "experiment: {kind: tension, axis: z, force: 1 mN}\ntime: {duration: 1 s}\n";
  CHECK_THROWS_WITH(load_scene(folder.write("scene.yaml", text), built_in_catalog()),
                    Contains("those that do are sliding, motion, release, creep, relaxation, cyclic, shake, drop and "
                             "parachute"));
}

TEST_CASE("a program's own experiment runs in scenes", "[scene][experiment][laboratory]") {
  ExperimentCatalog catalog = built_in_experiments();
  catalog.add(pull_info());
  CHECK_THROWS_WITH(catalog.add(pull_info()), Contains("there is an experiment 'pull' already"));
  CHECK_THROWS_WITH(catalog.add({.name = "nothing", .summary = "", .source = ""}),
                    Contains("neither `make` nor `read`"));
  const TemporaryFolder folder;
  const auto force = [&](const std::string& experiment) {
    const std::string path = folder.write("scene.yaml", kBody + "experiment: {" + experiment + "}\n");
    return Laboratory(path, {}, built_in_catalog(), catalog).run().get("force");
  };
  const std::string clamped = "fixed_grip: clamped, loaded_grip: clamped";
  CHECK(force("kind: pull, by: 3 mm") ==
        Approx(force("kind: tension, axis: z, displacement: 3 mm, " + clamped)).epsilon(1e-9));
  const LaboratoryResult run =
      Laboratory(folder.write("own.yaml", kBody + "experiment: {kind: pull}\nexpect: [{measure: grip_work, value: 1 J, "
                                                  "not_reproduced: unit alone, source: test}]\n"),
                 {}, built_in_catalog(), catalog)
          .run();
  CHECK(run.get("grip_work") == Approx(run.get("force") * 0.001 / 2));
  CHECK(run.measures[1].unit == "J");
  CHECK(force("kind: pull") == Approx(force("kind: pull, by: 1 mm")).epsilon(1e-12));
  CHECK_THROWS_WITH(force("kind: pull, by: 2 m"), Contains("experiment.by: '2 m' is out of range"));
  CHECK_THROWS_WITH(force("kind: pull, buy: 2 mm"), Contains("did you mean 'by'?"));
  CHECK_THROWS_WITH(force("kind: pul"), Contains("did you mean 'pull'?"));
}

TEST_CASE("one experiment holds several models at a time", "[experiment]") {
  const TemporaryFolder folder;
  const auto scene = load_scene(
      folder.write("scene.yaml", kBody + "experiment: {kind: tension, axis: z, force: 10 mN}\n"), built_in_catalog());
  const StaticExperiment& tension = *scene->experiment->at_rest();
  const Body& body = scene->specimen.body;
  Model first(body), second(body);
  const auto first_rig = tension.static_rig(first), second_rig = tension.static_rig(second);
  first_rig->set_load(1);
  second_rig->set_load(0.25);
  const auto pull = [&](const Model& model) { return model.load_forces(state_at_rest(body)).row(2).sum(); };
  CHECK(pull(first) == Approx(0.01));
  CHECK(pull(second) == Approx(0.0025));
  StaticResult solved;
  solved.reactions = Positions::Zero(3, static_cast<Eigen::Index>(first.supports.size()));
  const auto measured = [&](const StaticRig& rig) {
    return rig.measure({body.rest, solved.reactions}, state_at_rest(body), {}, solved).get("force");
  };
  CHECK(measured(*first_rig) == Approx(0.01));
  CHECK(measured(*second_rig) == Approx(0.0025));
}
