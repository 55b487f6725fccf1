#include "lab/experiment/hydrostatic/hydrostatic.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

ExperimentInfo hydrostatic_row() {
  using S = HydrostaticSetup;
  return with_keys({.name = "hydrostatic",
                    .summary = "equal strain along all directions: bulk modulus",
                    .source = "",
                    .of_shares = true,
                    .measures = hydrostatic_measures()},
                   Keys<S>{not_zero(key::quantity("strain", &S::strain, dimension::none,
                                                  "strain of each side; negative compresses; not 0", {-1, 100, true}),
                                    &S::strain)
                               .needed(),
                           key::choice("sides", &S::walls, {{"sliding", Walls::sliding}, {"affine", Walls::affine}},
                                       "whether six smooth walls carry the strain, or the whole surface follows it"),
                           grip_depth_key(&S::grip_depth), load_steps_key(&S::load_steps)},
                   [](const ExperimentContext& context, const S& setup) {
                     return make_hydrostatic(context.body, setup, context.rotation);
                   });
}
}  // namespace elastin::lab
