#include "lab/experiment/fixture.h"
#include "lab/experiment/motion/motion.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

ExperimentInfo vibration_row() {
  struct S {
    std::unique_ptr<const StaticExperiment> fixture;
    int count = 6;
    bool loaded = false;
    const ExperimentContext* context = nullptr;
  };
  return with_keys(
      {.name = "vibration",
       .summary = "natural frequencies of a body, free or fixed by a fixture; at rest",
       .source = "",
       .measures = vibration_measures()},
      Keys<S>{fixture_key<S>("how the body is fixed").otherwise("free body"),
              key::choice("load", &S::loaded, {{"removed", false}, {"applied", true}},
                          "whether the body vibrates about rest, or about its equilibrium under the fixture's load")
                  .refused_for([](const S& setup) {
                    return setup.loaded && !setup.fixture ? "there is no load: key 'fixture' is missing" : "";
                  }),
              key::whole("count", &S::count, 1, 10, "number of frequencies")},
      [](const ExperimentContext& context, S setup) {
        return make_vibration(context.body, std::move(setup.fixture), setup.count, setup.loaded);
      });
}

}  // namespace elastin::lab
