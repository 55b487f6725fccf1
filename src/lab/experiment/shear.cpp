#include "lab/experiment/shear.h"

#include <cmath>

#include "elastin/core/base/error.h"
#include "lab/experiment/driven.h"
#include "lab/experiment/faces.h"
#include "lab/experiment/moduli.h"

namespace elastin::lab {
namespace {

class Shear final : public Driven {
 public:
  Shear(const Body& body, const ShearSetup& setup, const Matrix3& axes)
      : Driven(body, setup.load_steps), setup_(setup), rise_(body.rest.transpose() * setup.axis) {
    rise_.array() -= rise_.minCoeff();
    area_ = setup.cross_section > 0 ? setup.cross_section
                                    : polygon_area(convex_hull(across(setup.axis).transpose() * body.rest));
    if (!(area_ > 0)) throw InputError("the body's molecules span no cross-section: give cross_section");
    if (setup.sides == Sides::affine)
      follow_shear(axes);
    else
      clamp_ends();
  }

  std::string name() const override { return "shear"; }
  CourseMeasures course() const override { return {"strain", "force"}; }
  bool let_go(Model& model) override {
    if (loaded_ == 0) return false;
    free_from(model, held_.size() - static_cast<std::size_t>(loaded_));
    return true;
  }

  Measures measure(Model& model, const Start& start, const State& state, const StaticOptions&,
                   StaticResult& solved) const override {
    const Positions pull = pull_of(start, solved);
    const double strain = released_ ? mean_way(state.positions) * strain_ / way_ : factor_ * strain_;
    // Simple shear keeps the volume and the area of the sheared planes: first Piola-Kirchhoff = Cauchy on them.
    const Vector3 traction = volume_ > 0 ? Vector3(virial(pull, body_.rest) * setup_.axis / volume_)
                                         : Vector3(pull.rightCols(loaded_).rowwise().sum() / area_);
    const double stress = traction.dot(setup_.direction);
    Measures measures;
    measures.set("shear_modulus", stress / strain);
    measures.set("stress", stress);
    measures.set("strain", strain);
    measures.set("force", stress * area_);
    measures.set("axial_force", traction.dot(setup_.axis) * area_);
    add_state(model, state, solved, std::abs(stress * area_), measures);
    return measures;
  }

  std::vector<MainMeasure> main_measures(const Material& material, const Measures& /*measured*/) const override {
    return {{"shear_modulus", lab::shear_modulus(material)}, {"force"}, {"axial_force"}};
  }

 private:
  void clamp_ends() {
    const Face fixed = end_face(body_, -setup_.axis, setup_.grip_depth),
               loaded = end_face(body_, setup_.axis, setup_.grip_depth);
    hold_fast(fixed.molecules);
    hold_fast(loaded.molecules);
    loaded_ = static_cast<Eigen::Index>(loaded.molecules.size());
    const double height = setup_.axis.dot(middle_of(loaded, body_.rest) - middle_of(fixed, body_.rest));
    way_ = setup_.displacement != 0 ? setup_.displacement : setup_.strain * height;
    strain_ = way_ / height;
  }

  void follow_shear(const Matrix3& axes) {
    const Surface surface = find_surface(body_, axes, setup_.grip_depth);
    hold_fast(surface.molecules);
    volume_ = surface.volume;
    strain_ = setup_.displacement != 0 ? setup_.displacement / rise_.maxCoeff() : setup_.strain;
  }

  Vector3 way(std::size_t held, double factor) const override {
    if (volume_ > 0) return factor * strain_ * rise_[held_[held].molecule] * setup_.direction;
    const bool loaded = held + static_cast<std::size_t>(loaded_) >= held_.size();
    return loaded ? Vector3(factor * way_ * setup_.direction) : Vector3::Zero();
  }

  /// Way of the loaded end along the shear [m].
  double mean_way(const Positions& places) const {
    double sum = 0;
    for (std::size_t i = held_.size() - static_cast<std::size_t>(loaded_); i < held_.size(); ++i)
      sum += setup_.direction.dot(places.col(held_[i].molecule) - body_.rest.col(held_[i].molecule));
    return sum / static_cast<double>(loaded_);
  }

  ShearSetup setup_;
  VectorX rise_;             // of each molecule above the lowest
  Eigen::Index loaded_ = 0;  // the last of the held molecules
  double way_ = 0, strain_ = 0;
  double area_ = 0, volume_ = 0;  // volume: affine sides only
};

}  // namespace

std::unique_ptr<Experiment> make_shear(const Body& body, const ShearSetup& setup, const Matrix3& axes) {
  return std::make_unique<Shear>(body, setup, axes);
}

}  // namespace elastin::lab
