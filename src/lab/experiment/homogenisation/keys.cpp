#include "lab/experiment/homogenisation/homogenisation.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

ExperimentInfo material_row() {
  return with_keys(
      {.name = "material",
       .summary = "six small strains of the surface: the body's 6 × 6 stiffness matrix and its isotropic means",
       .source = "",
       .measures = homogenisation_measures()},
      Keys<HomogenisationSetup>{grip_depth_key(&HomogenisationSetup::grip_depth)},
      [](const ExperimentContext& context, const HomogenisationSetup& setup) {
        return make_homogenisation(context.body, setup, context.rotation);
      });
}
}  // namespace elastin::lab
