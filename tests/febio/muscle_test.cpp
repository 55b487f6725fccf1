// A muscle's law: its stress and tangent as slopes of its energy, its shear moduli and its fibres' forces.

#include "febio/muscle.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/laws/solids/components.h"

using namespace elastin;
using namespace elastin::febio;

namespace {

Muscle muscle() {
  return {.direction = Vector3(2, -1, 2) / 3,
          .along = 500,
          .across = 700,
          .matrix = 300,
          .passive = 0.05,
          .rate = 6.6,
          .optimal = 0.9,
          .straight = 1.4,
          .peak = 3e4,
          .activation = 0.4};
}

/// C − I of a deformation gradient.
Matrix3 strain_of(const Matrix3& F) { return F.transpose() * F - Matrix3::Identity(); }

Matrix3 unit_change(int component) {
  Components one = Components::Zero();
  one[component] = component < 3 ? 1 : 0.5;
  return tensor(one);
}

}  // namespace

TEST_CASE("a muscle's stress and tangent are the slopes of its energy", "[febio]") {
  const Muscle law = muscle();
  // Near rest, in the fibres' toe, beyond it, shortened, and where w is far from 1: all branches.
  Matrix3 F[5];
  F[0] << 1.01, 0.02, 0, -0.01, 0.99, 0.01, 0, 0.02, 1.02;
  F[1] << 1.2, 0.3, 0.1, -0.2, 0.9, 0.1, 0.2, -0.1, 1.1;
  F[2] << 1.7, -0.4, 0.3, 0.2, 0.8, 0.1, 0.4, 0.1, 1.3;
  F[3] << 0.5, 0.1, 0, 0.1, 1.3, 0.2, 0, -0.2, 0.9;
  F[4] << 1.4, -0.1, 0.5, 0.2, 0.9, 0.7, 0.5, -0.6, 1.5;
  for (const Matrix3& gradient : F) {
    const Matrix3 A = strain_of(gradient), S = law.stress(Strained(A));
    const TangentModuli<3> D = law.tangent(Strained(A));
    CHECK((D - D.transpose()).norm() <= 1e-12 * D.norm());
    CHECK((S * (A + Matrix3::Identity())).trace() == Approx(0).margin(1e-10 * S.norm()));  // no pressure
    for (int c = 0; c < 6; ++c) {
      constexpr double step = 1e-5;
      const Matrix3 up = A + step * unit_change(c), down = A - step * unit_change(c);
      // dψ = ½ S : dC.
      const double slope = (law.energy(Strained(up)) - law.energy(Strained(down))) / step;
      CHECK(slope == Approx(S(kComponents[c][0], kComponents[c][1])).margin(1e-6 * S.norm()));
      const Components change = components(law.stress(Strained(up)) - law.stress(Strained(down))) / (2 * step);
      CHECK((change - D.col(c)).norm() <= 1e-6 * D.norm());
    }
  }
}

TEST_CASE("a muscle at rest has the moduli of shear along its fibres and across them, and no stress", "[febio]") {
  Muscle law = muscle();
  law.direction = Vector3::UnitX();
  law.peak = 0;
  const Matrix3 rest = Matrix3::Zero();
  CHECK(law.stress(Strained(rest)).norm() < 1e-12);
  // ψ = G γ² of a shear γ: S = 2 G A, A = C − I of it.
  const TangentModuli<3> D = law.tangent(Strained(rest));
  CHECK(2 * D(3, 3) == Approx(2 * law.along));   // in the plane 12
  CHECK(2 * D(5, 5) == Approx(2 * law.across));  // in the plane 23
}

TEST_CASE("a muscle's fibres pull with their largest force at their best length", "[febio]") {
  Muscle law = muscle();
  law.direction = Vector3::UnitX();
  law.along = law.across = law.matrix = 0;
  law.activation = 1;
  const double stretch = law.optimal;
  const Matrix3 F = Vector3(stretch, 1 / std::sqrt(stretch), 1 / std::sqrt(stretch)).asDiagonal();
  const Matrix3 cauchy = F * law.stress(Strained(strain_of(F))) * F;
  CHECK(cauchy(0, 0) - cauchy(1, 1) == Approx(law.peak));  // σ λ f/λ₀
  // Forces and their integrals have no jumps where their branches meet.
  constexpr double near = 1e-9;
  for (const double x : {0.4, 0.6, 1., 1.4, 1.6}) {
    const auto below = Muscle::active_force(x - near), above = Muscle::active_force(x + near);
    CHECK(below.value == Approx(above.value).margin(1e-7));
    CHECK(below.integral == Approx(above.integral).margin(1e-7));
    CHECK(law.passive_force(x - near).value == Approx(law.passive_force(x + near).value).margin(1e-7));
    CHECK(law.passive_force(x - near).integral == Approx(law.passive_force(x + near).integral).margin(1e-7));
  }
}
