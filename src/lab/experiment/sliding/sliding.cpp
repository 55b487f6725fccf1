#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/base/dense.h"
#include "elastin/contact/contact.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "lab/experiment/keys.h"
#include "lab/run/contact_measures.h"

namespace elastin::lab {
namespace {

enum class SlidingKind {
  incline,    ///< on a slope: does it stay, and how does it go if not
  sled,       ///< thrown along a level floor: how it is slowed down
  threshold,  ///< on a slope that is tilted slowly: when it begins to go
};

/// A body on a plane.
struct SlidingSetup {
  SlidingKind kind = SlidingKind::incline;
  Vector3 up = Vector3::UnitZ();     ///< across the plane, unit
  Vector3 along = Vector3::UnitX();  ///< down the slope, unit, across `up`
  double gravity = 9.81;             ///< [m/s²], > 0
  double angle = 0;                  ///< of the slope; of a threshold, at time 0
  double rate = 0;                   ///< of a threshold [1/s], > 0
  double speed = 0;                  ///< of a sled at time 0 [m/s]
  std::string floor;                 ///< the obstacle it stands on; empty: a plane of its own under the body
};

const MeasureList& sliding_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {"slide_distance", length, "displacement of the mass centre down the slope since the start"},
      {"slide_speed", velocity, "speed of the mass centre down the slope"},
      {"slide_acceleration", acceleration, "acceleration down the slope while it slides: a line fitted to the speed"},
      {"creep", length, "largest displacement of a molecule on the slope, of all frames"},
      {"turn", none, "angle by which the body has turned down the slope since the start [rad]", Role::share},
      {"slope", none, "slope of the plane", Role::none, "", "rad"},
      {"slip_angle", none, "slope at which the body begins to slide", Role::none, "", "rad"},
      {"slip_friction", none, "tan of that angle"}};
  return list;
}

/// Weight, tilted from straight down the normal of a plane by an angle that may grow in time.
class TiltedGravity final : public Load {
 public:
  TiltedGravity(const Body& body, const SlidingSetup& setup) : body_(body), setup_(setup), angle_(setup.angle) {}
  void set_angle(double angle) { angle_ = angle; }
  void add_forces(const State& state, Positions& forces) const override {
    forces += acceleration(state.time) * body_.mass.transpose();
  }
  double energy(const State& state) const override {
    return -acceleration(state.time).dot((state.positions - body_.rest) * body_.mass);
  }
  bool steady() const override { return setup_.rate == 0; }

 private:
  Vector3 acceleration(double time) const {
    const double angle = angle_ + setup_.rate * time;
    return setup_.gravity * (std::sin(angle) * setup_.along - std::cos(angle) * setup_.up);
  }
  const Body& body_;
  SlidingSetup setup_;
  double angle_;
};

/// A body has begun to slide when it has gone this part of a molecule's radius; before that it only shears.
constexpr double kSlipped = 0.1;
/// Angle by which a body that topples has turned; one that slides turns by what its softness allows. On a slope that
/// stays as it was one that turns by less, but moves by that more than by sliding, has begun to topple.
constexpr double kToppled = 0.1, kTopples = 0.02;

struct Line {
  double slope = 0, zero = 0;  ///< zero: where the line is 0
  int points = 0;
};

/// Straight through the points by least squares; no points if there are fewer than three.
Line fit_line(const std::vector<std::pair<double, double>>& points) {
  if (points.size() < 3) return {};
  double x_mean = 0, y_mean = 0, xy = 0, xx = 0;
  for (const auto& [x, y] : points)
    x_mean += x / static_cast<double>(points.size()), y_mean += y / static_cast<double>(points.size());
  for (const auto& [x, y] : points) xy += (x - x_mean) * (y - y_mean), xx += (x - x_mean) * (x - x_mean);
  return {xy / xx, x_mean - y_mean * xx / xy, static_cast<int>(points.size())};
}

/// Gravity tilts, the plane stays. The run begins where the body stands in equilibrium; on a slope too steep for that,
/// where it would stand on level ground. Adds its plane to the obstacles, just so deep in the body that this begins
/// with contact. Throws InputError if there is no such obstacle.
class Sliding final : public TimedExperiment {
 public:
  Sliding(const Body& body, const SlidingSetup& setup, contact::ContactOptions& contact) : body_(body), setup_(setup) {
    if (!setup.floor.empty()) {
      if (find_obstacle(contact.obstacles, setup.floor) < 0)
        throw InputError("there is no obstacle '" + setup.floor + "'");
      return;
    }
    const bool spheres = contact.surface == contact::ContactSurface::spheres;
    const VectorX reach = spheres ? body.radius : VectorX(VectorX::Zero(body.size()));
    contact::Obstacle plane;
    plane.name = "floor";
    if (find_obstacle(contact.obstacles, plane.name) >= 0)
      throw InputError("an obstacle is called 'floor' already: say floor: floor to slide on it");
    plane.shape = contact::shape::Plane{};
    plane.pose.turn = rotation_between(Vector3::UnitZ(), setup.up);
    const VectorX height = body.rest.transpose() * setup.up;
    const double depth = 1e-6 * body.radius.mean();  // what touches nothing has no equilibrium to begin from
    plane.pose.position = ((height - reach).minCoeff() + depth) * setup.up;
    contact.obstacles.push_back(plane);
  }

  std::string name() const override { return "sliding"; }
  MeasureList measures() const override { return sliding_measures(); }
  std::unique_ptr<TimedRig> timed_rig(Model& model) const override;

  void read_history(const std::vector<CurvePoint>& history, Measures& measures) const override {
    double creep = 0, fastest = 0, turn = 0;
    for (const CurvePoint& row : history) {
      if (const double own = row.measures.get("turn"); std::abs(own) > std::abs(turn)) turn = own;
      creep = std::max(creep, row.measures.get("creep"));
      fastest = std::max(fastest, std::abs(row.measures.get("slide_speed")));
    }
    measures.set("creep", creep);
    measures.set("turn", turn);
    if (topples(turn, history.back().measures.get("slide_distance"))) return;
    std::vector<std::pair<double, double>> points;
    const bool threshold = setup_.kind == SlidingKind::threshold;
    for (const CurvePoint& row : history) {
      const double speed = row.measures.get("slide_speed");
      if (threshold && speed > 0.1 * fastest) points.emplace_back(row.measures.get("slope"), std::sqrt(speed));
      if (!threshold && std::abs(speed) > 0.1 * fastest) points.emplace_back(row.time, speed);
    }
    const Line line = fit_line(points);
    if (line.points == 0) return;
    // Beyond the angle φ of friction the speed grows as sin² ((θ − φ)/2) of the slope θ: its root is straight there.
    const double gone = history.back().measures.get("slide_distance");
    // A body that slides from the start shows no such line: its zero is not beyond the slope at time 0.
    if (threshold && gone > kSlipped * body_.radius.mean() && line.zero > setup_.angle) {
      measures.set("slip_angle", line.zero);
      measures.set("slip_friction", std::tan(line.zero));
    }
    if (!threshold) measures.set("slide_acceleration", line.slope);
  }

  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    if (setup_.kind == SlidingKind::threshold) return {{"slip_friction"}, {"slip_angle"}};
    if (setup_.kind == SlidingKind::sled) return {{"slide_acceleration"}, {"slide_distance"}};
    return {{"creep"}, {"slide_distance"}, {"slide_acceleration"}};
  }

  std::string remark(const Measures& measures) const override {
    if (const double turn = measures.get("turn"); topples(turn, measures.get("slide_distance")))
      return "the body topples: it has turned by up to " + number(turn * 180 / std::numbers::pi, 3) +
             "°, so that its motion shows no friction; give it a wider base";
    if (setup_.kind != SlidingKind::threshold || std::isfinite(measures.get("slip_angle"))) return "";
    const double gone = measures.get("slide_distance");
    if (gone > kSlipped * body_.radius.mean())
      return "no angle of friction: the body slides from the start, for `from` is above it, at " +
             number(setup_.angle * 180 / std::numbers::pi, 3) + "°; write a smaller one";
    return "no angle of friction: the body has not begun to slide within the duration; write a longer one, a larger "
           "`from` or a larger `rate`";
  }

 private:
  friend class SlidingRig;
  bool topples(double turn, double slid) const {
    const VectorX height = body_.rest.transpose() * setup_.up;
    const double middle = height.dot(body_.mass) / body_.mass.sum() - height.minCoeff();
    return std::abs(turn) > kToppled || (setup_.kind != SlidingKind::threshold && std::abs(turn) > kTopples &&
                                         std::abs(turn) * middle > std::abs(slid) / 2);
  }

  const Body& body_;
  SlidingSetup setup_;
};

class SlidingRig final : public TimedRig {
 public:
  SlidingRig(const Sliding& experiment, Model& model)
      : experiment_(experiment), setup_(experiment.setup_), body_(experiment.body_), model_(model) {
    auto weight = std::make_unique<TiltedGravity>(body_, setup_);
    weight_ = weight.get();
    model.add(std::move(weight));
  }

  StaticResult start(State& state, const StaticOptions& options) override {
    model_.commit_step(state);  // friction holds the body where it is
    State stands = state;
    StaticResult solved = solve_static(model_, stands, options);
    if (solved.outcome != Outcome::converged && setup_.angle != 0) {
      weight_->set_angle(0);
      stands = state;
      solved = solve_static(model_, stands, options);
      weight_->set_angle(setup_.angle);
    }
    state = stands;
    state.velocities.colwise() += setup_.speed * setup_.along;
    begin_ = state.positions;
    return solved;
  }

  Measures read(const State& state) const override {
    const Positions displacement = state.positions - begin_;
    Measures measures;
    measures.set("slide_distance", setup_.along.dot(displacement * body_.mass) / body_.mass.sum());
    measures.set("slide_speed", setup_.along.dot(state.velocities * body_.mass) / body_.mass.sum());
    measures.set("creep", displacement.colwise().norm().maxCoeff());
    measures.set("turn", turn_of(state.positions));
    if (setup_.kind == SlidingKind::threshold) measures.set("slope", setup_.angle + setup_.rate * state.time);
    return measures;
  }

 private:
  /// In the plane of slope and normal, of the linear motion nearest to the molecules' [rad].
  double turn_of(const Positions& positions) const {
    Eigen::Matrix<double, 2, 3> seen;
    seen << setup_.along.transpose(), setup_.up.transpose();
    const auto about_middle = [&](const Positions& at) {
      const Points2 in_plane = seen * at;
      return Points2(in_plane.colwise() - in_plane * body_.mass / body_.mass.sum());
    };
    const Points2 before = about_middle(begin_), now = about_middle(positions);
    const Points2 weighted = before * body_.mass.asDiagonal();
    const Eigen::Matrix2d moments = weighted * now.transpose();
    return std::atan2(moments(1, 0) - moments(0, 1), moments.trace());
  }

  const Sliding& experiment_;
  const SlidingSetup& setup_;
  const Body& body_;
  Model& model_;
  TiltedGravity* weight_ = nullptr;  // owned by the model
  Positions begin_;
};

std::unique_ptr<TimedRig> Sliding::timed_rig(Model& model) const { return std::make_unique<SlidingRig>(*this, model); }

}  // namespace

ExperimentInfo sliding_row() {
  using S = SlidingSetup;
  constexpr Range slope{0, 1.57, false};  // up to a right angle
  const auto of_kind = [](SlidingKind kind) { return [kind](const Reader&, S& setup) { setup.kind = kind; }; };
  return with_keys(
      {.name = "sliding",
       .summary = "a body lies on a plane that is tilted, or slides along it: friction, slip angle; needs `contact`",
       .in_time = true,
       .measures = sliding_measures()},
      Keys<S>{
          key::direction("up", &S::up, "normal of the plane"),
          key::direction("along", &S::along, "direction down the slope, perpendicular to `up`")
              .refused_for([](const S& setup) {
                return perpendicular(setup.up, setup.along)
                           ? ""
                           : "`along` must be perpendicular to `up`, the normal of the plane";
              }),
          key::quantity("gravity", &S::gravity, dimension::acceleration, "acceleration of the weight", kPositive),
          Key<S>({"floor", "an obstacle's name", "", "", "a plane of its own", "what the body stands on"},
                 [](const Reader& value, S& setup, const Frame&) { setup.floor = value.text(); }),
          one_of<S>("give one of incline: {angle}, sled: {speed} and threshold: {from, rate}",
                    {key::below("incline", Keys<S>{key::angle("angle", &S::angle, "constant slope", slope).needed()})
                         .then(of_kind(SlidingKind::incline)),
                     key::below("sled", Keys<S>{key::quantity("speed", &S::speed, dimension::velocity,
                                                              "initial speed along a level floor", kPositive)
                                                    .needed()})
                         .then(of_kind(SlidingKind::sled)),
                     key::below(
                         "threshold",
                         Keys<S>{key::angle("from", &S::angle, "slope at time 0, which grows", slope).needed(),
                                 key::quantity("rate", &S::rate, {0, 0, -1}, "rate at which the slope grows", kPositive)
                                     .needed("needed with `from`")})
                         .then(of_kind(SlidingKind::threshold))})},
      [](const ExperimentContext& context, const S& setup) {
        return std::make_unique<Sliding>(context.body, setup, contact_of_scene(context));
      });
}

}  // namespace elastin::lab
