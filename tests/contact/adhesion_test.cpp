#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "elastin/contact/contact.h"
#include "elastin/core/base/error.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::contact;
using std::numbers::pi;

namespace {

constexpr double kRadius = 1, kWork = 1, kModulus = 1e5;  // R, w and E/(1 − ν²)

/// A quarter of a block whose upper side is z = 0, with cells that grow from its middle: the first n of a fine width.
Body graded_quarter(int fine, double width, double growth, int more) {
  std::vector<double> ticks{0};
  double step = width;
  for (int i = 0; i < fine + more; ++i) {
    if (i >= fine) step *= growth;
    ticks.push_back(ticks.back() + step);
  }
  const int n = static_cast<int>(ticks.size());
  std::vector<double> depths{0};
  step = width;
  while (depths.back() < ticks.back()) {
    if (static_cast<int>(depths.size()) > fine / 2) step *= growth;
    depths.push_back(depths.back() + step);
  }
  const int layers = static_cast<int>(depths.size());
  Body corners = cubic_lattice({n, n, layers}, 1, {true, false, false});
  for (int i = 0; i < corners.size(); ++i) {
    Eigen::Ref<Vector3> at = corners.rest.col(i);
    const auto tick = [](double number) { return static_cast<std::size_t>(std::lround(number)); };
    at = Vector3(ticks[tick(at.x())], ticks[tick(at.y())], depths[tick(at.z())] - depths.back());
  }
  Body body = with_cells(corners, cell_kind("hexahedron8"));
  set_matter(body, width / 4, 1, 0, 0);
  return body;
}

struct Sphere {
  Sphere(Body given, double peak, double stiffness) : body(std::move(given)), model(body) {
    Material material;
    material.poissons_ratio = 0.3;
    material.youngs_modulus = kModulus * (1 - 0.09);
    model.add(built_in_catalog().find("st_venant_kirchhoff").make(body, material, {}));
    ContactOptions options;
    options.surface = ContactSurface::triangles, options.stiffness = stiffness;
    options.adhesion = kWork, options.adhesion_range = 2 * kWork / peak;
    options.obstacles.push_back({"sphere", shape::Sphere{kRadius}});
    options.obstacles[0].motion = [this](double) {
      Pose pose;
      pose.position.z() = kRadius + height;
      return pose;
    };
    auto made = make_contact(body, options);
    contact = made.get();
    model.add(std::move(made));
    const double low = body.rest.row(2).minCoeff();
    for (int i = 0; i < body.size(); ++i) {
      Matrix3 free = Matrix3::Identity();
      if (body.rest(0, i) < 1e-9) free(0, 0) = 0;
      if (body.rest(1, i) < 1e-9) free(1, 1) = 0;
      if (body.rest(2, i) < low + 1e-9) free.setZero();
      if (free != Matrix3::Identity()) model.supports.push_back({i, free});
    }
    state = state_at_rest(body);
  }
  double pull() const { return -4 * contact->report(state).on_obstacles[0].z(); }

  double height = 0;  ///< of its lowest point
  Body body;
  Model model;
  Contact* contact;
  State state;
};

}  // namespace

TEST_CASE("a rigid sphere that touches a flat surface adheres with 2 pi R w", "[contact][adhesion]") {
  // Derjaguin's limit: any traction over gaps that are small against R, of which w is the integral.
  // A slab so thick that its cut sides, which count as surface, are out of the range of 2 cm.
  Body corners = cubic_lattice({31, 31, 2}, 0.01, {true, false, false});
  corners.rest.row(2) = (corners.rest.row(2).array() - 0.01) * 100;
  Body slab = with_cells(corners, cell_kind("hexahedron8"));
  set_matter(slab, 0.005, 1, 0, 0);
  const Sphere sphere(std::move(slab), 100, 1e6);
  CHECK(sphere.pull() == Approx(2 * pi * kRadius * kWork).epsilon(0.01));
}

TEST_CASE("a sphere is drawn off a soft body by the force of Maugis' theory", "[contact][adhesion][slow]") {
  // Parameter λ = σ (9 R / (2 π w E*²))^(1/3) with the mean traction σ = w / range; the fit of [Carpick 1999] to
  // Maugis' solution goes from 2 π R w (λ = 0) to Johnson, Kendall and Roberts' 3/2 π R w.
  const double lambda = 1, mean = lambda * std::cbrt(2 * pi * kWork * kModulus * kModulus / (9 * kRadius));
  Sphere sphere(graded_quarter(14, 0.0036, 1.8, 7), 2 * mean, 20 * mean * mean / kWork);
  double most = 0;
  for (int step = 0; step <= 6; ++step) {
    sphere.height = 2e-4 + 5e-5 * step;
    sphere.contact->set_moment(step);
    REQUIRE(solve_static(sphere.model, sphere.state, {.tolerance = 1e-6}).outcome == Outcome::converged);
    most = std::max(most, sphere.pull());
  }
  const double fit = 4.04 * std::pow(lambda, 1.4);
  CHECK(most == Approx((1.75 - 0.25 * (fit - 1) / (fit + 1)) * pi * kRadius * kWork).epsilon(0.03));
  sphere.height = 2e-3;
  sphere.contact->set_moment(9);
  REQUIRE(solve_static(sphere.model, sphere.state, {.tolerance = 1e-6}).outcome == Outcome::converged);
  CHECK(sphere.pull() == 0);
}

TEST_CASE("adhesion is refused where its traction has no peak", "[contact][adhesion]") {
  const Body body = graded_quarter(2, 0.01, 1.2, 2);
  ContactOptions options;
  options.surface = ContactSurface::triangles, options.stiffness = 100;
  options.adhesion = 1;
  CHECK_THROWS_WITH(make_contact(body, options), Catch::Contains("needs a range"));
  options.adhesion_range = 0.1;
  CHECK_THROWS_WITH(make_contact(body, options), Catch::Contains("must be above 0.141421 m"));
}
