#include "lab/experiment/inflation/inflation.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

const Keys<GasSetup>& gas_keys() {
  using S = GasSetup;
  static const Keys<S> keys{
      one_of<S>(
          "give one of amount (absolute pressure times volume, n R T) and start_pressure (absolute)",
          {key::quantity("amount", &S::amount, dimension::energy, "absolute pressure times volume, n R T", kPositive),
           key::quantity("start_pressure", &S::start_pressure, dimension::pressure,
                         "absolute pressure in the volume at rest", kPositive)}),
      key::quantity("exponent", &S::exponent, dimension::none,
                    "1: constant temperature; 1.4: air without exchange of heat", {1, 2}),
      key::quantity("ambient", &S::ambient, dimension::pressure, "absolute pressure outside", kNotNegative)};
  return keys;
}

ExperimentInfo inflation_row() {
  using S = InflationSetup;
  return with_keys({.name = "inflation",
                    .summary = "a closed membrane is inflated by pressure, by volume or by gas: radius, wall stress",
                    .source = "",
                    .measures = inflation_measures()},
                   Keys<S>{one_of<S>("give one of pressure, volume_ratio (volume over that at rest) and gas",
                                     {not_zero(key::quantity("pressure", &S::pressure, dimension::pressure,
                                                             "pressure inside over that outside; not 0"),
                                               &S::pressure),
                                      key::quantity("volume_ratio", &S::volume_ratio, dimension::none,
                                                    "enclosed volume over that at rest", kPositive),
                                      Key<S>({"gas", "map", "", "", "none", "gas that is let in; its keys stand below"},
                                             [](const Reader& value, S& setup, const Frame&) {
                                               Reader map = value;
                                               map.set_section("gas");
                                               setup.gas = gas_keys().read(map);
                                             })}),
                           symmetry_key(&S::symmetry), load_steps_key(&S::load_steps)},
                   [](const ExperimentContext& context, S setup) {
                     setup.axes = context.rotation;
                     return make_inflation(context.body, setup, context.material);
                   });
}
}  // namespace elastin::lab
