#include "lab/run/time_history_fits.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace elastin;
using namespace elastin::lab;

namespace {

template <class Function>
Series sampled(double from, double to, int count, Function function) {
  Series series{VectorX::LinSpaced(count, from, to), VectorX(count)};
  for (int i = 0; i < count; ++i) series.values[i] = function(series.times[i]);
  return series;
}

}  // namespace

TEST_CASE("an exponential is found again", "[fits]") {
  for (const double time : {0.05, 0.7, 12.}) {
    const auto fit = fit_exponential(sampled(1, 3, 50, [&](double t) { return 2 - 5 * std::exp(-(t - 1) / time); }));
    REQUIRE(fit);
    CHECK(fit->time == Approx(time).epsilon(1e-6));
    CHECK(fit->start == Approx(-3).epsilon(1e-6));
    CHECK(fit->end == Approx(2).epsilon(1e-5));
  }
  CHECK_FALSE(fit_exponential(sampled(0, 1, 20, [](double) { return 3.; })));
  CHECK_FALSE(fit_exponential(sampled(0, 1, 3, [](double t) { return t; })));
}

TEST_CASE("what is no exponential has a misfit, or none is found", "[fits]") {
  const auto vibration = fit_exponential(sampled(0, 1, 200, [](double t) { return 1 - std::cos(40 * t); }));
  CHECK((!vibration || vibration->misfit > 0.5));
  CHECK(fit_exponential(sampled(0, 3, 50, [](double t) { return std::exp(-t); }))->misfit < 1e-6);
  // Over within an interval, and hardly begun; constant but for the digits of a solver.
  CHECK_FALSE(fit_exponential(sampled(0, 1, 50, [](double t) { return std::exp(-500 * t); })));
  CHECK_FALSE(fit_exponential(sampled(0, 1, 50, [](double t) { return std::exp(-0.05 * t); })));
  CHECK_FALSE(fit_exponential(sampled(0, 1, 50, [](double t) { return 3 + 1e-7 * std::sin(1e4 * t); })));
}

TEST_CASE("a vibration that soon dies away has its damping, whatever comes behind it", "[fits]") {
  for (const double ratio : {0.05, 0.19, 0.3, 0.5})
    for (const double duration : {12., 20.}) {
      INFO("damping ratio " << ratio << " over " << duration);
      const double omega = std::sqrt(1 - ratio * ratio);
      const auto fit = fit_vibration(
          sampled(0, duration, 300, [&](double t) { return std::exp(-ratio * t) * std::cos(omega * t); }));
      REQUIRE(fit);
      CHECK(fit->decay_rate / std::hypot(fit->decay_rate, fit->circular_frequency) == Approx(ratio).epsilon(1e-6));
    }
}

TEST_CASE("a damped cosine is found again", "[fits]") {
  for (const double decay : {0., 0.3, 2.}) {
    const Series series =
        sampled(0, 4, 300, [&](double t) { return 1 + std::exp(-decay * t) * 0.2 * std::cos(9 * t + 0.4); });
    const auto fit = fit_vibration(series);
    REQUIRE(fit);
    CHECK(fit->circular_frequency == Approx(9).epsilon(1e-7));
    CHECK(fit->decay_rate == Approx(decay).margin(1e-6));
    CHECK(fit->mean == Approx(1).epsilon(1e-7));
    CHECK(fit->misfit < 1e-6);
    REQUIRE(period_of(series, 1));
    CHECK(*period_of(series, 1) == Approx(2 * M_PI / 9).epsilon(1e-4));
  }
  CHECK_FALSE(fit_vibration(sampled(0, 1, 50, [](double t) { return t; })));
}

TEST_CASE("turning points are those of the curve between the samples", "[fits]") {
  const Series turns = turning_points(sampled(0, 2, 41, [](double t) { return std::sin(M_PI * (t + 0.013)); }));
  REQUIRE(turns.times.size() == 2);
  CHECK(turns.times[0] == Approx(0.487).margin(1e-4));
  CHECK(turns.values[0] == Approx(1).margin(1e-6));
  CHECK(turns.times[1] == Approx(1.487).margin(1e-4));
  CHECK(turns.values[1] == Approx(-1).margin(1e-6));
}
