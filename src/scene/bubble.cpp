#include "experiment/bubble.h"

#include "scene/parts.h"

namespace elastin {
namespace {

constexpr Range kAboveBefore(double before) { return {before, kPositive.high, true}; }

/// measured: [[5000 Pa, 17 mm], …]
void read_measured(const Reader& reader, BubbleSetup& setup) {
  double before = 0;
  for (const Reader& item : reader.items()) {
    const auto pair = item.items(2);
    before = pair[0].quantity(dimension::pressure, kAboveBefore(before));
    setup.pressures.push_back(before);
    setup.heights.push_back(pair[1].quantity(dimension::length, kPositive));
  }
  if (setup.pressures.empty()) reader.fail("names no point; write [[pressure, height], ...]");
}

void read_pressures(Reader& reader, BubbleSetup& setup) {
  if (auto measured = reader.find("measured")) return read_measured(*measured, setup);
  const Reader pressure = reader.at("pressure");
  const auto steps = reader.find("load_steps");
  if (pressure.is_text()) {
    const double whole = pressure.quantity(dimension::pressure, kPositive);
    const int count = steps ? steps->whole(1, 100000) : 1;
    for (int step = 1; step <= count; ++step) setup.pressures.push_back(whole * step / count);
    return;
  }
  if (steps) steps->fail("a list of pressures has a load step for each");
  double before = 0;
  for (const Reader& item : pressure.items())
    setup.pressures.push_back(before = item.quantity(dimension::pressure, kAboveBefore(before)));
  if (setup.pressures.empty()) pressure.fail("names no pressure");
}

}  // namespace

std::unique_ptr<Experiment> read_bubble(Reader reader, const ExperimentPlace& place) {
  BubbleSetup setup;
  read_pressures(reader, setup);
  reader.finish();
  if (place.statics.linear) reader.fail("a flat membrane bears no pressure with small displacements");
  return reader.located([&] { return make_bubble(place.body, setup, place.material); });
}

}  // namespace elastin
