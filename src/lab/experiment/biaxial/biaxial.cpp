#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "elastin/core/base/error.h"
#include "elastin/core/model/share.h"
#include "lab/experiment/driven.h"
#include "lab/experiment/keys.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

/// A block or sheet stretched along two directions at once between smooth plane grips, free along the third.
struct BiaxialSetup {
  Vector3 first = Vector3::UnitX(), second = Vector3::UnitY();  ///< unit, perpendicular
  double first_strain = 0, second_strain = 0;  ///< nominal, of the distance of opposite end layers, > −1; 0 = kept
  double thickness = 0;                        ///< [m] of the body's triangles; 0 = they have no volume
  double grip_depth = 0;                       ///< [m]: see TensionSetup
  int load_steps = 1;
};

const MeasureList& biaxial_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"effective_modulus", pressure, "Young's modulus of a linear isotropic material with these stresses and strains",
        Role::youngs_modulus, "E"},
       {"poissons_ratio", none, "Poisson's ratio of that material", Role::poissons_ratio, "Poisson's ratio"},
       {"force", force, "force on the loaded end along the axis; beyond preload", Role::force},
       {"stress", pressure, "nominal stress along the axis", Role::stress},
       {"strain", none, "nominal strain along the axis", Role::strain},
       {"stress_across", pressure, "nominal stress along the second direction"},
       {"lateral_strain", none, "mean strain of the thickness", Role::history},
       {"isotropy_error", none,
        "of strains up to 1 %: the largest difference of a stress to that of that material, over the larger stress",
        Role::history}},
      {{"strain", "stress", true, "nominal stress"}, {"load", "strain"}}};
  return list;
}

/// Strains beyond which a law's own curve is no linear material's.
constexpr double kSmall = 0.01;

/// One of the two directions, with the molecules of its ends.
struct Direction {
  Vector3 along;
  double strain = 0, low = 0, length = 0, area = 0;  ///< [m], [m²]
  std::vector<std::size_t> loaded;                   ///< numbers of the fixed molecules at its far end
};

/// Equibiaxial tension where both strains are one, planar tension (pure shear) where the second is 0. E and ν are those
/// of a linear isotropic material with the same strain of the thickness and the same work: with σ₃ = 0
///     ν = −ε₃ / (ε₁ + ε₂ − ε₃),  σ₁ ε₁ + σ₂ ε₂ = E (ε₁² + ε₂² + 2 ν ε₁ ε₂) / (1 − ν²).    [Timoshenko & Goodier 1970,
/// section 6]
/// Throws InputError where the body has no opposite ends along the two directions.
class Biaxial final : public Driven {
 public:
  Biaxial(const Body& body, const BiaxialSetup& setup, std::string name)
      : Driven(body, setup.load_steps), name_(std::move(name)), thickness_(setup.thickness) {
    directions_ = {Direction{setup.first.normalized(), setup.first_strain, 0, 0, 0, {}},
                   Direction{setup.second.normalized(), setup.second_strain, 0, 0, 0, {}}};
    std::map<int, Matrix3> free;
    std::array<Face, 2> ends;
    EndFinder finder(body, setup.grip_depth);
    for (std::size_t k = 0; k < 2; ++k) {
      Direction& direction = directions_[k];
      const VectorX height = body.rest.transpose() * direction.along;
      const Face near = finder.find("fixed", -direction.along);
      ends[k] = finder.find("loaded", direction.along);
      const double high = largest_over(body, height.maxCoeff());
      direction.low = least_over(body, height.minCoeff()), direction.length = high - direction.low;
      if (!(direction.length > 0)) throw InputError("the body has no length along one of the axes");
      direction.area = find_section(body, direction.along, direction.low, high, setup.thickness).area;
      if (!(direction.area > 0))
        throw InputError("the body's cells fill no section that the load could be referred to");
      for (const Face* face : {&near, &std::as_const(ends[k])})
        for (const int molecule : face->molecules) {
          Matrix3& left = free.try_emplace(molecule, Matrix3::Identity()).first->second;
          left -= direction.along * direction.along.transpose();
        }
    }
    for (const auto& [molecule, left] : free) fixed_.push_back({molecule, left});
    for (std::size_t k = 0; k < 2; ++k)
      for (std::size_t index = 0; index < fixed_.size(); ++index)
        if (std::find(ends[k].molecules.begin(), ends[k].molecules.end(), fixed_[index].molecule) !=
            ends[k].molecules.end())
          directions_[k].loaded.push_back(index);
    findings_ = std::move(finder.findings);
    third_ = directions_[0].along.cross(directions_[1].along);
    middle_ = middle_of_whole(body);
    const Positions arms = body.rest.leftCols(owned_molecules(body)).colwise() - middle_;
    const double thick = sum_over(body, (arms.transpose() * third_).squaredNorm());
    sheet_ = !(thick > 1e-12 * sum_over(body, arms.squaredNorm()));
  }

  std::string name() const override { return name_; }
  MeasureList measures() const override { return biaxial_measures(); }
  ResponseMeasures response_measures() const override { return {"strain", "stress"}; }

  Measures measure(const Held& held, const Start& start, const State& state, const StaticOptions&,
                   StaticResult& solved) const override {
    const Positions pull = pull_of(start, solved), motion = state.positions - start.positions;
    std::array<double, 2> stress{}, force{};
    for (std::size_t k = 0; k < 2; ++k) {
      for (const std::size_t index : directions_[k].loaded)
        force[k] += directions_[k].along.dot(pull.col(static_cast<Eigen::Index>(index)));
      force[k] = sum_over(body_, force[k]);
      stress[k] = force[k] / directions_[k].area;
    }
    const double first = held.factor * directions_[0].strain, second = held.factor * directions_[1].strain;
    const double third = thickness_strain(motion), across = stress[1] / stress[0];
    // A sheet shows no strain of its thickness; where the two strains differ the stresses determine ν.
    const double ratio = !sheet_             ? -third / (first + second - third)
                         : determines_none() ? std::numeric_limits<double>::quiet_NaN()
                                             : (across * first - second) / (first - across * second);
    Measures measures;
    if (is_strained(first) || is_strained(second)) {
      const double modulus = (stress[0] * first + stress[1] * second) * (1 - ratio * ratio) /
                             (first * first + second * second + 2 * ratio * first * second);
      measures.set("effective_modulus", modulus);
      measures.set("poissons_ratio", ratio);
      if (std::max(std::abs(first), std::abs(second)) <= kSmall) {
        const double plane = modulus / (1 - ratio * ratio);
        measures.set("isotropy_error", std::max(std::abs(stress[0] - plane * (first + ratio * second)),
                                                std::abs(stress[1] - plane * (second + ratio * first))) /
                                           std::max(std::abs(stress[0]), std::abs(stress[1])));
      }
    }
    measures.set("force", force[0]);
    measures.set("stress", stress[0]);
    measures.set("strain", first);
    measures.set("stress_across", stress[1]);
    measures.set("lateral_strain", third);
    add_state(held.model, state, solved, sum_over(body_, pull.colwise().norm().sum()), measures);
    return measures;
  }

  Matrix3 against_load(const Vector3& /*at*/) const override {
    const auto& [first, second] = directions_;
    return first.along * first.along.transpose() + second.along * second.along.transpose();
  }

  std::optional<UniformTest> uniform(const Measures& measured) const override {
    const auto& [first, second] = directions_;
    BiaxialSetup own{first.along, second.along, measured.get("strain"), 0, thickness_};
    own.second_strain = own.first_strain * second.strain / first.strain;
    Matrix3 frame;
    frame << first.along, second.along, third_;
    return UniformTest{own.first_strain, frame,
                       [own](const Body& block) { return std::make_unique<Biaxial>(block, own, "biaxial"); }};
  }

  std::vector<MainMeasure> main_measures(const Material& material, const Measures& /*measured*/) const override {
    if (determines_none()) return {{"stress"}, {"stress_across"}};
    return {{"effective_modulus", material.youngs_modulus},
            {"poissons_ratio", material.poissons_ratio},
            {"stress"},
            {"stress_across"}};
  }

  std::string no_reference() const override {
    return determines_none() ? "two strains of one size determine neither E nor nu of a sheet; write two that differ, "
                               "or `calibrate: {experiment: {kind: tension, …}}`, which `calibrated:` rules follow"
                             : "";
  }

  std::vector<std::string> notes() const override {
    return {
        "E and ν are those of a linear material in plane stress that shows these stresses; at large strains a law "
        "has others"};
  }

 private:
  /// Whether it is a sheet with strains of one size, where rounding would determine E and ν.
  bool determines_none() const {
    const double first = std::abs(directions_[0].strain), second = std::abs(directions_[1].strain);
    return sheet_ && std::abs(first - second) < 1e-6 * first;
  }

  /// Slope of the motion along the third direction over the height along it; NaN of a sheet.
  double thickness_strain(const Positions& motion) const {
    if (sheet_) return std::numeric_limits<double>::quiet_NaN();
    const int owned = owned_molecules(body_);
    const VectorX height = (body_.rest.leftCols(owned).colwise() - middle_).transpose() * third_,
                  moved = motion.leftCols(owned).transpose() * third_;
    return sum_over(body_, height.dot(moved)) / sum_over(body_, height.squaredNorm());
  }

  Vector3 displacement(std::size_t index, double factor) const override {
    Vector3 moved = Vector3::Zero();
    for (const Direction& direction : directions_)
      moved += factor * direction.strain *
               (direction.along.dot(body_.rest.col(fixed_[index].molecule)) - direction.low) * direction.along;
    return moved;
  }

  std::string name_;
  double thickness_;  ///< [m] of the body's triangles
  std::array<Direction, 2> directions_;
  Vector3 third_, middle_;
  bool sheet_ = false;  ///< no extent along the third direction
};

}  // namespace

namespace {

constexpr Range kStrain{-1, 100, true};

/// A strain that is not 0.
double read_strain(const Reader& value) {
  const double strain = value.quantity(dimension::none, kStrain);
  if (strain == 0) value.fail("a load of zero moves nothing: nothing can be measured");
  return strain;
}

/// Of biaxial tension two strains or one for both; of planar tension the second is 0.
ExperimentInfo two_axes(ExperimentInfo info, bool planar) {
  using S = BiaxialSetup;
  const auto skew = [](const S& setup) {
    return perpendicular(setup.first, setup.second)
               ? ""
               : "must be perpendicular to the other axis; give both `axis` and `across`";
  };
  Key<S> strain = planar ? not_zero(key::quantity("strain", &S::first_strain, dimension::none,
                                                  "nominal strain along `axis`; not 0", kStrain),
                                    &S::first_strain)
                         : Key<S>({"strain", "number, or two numbers", "", "> −1 … 100", "needed",
                                   "nominal strain along both, or along each; the first is not 0"},
                                  [](const Reader& value, S& setup, const Frame&) {
                                    if (value.is_text()) {
                                      setup.first_strain = setup.second_strain = read_strain(value);
                                      return;
                                    }
                                    const auto both = value.items(2);
                                    setup.first_strain = read_strain(both[0]);
                                    setup.second_strain = both[1].quantity(dimension::none, kStrain);
                                  });
  const std::string name = info.name;
  return with_keys(
      std::move(info),
      Keys<S>{key::direction("axis", &S::first, "first direction, in which the body is stretched"),
              key::direction("across", &S::second, "second direction, perpendicular to it").refused_for(skew),
              std::move(strain).needed(), grip_depth_key(&S::grip_depth), load_steps_key(&S::load_steps)},
      [=](const ExperimentContext& context, S setup) {
        setup.thickness = context.material.thickness;
        return std::make_unique<Biaxial>(context.body, setup, name);
      });
}

}  // namespace

ExperimentInfo biaxial_row() {
  return two_axes(
      {.name = "biaxial",
       .summary = "a block or sheet is stretched along two directions between smooth grips, free along the third",
       .source = "Timoshenko & Goodier 1970, section 6",
       .of_shares = true,
       .measures = biaxial_measures()},
      false);
}

ExperimentInfo planar_row() {
  return two_axes(
      {.name = "planar",
       .summary = "a block or sheet is stretched along one direction and keeps its width along another: pure shear",
       .source = "Timoshenko & Goodier 1970, section 6",
       .of_shares = true,
       .measures = biaxial_measures()},
      true);
}

}  // namespace elastin::lab
