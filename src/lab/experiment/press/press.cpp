#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "elastin/core/base/error.h"
#include "elastin/core/model/parts.h"
#include "lab/experiment/keys.h"
#include "lab/experiment/tension/tension.h"
#include "lab/run/common_measures.h"
#include "lab/run/contact_measures.h"

namespace elastin::lab {
namespace {

/// A part of the body, or its near end, moved without a turn onto what lies before it; the far one stays.
struct PressSetup : GripSetup {
  Vector3 axis = -Vector3::UnitZ();    ///< of the motion, unit
  std::string moved_name, fixed_name;  ///< of bodies that have them
  std::optional<double> displacement;  ///< [m], > 0
  std::optional<double> force;         ///< or until this resists [N], > 0
  Grip grip = Grip::clamped;           ///< of both, across the axis
  int load_steps = 1;
};

const MeasureList& press_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"force", force, "force on the pressed part along its direction; beyond preload", Role::force},
       {"depth", length, "displacement of the pressed part since the start"},
       {"mean_pressure", pressure, "mean contact pressure: force / area"},
       {"pressure_spread", none, "largest |contact pressure / mean - 1| of the molecules under pressure"}},
      {{"depth", "force", true}}};
  return list;
}

/// Throws InputError on a setup that does not suit the body.
class Press final : public StaticExperiment {
 public:
  Press(const Body& body, const PressSetup& setup) : setup_(setup) {
    EndFinder finder(body, setup.grip_depth);
    moved_ = setup.loaded ? *setup.loaded : finder.find("loaded", -setup.axis).molecules;
    fixed_ = setup.fixed ? *setup.fixed : finder.find("fixed", setup.axis).molecules;
    findings_ = std::move(finder.findings);
    std::vector<int> both;
    std::set_intersection(moved_.begin(), moved_.end(), fixed_.begin(), fixed_.end(), std::back_inserter(both));
    if (!both.empty()) throw InputError("what is moved is held, too: molecule " + std::to_string(both.front()));
    for (const Part& part : body.parts) {
      if (!part.rigid) continue;
      const std::vector<int> whole = molecules_of(part);
      const auto count = std::count_if(whole.begin(), whole.end(), [&](int molecule) {
        return std::binary_search(moved_.begin(), moved_.end(), molecule);
      });
      if (count > 0 && count < static_cast<std::ptrdiff_t>(whole.size()))
        throw InputError("'" + part.name + "' is rigid and only its end would be moved: say move: " + part.name);
    }
    const VectorX height = body.rest.transpose() * setup.axis;
    if (setup.force) control_ = ForceControl(*setup.force, 1e-3 * (height.maxCoeff() - height.minCoeff()));
  }

  std::string name() const override { return "press"; }
  MeasureList measures() const override { return press_measures(); }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;
  int load_steps() const override { return setup_.load_steps; }
  const StaticExperiment* calibration() const override {
    return nullptr;
  }  // without contact there is nothing to calibrate by
  ResponseMeasures response_measures() const override { return {"depth", setup_.displacement ? "force" : ""}; }

  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    return {{"force"}, {"depth"}, {"contact_area"}, {"largest_pressure"}};
  }

  std::string remark(const Measures& measures) const override {
    if (!(measures.get("contacts") > 0)) return "nothing touches";
    const double total = measures.get("total_force"), force = std::isfinite(total) ? total : measures.get("force");
    if (setup_.force && std::abs(force / *setup_.force - 1) > 1e-5) return "the prescribed force was not reached";
    return "";
  }

 private:
  friend class PressRig;
  /// A smooth grip lets its body drift and turn in its plane. One molecule near the middle is held there, the one that
  /// is farthest from it may only come nearer or go away: that takes no force of a body in balance.
  void keep_in_plane(Model& model, std::size_t first) const {
    const auto position = [&](std::size_t i) -> Vector3 { return model.body().rest.col(model.supports[i].molecule); };
    const std::size_t end = model.supports.size();
    Vector3 centre = Vector3::Zero();
    for (std::size_t i = first; i < end; ++i) centre += position(i) / static_cast<double>(end - first);
    std::size_t middle = first, far = first;
    for (std::size_t i = first; i < end; ++i) {
      if ((position(i) - centre).norm() < (position(middle) - centre).norm()) middle = i;
      if ((position(i) - centre).norm() > (position(far) - centre).norm()) far = i;
    }
    if (far == middle) return;
    const Vector3 out = (position(far) - position(middle)).normalized();
    model.supports[middle].free.setZero();
    model.supports[far].free = out * out.transpose();
  }

  /// Largest |pressure / mean − 1| of the molecules that are pressed.
  static double pressure_spread(const VectorX& pressure) {
    double sum = 0;
    int count = 0;
    for (const double value : pressure)
      if (value > 0) sum += value, ++count;
    const double mean = sum / count;
    double spread = 0;
    for (const double value : pressure)
      if (value > 0) spread = std::max(spread, std::abs(value / mean - 1));
    return count > 0 ? spread : std::nan("");
  }

  PressSetup setup_;
  std::vector<int> moved_, fixed_;
  ForceControl control_;
};

class PressRig final : public StaticRig {
 public:
  PressRig(const Press& experiment, Model& model)
      : experiment_(experiment), setup_(experiment.setup_), model_(model), control_(experiment.control_) {
    const Matrix3 along = setup_.axis * setup_.axis.transpose();
    const Matrix3 free = setup_.grip == Grip::clamped ? Matrix3(Matrix3::Zero()) : Matrix3(Matrix3::Identity() - along);
    for (const std::vector<int>* grip : {&experiment_.fixed_, &experiment_.moved_}) {
      const std::size_t first = model.supports.size();
      for (const int molecule : *grip) model.supports.push_back({molecule, free, Vector3::Zero()});
      if (setup_.grip == Grip::sliding) experiment_.keep_in_plane(model, first);
    }
    contact_ = contact_of(model);
    if (setup_.force && contact_) find_approach(model.body().rest);  // `check` makes a model without contact
  }

  void meet(const Positions& positions) override {
    if (setup_.force && contact_ && positions != model_.body().rest) find_approach(positions);
  }

  void approach(Positions& positions) const override {
    for (std::size_t molecule = 0; approach_ > 0 && molecule < goes_along_.size(); ++molecule)
      if (goes_along_[molecule]) positions.col(static_cast<Eigen::Index>(molecule)) += approach_ * setup_.axis;
  }

  void set_load(double factor) override {
    if (setup_.force) control_.aim(factor);
    move_to(factor == 0 ? 0 : setup_.force ? approach_ + control_.displacement() : factor * *setup_.displacement);
  }

  bool seeks_load() const override { return setup_.force.has_value(); }
  bool adjust(const State& state) override {
    if (!setup_.force || displacement_ == 0 || !control_.adjust(resistance(state))) return false;
    move_to(approach_ + control_.displacement());
    return true;
  }

  void set_load_rate(double rate) override {
    if (!setup_.displacement) return;
    for (std::size_t i = experiment_.fixed_.size(); i < experiment_.fixed_.size() + experiment_.moved_.size(); ++i)
      model_.supports[i].velocity = rate * *setup_.displacement * setup_.axis;
  }

  Measures measure(const Start& start, const State& state, const StaticOptions&, StaticResult& solved) const override {
    double force = resistance(state);
    for (std::size_t i = experiment_.fixed_.size(); i < experiment_.fixed_.size() + experiment_.moved_.size(); ++i)
      force -= setup_.axis.dot(start.reactions.col(static_cast<Eigen::Index>(i)));
    Measures measures;
    measures.set("force", force);
    measures.set("depth", displacement_);
    const contact::ContactReport report = contact_->report(state);
    if (report.area > 0) measures.set("mean_pressure", largest_force(report) / report.area);
    measures.set("pressure_spread", experiment_.pressure_spread(report.pressure));
    add_state(model_, state, solved, std::abs(force), measures);
    return measures;
  }

 private:
  /// How far what is moved goes, rigid with all that it is joined to, before it touches. Nowhere where it touches
  /// already, is one with what is fixed, or meets nothing.
  void find_approach(const Positions& from) {
    const Body& body = model_.body();
    const BodyFindings findings = inspect(body);
    std::vector<char> moves(static_cast<std::size_t>(findings.pieces), 0);
    for (const int molecule : experiment_.moved_) moves[findings.piece_of[molecule]] = 1;
    for (const int molecule : experiment_.fixed_)
      if (moves[findings.piece_of[molecule]]) return;
    goes_along_.clear();
    for (const int piece : findings.piece_of) goes_along_.push_back(moves[piece]);
    const VectorX height = from.transpose() * setup_.axis;
    const double step = body.radius.mean(), most = 2 * (height.maxCoeff() - height.minCoeff());
    contact_->set_moment(0);
    const auto touches = [&](double displacement) {
      State state = state_at_rest(body);
      state.positions = from;
      approach_ = displacement;
      approach(state.positions);
      return contact_->report(state).pairs > 0;
    };
    double apart = 0, near = 0;
    while (!touches(near) && near <= most) apart = near, near += step;
    while (near <= most && near - apart > 1e-6 * step)
      (touches((apart + near) / 2) ? near : apart) = (apart + near) / 2;
    approach_ = near <= most ? near : 0;
  }

  void move_to(double displacement) {
    displacement_ = displacement;
    for (std::size_t i = experiment_.fixed_.size(); i < experiment_.fixed_.size() + experiment_.moved_.size(); ++i)
      model_.supports[i].displacement = displacement * setup_.axis;
  }

  /// With which the moved molecules are pressed back [N].
  double resistance(const State& state) const {
    Positions forces;
    model_.set_forces(state, forces);
    double sum = 0;
    for (const int molecule : experiment_.moved_) sum -= setup_.axis.dot(forces.col(molecule));
    return sum;
  }

  const Press& experiment_;
  const PressSetup& setup_;
  Model& model_;
  contact::Contact* contact_ = nullptr;  // owned by the model
  double displacement_ = 0;              // of what is moved [m]
  double approach_ = 0;                  // of it, before it touches [m]; the control begins there
  std::vector<char> goes_along_;         // of each molecule: whether it is joined to what is moved
  ForceControl control_;
};

std::unique_ptr<StaticRig> Press::make_rig(Model& model) const { return std::make_unique<PressRig>(*this, model); }

}  // namespace

ExperimentInfo press_row() {
  using S = PressSetup;
  const auto body_name = [](const char* name, std::string S::*member,
                            std::optional<std::vector<int>> GripSetup::*picked, const char* fallback,
                            const char* text) {
    return Key<S>({name, "a body's name, or [pick](#picked-molecules)", "", "", fallback, text},
                  [=](const Reader& value, S& setup, const Frame& frame) {
                    if (!value.is_text()) return end_key("", picked, "").read(value, setup, frame);
                    setup.*member = value.text();
                    value.located([&] { return find_part(*frame.body, setup.*member); });
                  });
  };
  std::vector<Key<S>> loads = travel_keys("displacement", &S::displacement, &S::axis, "displacement of what is moved");
  loads.push_back(key::quantity("force", &S::force, dimension::force,
                                "force that ends the motion, with that of a preload", kPositive));
  return with_keys(
      {.name = "press",
       .summary =
           "a body, or the near end of one, is pressed onto what lies before it: force, contact area; needs `contact`",
       .measures = press_measures()},
      Keys<S>{key::direction("axis", &S::axis, "direction of the motion"),
              one_of<S>("give one of displacement, strain and force", loads),
              body_name("move", &S::moved_name, &S::loaded, "the near end", "what is moved"),
              body_name("fix", &S::fixed_name, &S::fixed, "the far end, or rigid bodies", "what is fixed"),
              grip_key("grip", &S::grip, "how both are fixed across the axis"), grip_depth_key(&S::grip_depth),
              load_steps_key(&S::load_steps)},
      [](const ExperimentContext& context, S setup) {
        const Body& body = context.body;
        if (!setup.moved_name.empty()) setup.loaded = molecules_of(find_part(body, setup.moved_name));
        if (!setup.fixed_name.empty()) setup.fixed = molecules_of(find_part(body, setup.fixed_name));
        // What is rigid and is not moved stays where it is.
        const auto stays = [&](const Part& part) { return part.rigid && part.name != setup.moved_name; };
        if (setup.loaded && !setup.fixed && std::any_of(body.parts.begin(), body.parts.end(), stays))
          setup.fixed.emplace();
        contact_of_scene(context);
        return std::make_unique<Press>(body, setup);
      });
}

}  // namespace elastin::lab
