#include "lab/experiment/homogenisation/homogenisation.h"

#include <Eigen/Geometry>

#include "elastin/core/base/error.h"
#include "lab/experiment/tension/tension.h"
#include "lab/run/section.h"
#include "support/bodies.h"
#include "support/experiments.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;

namespace {

const StaticOptions kExact{.tolerance = 1e-13};

Run homogenise(const Specimen& specimen, const std::string& strategy, const Matrix3& axes = Matrix3::Identity()) {
  const auto experiment = make_homogenisation(specimen.body, {0}, axes);
  return solve(specimen, *experiment, strategy, kExact);
}

Stiffness6 cubic(double c11, double c12, double c44) {
  Stiffness6 stiffness = Stiffness6::Zero();
  stiffness.topLeftCorner<3, 3>().setConstant(c12);
  for (int i = 0; i < 3; ++i) stiffness(i, i) = c11, stiffness(i + 3, i + 3) = c44;
  return stiffness;
}

Stiffness6 isotropic(const Material& m) { return cubic(lame_lambda(m) + 2 * lame_mu(m), lame_lambda(m), lame_mu(m)); }

double relative_difference(const Run& run, const Stiffness6& expected) {
  REQUIRE(run.measures.stiffness_matrix);
  return (*run.measures.stiffness_matrix - expected).norm() / expected.norm();
}

/// Anisotropy index of a cubic solid from its Zener ratio Z = 2 C44 / (C11 - C12). [Ranganathan & Ostoja-Starzewski
/// 2008]
double cubic_index(double Z) { return 6. / 5 * std::pow(std::sqrt(Z) - 1 / std::sqrt(Z), 2); }

Specimen lattice(const std::array<int, 3>& molecules, const CubicPattern& pattern, double E = 1e4) {
  Specimen specimen;
  specimen.material.youngs_modulus = E;
  specimen.body = cubic_lattice(molecules, 0.01, pattern);
  set_matter(specimen.body, 0.005, 1000, 0, 1e-6 * (molecules[0] - 1) * (molecules[1] - 1) * (molecules[2] - 1));
  return specimen;
}

}  // namespace

TEST_CASE("means of an anisotropic stiffness: copper", "[material]") {
  // C11, C12, C44 = 168.4, 121.4, 75.4 GPa: K = 137.1, G between Reuss 40.03 and Voigt 54.64 GPa.  [Simmons & Wang
  // 1971]
  const Stiffness6 copper = cubic(168.4, 121.4, 75.4);
  const IsotropicMeans means = isotropic_means(copper, copper.inverse());
  CHECK(means.bulk_voigt == Approx(137.0667).epsilon(1e-6));
  CHECK(means.bulk_reuss == Approx(137.0667).epsilon(1e-6));
  CHECK(means.shear_voigt == Approx((47 + 3 * 75.4) / 5).epsilon(1e-12));
  CHECK(means.shear_reuss == Approx(5 * 47 * 75.4 / (4 * 75.4 + 3 * 47)).epsilon(1e-12));
  CHECK(means.anisotropy_index() == Approx(cubic_index(2 * 75.4 / 47)).epsilon(1e-12));
  CHECK(means.youngs() == Approx(9 * means.bulk() * means.shear() / (3 * means.bulk() + means.shear())));
}

TEST_CASE("cells are the isotropic stiffness itself on a jittered mesh", "[material]") {
  for (const BlockKind kind : {BlockKind::kuhn, BlockKind::alternating, BlockKind::body_centred})
    for (const double nu : {0., 0.3, 0.45})
      for (const char* law : {"st_venant_kirchhoff", "neo_hookean"}) {
        const Specimen specimen = jittered_specimen(kind, nu, 1e4, 4);
        const Run run = homogenise(specimen, law);
        INFO(law << ", nu " << nu);
        CHECK(relative_difference(run, isotropic(specimen.material)) < 1e-10);
        CHECK(run.measures.get("effective_modulus") == Approx(1e4).epsilon(1e-10));
        CHECK(run.measures.get("youngs_modulus_y") == Approx(1e4).epsilon(1e-10));
        CHECK(run.measures.get("poissons_ratio") == Approx(nu).margin(1e-10));
        CHECK(run.measures.get("shear_modulus") == Approx(1e4 / (2 * (1 + nu))).epsilon(1e-10));
        CHECK(run.measures.get("bulk_modulus") == Approx(1e4 / (3 * (1 - 2 * nu))).epsilon(1e-10));
        CHECK(run.measures.get("anisotropy_index") < 1e-10);
        CHECK(run.measures.get("patch_residual") < 1e-12);
        CHECK(run.residual < 1e-12);
        CHECK(run.measures.get("stiffness_asymmetry") < 1e-12);
      }
}

TEST_CASE("the lattice rule is isotropic with nu = 1/4", "[material]") {
  for (const CubicPattern& pattern : {CubicPattern{true, true, false}, {true, true, true}}) {
    const Specimen specimen = lattice({4, 5, 6}, pattern);
    CHECK(relative_difference(homogenise(specimen, "lattice"), isotropic(specimen.material)) < 1e-10);
  }
}

TEST_CASE("fitted springs are the isotropic stiffness on a jittered mesh, where one factor is not",
          "[material][fitted][slow]") {
  struct Case {
    const char* rule;
    double poissons_ratio;
  };
  for (const auto& [rule, nu] : {Case{"uniform", 0.25}, {"van_gelder", 0.25}, {"standard+volume", 0.35}}) {
    const Specimen specimen = jittered_specimen(BlockKind::body_centred, nu, 1e4, 4);
    CAPTURE(rule);
    constexpr double met = 2e-3;  // each modulus is fitted to 1e-3, and differs by more between two kinds of tests
    const Run fitted = homogenise(specimen, std::string("fitted:") + rule);
    CHECK(relative_difference(fitted, isotropic(specimen.material)) < met);
    CHECK(relative_difference(homogenise(specimen, std::string("calibrated:") + rule), isotropic(specimen.material)) >
          20 * met);
    CHECK(fitted.constants.minCoeff() >= 0);
    CHECK(fitted.warnings.empty());
    for (const int axis : {0, 1, 2}) {
      TensionSetup setup;
      setup.axis = Vector3::Unit(axis);
      setup.displacement = 1e-9;
      const Run pulled =
          solve(specimen, *make_tension(specimen.body, setup), std::string("fitted:") + rule, {.linear = true});
      CHECK(pulled.measures.get("effective_modulus") == Approx(1e4).epsilon(met));
      CHECK(pulled.measures.get("poissons_ratio") == Approx(nu).margin(0.02));  // at mid height, not of the whole
    }
  }
}

TEST_CASE("a turned body has the same fitted springs, whether it is a box or not", "[material][fitted]") {
  const Catalog catalog = built_in_catalog();
  const auto tapered = [] {
    Body body = jittered_block();
    for (int molecule = 0; molecule < body.size(); ++molecule)
      body.rest.col(molecule).tail<2>() *= 1 + 20 * body.rest(0, molecule);
    set_present_lengths(body);
    return body;
  };
  struct Case {
    Body body;
    const char* rule;
    double angle;
    Vector3 axis;
  };
  const Vector3 askew = Vector3(1, 2, 3).normalized();
  for (const auto& [given, rule, angle, axis] :
       {Case{jittered_block(), "van_gelder", EIGEN_PI / 180, Vector3::UnitZ()},
        {tapered(), "patch", 0.9, askew},
        {lattice({4, 3, 3}, {true, true, true}).body, "standard", 0.9, askew}}) {
    CAPTURE(rule);
    const Strategy fitted = catalog.find(std::string("fitted:") + rule);
    Body turned = given;
    rotate(turned, Eigen::AngleAxisd(angle, axis).toRotationMatrix());
    const VectorX upright = fitted.fit(given, {1e4}, {}).constants, constants = fitted.fit(turned, {1e4}, {}).constants;
    CHECK((constants - upright).norm() < 1e-6 * upright.norm());
  }
}

TEST_CASE("springs alone that are fitted to any other Poisson's ratio say what Cauchy's leaves", "[material][fitted]") {
  // E is met with nu = 1/4, G is E / 2.5 in place of E / (2 (1 + nu)): (1 + 0.4) / 1.25 - 1 = 12 % too stiff.
  Specimen specimen = lattice({4, 5, 6}, {true, true, false});
  specimen.material.poissons_ratio = 0.4;
  const Run run = homogenise(specimen, "fitted:uniform");
  REQUIRE(run.warnings.size() == 1);
  CHECK_THAT(run.warnings[0], Catch::Contains("Poisson's ratio 0.25 (Cauchy), not 0.4") &&
                                  Catch::Contains("G +12.0 %") && Catch::Contains("fitted:uniform+volume"));
  specimen.material.poissons_ratio = 0.25;
  CHECK(relative_difference(run, isotropic(specimen.material)) < 2e-3);
  // What the fit itself leaves comes first: tables show the words before a semicolon alone.
  Specimen cell;
  cell.material = {.youngs_modulus = 1e4, .poissons_ratio = 0.4};
  cell.body = tetrahedral_block(BlockKind::kuhn, {1, 1, 1}, {0.01, 0.01, 0.01});
  set_matter(cell.body, 0.005, 1000, 0, 0);
  const Run left = homogenise(cell, "fitted:van_gelder");
  REQUIRE(left.warnings.size() == 1);
  CHECK_THAT(left.warnings[0],
             Catch::StartsWith("the fit leaves off: E along x, y, z") && Catch::Contains("; springs alone have"));
  const Specimen loose = lattice({3, 3, 3}, {true, false, false});
  const Catalog catalog = built_in_catalog();
  const Run mechanism = run_strategy(loose, *make_homogenisation(loose.body, {0}, Matrix3::Identity()),
                                     choose_strategy(catalog, "fitted:standard"), {});
  CHECK_FALSE(mechanism.suited);
  CHECK_THAT(mechanism.cause, Catch::Contains("'fitted:standard' on this body") && Catch::Contains("no modulus"));
}

TEST_CASE("a cubic lattice of equal rules has the closed form of its sums", "[material]") {
  // C = 1/V sum k L² n n n n over the connections; a finite cube of c cells a side has them (1 + 1/c)² (axes), (1 +
  // 1/c) (face diagonals) and 1 times as often a cell as the infinite lattice. standard: k = E h²/L for a spacing of h.
  for (const bool space : {false, true}) {
    constexpr int c = 4;
    const double h = 0.01, E = 1e4, once = 1 + 1. / c;
    const double k1 = E * h * once * once, k2 = E * h / std::sqrt(2) * once, k3 = space ? E * h / std::sqrt(3) : 0;
    const double c11 = (k1 + 2 * k2 + 4. / 3 * k3) / h, c12 = (k2 + 4. / 3 * k3) / h;
    const Run run = homogenise(lattice({c + 1, c + 1, c + 1}, {true, true, space}), "standard");
    INFO((space ? "with" : "without") << " space diagonals");
    CHECK(relative_difference(run, cubic(c11, c12, c12)) < 1e-10);  // Cauchy: C44 = C12
    CHECK(run.measures.get("anisotropy_index") == Approx(cubic_index(2 * c12 / (c11 - c12))).epsilon(1e-8));
    // The closed form along an axis, from the same sums: E100 = (k1 + k2)(k1 + 4 k2 + 4 k3)/(h (k1 + 3 k2 + 8 k3/3)).
    const double along = (k1 + k2) * (k1 + 4 * k2 + 4 * k3) / (h * (k1 + 3 * k2 + 8 * k3 / 3));
    CHECK(run.measures.get("youngs_modulus_z") == Approx(along).epsilon(1e-10));
    CHECK(run.measures.get("patch_residual") < 1e-12);  // every inner molecule is a centre of symmetry
  }
}

TEST_CASE("the stiffness turns with the axes, and scales with E", "[material][invariance]") {
  Specimen specimen = lattice({4, 4, 4}, {true, true, false});
  add_jitter(specimen.body, 0.001, 4);
  const Run straight = homogenise(specimen, "standard");
  CHECK(straight.measures.get("patch_residual") > 1e-3);  // springs on a jittered body fail the patch test
  const Matrix3 turn = Eigen::AngleAxisd(0.8, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  Specimen turned = specimen;
  rotate(turned.body, turn);
  CHECK(relative_difference(homogenise(turned, "standard", turn), *straight.measures.stiffness_matrix) < 1e-10);
  Specimen stiff = specimen;
  stiff.material.youngs_modulus *= 4;
  CHECK(relative_difference(homogenise(stiff, "standard"), 4 * *straight.measures.stiffness_matrix) < 1e-10);
}

TEST_CASE("calibrated gives Hill's mean of the material", "[material]") {
  Specimen specimen = lattice({4, 4, 4}, {true, true, true});
  add_jitter(specimen.body, 0.0015, 4);
  for (const char* rule : {"calibrated:standard", "calibrated:angles"}) {
    const Run run = homogenise(specimen, rule);
    CHECK(run.measures.get("effective_modulus") == Approx(1e4).epsilon(1e-9));
    CHECK(run.measures.get("patch_residual") > 1e-3);
  }
}

TEST_CASE("a body without shear stiffness has a stiffness matrix and no moduli", "[material]") {
  const Run run = homogenise(lattice({4, 4, 4}, {true, false, false}), "standard");
  CHECK(relative_difference(run, cubic(1e4 * 16 / 9, 0, 0)) < 1e-10);
  CHECK(std::isnan(run.measures.get("effective_modulus")));
  CHECK_THAT(run.remark, Catch::Contains("singular"));
}

TEST_CASE("what has no volume has no stiffness matrix", "[material]") {
  CHECK_THROWS_AS(make_homogenisation(cubic_lattice({4, 4, 1}, 1, {true, true, false}), {0}, Matrix3::Identity()),
                  InputError);
  Body membrane = cubic_lattice({2, 2, 1}, 1, {true, true, false});
  membrane.triangles = {{0, 1, 2}, {1, 3, 2}};
  CHECK_THROWS_WITH(make_homogenisation(membrane, {0}, Matrix3::Identity()), Catch::Contains("membrane"));
}

TEST_CASE("a body whose sides curve shows its material all the same", "[material]") {
  for (const char* kind : {"hexahedron20", "hexahedron27", "tetrahedron10"}) {
    Specimen specimen;
    specimen.material = {.youngs_modulus = 9e4, .poissons_ratio = 0.3};
    specimen.body = cell_box(cell_kind(kind), {2, 2, 2}, {2, 2, 2}, 0);
    for (int molecule = 0; molecule < specimen.body.size(); ++molecule) {  // a square grid bent to a disc
      const double x = specimen.body.rest(0, molecule) - 1, y = specimen.body.rest(1, molecule) - 1;
      specimen.body.rest(0, molecule) = 0.01 * x * std::sqrt(1 - y * y / 2);
      specimen.body.rest(1, molecule) = 0.01 * y * std::sqrt(1 - x * x / 2);
      specimen.body.rest(2, molecule) *= 0.01;
    }
    set_simplices(specimen.body);
    INFO(kind);
    // Four points do not integrate what curved tetrahedra pass on to their nodes, so that inner ones move.
    const double passed_on = kind == std::string("tetrahedron10") ? 1e-6 : 1e-8;
    CHECK(relative_difference(homogenise(specimen, "st_venant_kirchhoff"), isotropic(specimen.material)) < passed_on);
  }
}
