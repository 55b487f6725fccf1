#include "lab/experiment/motion/motion.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

ExperimentInfo parachute_row() {
  using S = ParachuteSetup;
  return with_keys(
      {.name = "parachute",
       .summary = "a canopy with a load on `lines` falls through air: how it opens, largest force in a line",
       .source = "",
       .in_time = true,
       .measures = parachute_measures()},
      Keys<S>{
          key::direction("direction", &S::direction, "direction of the fall"),
          key::quantity("gravity", &S::gravity, dimension::acceleration, "acceleration of the fall", kNotNegative),
          key::quantity("speed", &S::speed, dimension::velocity, "speed along `direction` at time 0", kNotNegative)},
      [](const ExperimentContext& context, const S& setup) { return make_parachute(context.body, setup); });
}

}  // namespace elastin::lab
