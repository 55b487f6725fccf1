#include "lab/experiment/fixture.h"
#include "lab/experiment/motion/motion.h"
#include "lab/run/time_function.h"

#include "lab/experiment/keys.h"

namespace elastin::lab {

namespace {

struct MotionKeys : MotionSetup {
  const ExperimentContext* context = nullptr;
};

/// The keys that a kind of motion has, with its fixture's first.
ExperimentInfo motion(ExperimentInfo info, MotionKind kind, const char* fixture,
                      std::vector<Key<MotionKeys>> own = {}) {
  Key<MotionKeys> first = fixture_key<MotionKeys>(fixture);
  std::vector<Keys<MotionKeys>::Entry> entries{kind == MotionKind::motion ? std::move(first).otherwise("free body")
                                                                          : std::move(first).needed()};
  entries.insert(entries.end(), own.begin(), own.end());
  info.in_time = info.of_shares = true;
  const std::string name = info.name;
  return with_keys(std::move(info), Keys<MotionKeys>(std::move(entries)),
                   [=](const ExperimentContext& context, MotionKeys setup) {
                     setup.name = name;
                     setup.kind = kind;
                     return make_motion(context.body, std::move(setup));
                   });
}

}  // namespace

ExperimentInfo motion_row() {
  return motion({.name = "motion",
                 .summary = "a body, free or fixed and loaded by a fixture, is observed as it moves",
                 .source = "",
                 .measures = motion_measures()},
                MotionKind::motion, "how the body is fixed and loaded",
                {{{"in_time", "time function", "", "", "constant", "factor of the fixture's load"},
                  [](const Reader& value, MotionKeys& setup, const Frame&) {
                    if (!setup.fixture) value.fail("there is no load to change: key 'fixture' is missing");
                    setup.load = read_time_function(value);
                  }}});
}

ExperimentInfo release_row() {
  return motion({.name = "release",
                 .summary = "a loaded body is released, or loaded at once: free vibration, its frequency and damping",
                 .source = "",
                 .measures = motion_measures()},
                MotionKind::release, "how the body is fixed, and loaded before it is released",
                {key::choice("load", &MotionSetup::applied, {{"removed", false}, {"applied", true}},
                             "whether the load is taken away at time 0, or put on at once")});
}

ExperimentInfo creep_row() {
  return motion({.name = "creep",
                 .summary = "a force is applied and stays: displacement over time, retardation time",
                 .source = "",
                 .measures = motion_measures()},
                MotionKind::creep, "how the body is fixed, with the force that stays");
}

ExperimentInfo relaxation_row() {
  return motion(
      {.name = "relaxation",
       .summary = "a displacement grows and stays: force over time, relaxation time",
       .source = "",
       .measures = motion_measures()},
      MotionKind::relaxation, "how the body is fixed, with the displacement that stays",
      {key::quantity("ramp", &MotionSetup::ramp, dimension::time, "time in which the displacement grows", kPositive)
           .needed()
           .then([](const Reader&, MotionSetup& setup) { setup.load = TimeFunction::ramp(setup.ramp); })});
}

ExperimentInfo cyclic_row() {
  return motion(
      {.name = "cyclic",
       .summary = "a displacement oscillates: storage and loss modulus over the last period",
       .source = "",
       .measures = motion_measures()},
      MotionKind::cyclic, "how the body is fixed, with the displacement that is the amplitude",
      {key::quantity("frequency", &MotionSetup::frequency, {0, 0, -1}, "frequency of the oscillation", kPositive)
           .needed()
           .then([](const Reader&, MotionSetup& setup) { setup.load = TimeFunction::sine(setup.frequency); })});
}

}  // namespace elastin::lab
