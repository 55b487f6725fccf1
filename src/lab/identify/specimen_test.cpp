#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lab/experiment/repeated_curve.h"
#include "lab/identify/measured_test.h"
#include "lab/scene/scene.h"

namespace elastin::lab {
namespace {

constexpr double kAgreement = 1e-6;  // of what the scene prescribes with what was measured

/// What the specimen keeps of its own material: all that no law has.
Material on_specimen(Material material, const Material& own) {
  material.density = own.density, material.thickness = own.thickness, material.fibre = own.fibre;
  material.bending_rigidity = own.bending_rigidity;
  return material;
}

class SpecimenTest final : public MeasuredTest {
 public:
  SpecimenTest(const DataTest& test, MeasuredData data, std::unique_ptr<Scene> scene, const StrategyChoice& choice)
      : MeasuredTest(std::move(data)), scene_(std::move(scene)), choice_(choice), own_(scene_->specimen.material) {
    protocol_ = scene_->experiment->at_rest();
    if (!protocol_) test.fail("scene: " + scene_->path + " runs in time; identification needs an experiment at rest");
    if (scene_->statics.linear)
      test.fail("scene: " + scene_->path + " takes small displacements; leave out solver.small_displacements");
    if (!scene_->specimen.materials.empty()) test.fail("scene: " + scene_->path + " has several bodies");
    options_.statics = scene_->statics;
    prepare(scene_->specimen, choice_.strategy);
    if (const std::string reason = unsuited(scene_->specimen, *protocol_, choice_); !reason.empty())
      test.fail("scene: " + choice_.label + " " + reason);
    curve_.emplace(load_factors(test), options_.statics);
  }

  std::optional<Prediction> predict(const TestedMaterial& tested) override {
    scene_->specimen.material = on_specimen(tested.material, own_);
    const std::optional<HeldModel> held = model();
    if (!held) return std::nullopt;
    const std::vector<std::vector<HeldModel>> changed = changed_models(tested);
    scene_->specimen.material = own_;
    if (!changed_) return std::nullopt;
    Model& own = *held->model;
    StaticRig& rig = *held->rig->at_rest();
    Prediction result{VectorX::Zero(data_.y.size()),
                      MatrixX::Zero(data_.y.size(), static_cast<Eigen::Index>(tested.changes.size()))};
    const Start start{scene_->specimen.body.rest, Positions::Zero(3, static_cast<Eigen::Index>(own.supports.size()))};
    const auto visit = [&](std::size_t step, const State& state, StaticResult& solved) {
      const Measures measures = rig.measure(start, state, options_.statics, solved);
      const Eigen::Index point = order_[step];
      const double at = measures.get(along_), response = measures.get(up_);
      if (std::abs(at - data_.x[point]) > kAgreement * std::abs(whole_))
        throw InputError(scene_->path + ": shows " + along_ + " " + fmt::format("{:.6g}", at) +
                         " at the load that should give " + fmt::format("{:.6g}", data_.x[point]) +
                         "; the data must be over what the scene prescribes");
      result.values[point] = response;
      for (std::size_t change = 0; change < changed.size(); ++change) {
        const auto slope = slope_of(own, rig, start, state, solved, changed[change], tested.changes[change]);
        if (!slope) {
          why_ = "the stiffness at an equilibrium could not be solved";
          return false;
        }
        result.slopes(point, static_cast<Eigen::Index>(change)) = *slope;
      }
      return std::isfinite(response);
    };
    if (curve_->solve(own, rig, visit)) return result;
    if (!curve_->cause().empty()) why_ = "no equilibrium of the specimen: " + curve_->cause();
    return std::nullopt;
  }

 private:
  std::optional<HeldModel> model() {
    Run run;
    auto held = make_model(scene_->specimen, *protocol_, choice_, options_, run);
    if (!held) why_ = run.cause;
    return held;
  }

  std::vector<std::vector<HeldModel>> changed_models(const TestedMaterial& tested) {
    std::vector<std::vector<HeldModel>> changed;
    changed_ = true;
    for (const MaterialChange& change : tested.changes) {
      std::vector<HeldModel> models;
      for (const Material& other : change.materials) {
        scene_->specimen.material = on_specimen(other, own_);
        if (auto held = model()) models.push_back(std::move(*held));
      }
      changed_ &= models.size() == change.materials.size();
      changed.push_back(std::move(models));
    }
    return changed;
  }

  /// Where a number changes the supports' forces alone, what is left on free molecules is rounding, which no motion
  /// balances.
  static void leave_out_rounding(const Model& model, Positions& forces) {
    Positions fixed = Positions::Zero(3, forces.cols());
    for (const Support& support : model.supports) {
      const Vector3 force = forces.col(support.molecule);
      fixed.col(support.molecule) = force - support.free * force;
    }
    if ((forces - fixed).norm() < 1e-8 * forces.norm()) forces = fixed;
  }

  /// ∂f/∂θ at the positions kept, then K dx = ∂f/∂θ, then the measure at both sides along dx.
  std::optional<double> slope_of(Model& own, const StaticRig& rig, const Start& start, const State& state,
                                 const StaticResult& solved, const std::vector<HeldModel>& models,
                                 const MaterialChange& change) const {
    Positions forces = Positions::Zero(3, state.positions.cols());
    for (std::size_t i = 0; i < models.size(); ++i)
      forces += change.weights[i] * models[i].model->elastic_forces(state.positions);
    leave_out_rounding(own, forces);
    StaticOptions options = options_.statics;
    options.tolerance = std::max(options.tolerance, 1e-8);  // differences of forces are known to some 1e-10
    const StaticResponse response =
        static_response(own, state.positions, forces, Positions::Zero(3, forces.cols()), options);
    if (response.result.outcome != Outcome::converged) return std::nullopt;
    const double step = 0.5 / std::abs(change.weights.front());
    double slope = 0;
    for (const double side : {1., -1.}) {
      State at = state;
      StaticResult beside = solved;
      at.positions += side * step * response.motion;
      beside.reactions += side * step * response.result.reactions;
      slope += side * rig.measure(start, at, options_.statics, beside).get(up_) / (2 * step);
    }
    return slope;
  }

  /// The name of the first of a quantity's measures that the scene shows.
  static std::string measure_of(const DataTest& test, const DataQuantity& quantity, const Measures& shown) {
    for (const std::string& name : quantity.measures)
      if (std::isfinite(shown.get(name))) return name;
    test.fail("scene: it shows no " + quantity.name + "; the data have one");
    return "";
  }

  /// What part of the scene's load each point is: what it prescribes is proportional to its load, which one solve for
  /// small displacements shows.
  std::vector<double> load_factors(const DataTest& test) {
    const std::optional<HeldModel> held = model();
    if (!held) test.fail("scene: " + why_);
    StaticRig& rig = *held->rig->at_rest();
    rig.set_load(0);
    if (!held->model->load_forces(state_at_rest(scene_->specimen.body)).isZero(0))
      test.fail("scene: " + scene_->path + " has loads of its own besides the experiment's; they are not taken");
    rig.set_load(1);
    StaticOptions small = options_.statics;
    small.linear = true;
    State state = state_at_rest(scene_->specimen.body);
    StaticResult solved = solve_static(*held->model, state, small);
    if (solved.outcome != Outcome::converged) test.fail("scene: its body cannot be solved: " + solved.cause);
    const Start start{scene_->specimen.body.rest,
                      Positions::Zero(3, static_cast<Eigen::Index>(held->model->supports.size()))};
    const Measures shown = rig.measure(start, state, small, solved);
    along_ = measure_of(test, *data_.along, shown), up_ = measure_of(test, *data_.up, shown);
    whole_ = shown.get(along_);
    leave_out_rest();
    order_.resize(static_cast<std::size_t>(data_.x.size()));
    std::iota(order_.begin(), order_.end(), 0);
    std::stable_sort(order_.begin(), order_.end(),
                     [&](auto a, auto b) { return std::abs(data_.x[a]) < std::abs(data_.x[b]); });
    std::vector<double> factors;
    for (const Eigen::Index point : order_) {
      const double factor = data_.x[point] / whole_;
      if (factor < 0 || factor > 1 + kAgreement)
        throw InputError(
            SourceLocation{data_.file, data_.lines[static_cast<std::size_t>(point)]},
            fmt::format("{} of {:.6g} is beyond what {} prescribes, {:.6g} (SI): change its load, or cut the "
                        "data by `from` and `to`",
                        data_.along->name, data_.x[point], scene_->path, whole_));
      factors.push_back(std::min(factor, 1.));
    }
    return factors;
  }

  /// At rest there is nothing to be measured.
  void leave_out_rest() {
    MeasuredData kept = data_;
    kept.lines.clear();
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < data_.x.size(); ++i) {
      if (data_.x[i] == 0) continue;
      kept.x[count] = data_.x[i], kept.y[count++] = data_.y[i];
      kept.lines.push_back(data_.lines[static_cast<std::size_t>(i)]);
    }
    kept.x.conservativeResize(count), kept.y.conservativeResize(count);
    data_ = std::move(kept);
  }

  std::unique_ptr<Scene> scene_;
  StrategyChoice choice_;
  Material own_;
  const StaticProtocol* protocol_ = nullptr;
  RunOptions options_;
  std::string along_, up_;  ///< measures
  double whole_ = 0;        ///< what the scene's whole load prescribes, SI
  std::vector<Eigen::Index> order_;
  std::optional<RepeatedCurve> curve_;
  bool changed_ = true;  ///< whether all changed materials could be set up
};

}  // namespace

std::unique_ptr<MeasuredTest> make_specimen_test(const DataTest& test, const Catalog& catalog,
                                                 const std::vector<std::string>& overrides,
                                                 const std::string& strategy) {
  MeasuredData data = load_data(test);
  auto scene = load_scene(test.scene, catalog, overrides);
  const StrategyChoice choice = strategy.empty() ? scene->stiffness : choose_strategy(*scene, catalog, strategy);
  return std::make_unique<SpecimenTest>(test, std::move(data), std::move(scene), choice);
}

}  // namespace elastin::lab
