#include "core/forces/bending.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/shapes/surfaces.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/forces/tension.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "support/bodies.h"
#include "support/experiments.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

Body prepared(Body body) {
  set_matter(body, 0.001, 1000, 0.001, 0);
  add_cell_sides(body, bending_pairs(body));
  return body;
}

/// A sheet in the plane z = 0 from a function w(x, y), its energy over its area.
template <class Shape>
double energy_density(const Body& body, double area, double rigidity, double nu, Shape shape) {
  Positions positions = body.rest;
  for (int i = 0; i < body.size(); ++i) positions(2, i) += shape(positions(0, i), positions(1, i));
  return make_bending(body, rigidity, nu)->energy(positions) / area;
}

struct Cantilever {
  double length, width, thickness, E, nu;
  int squares;
};

/// Downward displacement of the tip's middle [m] under a force on the tip's side, spread by length; two rows of
/// molecules are held, and the length counts from the middle between them.
double tip_displacement(const Cantilever& c, double force, bool linear, double* shortening = nullptr) {
  const double h = c.width / c.squares;
  const int along = static_cast<int>(std::lround(c.length / h));
  Body body =
      rectangular_sheet({(along + 0.5) * h + h / 2, c.width}, {along + 1, c.squares}, SheetPattern::alternating);
  body = prepared(body);
  const Material material{.youngs_modulus = c.E, .poissons_ratio = c.nu, .thickness = c.thickness};
  Model model(body);
  model.add(built_in_catalog().find("st_venant_kirchhoff_membrane").make(body, material, {}));
  model.add(make_bending(body, c.E * std::pow(c.thickness, 3) / (12 * (1 - c.nu * c.nu)), c.nu));
  std::vector<int> tip;
  for (int i = 0; i < body.size(); ++i) {
    const double x = body.rest(0, i);
    if (x < 1.01 * h) model.supports.push_back({i, Matrix3::Zero(), Vector3::Zero()});
    if (x > (along + 0.99) * h) tip.push_back(i);
  }
  Positions forces = Positions::Zero(3, static_cast<Eigen::Index>(tip.size()));
  int middle = tip[0];
  for (std::size_t i = 0; i < tip.size(); ++i) {
    const double y = body.rest(1, tip[i]);
    const bool corner = y < 1e-9 || y > c.width - 1e-9;
    forces(2, static_cast<Eigen::Index>(i)) = -force / c.squares * (corner ? 0.5 : 1);
    if (std::abs(y - c.width / 2) < std::abs(body.rest(1, middle) - c.width / 2)) middle = tip[i];
  }
  model.add(std::make_unique<PointLoads>(body, tip, forces));
  State state = state_at_rest(body);
  const StaticResult solved = solve_static(model, state, {.linear = linear, .method = "direct", .tolerance = 1e-8});
  INFO(solved.cause);
  REQUIRE(solved.outcome == Outcome::converged);
  if (shortening) *shortening = body.rest(0, middle) - state.positions(0, middle);
  return body.rest(2, middle) - state.positions(2, middle);
}

}  // namespace

TEST_CASE("bending does nothing to a flat sheet, however stretched and placed", "[bending_stiffness]") {
  const Body body = prepared(disc(0.1, 4));
  const auto bending = make_bending(body, 2, 0.3);
  Matrix3 F;
  F << 1.2, 0.3, 0, -0.1, 0.8, 0, 0.4, -0.2, 1;  // flat stays flat
  Positions positions = F * body.rest;
  positions.colwise() += Vector3(1, -2, 3);
  Model model(body);
  model.add(make_bending(body, 2, 0.3));
  const VectorX force_densities = model.force_densities(positions);
  REQUIRE(force_densities.norm() > 0);
  const Positions none = model.elastic_forces(positions);
  CHECK(none.norm() <= 1e-11 * force_densities.norm() * 0.1);
  CHECK(bending->energy(positions) <= 1e-24 * force_densities.norm());
}

TEST_CASE("bending: forces are minus the gradient, on any sheet and at any bending", "[bending_stiffness]") {
  Body flat = disc(0.1, 3);
  add_jitter(flat, 0.004, 5);
  flat.rest.row(2).setZero();
  set_present_lengths(flat);
  const Body body = prepared(std::move(flat));
  Model model(body);
  model.add(make_bending(body, 2, 0.3));
  const Positions positions = deformed(body, 0.02), motion = random_motion(body, 3);
  const double h = 1e-6;
  const double rise = model.elastic_energy(positions + h * motion) - model.elastic_energy(positions - h * motion);
  const Positions forces = model.elastic_forces(positions);
  CHECK(rise / (2 * h) == Approx(-forces.cwiseProduct(motion).sum()).epsilon(1e-7));
  CHECK(forces.rowwise().sum().norm() <= 1e-11 * forces.norm());
  Positions predicted(3, body.size());
  State state = state_at_rest(body);
  state.positions = positions;
  Tangent(model, state).apply(motion, predicted);
  const Positions change = model.elastic_forces(positions - h * motion) - model.elastic_forces(positions + h * motion);
  CHECK((change / (2 * h) - predicted).norm() <= 1e-8 * predicted.norm());
}

TEST_CASE("bending: the energy of a plate under constant curvature", "[bending_stiffness]") {
  // D/2 ((w_xx + w_yy)² − 2 (1−ν)(w_xx w_yy − w_xy²)); what a free rim lacks of it fades as the squares shrink. With
  // diagonals in alternation a twist (w_xy) is 2.8 times too stiff.
  constexpr double nu = 0.3, D = 2;
  struct Shape {
    double xx, yy, xy;
  };
  for (const Shape& shape : {Shape{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, -1, 0}, {1, 0.5, -0.4}}) {
    Refinement off;
    for (std::size_t i = 0; i < 3; ++i) {
      const int n = 8 << i;
      const Body body = prepared(rectangular_sheet({1, 1}, {n, n}, SheetPattern::one_way));
      const double expected =
          D / 2 * (std::pow(shape.xx + shape.yy, 2) - 2 * (1 - nu) * (shape.xx * shape.yy - shape.xy * shape.xy));
      off[i] = energy_density(body, 1, D, nu,
                              [&](double x, double y) {
                                return 1e-3 * (shape.xx * x * x / 2 + shape.yy * y * y / 2 + shape.xy * x * y);
                              }) /
                   1e-6 / expected -
               1;
    }
    INFO(shape.xx << " " << shape.yy << " " << shape.xy << ": " << off[0] << " " << off[1] << " " << off[2]);
    CHECK(std::abs(off[2]) < 0.05);
    CHECK(std::abs(off[2]) < 0.6 * std::abs(off[1]) + 1e-9);
  }
}

TEST_CASE("bending says how much too stiff the lie of its triangles makes it", "[bending_stiffness]") {
  const auto excess = [](SheetPattern pattern, int squares) {
    return bending_excess(prepared(rectangular_sheet({0.04, 0.04}, {squares, squares}, pattern)), 0.3);
  };
  for (const int squares : {6, 24}) CHECK(excess(SheetPattern::one_way, squares) == Approx(1).epsilon(1e-9));
  CHECK(excess(SheetPattern::alternating, 24) > 2);
  CHECK(excess(SheetPattern::crossed, 24) > 1.1);
  // What a whole sheet stores where it is twisted says the same, but for its rim.
  const Body sheet = prepared(rectangular_sheet({0.04, 0.04}, {40, 40}, SheetPattern::alternating));
  const double twisted = energy_density(sheet, 0.04 * 0.04, 1, 0.3, [](double x, double y) { return x * y; }),
               plate = 1 - 0.3;
  CHECK(bending_excess(sheet, 0.3) == Approx(twisted / plate).epsilon(0.1));
}

TEST_CASE("bending: a clamped strip sinks like a beam, and like the elastica", "[bending_stiffness][slow]") {
  // Narrow against its length, wide against its thickness: E I with the beam's free sides. w = F L³/(3 E I).
  constexpr double E = 1e9, t = 1e-3, L = 0.2, b = 0.02, I = b * t * t * t / 12;
  Refinement ratio;
  for (std::size_t i = 0; i < 3; ++i)
    ratio[i] = tip_displacement({L, b, t, E, 0.3, 2 << i}, 1e-4, true) / (1e-4 * L * L * L / (3 * E * I));
  INFO(ratio[0] << " " << ratio[1] << " " << ratio[2]);
  CHECK(ratio[2] == Approx(1).epsilon(0.02));
  // F L²/(E I) = 2: w/L = 0.4935, u/L = 0.1606.                           [Mattiasson 1981, elliptic integrals]
  double shortening = 0;
  const double displacement =
      tip_displacement({L, b / 2, t, E, 0., 4}, E * I / (L * L), false, &shortening);  // I of half the width
  CHECK(displacement / L == Approx(0.4935).epsilon(0.02));
  CHECK(shortening / L == Approx(0.1606).epsilon(0.04));
}

TEST_CASE("bodies that cannot have bending stiffness say why", "[bending_stiffness]") {
  CHECK(unsuited_for_bending(disc(1, 3)).empty());
  CHECK(unsuited_for_bending(sphere(1, SphereMesh::icosahedron, 2)) ==
        "needs a sheet that is flat at rest: this one is 1.92e+03 mm deep, 55.3 % of its size");
  // A sheet whose places are in single precision is flat.
  Body sheet = rectangular_sheet({0.05, 0.03}, {10, 6}, SheetPattern::alternating);
  rotate(sheet, Eigen::AngleAxisd(0.7, Vector3(1, -2, 0.5).normalized()).toRotationMatrix());
  sheet.rest = sheet.rest.cast<float>().cast<double>().eval();
  CHECK(unsuited_for_bending(sheet).empty());
  sheet.rest.col(5) += Vector3::Constant(1e-6);
  CHECK(unsuited_for_bending(sheet).find("mm deep") != std::string::npos);
  CHECK(unsuited_for_bending(jittered_lattice()) == "needs triangles");
}
