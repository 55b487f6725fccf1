#include <chrono>

#include "elastin/core/simulation/parts.h"
#include "elastin/core/solve/statics.h"
#include "lab/run/uniform_block.h"
#include "web/lab_handle.h"

using elastin::c::given;
using elastin::c::guarded;
using namespace elastin;

/// A method to load the body, step by step.
struct Drawing {
  Simulation simulation;
  std::unique_ptr<lab::StaticExperiment> experiment;
  std::unique_ptr<lab::StaticRig> rig;
  State state;
  lab::Start start;
  int steps, done = 0;
};

struct elastin_lab_test {
  Material material;
  std::shared_ptr<const Strategy> law;  ///< whose value is the target; null: what the material states
  StaticOptions options;
  std::vector<std::unique_ptr<Drawing>> drawings;  ///< the scene's own, and on to the strain
  std::size_t now = 0;
  VectorX tensions;
};

namespace {

std::unique_ptr<Drawing> make_drawing(const elastin_lab& lab, const elastin_lab_settings& settings,
                                      const lab::TensionSetup& setup) {
  auto drawing = std::make_unique<Drawing>(Drawing{lab.simulation(settings, true), nullptr, nullptr, {}, {}, 1});
  const Body& body = drawing->simulation.body();
  Model& model = drawing->simulation.model();
  lab::TensionSetup under = setup;
  under.density *= settings.density / lab.parcel.material.density;
  drawing->experiment = lab::make_tension(body, under);
  drawing->experiment->set_further_supports(lab.parcel.further_supports);
  model.supports.clear();  // bone, which the grips may move
  drawing->rig = drawing->experiment->static_rig(model);
  fix_rigid_parts(model);
  drawing->state = state_at_rest(body);
  model.declare_history(drawing->state);
  drawing->steps = drawing->experiment->load_steps();
  return drawing;
}

/// The scene's other loads, its rest and its muscles act before anything is measured.
StaticResult begin(Drawing& drawing, const StaticOptions& options) {
  Model& model = drawing.simulation.model();
  drawing.rig->set_load(0);
  model.measure_rest_force();
  const bool rest = model.rest_force() == 0 && model.load_forces(drawing.state).isZero(0);
  StaticResult result;
  if (!rest) result = solve_static(model, drawing.state, options);
  drawing.start.positions = drawing.state.positions;
  drawing.start.reactions =
      rest ? Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size())) : result.reactions;
  return result;
}

lab::TensionSetup drawn_on(const lab::TensionSetup& scene, const Body& body, double strain, int steps) {
  lab::TensionSetup setup = scene;
  const VectorX heights = body.rest.transpose() * setup.axis.normalized();
  setup.force.reset();
  setup.gravity.reset();
  setup.displacement = strain * (heights.maxCoeff() - heights.minCoeff());
  setup.load_steps = steps;
  setup.cycle.clear();
  return setup;
}

/// The law that the material states, or else the strategy's own on cells; null where springs have no law.
std::shared_ptr<const Strategy> law_of(const elastin_lab& lab, const elastin_lab_settings& settings) {
  const lab::Parcel& parcel = lab.parcel;
  const Material& material = parcel.material;
  if (!parcel.body.parts.empty() || material.varies() || material.active || parcel.linear) return nullptr;
  const int dimensions = parcel.body.tetrahedra.empty() && !parcel.body.triangles.empty() ? 2 : 3;
  const std::string label = &given(settings.strategy, "strategy");
  std::string name = label;
  for (const lab::Parcel::Strategy& own : parcel.strategies)
    if (own.label == label) name = own.name;
  Strategy law = c::strategy_of(name.c_str());
  if (material.law || material.curve)
    law = c::catalog().find(StrategyName::of_law(material.law ? material.law->law : "curve", dimensions));
  return law.kind == StrategyKind::cell_law ? std::make_shared<const Strategy>(std::move(law)) : nullptr;
}

/// E and ν to compare a reading with; NaN: none.
struct Target {
  double modulus = NAN, ratio = NAN;
  bool of_law = false;
};

/// Below it a secant is the slope at rest.
constexpr double kNoStrain = 1e-6;
/// Of the material's modulus: what resists less has no modulus.
constexpr double kNoResistance = 1e-9;

/// As lab::make_record has it: those of the material with its fibres, or the law's own at the strain.
Target target_of(const elastin_lab_test& test, const Drawing& drawing, const lab::Measures& measures) {
  Target target;
  for (const lab::MainMeasure& measure : drawing.experiment->main_measures(test.material, measures))
    if (measure.name == "effective_modulus")
      target.modulus = measure.prescribed;
    else if (measure.name == "poissons_ratio")
      target.ratio = measure.prescribed;
  const auto uniform = test.law && std::isfinite(target.modulus) ? drawing.experiment->uniform(measures) : std::nullopt;
  if (!uniform || !(std::abs(uniform->strain) > kNoStrain)) return target;
  const auto own = lab::measured_on_block(*uniform, drawing.simulation.body(), *test.law, test.material, {});
  return own ? Target{own->get("effective_modulus"), own->get("poissons_ratio"), true} : target;
}

/// A page that waits for one step answers to nothing else [s].
constexpr int kLongestStep = 10;

elastin_status advance(elastin_lab_test& test, elastin_lab_reading* out) {
  using Clock = std::chrono::steady_clock;
  test.options.stop = [end = Clock::now() + std::chrono::seconds(kLongestStep)] { return Clock::now() > end; };
  Drawing* drawing = test.drawings[test.now].get();
  if (drawing->done == drawing->steps) {
    if (test.now + 1 == test.drawings.size()) throw InputError("the test is over");
    drawing = test.drawings[++test.now].get();
  }
  StaticResult result;
  if (drawing->done == 0) result = begin(*drawing, test.options);
  if (result.outcome == Outcome::converged) {
    drawing->rig->set_load(drawing->experiment->load_factor(++drawing->done));
    result = solve_static(drawing->simulation.model(), drawing->state, test.options);
  }
  if (result.outcome == Outcome::interrupted)
    return c::failed(ELASTIN_STOPPED,
                     "a step of the test took more than 10 s, and the test was given up: pull less far");
  if (result.outcome != Outcome::converged) return c::failed(ELASTIN_STOPPED, result.cause.c_str());
  drawing->simulation.model().commit_step(drawing->state);
  const lab::Measures measures = drawing->rig->measure(drawing->start, drawing->state, test.options, result);
  const bool last = drawing->done == drawing->steps && test.now + 1 == test.drawings.size();
  const bool own = test.now == 0, own_end = own && drawing->done == drawing->steps;
  const double modulus = measures.get("effective_modulus");
  if (own_end && std::abs(modulus) < kNoResistance * test.material.youngs_modulus)
    return c::failed(ELASTIN_STOPPED,
                     "the body does not resist this pull, as it folds or moves as a mechanism: it shows no modulus");
  const Target target = own_end ? target_of(test, *drawing, measures) : Target{};
  const elastin_lab_reading reading{0,
                                    own + own_end,
                                    last,
                                    target.of_law,
                                    measures.get("strain"),
                                    measures.get("stress"),
                                    modulus,
                                    measures.get("poissons_ratio"),
                                    target.modulus,
                                    target.ratio};
  c::put(reading, out, "elastin_lab_reading");
  return ELASTIN_OK;
}

}  // namespace

extern "C" {

elastin_status elastin_lab_test_begin(const elastin_lab* lab, const elastin_lab_settings* settings, double strain,
                                      int steps, elastin_lab_test** test) {
  return guarded([&] {
    given(test, "test");
    const lab::Parcel& parcel = given(lab, "lab").parcel;
    if (!(strain > -0.9 && strain < 10 && steps > 0 && steps < 10000))
      throw InputError("the strain must lie between -0.9 and 10, the steps between 1 and 9999");
    const elastin_lab_settings chosen = c::checked_copy(settings, "elastin_lab_settings");
    auto made = std::make_unique<elastin_lab_test>();
    made->material = given(lab, "lab").material(chosen);
    made->law = law_of(*lab, chosen);
    made->options.linear = parcel.linear;
    made->options.tolerance = parcel.tolerance;
    made->drawings.push_back(make_drawing(*lab, chosen, parcel.tension));
    made->drawings.push_back(make_drawing(*lab, chosen, drawn_on(parcel.tension, parcel.body, strain, steps)));
    *test = made.release();
  });
}

elastin_status elastin_lab_test_step(elastin_lab_test* test, elastin_lab_reading* reading) {
  return guarded([&] { return advance(given(test, "test"), reading); });
}

elastin_status elastin_lab_test_positions(const elastin_lab_test* test, const double** values, size_t* count) {
  return guarded([&] { c::show(given(test, "test").drawings[test->now]->state.positions, values, count); });
}

elastin_status elastin_lab_test_tensions(elastin_lab_test* test, const double** values, size_t* count) {
  return guarded([&] {
    const Drawing& drawing = *given(test, "test").drawings[test->now];
    const Body& body = drawing.simulation.body();
    test->tensions = drawing.simulation.model().force_densities(drawing.state.positions);
    for (int connection = 0; connection < body.connections.size(); ++connection) {
      const auto& [a, b] = body.connections.ends[connection];
      test->tensions[connection] *= (drawing.state.positions.col(b) - drawing.state.positions.col(a)).norm();
    }
    c::show(test->tensions, values, count);
  });
}

void elastin_lab_test_free(elastin_lab_test* test) { delete test; }
}
