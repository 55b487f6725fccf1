#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "contact/search.h"
#include "core/base/dense.h"
#include "elastin/contact/contact.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "lab/experiment/keys.h"
#include "lab/experiment/tension/tension.h"
#include "lab/run/common_measures.h"
#include "lab/run/contact_measures.h"

namespace elastin::lab {
namespace {

enum class IndenterShape {
  sphere,
  flat,      ///< the end of a cylinder
  obstacle,  ///< one of the scene's own
};

/// A rigid indenter is pressed into a body that stands on the far end.
struct IndentationSetup : GripSetup {
  Vector3 axis = -Vector3::UnitZ();  ///< of the indenter's motion, unit
  IndenterShape shape = IndenterShape::sphere;
  double radius = 0;            ///< [m]
  std::string obstacle;         ///< its name, of IndenterShape::obstacle; it begins where the scene has it
  std::optional<Vector3> at;    ///< a place on the indenter's axis [m]; none: the middle of the body, in the planes
  std::optional<double> depth;  ///< [m] from first touch, > 0
  std::optional<double> force;  ///< or until this resists [N], > 0, of the whole body
  Grip bottom = Grip::clamped;
  std::vector<Vector3> symmetry;  ///< unit normals of planes through the origin, across each other and the axis
  int load_steps = 1;
  Matrix3 frame = Matrix3::Identity();  ///< columns: along x, y and z of the scene before it was turned
};

const MeasureList& indentation_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"indentation_modulus", pressure,
        "Hertz's modulus of a sphere, or that of a flat punch, on a half-space: E* (1 - nu^2)", Role::modulus,
        "E of indentation"},
       {"force", force, "force on the indenter along its direction, beyond that before it moves", Role::force},
       {"depth", length, "displacement of the indenter since first touch; of an obstacle since the start"},
       {"molecules_in_contact", none, "number of molecules of the whole body on which the indenter presses"},
       {"mean_pressure", pressure, "mean contact pressure: force / area"}},
      {{"depth", "force", true}}};
  return list;
}

constexpr const char* kIndenter = "indenter";

/// Of the radius of contact in the body's thickness and width: an incompressible layer that is glued to its bed is
/// stiffer than a half-space by 1.13 of it, to first order.                  [Dimitriadis et al. 2002]
constexpr double kHalfSpace = 0.05;

/// Molecules in contact below which a modulus is that of their positions.
constexpr int kFewestInContact = 9;

/// Adds its indenter to the obstacles. The modulus that it measures is Hertz's of a sphere on a half-space, E* = 3 F /
/// (4 √R d^1.5), or that of a flat punch, E* = F / (2 a d) [Johnson 1985, ch. 3, 4], times 1 − ν². Throws InputError on
/// a setup that does not suit the body.
class Indentation final : public StaticExperiment {
 public:
  Indentation(const Body& body, const IndentationSetup& setup, const Material& material,
              contact::ContactOptions& contact)
      : setup_(setup),
        poissons_ratio_(material.poissons_ratio),
        adhesive_(contact.adhesion > 0 && setup.shape != IndenterShape::obstacle) {
    check_place(body);
    fix_in_planes(body, setup.symmetry, fixed_);
    fix_bottom(body);
    if (setup.shape == IndenterShape::obstacle) {
      indenter_ = find_obstacle(contact.obstacles, setup.obstacle);
      if (indenter_ < 0) throw InputError("there is no obstacle '" + setup.obstacle + "'");
    } else {
      if (find_obstacle(contact.obstacles, kIndenter) >= 0)
        throw InputError("an obstacle has the indenter's own name, 'indenter'");
      spheres_ = contact.surface == contact::ContactSurface::spheres;
      choose_base(body);
      contact.obstacles.push_back(indenter(body));
      indenter_ = static_cast<int>(contact.obstacles.size()) - 1;
    }
    contact::Obstacle& obstacle = contact.obstacles[indenter_];
    if (obstacle.motion)
      throw InputError("the indenter '" + obstacle.name + "' has a motion of its experiment: leave that out");
    // The moment at which the rig requests its obstacles' poses is the indenter's displacement.
    obstacle.motion = [start = obstacle.pose, axis = setup.axis](double displacement) {
      contact::Pose pose = start;
      pose.position += displacement * axis;
      return pose;
    };
    const double depth = setup.depth ? *setup.depth : first_depth(*setup.force, material);
    if (setup.force) control_ = ForceControl(*setup.force, first_depth(*setup.force / copies(), material));
    if (setup.shape != IndenterShape::obstacle) find_extent(body, depth);
  }

  std::string name() const override { return "indentation"; }
  MeasureList measures() const override { return indentation_measures(); }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;
  int load_steps() const override { return setup_.load_steps; }
  double copies() const override { return std::pow(2, setup_.symmetry.size()); }
  const StaticExperiment* calibration() const override {
    return nullptr;
  }  // without contact there is nothing to calibrate by

  std::vector<MainMeasure> main_measures(const Material& material, const Measures&) const override {
    std::vector<MainMeasure> measures{{"force"}, {"depth"}, {"contact_area"}};
    if (setup_.shape != IndenterShape::obstacle)
      measures.insert(measures.begin(), {"indentation_modulus", apparent() ? std::numeric_limits<double>::quiet_NaN()
                                                                           : material.youngs_modulus});
    return measures;
  }

  bool apparent() const override { return adhesive_ || contact_share_ > kHalfSpace; }
  std::string no_reference() const override {
    if (!apparent()) return "";
    return (adhesive_ ? "the surface adheres" : "the body is no half-space") +
           std::string(", so its modulus is apparent; compare with the solid itself (neo_hookean, refined)");
  }
  std::vector<std::string> notes() const override {
    std::vector<std::string> notes;
    if (adhesive_)
      notes.push_back("indentation_modulus is apparent: its formula knows no adhesion, which pulls the indenter in");
    if (contact_share_ > kHalfSpace)
      notes.push_back("indentation_modulus is apparent: " +
                      (std::isfinite(contact_share_)
                           ? "the radius of contact is " + number(100 * contact_share_, 2) +
                                 " % of the body's thickness or of the distance to its side"
                           : std::string("the indenter's axis lies in a side of the body, or beyond it")) +
                      ", where the formula takes a half-space");
    return notes;
  }

  std::string remark(const Measures& measures) const override {
    if (!(measures.get("contacts") > 0)) return "the indenter touches nothing";
    if (setup_.force && std::abs(measures.get("force") / *setup_.force - 1) > 1e-5)
      return "the prescribed force was not reached";
    const double touching = measures.get("molecules_in_contact");
    if (setup_.shape != IndenterShape::obstacle && touching < kFewestInContact)
      return "the indenter presses on " + counted(std::lround(touching), "molecule") + " alone, where some " +
             std::to_string(kFewestInContact) +
             " are needed for a contact: force and modulus depend on where they lie; refine the body there (`grade`), "
             "press deeper, or take a larger radius";
    return "";
  }

 private:
  friend class IndentationRig;
  /// Planes of symmetry cut the indenter in the middle.
  void check_place(const Body& body) const {
    const double size = (body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()).norm();
    for (const Vector3& normal : setup_.symmetry)
      if (const double off = setup_.at ? std::abs(normal.dot(*setup_.at)) : 0; off > 1e-9 * size)
        throw InputError("at: the indenter's axis is " + number(1e3 * off, 3) +
                         " mm away from a plane of symmetry, which must contain it; write a place in the plane, or "
                         "leave the `symmetry` out and model the whole body");
  }

  void fix_bottom(const Body& body) {
    const Matrix3 along = setup_.axis * setup_.axis.transpose();
    EndFinder finder(body, setup_.grip_depth);
    const Face bottom = finder.find("fixed", setup_.axis, setup_.fixed);
    findings_ = std::move(finder.findings);
    for (const int molecule : bottom.molecules) {
      Matrix3& free = fixed_.try_emplace(molecule, Matrix3::Identity()).first->second;
      free = setup_.bottom == Grip::clamped ? Matrix3(Matrix3::Zero()) : Matrix3(free - along);
    }
  }

  /// Its least and largest place along x, y and z as the scene was before it was turned.
  std::array<Vector3, 2> outline(const Body& body) const {
    const Positions own = setup_.frame.transpose() * body.rest;
    return {own.rowwise().minCoeff(), own.rowwise().maxCoeff()};
  }

  Vector3 middle_of(const Body& body) const {
    const auto [low, high] = outline(body);
    return setup_.frame * (low + high) / 2;
  }

  /// What the radius of contact is of the body's thickness along the axis, or of the way to its nearest free side.
  void find_extent(const Body& body, double depth) {
    const double radius = setup_.shape == IndenterShape::sphere ? std::sqrt(setup_.radius * depth) : setup_.radius;
    const auto [low, high] = outline(body);
    const Vector3 at = setup_.frame.transpose() * setup_.at.value_or(middle_of(body));
    double extent = (setup_.frame.transpose() * setup_.axis).cwiseAbs().dot(high - low);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 across = setup_.frame.col(axis);
      if (std::abs(across.dot(setup_.axis)) > 0.5) continue;
      const auto mirrors = [&](const Vector3& normal) { return std::abs(normal.dot(across)) > 0.5; };
      const bool mirrored = std::any_of(setup_.symmetry.begin(), setup_.symmetry.end(), mirrors);
      extent =
          std::min(extent, mirrored ? high[axis] - low[axis] : std::min(high[axis] - at[axis], at[axis] - low[axis]));
    }
    contact_share_ = extent > 0 ? radius / extent : std::numeric_limits<double>::infinity();
  }

  /// The foot of the indenter's axis, in the plane through the origin across it.
  void choose_base(const Body& body) {
    base_ = setup_.at.value_or(middle_of(body));
    for (const Vector3& normal : setup_.symmetry) base_ -= normal.dot(base_) * normal;
    base_ -= setup_.axis.dot(base_) * setup_.axis;
  }

  /// Place along the axis [m] at which the indenter touches the body, of a sphere that of its middle; infinite where
  /// nothing lies before it.
  double first_touch(const Body& body, const Positions& positions) const {
    const bool sphere = setup_.shape == IndenterShape::sphere;
    const double radius = setup_.radius;
    double first = std::numeric_limits<double>::infinity();
    const auto meet = [&](const Vector3& position, double r) {
      const double along = setup_.axis.dot(position), off = (position - base_ - along * setup_.axis).norm();
      if (off <= (sphere ? radius + r : radius))
        first = std::min(first, along - (sphere ? std::sqrt(std::pow(radius + r, 2) - off * off) : r));
    };
    for (int molecule = 0; molecule < body.size(); ++molecule)
      meet(positions.col(molecule), spheres_ ? body.radius[molecule] : 0);
    if (!spheres_)  // in a hollow a side's middle comes before its corners
      for (const contact::Sample& sample : contact::side_samples(body, contact::surface_sides(body))) {
        Vector3 position = Vector3::Zero();
        for (int i = 0; i < sample.count; ++i) position += sample.weights[i] * positions.col(sample.molecules[i]);
        meet(position, 0);
      }
    return first - 1e-9 * radius;  // what only seems to be pressed in, by rounding, would have to be in equilibrium
  }

  /// The indenter where it just touches the body at rest.
  contact::Obstacle indenter(const Body& body) {
    const bool sphere = setup_.shape == IndenterShape::sphere;
    const double radius = setup_.radius;
    touches_ = first_touch(body, body.rest);
    if (!std::isfinite(touches_))
      throw InputError("no molecule lies before the indenter: give `at`, a point on its axis");
    contact::Obstacle obstacle;
    obstacle.name = kIndenter;
    obstacle.pose.turn = rotation_between(-Vector3::UnitZ(), setup_.axis);
    const double length = 4 * radius;
    if (sphere)
      obstacle.shape = contact::shape::Sphere{radius};
    else
      obstacle.shape = contact::shape::Cylinder{radius, length};
    obstacle.pose.position = base_ + (sphere ? touches_ : touches_ - length / 2) * setup_.axis;
    return obstacle;
  }

  /// [m] by Hertz, or of a flat punch.
  double first_depth(double force, const Material& material) const {
    const double modulus = material.youngs_modulus / (1 - poissons_ratio_ * poissons_ratio_), radius = setup_.radius;
    return setup_.shape == IndenterShape::sphere ? std::pow(3 * force / (4 * modulus * std::sqrt(radius)), 2. / 3)
                                                 : force / (2 * radius * modulus);
  }

  IndentationSetup setup_;
  double poissons_ratio_;
  bool adhesive_;  ///< of an indenter whose modulus is measured
  FixedMolecules fixed_;
  int indenter_ = 0;
  bool spheres_ = false;            ///< as what the body touches, of an indenter of its own
  Vector3 base_ = Vector3::Zero();  ///< the foot of its axis
  double touches_ = 0;              ///< [m] along it, where it touches the body at rest
  ForceControl control_;
  double contact_share_ = 0;  ///< see find_extent
};

class IndentationRig final : public StaticRig {
 public:
  IndentationRig(const Indentation& experiment, Model& model)
      : experiment_(experiment), setup_(experiment.setup_), model_(model), control_(experiment.control_) {
    for (const auto& [molecule, free] : experiment_.fixed_) model.supports.push_back({molecule, free, Vector3::Zero()});
    contact_ = contact_of(model);
  }

  bool withdraw() override {
    if (setup_.shape == IndenterShape::obstacle) return false;
    const Positions& rest = model_.body().rest;
    begins_ = -10 * (rest.rowwise().maxCoeff() - rest.rowwise().minCoeff()).norm();
    return true;
  }
  void meet(const Positions& positions) override {
    if (setup_.shape == IndenterShape::obstacle) return;
    const double first = experiment_.first_touch(model_.body(), positions);
    begins_ = std::isfinite(first) ? first - experiment_.touches_ : 0;
  }

  void set_load(double factor) override {
    if (setup_.force) control_.aim(factor);
    move_to(factor == 0 ? 0 : setup_.force ? control_.displacement() : factor * *setup_.depth);
  }

  bool seeks_load() const override { return setup_.force.has_value(); }
  bool adjust(const State& state) override {
    if (!setup_.force || displacement_ == 0 || !control_.adjust(resistance(contact_->report(state)))) return false;
    move_to(control_.displacement());
    return true;
  }

  Measures measure(const Start& start, const State& state, const StaticOptions&, StaticResult& solved) const override {
    const contact::ContactReport report = contact_->report(state);
    const double whole = resistance(report), force = whole - resistance_at(start);
    const double depth = displacement_, radius = setup_.radius;
    Measures measures;
    measures.set("force", force);
    measures.set("depth", depth);
    const double plane_strain = 1 - experiment_.poissons_ratio_ * experiment_.poissons_ratio_;
    const bool indented = is_strained(depth / radius);
    if (indented && setup_.shape == IndenterShape::sphere)
      measures.set("indentation_modulus", plane_strain * 3 * force / (4 * std::sqrt(radius) * std::pow(depth, 1.5)));
    if (indented && setup_.shape == IndenterShape::flat)
      measures.set("indentation_modulus", plane_strain * force / (2 * radius * depth));
    measures.set("molecules_in_contact", molecules_in_contact(report));
    if (report.area > 0) measures.set("mean_pressure", whole / (experiment_.copies() * report.area));
    add_state(model_, state, solved, std::abs(force), measures, experiment_.copies());
    return measures;
  }

 private:
  /// Of the whole body: what lies in a plane of symmetry has no copy across it.
  double molecules_in_contact(const contact::ContactReport& report) const {
    double count = 0;
    for (int molecule = 0; molecule < report.forces.cols(); ++molecule) {
      if (report.forces.col(molecule).isZero(0)) continue;
      const auto in_plane = [&](const Vector3& normal) {
        return std::abs(normal.dot(model_.body().rest.col(molecule))) < 1e-6 * model_.body().radius[molecule];
      };
      const auto planes = std::count_if(setup_.symmetry.begin(), setup_.symmetry.end(), in_plane);
      count += experiment_.copies() / std::pow(2, planes);
    }
    return count;
  }

  void move_to(double displacement) {
    displacement_ = displacement;
    contact_->set_moment(begins_ + displacement);
  }

  /// With which the body presses back [N].
  double resistance(const contact::ContactReport& report) const {
    return -experiment_.copies() * setup_.axis.dot(report.on_obstacles[experiment_.indenter_]);
  }

  /// The same before an obstacle of the scene moves: preload may press on it.
  double resistance_at(const Start& start) const {
    if (setup_.shape != IndenterShape::obstacle || start.positions == model_.body().rest) return 0;
    State before = state_at_rest(model_.body());
    before.positions = start.positions;
    before.contact_history = start.touches;
    contact_->set_moment(begins_);
    const double resisted = resistance(contact_->report(before));
    contact_->set_moment(begins_ + displacement_);
    return resisted;
  }

  const Indentation& experiment_;
  const IndentationSetup& setup_;
  Model& model_;
  contact::Contact* contact_ = nullptr;  // owned by the model
  double displacement_ = 0;              // of the indenter [m], since it began
  double begins_ = 0;                    // [m], from where it touches the body at rest
  ForceControl control_;
};

std::unique_ptr<StaticRig> Indentation::make_rig(Model& model) const {
  return std::make_unique<IndentationRig>(*this, model);
}

}  // namespace

namespace {

Keys<IndentationSetup> form_keys(IndenterShape shape, const char* text) {
  return {key::quantity("radius", &IndentationSetup::radius, dimension::length, text, kPositive)
              .needed()
              .then([shape](const Reader&, IndentationSetup& setup) { setup.shape = shape; })};
}

/// sphere: {radius: 5 mm}, flat: {radius: 5 mm}, or an obstacle's name.
Key<IndentationSetup> indenter_key() {
  const Keys<IndentationSetup> forms{
      one_of<IndentationSetup>("write {sphere: {radius: 5 mm}}, {flat: {radius: 5 mm}}, or the name of an obstacle",
                               {key::below("sphere", form_keys(IndenterShape::sphere, "radius of a sphere")),
                                key::below("flat", form_keys(IndenterShape::flat, "radius of a flat punch"))})};
  const Key<IndentationSetup> form = key::below("indenter", forms, "what is pressed into the body");
  std::vector<SceneKey> rows = form.rows();
  rows.front().type = "map, or an obstacle's name";
  return Key<IndentationSetup>("indenter", rows,
                               [form](const Reader& value, IndentationSetup& setup, const Frame& frame) {
                                 if (!value.is_text()) return form.read(value, setup, frame);
                                 setup.shape = IndenterShape::obstacle;
                                 setup.obstacle = value.text();
                               })
      .needed();
}

}  // namespace

ExperimentInfo indentation_row() {
  std::vector<Key<IndentationSetup>> loads =
      travel_keys("depth", &IndentationSetup::depth, &IndentationSetup::axis, "depth from the first contact point");
  loads.push_back(key::quantity("force", &IndentationSetup::force, dimension::force,
                                "force, of the whole body, that ends the motion; not of an obstacle", kPositive)
                      .refused_for([](const IndentationSetup& setup) {
                        return setup.force && setup.shape == IndenterShape::obstacle ? "of an obstacle give the depth"
                                                                                     : "";
                      }));
  return with_keys(
      {.name = "indentation",
       .summary = "a rigid indenter is pressed into a body that stands on its far end: force, indentation modulus; "
                  "needs `contact`",
       .source = "Johnson 1985, ch. 3, 4",
       .measures = indentation_measures()},
      Keys<IndentationSetup>{
          key::direction("axis", &IndentationSetup::axis, "direction of the motion"), indenter_key(),
          one_of("give one of depth, strain and force", loads),
          key::vector("at", &IndentationSetup::at, dimension::length,
                      "a position on the indenter's axis; not of an obstacle")
              .otherwise("the middle")
              .refused_for([](const IndentationSetup& setup) {
                return setup.at && setup.shape == IndenterShape::obstacle ? "an obstacle begins where the scene has it"
                                                                          : "";
              }),
          grip_key("bottom", &IndentationSetup::bottom, "how the far end is fixed"),
          end_key("fixed", &IndentationSetup::fixed, "the far end"), grip_depth_key(&IndentationSetup::grip_depth),
          symmetry_key(&IndentationSetup::symmetry).then([](const Reader& value, IndentationSetup& setup) {
            for (const Vector3& normal : setup.symmetry)
              if (std::abs(normal.dot(setup.axis)) > 1e-9) value.fail("must be perpendicular to the indenter's axis");
          }),
          load_steps_key(&IndentationSetup::load_steps)},
      [](const ExperimentContext& context, IndentationSetup setup) {
        setup.frame = context.rotation;
        return std::make_unique<Indentation>(context.body, setup, context.material, contact_of_scene(context));
      });
}

}  // namespace elastin::lab
