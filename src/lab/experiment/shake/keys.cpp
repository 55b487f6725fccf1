#include "lab/experiment/motion/motion.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

ExperimentInfo shake_row() {
  struct S : ShakeSetup {
    std::optional<Vector3> oscillates;  ///< none: along the axis
  };
  std::vector<Key<ShakeSetup>> amplitude =
      travel_keys("amplitude", &ShakeSetup::amplitude, &ShakeSetup::axis, "amplitude of the clamped end");
  return with_keys(
      {.name = "shake",
       .summary = "the clamped end of a body oscillates: amplitude ratio and phase of the far end",
       .source = "",
       .in_time = true,
       .of_shares = true,
       .measures = shake_measures()},
      Keys<S>{key::direction("axis", &S::axis, "from the clamped end to the far one"),
              key::direction("direction", &S::oscillates, "direction of the oscillation").otherwise("`axis`"),
              one_of<S>("key 'amplitude' is missing", {amplitude.begin(), amplitude.end()}).naming_the_second(),
              Key<S>(key::quantity("frequency", &ShakeSetup::frequency, {0, 0, -1}, "frequency of the oscillation",
                                   kPositive)
                         .needed()),
              grip_depth_key(&ShakeSetup::grip_depth)},
      [](const ExperimentContext& context, S setup) {
        setup.direction = setup.oscillates.value_or(setup.axis);
        return make_shake(context.body, setup);
      });
}

}  // namespace elastin::lab
