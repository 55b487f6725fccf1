#include "lab/run/time_options.h"

namespace elastin::lab {
namespace {

struct TimeFunctionSetup {
  double duration = 0, at = 0, frequency = 0, phase = 0, mean = 0;
  std::optional<TimeFunction> function;
};

TimeFunction table_of(const Reader& table) {
  std::vector<std::pair<double, double>> points;
  for (const Reader& item : table.items()) {
    const auto pair = item.items(2);
    points.emplace_back(pair[0].quantity(dimension::time), pair[1].quantity(dimension::none));
    if (points.size() > 1 && points.back().first < points[points.size() - 2].first)
      pair[0].fail("the times of a table must not fall");
  }
  return table.located([&] { return TimeFunction(std::move(points)); });
}

const Keys<TimeFunctionSetup>& time_function_keys() {
  static const Keys<TimeFunctionSetup> keys{one_of<TimeFunctionSetup>(
      "a function of time is one of ramp, step, sine, table",
      {key::below("ramp", Keys<TimeFunctionSetup>{key::quantity("duration", &TimeFunctionSetup::duration,
                                                                dimension::time, "from 0 to 1 in this time", kPositive)
                                                      .needed()})
           .then([](const Reader&, TimeFunctionSetup& setup) { setup.function = TimeFunction::ramp(setup.duration); }),
       key::below("step", Keys<TimeFunctionSetup>{key::quantity("at", &TimeFunctionSetup::at, dimension::time,
                                                                "0 before this time, 1 from then on", kNotNegative)
                                                      .needed()})
           .then([](const Reader&, TimeFunctionSetup& setup) { setup.function = TimeFunction::step(setup.at); }),
       key::below(
           "sine",
           Keys<TimeFunctionSetup>{key::quantity("frequency", &TimeFunctionSetup::frequency, {0, 0, -1},
                                                 "mean + sin(2π frequency t + phase)", kPositive)
                                       .needed(),
                                   key::quantity("phase", &TimeFunctionSetup::phase, dimension::none, "phase [rad]"),
                                   key::quantity("mean", &TimeFunctionSetup::mean, dimension::none, "mean value")})
           .then([](const Reader&, TimeFunctionSetup& setup) {
             setup.function = TimeFunction::sine(setup.frequency, setup.phase, setup.mean);
           }),
       Key<TimeFunctionSetup>(
           {"table", "list of pairs", "s", "", "none", "`[time, factor]`, times ascending"},
           [](const Reader& value, TimeFunctionSetup& setup, const Frame&) { setup.function = table_of(value); })})};
  return keys;
}

}  // namespace

TimeFunction read_time_function(const Reader& reader) {
  if (!reader.is_map()) reader.fail("write {ramp: …}, {step: …}, {sine: …} or {table: [[time, factor], …]}");
  Reader map = reader;
  map.set_section("time_function");
  TimeFunction function = *time_function_keys().read(map).function;
  reader.note(function);
  return function;
}

KeySection time_function_section() {
  return {"time_function", "Functions of time",
          "A *time function* is a map of one of these:", time_function_keys().rows()};
}

}  // namespace elastin::lab
