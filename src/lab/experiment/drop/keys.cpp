#include "elastin/core/forces/floor.h"
#include "lab/experiment/motion/motion.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

namespace {

struct DropKeys : DropSetup {
  const ExperimentContext* context = nullptr;
};

}  // namespace

ExperimentInfo drop_row() {
  using S = DropKeys;
  const auto of_floor = [](Key<DropSetup> key) {
    return Key<S>(key).then([](const Reader& value, S& setup) {
      if (setup.context->contact)
        value.fail("belongs to the floor of `drop`; this scene has contact and obstacles of its own");
    });
  };
  return with_keys(
      {.name = "drop",
       .summary = "a free body falls on a floor, or on the scene's obstacles: restitution, duration of contact",
       .source = "",
       .in_time = true,
       .of_shares = true,
       .measures = drop_measures()},
      Keys<S>{key::direction("direction", &S::direction, "direction of the fall"),
              key::quantity("gravity", &S::gravity, dimension::acceleration, "acceleration of the fall", kNotNegative),
              of_floor(key::quantity("height", &DropSetup::height, dimension::length,
                                     "height of the lowest sphere above the floor; not with `contact`", kNotNegative)),
              key::quantity("speed", &DropSetup::speed, dimension::velocity, "speed along `direction` at time 0",
                            kNotNegative),
              of_floor(key::quantity("stiffness", &DropSetup::stiffness, dimension::stiffness,
                                     "stiffness of the floor for each molecule; not with `contact`", kPositive)
                           .otherwise("E × mean diameter")),
              of_floor(key::quantity("damping", &DropSetup::damping, dimension::damping,
                                     "damping of the floor; not with `contact`", kNotNegative))},
      [](const ExperimentContext& context, S setup) {
        if (context.contact) setup.contact = *context.contact;
        if (setup.stiffness == 0) setup.stiffness = default_floor_stiffness(context.body, context.material);
        if (!(setup.speed > 0 || (setup.gravity > 0 && (setup.height > 0 || setup.contact))))
          throw InputError("nothing falls: give a speed, or gravity and a height");
        return make_drop(context.body, setup);
      });
}

}  // namespace elastin::lab
