#include "lab/experiment/sliding/sliding.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

ExperimentInfo sliding_row() {
  using S = SlidingSetup;
  constexpr Range slope{0, 1.57, false};  // up to a right angle
  const auto of_kind = [](SlidingKind kind) { return [kind](const Reader&, S& setup) { setup.kind = kind; }; };
  return with_keys(
      {.name = "sliding",
       .summary = "a body lies on a plane that is tilted, or slides along it: friction, slip angle; needs `contact`",
       .source = "",
       .in_time = true,
       .measures = sliding_measures()},
      Keys<S>{
          key::direction("up", &S::up, "normal of the plane"),
          key::direction("along", &S::along, "direction down the slope, perpendicular to `up`")
              .refused_for([](const S& setup) {
                return perpendicular(setup.up, setup.along)
                           ? ""
                           : "`along` must be perpendicular to `up`, the normal of the plane";
              }),
          key::quantity("gravity", &S::gravity, dimension::acceleration, "acceleration of the weight", kPositive),
          Key<S>({"floor", "an obstacle's name", "", "", "a plane of its own", "what the body stands on"},
                 [](const Reader& value, S& setup, const Frame&) { setup.floor = value.text(); }),
          one_of<S>("give one of incline: {angle}, sled: {speed} and threshold: {from, rate}",
                    {key::below("incline", Keys<S>{key::angle("angle", &S::angle, "constant slope", slope).needed()})
                         .then(of_kind(SlidingKind::incline)),
                     key::below("sled", Keys<S>{key::quantity("speed", &S::speed, dimension::velocity,
                                                              "initial speed along a level floor", kPositive)
                                                    .needed()})
                         .then(of_kind(SlidingKind::sled)),
                     key::below(
                         "threshold",
                         Keys<S>{key::angle("from", &S::angle, "slope at time 0, which grows", slope).needed(),
                                 key::quantity("rate", &S::rate, {0, 0, -1}, "rate at which the slope grows", kPositive)
                                     .needed("needed with `from`")})
                         .then(of_kind(SlidingKind::threshold))})},
      [](const ExperimentContext& context, const S& setup) {
        return make_sliding(context.body, setup, contact_of_scene(context));
      });
}

}  // namespace elastin::lab
