#include "lab/experiment/bending/bending.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

ExperimentInfo bending_row() {
  using S = BendingSetup;
  return with_keys(
      {.name = "bending",
       .summary = "a cantilever bends under its own weight or a force on its tip: effective modulus, deflection",
       .source = "Timoshenko 1921, Cowper 1966",
       .of_shares = true,
       .measures = bending_measures()},
      Keys<S>{key::direction("axis", &S::axis, "from the clamped root to the tip"),
              key::direction("direction", &S::direction, "direction of the load, perpendicular to `axis`")
                  .needed()
                  .refused_for([](const S& setup) {
                    return perpendicular(setup.axis, setup.direction) ? "" : "must be perpendicular to the axis";
                  }),
              any_of<S>("give gravity, a force on the tip, or both",
                        {not_zero(key::quantity("gravity", &S::gravity, dimension::acceleration,
                                                "acceleration that gives the weight; not 0"),
                                  &S::gravity),
                         not_zero(key::quantity("force", &S::force, dimension::force, "force on the tip; not 0"),
                                  &S::force)}),
              grip_depth_key(&S::grip_depth), load_steps_key(&S::load_steps)},
      [](const ExperimentContext& context, const S& setup) {
        return make_bending(context.body, setup, context.material);
      });
}
}  // namespace elastin::lab
