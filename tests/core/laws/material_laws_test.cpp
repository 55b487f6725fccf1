// Laws that see C: stress and tangent by differences, and what the cell driver makes of them on each shape.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/laws/membranes/hencky_energy_membrane.h"
#include "core/laws/membranes/hencky_membrane.h"
#include "core/laws/solids/curve.h"
#include "core/laws/solids/fibre.h"
#include "core/laws/solids/neo_hookean.h"
#include "core/laws/solids/st_venant_kirchhoff.h"
#include "support/cells.h"

using namespace elastin;
using namespace elastin::testing;

static_assert(SolidLaw<NeoHookean> && MembraneLaw<NeoHookean> && !LengthLaw<NeoHookean>);
static_assert(SolidLaw<StVenantKirchhoff> && MembraneLaw<StVenantKirchhoff>);
static_assert(SolidLaw<Curve> && MembraneLaw<Curve>);
static_assert(SolidLaw<FibreLaw> && !MembraneLaw<FibreLaw>);
static_assert(MembraneLaw<Hencky> && !SolidLaw<Hencky>);

namespace {

std::vector<Material> materials() {
  Material plain = material_of(5000, 0.3), curved = plain;
  plain.fibre = curved.fibre = Fibre{Vector3(2, -1, 2) / 3, StressStrain::toe(0.03, 1e4, 3e5)};
  curved.curve = StressStrain::through({{-0.4, -3000}, {0, 0}, {0.3, 1200}, {1, 9000}});
  curved.youngs_modulus = curved.curve->modulus(0);
  return {plain, curved};
}

/// The components of a symmetric tensor in the order of TangentModuli.
template <int d>
Eigen::Matrix<double, d*(d + 1) / 2, 1> components(const Tensor<d>& tensor) {
  Eigen::Matrix<double, d*(d + 1) / 2, 1> result;
  result.template head<d>() = tensor.diagonal();
  for (int i = 0, row = d; i < d; ++i)
    for (int j = i + 1; j < d; ++j) result[row++] = tensor(i, j);
  return result;
}

/// C − I of a random stretch and shear; every third near rest, every third with nearly equal stretches.
template <int d>
Tensor<d> random_strain(Random& random, int trial) {
  const double size = trial % 3 == 0 ? 1e-3 : trial % 3 == 1 ? 1e-7 : 0.3;
  const double even = trial % 3 == 1 ? 1 + 0.4 * random.number() : 1;
  const Tensor<d> F = even * (Tensor<d>::Identity() + size * random.matrix<d, d>());
  return F.transpose() * F - Tensor<d>::Identity();
}

/// S : Ȧ/2 is the energy's rate and ∂S/∂C : Ȧ the stress's, along a random change of C.
template <int d, class Point>
void check_point(const Point& law, Random& random, double stiffness) {
  for (int trial = 0; trial < 60; ++trial) {
    const Tensor<d> A = random_strain<d>(random, trial), any = random.matrix<d, d>();
    const Tensor<d> direction = (any + any.transpose()) / 2;
    const double h = 1e-5;
    const auto energy = [&](double times) { return law.energy(A + times * h * direction); };
    const double rate = (8 * (energy(1) - energy(-1)) - energy(2) + energy(-2)) / (12 * h);
    const Tensor<d> S = law.stress(A);
    // Fourth-order differences: rounding of W, 1e-16 of the stiffness at strains of 1, over the step.
    CHECK(std::abs(rate - S.cwiseProduct(direction).sum() / 2) <= 1e-8 * (S.norm() + stiffness));
    const auto stress = [&](double times) -> Tensor<d> { return law.stress(A + times * h * direction); };
    const Tensor<d> change = (8 * (stress(1) - stress(-1)) - stress(2) + stress(-2)) / (12 * h);
    auto strain = components<d>(direction);
    strain.tail(strain.size() - d) *= 2;
    const TangentModuli<d> tangent = law.tangent(A);
    CHECK((tangent * strain - components<d>(change)).norm() <= 1e-6 * (tangent.norm() + stiffness));
    CHECK((tangent - tangent.transpose()).norm() <= 1e-13 * tangent.norm());
  }
}

/// A random cell deformed at random.
template <class Shape>
struct Trial {
  NodePositions<Shape::nodes> rest, now;
  CellVector<Shape::nodes> s;
  explicit Trial(Random& random)
      : rest(random_cell<Shape::nodes>(random)),
        now((random_deformation(random) * rest).colwise() + 0.01 * random.matrix<3, 1>()),
        s(squared_lengths<Shape::nodes>(now)) {}
};

/// That the kernel's q is −Σ w B_aᵀ S B_b, its forces −Σ w F S B_a and its energy Σ w W, F from where the nodes are.
template <class Law, class Shape, class Kernel = CellKernel<Law, Shape>>
void check_kernel(const Material& material) {
  constexpr int d = Shape::dimensions, nodes = Shape::nodes;
  Random random(61);
  const auto law = detail::at_work<d>(Law{}, material);
  for (int trial = 0; trial < 50; ++trial) {
    const Trial<Shape> cell(random);
    const RestCell<Shape> rest(cell.rest);
    const auto k = Kernel{}.constants(cell.rest, material);
    NodePositions<nodes> expected = NodePositions<nodes>::Zero();
    double energy = 0;
    for (std::size_t g = 0; g < Shape::points.size(); ++g) {
      const Eigen::Matrix<double, 3, d> F = cell.now * rest.gradients[g].transpose();
      const Tensor<d> A = F.transpose() * F - Tensor<d>::Identity();
      expected -= rest.weights[g] * F * law.stress(A) * rest.gradients[g];
      energy += rest.weights[g] * law.energy(A);
    }
    const CellVector<nodes> q = Kernel{}.force_densities(k, cell.s);
    // Rounding of places, over a cell thin by a factor of some ten, stiffer than its stress by as much.
    CHECK((forces<nodes>(cell.now, q) - expected).norm() <= 1e-11 * expected.norm());
    CHECK(Kernel{}.energy(k, cell.s) == Approx(energy).epsilon(1e-10));
    const PointKernel<Law, Shape> at_points;
    const auto points = at_points.constants(cell.rest, material);
    CHECK((q - at_points.force_densities(points, cell.s)).norm() <= 1e-11 * q.norm());
    const auto slope = Kernel{}.slope(k, cell.s);
    CHECK((slope - at_points.slope(points, cell.s)).norm() <= 1e-11 * slope.norm());
  }
}

}  // namespace

TEMPLATE_TEST_CASE("a solid law: S = 2 dW/dC, and its tangent", "[law]", StVenantKirchhoff, NeoHookean, Curve,
                   FibreLaw) {
  Random random(60);
  for (const Material& material : materials()) check_point<3>(TestType{}.solid(material), random, 3e5);
}

TEMPLATE_TEST_CASE("a membrane law: S = 2 dW/dC, and its tangent", "[law]", StVenantKirchhoff, NeoHookean, Curve,
                   HenckyEnergy) {
  Random random(62);
  for (const Material& material : materials()) check_point<2>(TestType{}.membrane(material), random, 5e3 * 1e-3);
}

TEMPLATE_TEST_CASE("a solid law on a tetrahedron: forces are those of the stress at its points", "[law]",
                   StVenantKirchhoff, NeoHookean, Curve, FibreLaw) {
  for (const Material& material : materials()) check_kernel<TestType, Tetrahedron4>(material);
}

TEMPLATE_TEST_CASE("a membrane law on a triangle: forces are those of the stress at its points", "[law]",
                   StVenantKirchhoff, NeoHookean, Curve, HenckyEnergy) {
  for (const Material& material : materials()) check_kernel<TestType, Triangle3>(material);
}

TEST_CASE("a law in plane stress is the solid whose thickness has no stress", "[law]") {
  // The thickness stretch at which the solid has no stress across, by halving.
  Random random(63);
  const Material material = material_of(5000, 0.3);
  const auto check = [&](const auto& solid, const auto& membrane) {
    for (int trial = 0; trial < 30; ++trial) {
      const Eigen::Matrix2d A = random_strain<2>(random, trial);
      Matrix3 full = Matrix3::Zero();
      full.topLeftCorner<2, 2>() = A;
      double low = -0.99, high = 9;
      for (int halving = 0; halving < 60; ++halving) {
        full(2, 2) = (low + high) / 2;
        (solid.stress(full)(2, 2) < 0 ? low : high) = full(2, 2);
      }
      const Eigen::Matrix2d expected = material.thickness * solid.stress(full).topLeftCorner(2, 2);
      CHECK((membrane.stress(A) - expected).norm() <= 1e-10 * (expected.norm() + 5));
    }
  };
  check(NeoHookean{}.solid(material), NeoHookean{}.membrane(material));
  check(StVenantKirchhoff{}.solid(material), StVenantKirchhoff{}.membrane(material));
  check(Curve{}.solid(material), Curve{}.membrane(material));  // Biot stress per rest section: any thickness
}
