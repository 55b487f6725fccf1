#include "lab/experiment/torsion/torsion.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

ExperimentInfo torsion_row() {
  using S = TorsionSetup;
  return with_keys(
      {.name = "torsion",
       .summary = "one end of a clamped bar is turned about its axis at constant height: torque, shear "
                  "modulus of a rectangle",
       .source = "Timoshenko & Goodier 1970, section 109",
       .of_shares = true,
       .measures = torsion_measures()},
      Keys<S>{key::direction("axis", &S::axis, "axis of the body, from the fixed end to the loaded one"),
              not_zero(key::angle("angle", &S::angle, "rotation of the turned end; not 0"), &S::angle).needed(),
              grip_depth_key(&S::grip_depth), load_steps_key(&S::load_steps)},
      [](const ExperimentContext& context, S setup) {
        setup.straight = context.statics.linear;
        return make_torsion(context.body, setup);
      });
}
}  // namespace elastin::lab
