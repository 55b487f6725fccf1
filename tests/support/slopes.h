#pragma once
#include <catch2/catch.hpp>

#include "elastin/core/forces/model.h"
#include "elastin/core/forces/tangent.h"

namespace elastin::testing {

/// Along `motion`: forces are the energy's slope, the tangent theirs, and its blocks what it does.
inline void check_slopes(Model& model, const Positions& positions, const Positions& motion) {
  const auto energy = [&](double step) { return model.elastic_energy(positions + step * motion); };
  const double h = 1e-7;
  const double measured = (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h);
  CHECK(measured == Approx(-model.elastic_forces(positions).cwiseProduct(motion).sum()).epsilon(1e-6));
  const State at{positions, Positions::Zero(3, positions.cols())};
  const Tangent tangent(model, at);
  Positions predicted(3, positions.cols()), assembled = Positions::Zero(3, positions.cols());
  tangent.apply(motion, predicted);
  const double k = 1e-8;
  const Positions change =
      -(model.elastic_forces(positions + k * motion) - model.elastic_forces(positions - k * motion)) / (2 * k);
  CHECK((predicted - change).norm() <= 1e-5 * change.norm());
  tangent.visit_blocks([&](int a, int b, const Matrix3& part) { assembled.col(a) += part * motion.col(b); });
  CHECK((assembled - predicted).norm() <= 1e-11 * predicted.norm());
}

}  // namespace elastin::testing
