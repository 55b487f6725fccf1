#include "lab/experiment/keys.h"
#include "elastin/core/model/rest.h"
#include "lab/experiment/tension/tension.h"

namespace elastin::lab {

namespace {

/// Of tension and compression, whose load pulls or presses by a positive amount.
Keys<TensionSetup> bar_keys(bool compression) {
  const auto load = [compression](Key<TensionSetup> key, std::optional<double> TensionSetup::*member) {
    return std::move(key).then([=](const Reader& value, TensionSetup& setup, const Frame& frame) {
      double& amount = *(setup.*member);
      if (amount == 0 && !frame.body->unstressed)
        value.fail("a load of zero stretches nothing: no modulus can be measured");
      if (compression && amount < 0)
        value.fail("'" + value.text() + "' would pull: compression presses by a positive amount; write " +
                   value.text().substr(value.text().find('-') + 1) + ", or kind: tension to pull");
      if (compression) amount = -amount;
      if (member == &TensionSetup::strain && amount <= -1)
        value.fail("'" + value.text() + "' leaves nothing of the body's length");
    });
  };
  using S = TensionSetup;
  const std::string grip = "whether the end is also fixed sideways";
  return {
      axis_key(&S::axis, "axis of the bar, from the fixed end to the loaded one"),
      one_of<S>("give a force or a displacement, or a strain, for example strain: 10 %",
                {load(key::quantity("force", &S::force, dimension::force, "force on the loaded end; not 0"), &S::force),
                 load(key::quantity("displacement", &S::displacement, dimension::length,
                                    "displacement of the loaded end; not 0"),
                      &S::displacement)
                     .first(refuse_percent),
                 load(key::quantity("strain", &S::strain, dimension::none,
                                    "that displacement over the distance of the end layers; not 0"),
                      &S::strain),
                 load(key::quantity(
                          "gravity", &S::gravity, dimension::acceleration,
                          "acceleration by which the body's own weight is the load: under tension it hangs from its "
                          "fixed end, under compression it stands on it; not 0"),
                      &S::gravity)})
          .naming_the_second(),
      grip_key("fixed_grip", &S::fixed_grip, grip),
      grip_key("loaded_grip", &S::loaded_grip, grip),
      key::choice("load_sharing", &S::sharing, {{"area", LoadSharing::area}, {"molecules", LoadSharing::molecules}},
                  "how the molecules of the loaded end share a force: by tributary areas, or equally"),
      key::choice("reading", &S::reading, {{"mean", Reading::mean}, {"corner", Reading::corner}},
                  "elongation of the loaded end, or of one corner molecule"),
      cross_section_key(&S::cross_section),
      key::quantity("gauge_length", &S::gauge_length, dimension::length, "length l₀ to which the strain refers",
                    kPositive)
          .otherwise("between the end layers"),
      Key<S>({"gauge", "two quantities", "m", "≥ 0, > 0", "none",
              "planes, measured from the fixed end, between which an extensometer reads"},
             [](const Reader& value, S& setup, const Frame&) {
               const auto planes = value.items(2);
               setup.gauge = {planes[0].quantity(dimension::length, kNotNegative),
                              planes[1].quantity(dimension::length, kPositive)};
             }),
      grip_keys<S>(),
      load_steps_key(&S::load_steps),
      Key<S>({"cycle", "list of numbers", "", "0 … 1", "`[1]`",
              "parts of the load that are reached one after the other, each in `load_steps`: [1, 0, 1]"},
             [](const Reader& value, S& setup, const Frame&) {
               for (const Reader& item : value.items()) {
                 const double before = setup.cycle.empty() ? 0 : setup.cycle.back();
                 setup.cycle.push_back(item.quantity(dimension::none, {0, 1, false}));
                 if (setup.cycle.back() == before)
                   item.fail("the load already exists: each part must differ from the one before");
               }
             })};
}

ExperimentInfo bar(ExperimentInfo info, bool compression) {
  return with_keys(std::move(info), bar_keys(compression), [](const ExperimentContext& context, TensionSetup setup) {
    setup.thickness = context.material.thickness, setup.density = context.material.density;
    return make_tension(context.body, setup);
  });
}

}  // namespace

ExperimentInfo tension_row() {
  return bar({.name = "tension",
              .summary = "a bar is pulled along its axis: effective modulus, Poisson's ratio, stress–strain curve",
              .of_shares = true,
              .measures = tension_measures()},
             false);
}

ExperimentInfo compression_row() {
  return bar({.name = "compression",
              .summary = "a bar is pressed along its axis and measured as in tension",
              .of_shares = true,
              .measures = tension_measures()},
             true);
}
}  // namespace elastin::lab
