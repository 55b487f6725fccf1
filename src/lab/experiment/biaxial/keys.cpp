#include "lab/experiment/biaxial/biaxial.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

namespace {

constexpr Range kStrain{-1, 100, true};

/// A strain that is not 0.
double read_strain(const Reader& value) {
  const double strain = value.quantity(dimension::none, kStrain);
  if (strain == 0) value.fail("a load of zero moves nothing: nothing can be measured");
  return strain;
}

/// Of biaxial tension two strains or one for both; of planar tension the second is 0.
ExperimentInfo two_axes(ExperimentInfo info, bool planar) {
  using S = BiaxialSetup;
  const auto skew = [](const S& setup) {
    return perpendicular(setup.first, setup.second)
               ? ""
               : "must be perpendicular to the other axis; give both `axis` and `across`";
  };
  Key<S> strain = planar ? not_zero(key::quantity("strain", &S::first_strain, dimension::none,
                                                  "nominal strain along `axis`; not 0", kStrain),
                                    &S::first_strain)
                         : Key<S>({"strain", "number, or two numbers", "", "> −1 … 100", "needed",
                                   "nominal strain along both, or along each; the first is not 0"},
                                  [](const Reader& value, S& setup, const Frame&) {
                                    if (value.is_text()) {
                                      setup.first_strain = setup.second_strain = read_strain(value);
                                      return;
                                    }
                                    const auto both = value.items(2);
                                    setup.first_strain = read_strain(both[0]);
                                    setup.second_strain = both[1].quantity(dimension::none, kStrain);
                                  });
  const std::string name = info.name;
  return with_keys(
      std::move(info),
      Keys<S>{key::direction("axis", &S::first, "first direction, in which the body is stretched"),
              key::direction("across", &S::second, "second direction, perpendicular to it").refused_for(skew),
              std::move(strain).needed(), grip_depth_key(&S::grip_depth), load_steps_key(&S::load_steps)},
      [=](const ExperimentContext& context, S setup) {
        setup.thickness = context.material.thickness;
        return make_biaxial(context.body, setup, name);
      });
}

}  // namespace

ExperimentInfo biaxial_row() {
  return two_axes(
      {.name = "biaxial",
       .summary = "a block or sheet is stretched along two directions between smooth grips, free along the third",
       .source = "Timoshenko & Goodier 1970, section 6",
       .of_shares = true,
       .measures = biaxial_measures()},
      false);
}

ExperimentInfo planar_row() {
  return two_axes(
      {.name = "planar",
       .summary = "a block or sheet is stretched along one direction and keeps its width along another: pure shear",
       .source = "Timoshenko & Goodier 1970, section 6",
       .of_shares = true,
       .measures = biaxial_measures()},
      true);
}
}  // namespace elastin::lab
