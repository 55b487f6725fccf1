#include "lab/experiment/shear/shear.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

ExperimentInfo shear_row() {
  using S = ShearSetup;
  constexpr double upright = 1.57;  // a right angle shears without end
  return with_keys(
      {.name = "shear",
       .summary = "planes across the axis slide along a direction, at constant height: shear modulus",
       .source = "",
       .of_shares = true,
       .measures = shear_measures()},
      Keys<S>{
          key::direction("axis", &S::axis, "axis of the body, from the fixed end to the loaded one"),
          key::direction("direction", &S::direction, "direction of the displacement, perpendicular to `axis`")
              .needed()
              .refused_for([](const S& setup) {
                return perpendicular(setup.axis, setup.direction) ? "" : "must be perpendicular to the axis";
              }),
          one_of<S>("give one of displacement, strain (displacement over height) and angle",
                    {not_zero(key::quantity("displacement", &S::displacement, dimension::length,
                                            "displacement of the loaded end; not 0"),
                              &S::displacement)
                         .first(refuse_percent),
                     not_zero(key::quantity("strain", &S::strain, dimension::none, "displacement over height; not 0"),
                              &S::strain),
                     not_zero(key::angle("angle", &S::angle, "angle of shear; not 0", {-upright, upright, false}),
                              &S::angle)}),
          key::choice("sides", &S::sides, {{"free", Sides::free}, {"affine", Sides::affine}},
                      "whether two rigid plates carry the shear, or the whole surface follows it"),
          cross_section_key(&S::cross_section), grip_depth_key(&S::grip_depth), load_steps_key(&S::load_steps)},
      [](const ExperimentContext& context, S setup) {
        if (setup.angle != 0) setup.strain = std::tan(setup.angle);
        return make_shear(context.body, setup, context.rotation);
      });
}
}  // namespace elastin::lab
