#include "lab/experiment/tension/tension.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "core/base/dense.h"
#include "core/shapes/refinement.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/model/share.h"
#include "lab/run/common_measures.h"
#include "lab/run/ends.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

/// Of the length: grips that hold layers to this depth show in the modulus.
constexpr double kThickGrip = 0.02;

class Tension final : public StaticExperiment {
 public:
  Tension(const Body& body, const TensionSetup& setup) : body_(body), setup_(setup), plane_(across(setup.axis)) {
    setup_.axis.normalize();
    height_ = body.rest.transpose() * setup_.axis;
    low_ = least_over(body, height_.minCoeff()), high_ = largest_over(body, height_.maxCoeff());
    Ends ends(body, setup_.axis, setup);
    findings_ = std::move(ends.findings);
    loaded_ = std::move(ends.loaded.molecules);
    fixed_ = std::move(ends.fixed.molecules);
    share_ = setup.sharing == LoadSharing::area ? std::move(ends.loaded.share) : equal_shares(loaded_);
    fixed_share_ = equal_shares(fixed_);
    const Points2 seen = plane_.transpose() * body.rest;
    choose_corner(seen);
    const bool held = setup.strain || setup.displacement;
    const double whole =
        (held ? end_of_grip(body, loaded_, setup_.axis, mean_height(loaded_, share_)) : mean_height(loaded_, share_)) -
        end_of_grip(body, fixed_, setup_.axis, mean_height(fixed_, fixed_share_));
    fixed_depth_ = end_of_grip(body, fixed_, setup_.axis, low_) - low_;
    loaded_depth_ = high_ - end_of_grip(body, loaded_, setup_.axis, high_);
    choose_gauge(low_, whole);
    if (setup.strain) {
      setup_.displacement = *setup.strain * whole;
      setup_.strain.reset();
    }
    choose_section(ends.low, ends.high);
    if (section_ && !setup.gauge && ends.slanted)
      section_->variation =
          std::max(section_->variation, find_section(body, setup_.axis, low_, high_, setup_.thickness).variation);
    choose_force();
    choose_middle((ends.low + ends.high) / 2);
    for (const Part& part : body.parts)
      if (force_ && part.rigid && meets(part, loaded_))
        throw InputError("body '" + part.name + "' at the loaded end is rigid: give a displacement instead of a force");
  }

  const TensionSetup& setup() const { return setup_; }
  std::string name() const override { return "tension"; }
  MeasureList measures() const override { return tension_measures(); }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;
  std::optional<Vector3> axis() const override { return setup_.axis; }
  int load_steps() const override {
    return setup_.load_steps * static_cast<int>(std::max<std::size_t>(1, setup_.cycle.size()));
  }
  double load_factor(int step) const override {
    const double at = static_cast<double>(step) / setup_.load_steps;
    if (setup_.cycle.empty()) return at;
    const auto turn = std::min(static_cast<std::size_t>((step - 1) / setup_.load_steps), setup_.cycle.size() - 1);
    const double from = turn == 0 ? 0 : setup_.cycle[turn - 1], part = at - static_cast<double>(turn);
    return from + part * (setup_.cycle[turn] - from);
  }
  ResponseMeasures response_measures() const override { return {"elongation", setup_.displacement ? "force" : ""}; }
  bool apparent() const override { return section_ && !section_->prism(); }

  std::string no_reference() const override {
    if (apparent()) return "the body is no prism along the axis, so its modulus is apparent; compare with " + solid();
    if (!clamps_reach_gauge()) return "";
    const bool clamped = setup_.fixed_grip == Grip::clamped || setup_.loaded_grip == Grip::clamped;
    return std::string(clamped ? "the grips clamp" : "the grips hold several layers, which do not narrow as the rest") +
           ", so no specimen shows the material's E; compare with " + solid();
  }

  std::vector<std::string> notes() const override {
    std::vector<std::string> notes;
    if (!section_) return notes;
    if (section_->of_hull && setup_.cross_section == 0)
      notes.push_back("cross-section of " + area_text(area_) +
                      (area_ < section_->area
                           ? ": the volume of the masses over the length; the convex hull of the molecules, " +
                                 area_text(section_->area) + ", is not full"
                           : ": the convex hull of the molecules seen along the axis; the body has no cells that state "
                             "its volume"));
    if (apparent()) {
      char percent[16];
      std::snprintf(percent, sizeof percent, "%.0f %%", 100 * section_->variation);
      notes.push_back("effective_modulus is apparent: the section varies by " + std::string(percent) +
                      " along the axis about its mean of " + area_text(section_->area));
    }
    return notes;
  }

  std::optional<UniformTest> uniform(const Measures& measured) const override {
    TensionSetup own;
    own.axis = setup_.axis, own.strain = measured.get("strain"), own.thickness = setup_.thickness;
    if (!setup_.cycle.empty() || clamps_reach_gauge()) return std::nullopt;
    return UniformTest{*own.strain, rotation_between(Vector3::UnitX(), own.axis),
                       [own](const Body& block) { return make_tension(block, own); }};
  }

  std::vector<MainMeasure> main_measures(const Material& material, const Measures& measured) const override {
    if (setup_.displacement == 0.) return {{"force"}};  // with which a body pushes that has a rest
    UniaxialResponse target = uniaxial_response(material, setup_.axis);
    const double strain = measured.get("strain");
    if (std::isfinite(strain) && strain != 0)  // the secant of a curve, where no block shows the law's
      if (const auto stress = uniaxial_stress(material, setup_.axis, strain)) target.youngs_modulus = *stress / strain;
    if (!setup_.cycle.empty() && std::isfinite(strain)) {
      constexpr double none = std::numeric_limits<double>::quiet_NaN();
      return {{"effective_modulus", none}, {"poissons_ratio", none}, {"elongation"}};
    }
    if (apparent()) target.youngs_modulus = std::numeric_limits<double>::quiet_NaN();
    std::vector<MainMeasure> measures{
        {"effective_modulus", target.youngs_modulus}, {"poissons_ratio", target.poissons_ratio}, {"elongation"}};
    if (material.curve || material.fibre || material.law) measures.push_back({"curve_error"});
    return measures;
  }

 private:
  friend class TensionRig;
  /// The corner is the loaded molecule furthest from the layer's middle; of equals, the first.
  void choose_corner(const Points2& seen) {
    const auto owned = std::count_if(loaded_.begin(), loaded_.end(), [&](int molecule) { return owns(molecule); });
    const double count = sum_over(body_, static_cast<double>(owned));
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < loaded_.size(); ++i)
      if (owns(loaded_[i])) middle += seen.col(loaded_[i]) / count;
    sum_over(body_, {middle.data(), 2});
    double furthest = -1;
    for (std::size_t i = 0; i < loaded_.size(); ++i) {
      const double distance = (seen.col(loaded_[i]) - middle).norm();
      if (owns(loaded_[i]) && distance > furthest * (1 + 1e-9))
        furthest = distance, corner_ = static_cast<Eigen::Index>(i);
    }
    if (!body_.share) return;
    const double most = largest_over(body_, furthest);
    const bool mine = furthest >= 0 && furthest * (1 + 1e-9) >= most;
    const double none = std::numeric_limits<double>::infinity();
    const double number = mine ? static_cast<double>(number_in_whole(body_, loaded_[corner_])) : none;
    if (const double first = least_over(body_, number); !mine || number > first) corner_ = -1;
  }

  void choose_gauge(double low, double whole) {
    gauge_length_ = setup_.gauge_length > 0 ? setup_.gauge_length : whole;
    if (setup_.gauge_length > 0)
      note_stated(
          "gauge_length", "strain and modulus", setup_.gauge_length,
          {setup_.gauge ? (*setup_.gauge)[1] - (*setup_.gauge)[0] : whole},
          [](double length) { return number(1e3 * length, 4) + " mm"; }, findings_);
    if (!setup_.gauge) return;
    const auto& [first, second] = *setup_.gauge;
    if (!(first >= 0 && second > first && low + second <= high_ * (1 + 1e-9)))
      throw InputError("gauge: the planes must lie between the ends of the body, the first below the second");
    if (setup_.gauge_length == 0) gauge_length_ = second - first;
    for (const int plane : {0, 1}) {
      const double at = low + (*setup_.gauge)[plane];
      for (int c = 0; c < body_.connections.proper(); ++c) {
        const auto& [a, b] = body_.connections.ends[c];
        const double part = (at - height_[a]) / (height_[b] - height_[a]);
        if (computes(body_, c) && part >= -1e-9 && part <= 1 + 1e-9) crossings_[plane].push_back({c, part});
      }
      crossing_count_[plane] = sum_over(body_, static_cast<double>(crossings_[plane].size()));
      if (crossing_count_[plane] == 0) throw InputError("gauge: no connection crosses the plane");
    }
  }

  /// The force that the section carries, and the molecules on which it acts. A weight's is its mean over what is
  /// measured: each molecule pulls at what lies between it and the fixed end, Σ m g min(h, l₀) / l₀. A body that a
  /// force on its end strains uniformly shows the same modulus under both, by reciprocity.             [Betti 1872]
  void choose_force() {
    if (!setup_.gravity) {
      force_ = setup_.force;
      pulled_ = loaded_;
      pull_ = share_;
      return;
    }
    const double low = setup_.gauge ? low_ + (*setup_.gauge)[0] : mean_height(fixed_, fixed_share_);
    const double high = setup_.gauge ? low_ + (*setup_.gauge)[1] : mean_height(loaded_, share_);
    const VectorX carried = ((height_.array() - low) / (high - low)).cwiseMax(0).cwiseMin(1);
    const int owned = owned_molecules(body_);
    const double mass = sum_over(body_, body_.mass.head(owned).dot(carried.head(owned)));
    if (!(mass > 0)) throw InputError("nothing that is measured carries weight");
    force_ = *setup_.gravity * mass;
    pulled_.resize(static_cast<std::size_t>(body_.size()));
    std::iota(pulled_.begin(), pulled_.end(), 0);
    pull_ = body_.mass / mass;
    pull_.tail(body_.size() - owned).setZero();
  }

  /// The scene's own area, or that of the body, between the gauge planes if there are any. An area that is stated makes
  /// no prism where the body's cells show another section.
  void choose_section(double low, double high) {
    section_ = setup_.gauge ? find_section(body_, setup_.axis, low_ + (*setup_.gauge)[0],
                                           std::min(high_, low_ + (*setup_.gauge)[1]), setup_.thickness)
                            : find_section(body_, setup_.axis, low, high, setup_.thickness);
    area_ = setup_.cross_section > 0 ? setup_.cross_section : section_->area;
    // Of a hollow body without cells, as a packing in a tube is.
    const double of_masses = setup_.density > 0 ? body_.mass.sum() / setup_.density / (high_ - low_) : 0;
    if (setup_.cross_section == 0 && section_->of_hull && !setup_.gauge && !body_.share && of_masses > 0 &&
        of_masses < 0.9 * area_)
      area_ = of_masses;
    note_stated_section(body_, setup_.axis, setup_.cross_section, section_->area, findings_);
    if (setup_.cross_section > 0 && section_->of_hull) section_.reset();
    if (!(area_ > 0)) throw InputError("the body's molecules span no cross-section: give cross_section");
  }

  /// Clamps disturb what lies within one width of them [Saint-Venant]; a gauge beyond that shows the material. So do
  /// sliding grips that hold several layers along the axis.
  bool clamps_reach_gauge() const {
    const double length = high_ - low_, width = std::sqrt(area_), thick = kThickGrip * length;
    const bool below = setup_.fixed_grip == Grip::clamped || fixed_depth_ > thick,
               above = setup_.loaded_grip == Grip::clamped || (setup_.displacement && loaded_depth_ > thick);
    if (!setup_.gauge) return below || above;
    return (below && (*setup_.gauge)[0] < fixed_depth_ + width) ||
           (above && length - (*setup_.gauge)[1] < loaded_depth_ + width);
  }

  /// What solves the same problem.
  std::string solid() const {
    return body_.tetrahedra.empty() && !body_.triangles.empty() ? "a membrane law, refined"
                                                                : "the solid itself (neo_hookean, refined)";
  }

  /// Chooses the molecules about mid height (between the gauge planes, if any) whose motion shows the lateral strain
  /// there. They count by what of the body is theirs, and the less the further they lie from it: not at all at the mean
  /// rise of the connections that cross it, or further where these are too few to span the section.
  void choose_middle(double middle) {
    if (setup_.gauge) middle = low_ + ((*setup_.gauge)[0] + (*setup_.gauge)[1]) / 2;
    std::array<double, 2> rises{};  // their sum, and how many
    const double level = 1e-6 * (high_ - low_);
    for (int c = 0; c < body_.connections.proper(); ++c) {
      const auto [below, above] =
          std::minmax(height_[body_.connections.ends[c][0]], height_[body_.connections.ends[c][1]]);
      if (computes(body_, c) && above - below > level && below <= middle + level && above >= middle - level)
        rises[0] += above - below, ++rises[1];
    }
    sum_over(body_, rises);
    const VectorX shares = shares_of_section();
    middle_.resize(static_cast<std::size_t>(owned_molecules(body_)));
    std::iota(middle_.begin(), middle_.end(), 0);
    middle_weight_ = shares;
    const double spanned = roundness();
    const std::vector<int> all = std::move(middle_);
    for (double reach = rises[1] > 0 ? rises[0] / rises[1] : high_ - low_;; reach *= 2) {
      middle_.clear();
      for (const int molecule : all)
        if (std::abs(height_[molecule] - middle) < reach - level) middle_.push_back(molecule);
      middle_weight_.resize(static_cast<Eigen::Index>(middle_.size()));
      for (std::size_t i = 0; i < middle_.size(); ++i)
        middle_weight_[static_cast<Eigen::Index>(i)] =
            shares[middle_[i]] * (1 - std::abs(height_[middle_[i]] - middle) / reach);
      if (roundness() >= 0.1 * spanned - 1e-9 || reach > high_ - low_) break;
    }
  }

  /// What of the body belongs to each owned molecule: of its cells, or without them by mass.
  VectorX shares_of_section() const {
    const int owned = owned_molecules(body_);
    const bool cells =
        !body_.blocks.empty() || !body_.cubes.empty() || !body_.tetrahedra.empty() || !body_.triangles.empty();
    if (any_over(body_, cells)) {
      const VectorX volumes = volumes_of_molecules(body_).head(owned);
      if (least_over(body_, owned > 0 ? volumes.minCoeff() : 1) > 0) return volumes;
    }
    const bool heavy = body_.mass.size() == body_.size() && sum_over(body_, body_.mass.sum()) > 0;
    return heavy ? VectorX(body_.mass.head(owned)) : VectorX(VectorX::Ones(owned));
  }

  /// Of the molecules at mid height, seen along the axis: determinant over squared trace of their spread, 0 where they
  /// lie in a line, and −1 where they are one place.
  double roundness() const {
    const auto [positions, spread] = spread_of_middle();
    return spread.trace() > 0 ? spread.determinant() / std::pow(spread.trace(), 2) : -1;
  }

  /// A plane along the axis to which the scene's supports hold all molecules that lie in it, at a side of the body,
  /// which moves as half of a body with an image behind it.
  struct Mirror {
    Eigen::RowVector2d normal;  ///< in the plane across the axis
    double distance;            ///< from the origin along it [m]
  };

  /// Their places in the plane less their mean [m], those of their images behind `mirrors` with them, and Σ w y yᵀ
  /// [m²].
  std::pair<Eigen::MatrixX2d, Eigen::Matrix2d> spread_of_middle(const std::vector<Mirror>& mirrors = {}) const {
    Eigen::MatrixX2d places(static_cast<Eigen::Index>(middle_.size()), 2);
    for (std::size_t i = 0; i < middle_.size(); ++i)
      places.row(static_cast<Eigen::Index>(i)) = body_.rest.col(middle_[i]).transpose() * plane_;
    places = with_images(std::move(places), mirrors, 1);
    const VectorX weights = weights_of(places);
    Eigen::RowVector2d mean = weights.transpose() * places;
    sum_over(body_, {mean.data(), 2});
    places.rowwise() -= mean / sum_over(body_, weights.sum());
    Eigen::Matrix2d spread = places.transpose() * weights.asDiagonal() * places;
    sum_over(body_, {spread.data(), 4});
    return {std::move(places), spread};
  }

  /// None where two are not at right angles: their images would have images.
  std::vector<Mirror> mirrors() const {
    constexpr std::size_t most = 8;
    constexpr int size = 4;  // of a support that leaves one direction out: this direction, and where it lies along it
    std::vector<double> own;
    for (const Support& support : further_supports()) {
      const Matrix3 fixed = Matrix3::Identity() - support.free;
      if (std::abs(fixed.trace() - 1) > 1e-9 || (plane_.transpose() * fixed * plane_).trace() < 1 - 1e-9) continue;
      Eigen::Index column = 0;
      fixed.colwise().norm().maxCoeff(&column);
      const Vector3 along = fixed.col(column).normalized();
      bool known = own.size() >= size * most;
      for (std::size_t i = 0; i < own.size(); i += size) known |= along.dot(Vector3(&own[i])) > 1 - 1e-9;
      if (!known) own.insert(own.end(), {along[0], along[1], along[2], along.dot(body_.rest.col(support.molecule))});
    }
    const std::vector<double> all = gathered_over(body_, own);
    std::vector<Mirror> found;
    for (std::size_t i = 0; i < all.size(); i += size) {
      const Vector3 along(&all[i]);
      const Mirror mirror{along.transpose() * plane_, all[i + 3]};
      const bool known = std::any_of(found.begin(), found.end(), [&](const Mirror& one) {
        return std::abs(one.normal.dot(mirror.normal)) > 1 - 1e-9;
      });
      if (!known && holds_side(along, mirror.distance)) found.push_back(mirror);
    }
    const bool square =
        found.size() < 2 || (found.size() == 2 && std::abs(found[0].normal.dot(found[1].normal)) < 1e-9);
    return square ? found : std::vector<Mirror>{};
  }

  /// Whether the body lies on one side of a plane, and supports hold all molecules that lie in it along its normal.
  bool holds_side(const Vector3& normal, double distance) const {
    const VectorX heights = (body_.rest.transpose() * normal).array() - distance;
    const double near = 1e-9 * (high_ - low_);
    if (least_over(body_, heights.minCoeff()) < -near && largest_over(body_, heights.maxCoeff()) > near) return false;
    std::vector<char> held(static_cast<std::size_t>(body_.size()));
    for (const Support& support : further_supports()) held[support.molecule] = (support.free * normal).norm() < 1e-9;
    bool slips = false;
    for (int molecule = 0; molecule < owned_molecules(body_); ++molecule)
      slips |= std::abs(heights[molecule]) <= near && !held[molecule];
    return !any_over(body_, slips);
  }

  /// `values` of molecules in the plane, and those of their images: of places, or of motions with `part` 0.
  static Eigen::MatrixX2d with_images(Eigen::MatrixX2d values, const std::vector<Mirror>& mirrors, double part) {
    for (const auto& [normal, distance] : mirrors) {
      const Eigen::Index count = values.rows();
      values.conservativeResize(2 * count, 2);
      const VectorX behind = (values.topRows(count) * normal.transpose()).array() - part * distance;
      values.bottomRows(count) = values.topRows(count) - 2 * behind * normal;
    }
    return values;
  }
  VectorX weights_of(const Eigen::MatrixX2d& with_images) const {
    return middle_weight_.replicate(middle_.empty() ? 1 : with_images.rows() / middle_weight_.size(), 1);
  }

  double mean_height(const std::vector<int>& molecules, const VectorX& weights) const {
    double mean = 0;
    for (std::size_t i = 0; i < molecules.size(); ++i)
      mean += weights[static_cast<Eigen::Index>(i)] * height_[molecules[i]];
    return sum_over(body_, mean);
  }

  double mean_along(const std::vector<int>& molecules, const VectorX& weights, const Positions& motion) const {
    double mean = 0;
    for (std::size_t i = 0; i < molecules.size(); ++i)
      mean += weights[static_cast<Eigen::Index>(i)] * setup_.axis.dot(motion.col(molecules[i]));
    return sum_over(body_, mean);
  }

  /// Mean motion along the axis where connections cross a gauge plane, linear between their ends.
  double plane_motion(int plane, const Positions& motion) const {
    double sum = 0;
    for (const auto& [c, part] : crossings_[plane]) {
      const auto& [a, b] = body_.connections.ends[c];
      sum += setup_.axis.dot((1 - part) * motion.col(a) + part * motion.col(b));
    }
    return sum_over(body_, sum) / crossing_count_[plane];
  }

  double read_elongation(const Positions& motion) const {
    if (setup_.gauge) return plane_motion(1, motion) - plane_motion(0, motion);
    const double start = mean_along(fixed_, fixed_share_, motion);
    if (setup_.reading == Reading::corner) {
      const double own = corner_ < 0 ? 0 : setup_.axis.dot(motion.col(loaded_[corner_]));
      return sum_over(body_, own) - start;
    }
    return mean_along(loaded_, share_, motion) - start;
  }

  /// Mean in-plane stretch less 1 of the molecules at mid height, of the linear motion fitted to them; NaN if they do
  /// not span the plane. Neither the directions that span it nor, with large displacements, a turn about the axis,
  /// which sliding grips leave free, change it: with F = I + gradient, the stretches add up to √((F_xx + F_yy)² + (F_xy
  /// − F_yx)²).
  double lateral_strain(const Positions& motion, bool small) const {
    const std::vector<Mirror> images = mirrors();
    const auto [places, spread] = spread_of_middle(images);
    Eigen::MatrixX2d moves(static_cast<Eigen::Index>(middle_.size()), 2);
    for (std::size_t i = 0; i < middle_.size(); ++i)
      moves.row(static_cast<Eigen::Index>(i)) = motion.col(middle_[i]).transpose() * plane_;
    moves = with_images(std::move(moves), images, 0);
    Eigen::Matrix2d moments = places.transpose() * weights_of(places).asDiagonal() * moves;
    sum_over(body_, {moments.data(), 4});
    if (!(spread.determinant() > 1e-12 * std::pow(spread.trace(), 2))) {  // a sheet: they lie in a line
      if (!(spread.trace() > 0)) return std::numeric_limits<double>::quiet_NaN();
      const double angle = std::atan2(2 * spread(0, 1), spread(0, 0) - spread(1, 1)) / 2;
      const Eigen::Vector2d line(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d slope = moments.transpose() * line / spread.trace();  // of the motion along the line
      return small ? slope.dot(line) : (line + slope).norm() - 1;
    }
    const Eigen::Matrix2d gradient = spread.inverse() * moments;
    const double sum = gradient.trace(), turn = small ? 0 : gradient(0, 1) - gradient(1, 0);
    return (sum * (4 + sum) + turn * turn) / (2 * (std::hypot(2 + sum, turn) + 2));
  }

  static bool meets(const Part& part, const std::vector<int>& molecules) {
    return std::any_of(molecules.begin(), molecules.end(),
                       [&](int m) { return m >= part.first && m < part.first + part.count; });
  }

  /// Bone at an end is held, or moved, as a whole.
  void add_supports(Model& model, const std::vector<int>& end, const Matrix3& free) const {
    std::vector<int> rigid;
    for (const Part& part : body_.parts)
      if (part.rigid && meets(part, end)) {
        const std::vector<int> all = molecules_of(part);
        rigid.insert(rigid.end(), all.begin(), all.end());
      }
    std::sort(rigid.begin(), rigid.end());
    rigid.erase(std::unique(rigid.begin(), rigid.end()), rigid.end());
    for (const int molecule : end)
      if (!std::binary_search(rigid.begin(), rigid.end(), molecule)) model.supports.push_back({molecule, free});
    for (const int molecule : rigid) model.supports.push_back({molecule});
  }

  bool owns(int molecule) const { return molecule < owned_molecules(body_); }

  /// One over how many all processes have of them, 0 for ghosts.
  VectorX equal_shares(const std::vector<int>& molecules) const {
    VectorX shares(static_cast<Eigen::Index>(molecules.size()));
    for (std::size_t i = 0; i < molecules.size(); ++i) shares[static_cast<Eigen::Index>(i)] = owns(molecules[i]);
    const double count = sum_over(body_, shares.sum());
    for (double& share : shares) share = share > 0 ? 1. / count : 0;
    return shares;
  }

  const Body& body_;
  TensionSetup setup_;
  Eigen::Matrix<double, 3, 2> plane_;
  VectorX height_;                             // of each molecule along the axis
  double low_ = 0, high_ = 0;                  // of the body along it
  double fixed_depth_ = 0, loaded_depth_ = 0;  // [m] of grips of several layers
  std::vector<int> fixed_, loaded_, middle_;
  VectorX middle_weight_;        // of the molecules at mid height
  VectorX share_, fixed_share_;  // of an end, sum 1
  std::optional<double> force_;  // that a section carries in the mean [N]
  std::vector<int> pulled_;      // the molecules on which it acts
  VectorX pull_;                 // on each of them, over that force
  double area_ = 0, gauge_length_ = 0;
  std::optional<Section> section_;  // none where the scene states it and the body has no cells to measure it
  Eigen::Index corner_ = -1;        // index into loaded_; none: another process has it
  std::array<std::vector<std::pair<int, double>>, 2> crossings_;
  std::array<double, 2> crossing_count_{};  // of all processes
};

class TensionRig final : public StaticRig {
 public:
  TensionRig(const Tension& experiment, Model& model)
      : experiment_(experiment), setup_(experiment.setup_), body_(experiment.body_), model_(model) {
    const Matrix3 along = setup_.axis * setup_.axis.transpose(), nothing = Matrix3::Zero();
    const Matrix3 sideways = Matrix3::Identity() - along;
    experiment_.add_supports(model, experiment_.fixed_, setup_.fixed_grip == Grip::clamped ? nothing : sideways);
    first_loaded_support_ = model.supports.size();
    if (setup_.displacement || setup_.loaded_grip == Grip::clamped)
      experiment_.add_supports(
          model, experiment_.loaded_,
          (setup_.displacement ? nothing : along) + (setup_.loaded_grip == Grip::clamped ? nothing : sideways));
    end_of_loaded_supports_ = model.supports.size();
    if (experiment_.force_) {
      auto load = std::make_unique<PointLoads>(body_, experiment_.pulled_,
                                               *experiment_.force_ * setup_.axis * experiment_.pull_.transpose());
      load_ = load.get();
      model.add(std::move(load));
    }
  }

  void set_load(double factor) override {
    if (load_) load_->set_factor(factor);
    factor_ = factor;
    if (setup_.displacement)
      for (std::size_t i = first_loaded_support_; i < end_of_loaded_supports_; ++i)
        model_.supports[i].displacement = factor * *setup_.displacement * setup_.axis;
  }

  void set_load_rate(double rate) override {
    if (setup_.displacement)
      for (std::size_t i = first_loaded_support_; i < end_of_loaded_supports_; ++i)
        model_.supports[i].velocity = rate * *setup_.displacement * setup_.axis;
  }

  void release(const State& /*loaded*/) override {
    set_load(0);
    if (setup_.displacement) model_.release_supports(first_loaded_support_, end_of_loaded_supports_);
  }

  Measures measure(const Start& start, const State& state, const StaticOptions&, StaticResult& solved) const override {
    Measures measures;
    const Positions motion = state.positions - start.positions;
    const double force =
        experiment_.force_ ? factor_ * *experiment_.force_ : loaded_reaction(solved.reactions - start.reactions);
    const double elongation = experiment_.read_elongation(motion), strain = elongation / experiment_.gauge_length_,
                 stress = force / experiment_.area_;
    // Of each shape, not of the motion between them, which a turn about the axis changes where preload strains the
    // body.
    const double lateral = experiment_.lateral_strain(state.positions - body_.rest, solved.linear) -
                           experiment_.lateral_strain(start.positions - body_.rest, solved.linear);
    if (is_strained(strain)) measures.set("effective_modulus", stress / strain);
    measures.set("elongation", elongation);
    if (is_strained(strain)) measures.set("poissons_ratio", -lateral / strain);
    measures.set("force", force);
    measures.set("stress", stress);
    measures.set("strain", strain);
    measures.set("lateral_strain", lateral);
    add_state(model_, state, solved, std::abs(force), measures);
    return measures;
  }

  void measure_end(const State& state, const StaticOptions& options, Measures& measures,
                   int& iterations) const override {
    Positions load = Positions::Zero(3, body_.size()), displacement = load;
    if (experiment_.force_)
      for (std::size_t i = 0; i < experiment_.pulled_.size(); ++i)
        load.col(experiment_.pulled_[i]) = experiment_.pull_[static_cast<Eigen::Index>(i)] * setup_.axis;
    if (setup_.displacement)
      for (const int molecule : experiment_.loaded_)
        displacement.col(molecule) = experiment_.gauge_length_ * setup_.axis;
    const StaticResponse response = static_response(model_, state.positions, load, displacement, options);
    iterations += response.result.linear_iterations;
    if (response.result.outcome != Outcome::converged) return;
    const double force = experiment_.force_ ? 1 : loaded_reaction(response.result.reactions);
    measures.set("tangent_modulus", force / experiment_.area_ /
                                        (experiment_.read_elongation(response.motion) / experiment_.gauge_length_));
  }

 private:
  /// Force along the axis with which the loaded supports pull [N].
  double loaded_reaction(const Positions& reactions) const {
    double sum = 0;
    for (Eigen::Index i = static_cast<Eigen::Index>(first_loaded_support_);
         i < static_cast<Eigen::Index>(end_of_loaded_supports_); ++i)
      sum += setup_.axis.dot(reactions.col(i));
    return sum_over(body_, sum);
  }

  const Tension& experiment_;
  const TensionSetup& setup_;
  const Body& body_;
  Model& model_;
  double factor_ = 1;
  PointLoads* load_ = nullptr;  // owned by the model
  std::size_t first_loaded_support_ = 0, end_of_loaded_supports_ = 0;
};

std::unique_ptr<StaticRig> Tension::make_rig(Model& model) const { return std::make_unique<TensionRig>(*this, model); }

}  // namespace

const MeasureList& tension_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"effective_modulus", pressure, "Young's modulus: secant F l0 / (A dl)", Role::youngs_modulus, "E"},
       {"poissons_ratio", none, "- lateral strain at mid height / strain", Role::poissons_ratio, "Poisson's ratio"},
       {"elongation", length, "dl, read as the scene says; negative in compression; from the state under preload",
        Role::displacement},
       {"force", force, "F on the loaded end, along the axis; negative in compression; beyond preload", Role::force},
       {"stress", pressure, "F / A", Role::stress},
       {"strain", none, "dl / l0", Role::strain},
       {"lateral_strain", none, "mean in-plane strain of the molecules at mid height", Role::history},
       {"tangent_modulus", pressure, "d stress / d strain at the last load step, from a linear solve there",
        Role::modulus}},
      {{"strain", "stress", true, "nominal stress"}, {"elongation", "force", true}, {"load", "elongation", true}}};
  return list;
}

const TensionSetup* tension_setup(const Experiment& experiment) {
  const auto* tension = dynamic_cast<const Tension*>(&experiment);
  return tension ? &tension->setup() : nullptr;
}

std::unique_ptr<StaticExperiment> make_tension(const Body& body, const TensionSetup& setup) {
  if (molecules_of_whole(body) < 2)
    throw InputError("tension needs at least 2 molecules; the body has " + std::to_string(body.size()));
  return std::make_unique<Tension>(body, setup);
}

}  // namespace elastin::lab
