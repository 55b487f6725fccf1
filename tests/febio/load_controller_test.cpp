// Load curves of FEBio.

#include "febio/load_controller.h"

#include <catch2/catch.hpp>

using namespace elastin::febio;

TEST_CASE("load curves of FEBio between and beyond their points", "[febio]") {
  LoadController curve{.points = {{0, 1}, {1, 3}, {3, 0}}};
  CHECK(curve.value(0.5) == Approx(2));
  CHECK(curve.value(2) == Approx(1.5));
  CHECK(curve.value(-1) == 1);
  CHECK(curve.value(9) == 0);
  curve.extension = LoadController::Extension::extrapolate;
  CHECK(curve.value(5) == Approx(-3));
  CHECK(curve.value(-1) == Approx(-1));
  curve.extension = LoadController::Extension::repeat;
  CHECK(curve.value(3.5) == Approx(2));
  CHECK(curve.value(-2) == Approx(3));
  curve.interpolation = LoadController::Interpolation::step;
  CHECK(curve.value(0.1) == 3);
  CHECK(curve.value(1) == 3);
  CHECK(curve.value(1.1) == 0);
}

TEST_CASE("a smooth load curve meets a parabola everywhere, and a line through two points", "[febio]") {
  LoadController curve{.interpolation = LoadController::Interpolation::smooth, .points = {{0, 0}, {2, 1}}};
  CHECK(curve.value(0.5) == Approx(0.25));
  const auto parabola = [](double t) { return 1 - 2 * t + 3 * t * t; };
  curve.points.clear();
  for (const double t : {0., 0.4, 1., 1.7, 2.}) curve.points.push_back({t, parabola(t)});
  for (const double t : {0.1, 0.4, 0.6, 1.3, 1.9}) CHECK(curve.value(t) == Approx(parabola(t)).epsilon(1e-12));
}
