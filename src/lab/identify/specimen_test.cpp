#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "config/scene_text.h"
#include "core/model/carried_points.h"
#include "core/solve/responses.h"
#include "elastin/core/base/text.h"
#include "lab/identify/measured_test.h"
#include "lab/run/load_path.h"
#include "lab/scene/scene.h"

namespace elastin::lab {
namespace {

constexpr double kNear = 0.2;         // of the path from rest: within it equilibria are predicted
constexpr double kRoughSlope = 1e-5;  // unbalanced force of a slope, during a search
constexpr double kAgreement = 1e-6;   // of what the scene prescribes with what was measured

/// What the specimen keeps of its own material: all that no law has.
Material on_specimen(Material material, const Material& own) {
  material.density = own.density, material.thickness = own.thickness, material.fibre = own.fibre;
  material.bending_rigidity = own.bending_rigidity;
  return material;
}

/// Points of a body as an observer at rest sees them move.
class SeenPoints {
 public:
  /// @param data of points; their places are completed
  SeenPoints(const Body& body, MeasuredData& data, const Matrix3& rotation, bool fixed)
      : data_(data), rotation_(rotation), fixed_(fixed), carried_(body, placed(body, data, rotation)) {
    const double size = (body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()).norm();
    for (int p = 0; p < carried_.size(); ++p)
      if (carried_.beyond[p] > kOutside * size)
        throw InputError(SourceLocation{data.file, data.lines[p]},
                         fmt::format("this point lies {:.3g} mm outside of the body; are its unit and its axes those "
                                     "of the scene, and is it where the point is at rest?",
                                     1e3 * carried_.beyond[p]));
  }

  /// The displacements that these readings show when the molecules are at `positions`; of a frame that moves, after the
  /// turn and shift of the whole body that bring them nearest to the measured ones.
  VectorX readings(const std::vector<Eigen::Index>& rows, const Positions& positions) const {
    const auto count = static_cast<Eigen::Index>(rows.size());
    Positions at = seen_at(rows, positions);
    if (!fixed_) move_frame(rows, at);
    VectorX shown(count);
    for (Eigen::Index i = 0; i < count; ++i)
      shown[i] = at(data_.axes[rows[i]], i) - data_.places(data_.axes[rows[i]], rows[i]);
    return shown;
  }

  /// How these readings change with the positions.
  ReadingSlopes slopes(const std::vector<Eigen::Index>& rows, const Positions& positions) const {
    Positions at = seen_at(rows, positions);
    ReadingSlopes found;
    Matrix3 turn = rotation_.transpose();
    if (!fixed_) {
      turn = move_frame(rows, at) * turn;
      found.of_frame = frame_slopes(rows, at);
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (int j = carried_.starts[rows[i]]; j < carried_.starts[rows[i] + 1]; ++j)
        for (int axis = 0; axis < 3; ++axis)
          entries.emplace_back(static_cast<int>(i), 3 * carried_.molecules[j] + axis,
                               carried_.weights[j] * turn(data_.axes[rows[i]], axis));
    found.of_positions.resize(static_cast<Eigen::Index>(rows.size()), positions.size());
    found.of_positions.setFromTriplets(entries.begin(), entries.end());
    return found;
  }

 private:
  static constexpr double kOutside = 0.05;  // of the body's size, the most that a point may lie outside of it

  static Positions placed(const Body& body, MeasuredData& data, const Matrix3& rotation) {
    if (!data.places.row(2).allFinite()) {
      const double top = (rotation.transpose() * body.rest).row(2).maxCoeff();
      data.places.row(2).setConstant(top);
      data.notes.push_back(
          fmt::format("no column z: the points lie where the body is highest, z = {:.6g} mm", 1e3 * top));
    }
    return rotation * data.places;
  }

  Positions seen_at(const std::vector<Eigen::Index>& rows, const Positions& positions) const {
    Positions at(3, static_cast<Eigen::Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i)
      at.col(static_cast<Eigen::Index>(i)) = rotation_.transpose() * carried_.at(positions, static_cast<int>(rows[i]));
    return at;
  }

  /// What turns, of a size that moves points by about the body's, and shifts change of readings at these places.
  MatrixX frame_slopes(const std::vector<Eigen::Index>& rows, const Positions& at) const {
    Vector3 measured = Vector3::Zero(), turned;
    for (const Eigen::Index row : rows) measured[data_.axes[row]] = 1;
    for (int axis = 0; axis < 3; ++axis) turned[axis] = measured[(axis + 1) % 3] * measured[(axis + 2) % 3];
    const Vector3 middle = at.rowwise().mean();
    const double size = (at.colwise() - middle).norm();
    MatrixX slopes(at.cols(), 6);
    for (Eigen::Index i = 0; i < at.cols(); ++i) {
      const Vector3 direction = Vector3::Unit(data_.axes[rows[i]]), arm = at.col(i) - middle;
      slopes.row(i) << arm.cross(direction).cwiseProduct(turned).transpose() / size, direction.transpose();
    }
    return slopes;
  }

  /// Gauss and Newton's steps for a shift in the directions that are measured, and turns of these into each other.
  /// Returns the turn.
  Matrix3 move_frame(const std::vector<Eigen::Index>& rows, Positions& at) const {
    constexpr int most = 50;
    constexpr double enough = 1e-14;  // of the body's size
    Matrix3 whole = Matrix3::Identity();
    VectorX missing(at.cols()), weights = VectorX::Ones(at.cols());
    if (data_.deviations.size() > 0) weights = data_.deviations(rows).cwiseInverse();
    for (int step = 0; step < most; ++step) {
      const Vector3 middle = at.rowwise().mean();
      const double size = (at.colwise() - middle).norm();
      for (Eigen::Index i = 0; i < at.cols(); ++i) {
        const int axis = data_.axes[rows[i]];
        missing[i] = weights[i] * (data_.y[rows[i]] + data_.places(axis, rows[i]) - at(axis, i));
      }
      const MatrixX slopes = weights.asDiagonal() * frame_slopes(rows, at);
      const VectorX change = slopes.completeOrthogonalDecomposition().solve(missing);
      const Vector3 turn = change.head<3>() / size;
      const Matrix3 rotation =
          turn.norm() > 0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() : Matrix3::Identity();
      at = (rotation * (at.colwise() - middle)).colwise() + (middle + change.tail<3>());
      whole = rotation * whole;
      if (change.norm() <= enough * size) break;
    }
    return whole;
  }

  const MeasuredData& data_;
  Matrix3 rotation_;
  bool fixed_;
  CarriedPoints carried_;
};

class SpecimenTest final : public MeasuredTest {
 public:
  SpecimenTest(const DataTest& test, MeasuredData data, std::unique_ptr<Scene> scene, const StrategyChoice& choice,
               const Catalog& catalog, const std::vector<std::string>& overrides)
      : MeasuredTest(std::move(data)),
        catalog_(catalog),
        overrides_(overrides),
        scene_(std::move(scene)),
        choice_(choice),
        own_(scene_->specimen.material) {
    experiment_ = scene_->experiment->at_rest();
    if (!experiment_)
      test.fail("scene: " + scene_->source.path() + " runs in time; identification needs an experiment at rest");
    if (scene_->statics.linear)
      test.fail("scene: " + scene_->source.path() + " takes small displacements; leave out solver.small_displacements");
    if (!scene_->specimen.materials.empty()) test.fail("scene: " + scene_->source.path() + " has several bodies");
    options_.statics = scene_->statics;
    prepare(scene_->specimen, choice_.strategy);
    if (const std::string reason = unsuited(scene_->specimen, *experiment_, choice_); !reason.empty())
      test.fail("scene: " + choice_.label + " " + reason);
    const Specimen& specimen = scene_->specimen;
    follows_modulus_ = specimen.contact && specimen.contact->stiffness ==
                                               contact::default_contact_stiffness(specimen.body, own_.youngs_modulus);
    if (test.kind->points) see_points(test);
    curve_.emplace(load_factors(test), options_.statics);
    if (data_.deviations.size() == 0 && test.deviation)
      data_.deviations = VectorX::Constant(data_.y.size(), test.deviation(data_.up->unit));
    has_history_ =
        specimen.contact && (specimen.contact->friction > 0 || specimen.contact->penetration > 0 || along_ == "force");
  }

  std::optional<Prediction> predict(const TestedMaterial& tested) override {
    const bool friction = tested.trial.friction.has_value();
    if (has_history_ || friction)
      return by_differences(tested, [&](const Trial& trial) {
        curve_->forget();
        const std::optional<Prediction> found = curve_of({tested.row, trial, {}});
        return found ? std::optional(found->values) : std::nullopt;
      });
    return curve_of(tested);
  }

  std::vector<MaterialNumber> own_numbers() const override {
    std::vector<MaterialNumber> numbers;
    for (const ParameterInfo& info : choice_.strategy.parameters) {
      const auto given = choice_.values.find(info.name);
      const double value = given != choice_.values.end() ? given->second : info.fallback;
      if (info.kind == ValueKind::number && std::isfinite(value))
        numbers.push_back(
            {info.name, info.unit, info.low, info.high, info.above_low, value, MaterialNumber::Kind::rule_parameter});
    }
    if (const auto& contact = scene_->specimen.contact)
      numbers.push_back({"friction", dimension::none, 0, std::numeric_limits<double>::infinity(), false,
                         contact->friction, MaterialNumber::Kind::friction});
    return numbers;
  }

  std::vector<std::pair<std::string, std::string>> scene_keys(const Trial& trial, bool plain) const override {
    std::vector<std::pair<std::string, std::string>> keys;
    const StrategyChoice choice = choice_for(trial);
    ParameterValues values = choice.values;
    for (const auto& [name, value] : trial.rule) values[name] = value;
    const bool stated = choice.label == scene_->stiffness.label && !choice.values.empty();
    std::string text = choice.label;
    for (const ParameterInfo& info : choice.strategy.parameters) {
      const auto found = values.find(info.name);
      if (found == values.end()) continue;
      const std::string value = quantity_text(found->second, info.unit, plain);
      text += ", " + info.name + ": " + value;
      if (stated) keys.emplace_back("stiffness." + info.name, value);
    }
    if (!stated && (!trial.rule.empty() || choice.label != scene_->stiffness.label))
      keys.emplace_back("stiffness", values.empty() ? text : "{strategy: " + text + "}");
    for (const auto& [key, value] : trial.keys)
      keys.emplace_back(key, quantity_text(value, config::stated_number(scene_->source, overrides_, key).unit, plain));
    if (trial.friction) keys.emplace_back("contact.friction", fmt::format("{:.9g}", *trial.friction));
    return keys;
  }

  const Body* body() const override { return &scene_->specimen.body; }

  std::shared_ptr<const void> visit_equilibria(const std::function<void(Body&)>& change,
                                               const std::function<void(const SpecimenStep&)>& visit) override {
    if (has_history_) throw InputError(scene_->source.path() + ": its states depend on how they were reached");
    change(scene_->specimen.body);
    if (const std::string reason = unsuited(scene_->specimen, *experiment_, choice_); !reason.empty())
      throw InputError(scene_->source.path() + ": " + choice_.label + " " + reason);
    std::optional<Tried> tried = model(own_);
    if (!tried) return nullptr;
    Model& own = tried->model();
    const StaticRig& rig = tried->rig();
    const Start start = start_at(own);
    why_.clear();
    const bool solved =
        curve_->solve(own, tried->rig(), [&](std::size_t step, const State& state, StaticResult& found) {
          const std::vector<Eigen::Index>& rows = levels_[step];
          VectorX read = readings(rows, rig, start, state, found);
          if (!read.allFinite()) return false;
          visit({rows, own, state, std::move(read), [&] {
                   return seen_ ? seen_->slopes(rows, state.positions)
                                : slopes_of_measure(rows, rig, start, state, found);
                 }});
          return true;
        });
    if (!solved && !curve_->cause().empty()) why_ = "no equilibrium of the specimen: " + curve_->cause();
    return solved ? std::make_shared<Tried>(std::move(*tried)) : nullptr;
  }

 private:
  /// Of a measure that is a sum of reactions, by what a newton more of each makes of it.
  ReadingSlopes slopes_of_measure(const std::vector<Eigen::Index>& rows, const StaticRig& rig, const Start& start,
                                  const State& state, const StaticResult& solved) const {
    StaticResult changed = solved;
    const auto read = [&](const State& at) { return readings(rows, rig, start, at, changed); };
    const VectorX here = read(state);
    ReadingSlopes slopes;
    slopes.of_reactions.resize(here.size(), solved.reactions.size());
    const double size = std::max(solved.reactions.norm(), 1e-300);
    for (Eigen::Index i = 0; i < solved.reactions.size(); ++i) {
      const double before = solved.reactions.data()[i];
      changed.reactions.data()[i] = before + size;
      slopes.of_reactions.col(i) = (read(state) - here) / size;
      changed.reactions.data()[i] = before;
    }
    const VectorX sum =
        slopes.of_reactions * Eigen::Map<const VectorX>(solved.reactions.data(), solved.reactions.size());
    if ((sum - here).norm() > 1e-9 * here.norm())
      throw InputError(scene_->source.path() + ": its " + up_ + " is no sum of the supports' forces");
    return slopes;
  }

  /// Slopes by one linear solve each at every equilibrium.
  std::optional<Prediction> curve_of(const TestedMaterial& tested) {
    const std::optional<Tried> tried = model(tested.trial);
    if (!tried) return std::nullopt;
    std::vector<std::vector<Tried>> changed;
    for (const TrialChange& change : tested.changes) {
      std::vector<Tried>& models = changed.emplace_back();
      for (const Trial& other : change.trials) {
        auto perturbed = model(other);
        if (!perturbed) return std::nullopt;
        models.push_back(std::move(*perturbed));
      }
    }
    Model& own = tried->model();
    StaticRig& rig = tried->rig();
    Prediction result{VectorX::Zero(data_.y.size()),
                      MatrixX::Zero(data_.y.size(), static_cast<Eigen::Index>(tested.changes.size()))};
    const Start start = start_at(own);
    const double tolerance = std::max(options_.statics.tolerance, tested.accuracy);
    // Differences of forces are known to some 1e-10; a search on its way can do with less.
    const double slope_tolerance = std::max(tolerance, tested.accuracy > 0 ? kRoughSlope : 1e-8);
    curve_->set_tolerance(tolerance);
    const auto visit = [&](std::size_t step, const State& state, StaticResult& solved) {
      const std::vector<Eigen::Index>& rows = levels_[step];
      if (prescribes()) {
        const double at = rig.measure(start, state, options_.statics, solved).get(along_), stated = data_.x[rows[0]];
        if (std::abs(at - stated) > kAgreement * std::abs(whole_))
          throw InputError(scene_->source.path() + ": shows " + along_ + " " + fmt::format("{:.6g}", at) +
                           " at the load that should give " + fmt::format("{:.6g}", stated) +
                           "; the data must be over what the scene prescribes, which is the file's first column of "
                           "what is known: are its columns exchanged?");
      }
      const VectorX response = readings(rows, rig, start, state, solved);
      result.values(rows) = response;
      reached_[step].distance = (state.positions - start.positions).norm();
      if (changed.empty()) return response.allFinite();
      const State still{state.positions,
                        own.feels_velocity() ? Positions(Positions::Zero(3, state.positions.cols())) : Positions()};
      Responses responses(own, still, options_.statics);
      for (std::size_t change = 0; change < changed.size(); ++change) {
        for (const Tried& other : changed[change]) set_load(other.model(), other.rig(), curve_->factor(step));
        const auto slope = slope_of(rows, own, rig, start, state, solved, changed[change], tested.changes[change],
                                    responses, slope_tolerance, motion_of(step, change, tested));
        if (!slope) {
          if (why_.empty()) why_ = "the stiffness at an equilibrium could not be solved";
          return false;
        }
        result.slopes(rows, static_cast<Eigen::Index>(change)) = *slope;
      }
      return response.allFinite();
    };
    why_.clear();
    expect(tested.numbers);
    reached_.resize(levels_.size());
    const bool solved = curve_->solve(own, rig, visit);
    numbers_.clear();
    if (solved) numbers_.insert(tested.numbers.begin(), tested.numbers.end());
    if (solved) return result;
    if (!curve_->cause().empty()) why_ = "no equilibrium of the specimen: " + curve_->cause();
    return std::nullopt;
  }

  /// Whether the data are over something that the scene prescribes, and not over parts of its load.
  bool prescribes() const { return data_.along && data_.along->name != "load_factor"; }

  /// What an equilibrium shows of these rows.
  VectorX readings(const std::vector<Eigen::Index>& rows, const StaticRig& rig, const Start& start, const State& state,
                   StaticResult& solved) const {
    if (seen_) return seen_->readings(rows, state.positions);
    return VectorX::Constant(static_cast<Eigen::Index>(rows.size()),
                             rig.measure(start, state, options_.statics, solved).get(up_));
  }

  void see_points(const DataTest& test) {
    seen_.emplace(scene_->specimen.body, data_, scene_->rotation, test.fixed_frame);
    std::map<double, int> at;
    for (const double load : data_.x) ++at[load];
    for (const auto& [load, count] : at)
      if (!test.fixed_frame && count <= 6)
        test.fail(
            fmt::format("{} has {} at the load {:.6g}: a frame that moves takes six of them; measure more points, "
                        "or write frame: fixed",
                        data_.file, counted(count, "displacement"), load));
  }

  /// Where the motion of an equilibrium with a number is kept.
  Positions& motion_of(std::size_t step, std::size_t change, const TestedMaterial& tested) {
    if (change < tested.numbers.size()) return reached_[step].motions[tested.numbers[change].first];
    unnamed_.resize(3, 0);
    return unnamed_;
  }

  /// Begins near the equilibria of these numbers: the last ones moved by Σ ∂x/∂θ Δθ, where that is a small part of
  /// their way from rest.
  void expect(const std::vector<std::pair<std::string, double>>& numbers) {
    for (std::size_t step = 0; step < reached_.size(); ++step) {
      Positions motion = Positions::Zero(3, scene_->specimen.body.size());
      for (const auto& [name, value] : numbers) {
        const auto before = numbers_.find(name);
        const auto by_number = reached_[step].motions.find(name);
        if (before != numbers_.end() && by_number != reached_[step].motions.end())
          motion += (value - before->second) * by_number->second;
      }
      if (motion.norm() < kNear * reached_[step].distance) curve_->expect(step, std::move(motion));
    }
  }

  Start start_at(const Model& model) const {
    return {scene_->specimen.body.rest, Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size()))};
  }

  /// The strategy for this material: the scene's, and where that is a cell law and the material has another law, that,
  /// without the volume term that the scene's has where the cells have none for this law.
  StrategyChoice choice_for(const Trial& trial) const {
    const auto& tried = trial.material.law;
    if (!tried || choice_.strategy.kind != StrategyKind::cell_law || (own_.law && own_.law->law == tried->law))
      return choice_;
    StrategyName name = choice_.name;
    name.rule = StrategyName::of_law(tried->law, choice_.strategy.dimensions).rule;
    StrategyChoice choice = choose_strategy(*scene_, catalog_, name.text());
    if (!choice.strategy.volume_modulus || choice.strategy.unsuited(scene_->specimen.body).empty()) return choice;
    name.volume = false;
    return choose_strategy(*scene_, catalog_, name.text());
  }

  /// A trial at work, with the scene that it is of.
  struct Tried {
    std::shared_ptr<Scene> scene;  ///< outlives the model
    HeldModel held;
    Model& model() const { return *held.model; }
    StaticRig& rig() const { return *held.rig->at_rest(); }
  };

  /// The specimen with what is tried in the place of its own; contact that follows from the modulus follows it.
  std::optional<Tried> model(const Trial& trial) {
    std::optional<Tried> tried;
    try {
      const std::shared_ptr<Scene> scene = trial.keys.empty() ? scene_ : scene_with(trial);
      Specimen& specimen = scene->specimen;
      const auto contact = specimen.contact;
      specimen.material = on_specimen(trial.material, own_);
      if (contact && trial.friction) specimen.contact->friction = *trial.friction;
      if (follows_modulus_)
        specimen.contact->stiffness =
            contact::default_contact_stiffness(specimen.body, specimen.material.youngs_modulus);
      StrategyChoice choice = choice_for(trial);
      for (const auto& [name, value] : trial.rule) choice.values[name] = value;
      Run run;
      if (choice.label != choice_.label)
        if (const std::string reason = unsuited(specimen, *scene->experiment->at_rest(), choice); !reason.empty())
          run.cause = choice.label + " " + reason;
      if (run.cause.empty())
        if (auto held = make_model(specimen, *scene->experiment, choice, options_, run))
          tried.emplace(Tried{scene, std::move(*held)});
      if (!tried) why_ = run.cause;
      specimen.material = own_, specimen.contact = contact;
    } catch (const InputError& error) {
      why_ = error.what();
      scene_->specimen.material = own_;
    }
    return tried;
  }

  /// The test's scene with other numbers under some of its keys. Throws InputError where these change more than forces.
  std::shared_ptr<Scene> scene_with(const Trial& trial) const {
    std::vector<std::string> changed = overrides_;
    std::string names;
    for (const auto& [key, value] : trial.keys) {
      changed.push_back(key + "=" + config::stated_number(scene_->source, overrides_, key).with(value));
      names += (names.empty() ? "" : ", ") + key;
    }
    std::shared_ptr<Scene> scene = load_scene(scene_->source, catalog_, changed);
    const Body &own = scene_->specimen.body, &body = scene->specimen.body;
    const auto fail = [&](const std::string& what) { throw InputError("unknown " + names + ": it changes " + what); };
    if (body.size() != own.size() || body.connections.ends != own.connections.ends)
      fail("which molecules there are, or what joins them");
    if ((body.rest - own.rest).norm() > 1e-12 * own.rest.norm()) fail("the body's shape at rest");
    prepare(scene->specimen, choice_.strategy);
    return scene;
  }

  /// Of forces on free molecules.
  static double free_norm(const Model& model, Positions forces) {
    for (const Support& support : model.supports)
      forces.col(support.molecule) = support.free * Vector3(forces.col(support.molecule));
    return forces.norm();
  }

  /// K dx = forces, from a dx of about here; none: from 0. What that leaves may be rounding alone.
  static StaticResponse response_to(const Model& own, Responses& responses, const Positions& forces, double tolerance,
                                    const Positions& about) {
    const Positions still = Positions::Zero(3, forces.cols());
    Positions missing = still;
    if (about.size() > 0) responses.tangent().apply(about, missing);
    missing = forces - missing;
    const double left = free_norm(own, missing), whole = free_norm(own, forces);
    if (about.size() == 0 || !(left < whole)) return responses.to(forces, still, tolerance);
    StaticResponse response;
    response.motion = still;
    if (left > tolerance * whole) {
      response = responses.to(missing, still, std::min(tolerance * whole / left, 0.1));
    } else {
      response.result.reactions = Positions(3, static_cast<Eigen::Index>(own.supports.size()));
      for (std::size_t i = 0; i < own.supports.size(); ++i) {
        const Vector3 force = missing.col(own.supports[i].molecule);
        response.result.reactions.col(static_cast<Eigen::Index>(i)) = own.supports[i].free * force - force;
      }
    }
    response.motion += about;
    return response;
  }

  /// Where a number changes the supports' forces alone, what is left on free molecules is rounding, or what the
  /// equilibrium left unbalanced, which no motion balances.
  /// @param unbalanced of the equilibrium, over loads and reactions
  static void leave_out_rounding(const Model& model, double unbalanced, Positions& forces) {
    constexpr double rounding = 1e-8, times = 4;  // the norms are over different molecules
    Positions fixed = Positions::Zero(3, forces.cols());
    for (const Support& support : model.supports) {
      const Vector3 force = forces.col(support.molecule);
      fixed.col(support.molecule) = force - support.free * force;
    }
    if ((forces - fixed).norm() < std::max(rounding, times * unbalanced) * forces.norm()) forces = fixed;
  }

  /// ∂f/∂θ at the positions kept, then K dx = ∂f/∂θ, then the measure at both sides along dx, and what the number makes
  /// of the measure itself.
  /// @param motion dx of about here, from which the solve begins; then that of here
  std::optional<VectorX> slope_of(const std::vector<Eigen::Index>& rows, const Model& own, const StaticRig& rig,
                                  const Start& start, const State& state, const StaticResult& solved,
                                  const std::vector<Tried>& models, const TrialChange& change, Responses& responses,
                                  double tolerance, Positions& motion) {
    if (models.empty()) return std::nullopt;
    Positions forces = Positions::Zero(3, state.positions.cols());
    VectorX slope = VectorX::Zero(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t i = 0; i < models.size(); ++i) {
      const Model& model = models[i].model();
      forces += change.weights[i] * (model.elastic_forces(state.positions) + model.load_forces(state));
      Positions held = state.positions;
      apply_supports(model, held);
      if ((held - state.positions).norm() > 1e-9 * (state.positions - start.positions).norm()) {
        why_ = "an unknown of the scene changes what its experiment prescribes";
        return std::nullopt;
      }
      StaticResult same = solved;
      slope += change.weights[i] * readings(rows, models[i].rig(), start, state, same);
    }
    leave_out_rounding(own, solved.residual, forces);
    const auto response = response_to(own, responses, forces, tolerance, motion);
    if (response.result.outcome != Outcome::converged) return std::nullopt;
    motion = response.motion;
    const double step = 0.5 / std::abs(change.weights.front());
    for (const double side : {1., -1.}) {
      State at = state;
      StaticResult perturbed = solved;
      at.positions += side * step * response.motion;
      perturbed.reactions += side * step * response.result.reactions;
      slope += side / (2 * step) * readings(rows, rig, start, at, perturbed);
    }
    return slope;
  }

  /// The name of the first of a quantity's measures that the scene shows; "" where it shows none.
  static std::string measure_of(const DataQuantity& quantity, const Measures& shown) {
    for (const std::string& name : quantity.measures)
      if (std::isfinite(shown.get(name))) return name;
    return "";
  }

  /// What part of the scene's load each point is. What a rig prescribes it may know by itself, at rest: a pressure, an
  /// indenter's depth. Else it is proportional to the load, which one solve for small displacements shows.
  std::vector<double> load_factors(const DataTest& test) {
    const std::optional<Tried> held = model(own_);
    if (!held) test.fail("scene: " + why_);
    Model& own = held->model();
    StaticRig& rig = held->rig();
    const State rest = state_at_rest(scene_->specimen.body);
    set_load(own, rig, 0);
    if (!own.load_forces(rest).isZero(0))
      test.fail("scene: " + scene_->source.path() +
                " has loads of its own besides the experiment's; they are not taken");
    const Start start = start_at(own);
    const auto at_rest = [&](double factor) {
      set_load(own, rig, factor);
      StaticResult unloaded;
      unloaded.reactions = start.reactions;
      return rig.measure(start, rest, options_.statics, unloaded);
    };
    const auto find_measures = [&](const Measures& shown) {
      if (prescribes()) along_ = measure_of(*data_.along, shown);
      if (!test.measure.empty())
        up_ = std::isfinite(shown.get(test.measure)) ? test.measure : "";
      else if (!seen_)
        up_ = measure_of(*data_.up, shown);
    };
    Measures shown = at_rest(1);
    find_measures(shown);
    const bool known = !along_.empty() && (seen_ || !up_.empty()) && shown.get(along_) != 0;
    if (!known && !(seen_ && !prescribes())) {
      StaticOptions small = options_.statics;
      small.linear = true;
      State state = rest;
      StaticResult solved = solve_static(own, state, small);
      if (solved.outcome != Outcome::converged) test.fail("scene: its body cannot be solved: " + solved.cause);
      shown = rig.measure(start, state, small, solved);
      find_measures(shown);
      for (const auto& [name, quantity] :
           {std::pair{along_, prescribes() ? data_.along : nullptr}, std::pair{up_, seen_ ? nullptr : data_.up}})
        if (quantity && name.empty())
          test.fail(quantity == data_.up && !test.measure.empty()
                        ? "measure: the scene has no '" + test.measure + "'" + suggestion(test.measure, names_in(shown))
                        : "scene: it shows no " + quantity->name + "; the data have one, and it shows " +
                              shown_in(shown));
      if (!seen_) check_sign(shown.get(up_));
    }
    if (prescribes()) whole_ = shown.get(along_);
    if (prescribes() && !seen_) leave_out_rest();
    std::vector<Eigen::Index> order(static_cast<std::size_t>(data_.x.size()));
    std::iota(order.begin(), order.end(), 0);
    if (data_.along)
      std::stable_sort(order.begin(), order.end(),
                       [&](auto a, auto b) { return std::abs(data_.x[a]) < std::abs(data_.x[b]); });
    std::vector<double> factors;
    for (const Eigen::Index point : order) {
      if (seen_ && !levels_.empty() && data_.x[levels_.back()[0]] == data_.x[point]) {
        levels_.back().push_back(point);
        continue;
      }
      levels_.push_back({point});
      factors.push_back(prescribes() ? load_factor_of(point, known, at_rest) : data_.x[point]);
      if (data_.along && !prescribes() && !(factors.back() > 0 && factors.back() <= 1))
        throw InputError(
            SourceLocation{data_.file, data_.lines[point]},
            fmt::format("load_factor {:.6g} is no part of the scene's load; it goes from 0 to 1", data_.x[point]));
    }
    return factors;
  }

  /// What part of the scene's load a row of what it prescribes is.
  template <class AtRest>
  double load_factor_of(Eigen::Index point, bool known, const AtRest& at_rest) const {
    const double part = data_.x[point] / whole_;
    const auto fail = [&](const char* what, const char* advice) {
      throw InputError(SourceLocation{data_.file, data_.lines[point]},
                       fmt::format("{} of {:.6g} {} {} prescribes, {:.6g} (SI){}", data_.along->name, data_.x[point],
                                   what, scene_->source.path(), whole_, advice));
    };
    if (part < 0)
      fail("has the other sign than what",
           "; of compression both displacement and force are negative, which signs: pressing makes of positive ones");
    if (part > 1 + kAgreement) fail("is beyond what", ": change its load, or cut the data by `from` and `to`");
    return known ? bisected(part, [&](double at) { return at_rest(at).get(along_) / whole_; }) : std::min(part, 1.);
  }

  static std::vector<std::string> names_in(const Measures& shown) {
    std::vector<std::string> names;
    for (const auto& [name, value] : shown.all()) names.push_back(name);
    return names;
  }

  /// What data may have of this scene.
  static std::string shown_in(const Measures& shown) {
    std::string names;
    for (const DataQuantity& quantity : data_quantities())
      if (!measure_of(quantity, shown).empty()) names += (names.empty() ? "" : ", ") + quantity.name;
    return names;
  }

  /// @param response of small displacements to the whole load
  void check_sign(double response) const {
    Eigen::Index last = 0;
    data_.x.cwiseAbs().maxCoeff(&last);
    if (data_.y[last] * response >= 0) return;
    throw InputError(
        SourceLocation{data_.file, data_.lines[last]},
        fmt::format("{} of {:.6g} (SI) has the other sign than the specimen's: of tension displacement and "
                    "force are positive, of compression both negative; signs: pressing reads positive ones so",
                    data_.up->name, data_.y[last]));
  }

  /// Where a function that rises from 0 to 1 has a value: at that value itself, if it is straight.
  template <class Function>
  static double bisected(double value, const Function& function) {
    double low = 0, high = 1, middle = std::min(value, 1.);
    for (int i = 0; i < 60 && std::abs(function(middle) - value) > 1e-12; ++i) {
      (function(middle) < value ? low : high) = middle;
      middle = (low + high) / 2;
    }
    return middle;
  }

  /// At rest, and where readings scatter to its other side, there is nothing to be measured but an offset.
  void leave_out_rest() {
    constexpr double offset = 0.01;  // of the largest value, beyond which it is no scatter
    MeasuredData kept = data_;
    kept.lines.clear();
    Eigen::Index count = 0;
    const double scatter = offset * data_.x.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < data_.x.size(); ++i) {
      if (data_.x[i] == 0 || (data_.x[i] / whole_ < 0 && std::abs(data_.x[i]) < scatter)) {
        if (std::abs(data_.y[i]) > std::max(offset * data_.y.cwiseAbs().maxCoeff(), 4 * data_.noise))
          throw InputError(
              SourceLocation{data_.file, data_.lines[i]},
              fmt::format("{} is {:.6g} (SI) at rest, where it is 0: zero: found counts from where the load begins; "
                          "else subtract that from all rows, or leave this one out",
                          data_.up->name, data_.y[i]));
        continue;
      }
      kept.x[count] = data_.x[i], kept.y[count++] = data_.y[i];
      kept.lines.push_back(data_.lines[i]);
    }
    kept.x.conservativeResize(count), kept.y.conservativeResize(count);
    data_ = std::move(kept);
  }

  const Catalog& catalog_;
  std::vector<std::string> overrides_;
  std::shared_ptr<Scene> scene_;
  StrategyChoice choice_;
  Material own_;
  const StaticExperiment* experiment_ = nullptr;
  RunOptions options_;
  std::string along_, up_;                         ///< measures
  double whole_ = 0;                               ///< what the scene's whole load prescribes, SI
  std::optional<SeenPoints> seen_;                 ///< of points
  std::vector<std::vector<Eigen::Index>> levels_;  ///< rows at each load
  /// An equilibrium of the last curve.
  struct Reached {
    double distance = 0;                            ///< from rest, a norm over all molecules [m]
    std::map<std::string, Positions> motions = {};  ///< with each number, ∂x/∂θ of about there
  };
  std::vector<Reached> reached_;
  Positions unnamed_;        ///< of a number without a name
  ParameterValues numbers_;  ///< of the last curve
  std::optional<RepeatedCurve> curve_;
  bool follows_modulus_ = false;  ///< whether the stiffness of contact follows from the modulus
  bool has_history_ = false;      ///< whether a state depends on how it was reached, or its load is sought
};

}  // namespace

std::unique_ptr<MeasuredTest> make_specimen_test(const DataTest& test, const Catalog& catalog,
                                                 const std::vector<std::string>& overrides,
                                                 const std::string& strategy) {
  return make_specimen_test(test, test.kind->points ? load_points(test) : load_data(test), catalog, overrides,
                            strategy);
}

std::unique_ptr<MeasuredTest> make_specimen_test(const DataTest& test, MeasuredData data, const Catalog& catalog,
                                                 const std::vector<std::string>& overrides,
                                                 const std::string& strategy) {
  auto scene = load_scene(*test.scene, catalog, overrides);
  const StrategyChoice choice = strategy.empty() ? scene->stiffness : choose_strategy(*scene, catalog, strategy);
  return std::make_unique<SpecimenTest>(test, std::move(data), std::move(scene), choice, catalog, overrides);
}

}  // namespace elastin::lab
