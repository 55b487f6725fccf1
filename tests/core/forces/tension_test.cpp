#include "elastin/core/forces/tension.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/shapes/surfaces.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/shapes/shapes.h"
#include "elastin/core/simulation/parts.h"
#include "elastin/core/solve/statics.h"
#include "lab/run/specimen.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

/// A sheet of 0.2 × 0.1 m whose rim is sheared by γ along x: displacement = γ y.
struct Sheared {
  Body body = rectangular_sheet({0.2, 0.1}, {8, 4}, SheetPattern::alternating);
  Material material{.youngs_modulus = 1e6, .poissons_ratio = 0.3, .thickness = 1e-4};
  State state;
  StaticResult solved;
  std::unique_ptr<Model> model;

  Sheared(const std::string& strategy, double shear) {
    set_matter(body, 0.001, 1000, material.thickness, 0);
    model = std::make_unique<Model>(body);
    model->add(choose_strategy(built_in_catalog(), strategy).strategy.make(body, material, {}));
    Matrix3 in_plane = Matrix3::Identity();
    in_plane(2, 2) = 0;
    for (int i = 0; i < body.size(); ++i) {
      const double x = body.rest(0, i), y = body.rest(1, i);
      const bool rim = std::min({x, y, 0.2 - x, 0.1 - y}) < 1e-9;
      model->supports.push_back({i, rim ? Matrix3(Matrix3::Zero()) : in_plane, Vector3(shear * y, 0, 0)});
    }
    state = state_at_rest(body);
    solved = solve_static(*model, state, {});
    INFO(solved.cause);
    REQUIRE(solved.outcome == Outcome::converged);
  }
};

Matrix3 sheared_by(double shear) {
  Matrix3 F = Matrix3::Identity();
  F(0, 1) = shear;
  return F;
}

}  // namespace

TEST_CASE("a sheared sheet that wrinkles is a tension field", "[wrinkling]") {
  // Uniaxial: S = E (λ₁² − 1)/2 n nᵀ along the longest stretch λ₁, whatever Poisson's ratio; the true tension is
  // t F S Fᵀ / J, here J = 1.
  const double shear = GENERATE(0.002, 0.1, 0.4);
  const Sheared wrinkled("st_venant_kirchhoff_membrane+wrinkling", shear);
  const Matrix3 F = sheared_by(shear);
  const Eigen::SelfAdjointEigenSolver<Matrix3> C(F.transpose() * F);
  const Vector3 n = C.eigenvectors().col(2);
  const Matrix3 expected = 1e6 * 1e-4 * (C.eigenvalues()[2] - 1) / 2 * (F * n) * (F * n).transpose();
  for (const Matrix3& tension : triangle_tensions(*wrinkled.model, wrinkled.state.positions))
    CHECK((tension - expected).norm() <= 1e-7 * expected.norm());
  CHECK(find_compression(*wrinkled.model, wrinkled.state.positions).triangles == 0);
  // At small shear the tension field has E/4 where the sheet that bears compression has E/(2 (1 + ν)).
  if (shear == 0.002) CHECK(expected(0, 1) == Approx(1e6 * 1e-4 * shear / 4).epsilon(0.005));
}

TEST_CASE("compression that a membrane bears is found and named", "[wrinkling]") {
  const Sheared plain("st_venant_kirchhoff_membrane", 0.1);
  const Compression found = find_compression(*plain.model, plain.state.positions);
  CHECK(found.triangles == 64);
  // Shear stress G γ, less what the stretch of second order pulls; per length t of it.
  CHECK(found.tension < -0.8 * 1e-4 * 1e6 / 2.6 * 0.1);
  CHECK(found.tension > -1.0 * 1e-4 * 1e6 / 2.6 * 0.1);
}

TEST_CASE("a sheet in plain tension is not in compression by what its mesh misses", "[wrinkling]") {
  // Of two tensions across each other one is none, but for a rounding of 3e-4 of the other, as of a coarse mesh.
  for (const auto& [rounding, pressed] : {std::pair{3e-4, 0}, {3e-3, 64}}) {
    Sheared sheet("st_venant_kirchhoff_membrane", 0);
    const Matrix3 stretch = Vector3(1.01, 1 - 0.00302 - rounding * 0.01, 1).asDiagonal();
    const Positions stretched = stretch * sheet.body.rest;
    CHECK(find_compression(*sheet.model, stretched).triangles == pressed);
  }
}

TEST_CASE("a membrane that relaxes has the law's tension in each triangle, times what is left", "[wrinkling][prony]") {
  // Strains vary from triangle to triangle, so that shares of connections would be wrong.
  Material material{.youngs_modulus = 1e6, .poissons_ratio = 0.3, .thickness = 1e-4};
  material.relaxation = Relaxation{{{0.3, 1}}};
  Body sheet = rectangular_sheet({0.2, 0.1}, {4, 2}, SheetPattern::crossed);
  set_matter(sheet, 0.001, 1000, material.thickness, 0);
  Positions positions = sheet.rest;
  for (int i = 0; i < sheet.size(); ++i)
    positions.col(i) += Vector3(0.3 * positions(0, i) + positions(1, i) * positions(1, i), -0.05 * positions(1, i), 0);
  for (const std::string law : {"neo_hookean_membrane", "neo_hookean_membrane+wrinkling"}) {
    Model plain(sheet), relaxing(sheet);
    plain.add(choose_strategy(built_in_catalog(), law).strategy.make(sheet, material, {}));
    relaxing.add(choose_strategy(built_in_catalog(), "prony:" + law).strategy.make(sheet, material, {}));
    const std::vector<Matrix3> elastic = triangle_tensions(plain, positions);
    State state = state_at_rest(sheet);
    relaxing.declare_history(state);
    const auto check = [&](double factor) {
      const std::vector<Matrix3> found = triangle_tensions(relaxing, positions);
      for (std::size_t cell = 0; cell < found.size(); ++cell)
        CHECK((found[cell] - factor * elastic[cell]).norm() <= 1e-6 * elastic[cell].norm());
    };
    relaxing.begin_step(state, std::numeric_limits<double>::infinity());
    check(1);
    relaxing.commit_step(state);
    relaxing.begin_step(state, 1e-9);
    check(1.3);
    state.positions = positions, state.time = 1e-9;
    relaxing.commit_step(state);
    relaxing.begin_step(state, 0.5);
    check(1 + 0.3 * std::exp(-0.5));
  }
}

TEST_CASE("springs share their forces among triangles: the mean tension is right", "[wrinkling]") {
  const Sheared springs("van_gelder", 0.01);
  const auto tensions = triangle_tensions(*springs.model, springs.state.positions);
  Matrix3 virial = Matrix3::Zero(), sum = Matrix3::Zero();
  const VectorX q = springs.model->force_densities(springs.state.positions);
  const auto& ends = springs.body.connections.ends;
  for (std::size_t c = 0; c < ends.size(); ++c) {
    const Vector3 d = springs.state.positions.col(ends[c][1]) - springs.state.positions.col(ends[c][0]);
    virial += q[static_cast<Eigen::Index>(c)] * d * d.transpose();
  }
  for (std::size_t cell = 0; cell < tensions.size(); ++cell)
    sum += tensions[cell] * area_vector(springs.state.positions, springs.body.triangles[cell]).norm();
  CHECK((sum - virial).norm() <= 1e-12 * virial.norm());
}

TEST_CASE("each triangle of a body of several parts has its own tension, as if its part were alone", "[wrinkling]") {
  // The parts' strains vary from triangle to triangle, so that shares of connections would be wrong.
  const Material material{.youngs_modulus = 1e6, .poissons_ratio = 0.3, .thickness = 1e-4};
  Body sheet = rectangular_sheet({0.2, 0.1}, {4, 2}, SheetPattern::alternating), whole;
  set_matter(sheet, 0.001, 1000, material.thickness, 0);
  for (const char* name : {"left", "right"}) {
    Part part;
    part.name = name;
    add_part(whole, sheet, part);
    sheet.rest.row(0).array() += 1;
  }
  Positions positions = whole.rest;
  for (int i = 0; i < whole.size(); ++i)
    positions.col(i) += Vector3(0.3 * positions(1, i) * positions(1, i), 0.02 * positions(0, i) * positions(1, i), 0);
  const Strategy strategy = choose_strategy(built_in_catalog(), "neo_hookean_membrane").strategy;
  Model together(whole);
  together.add(in_parts(strategy, whole, {material}).make(whole, material, {}));
  const std::vector<Matrix3> found = triangle_tensions(together, positions);
  const std::size_t triangles = sheet.triangles.size();
  REQUIRE(found.size() == 2 * triangles);
  for (const Part& part : whole.parts) {
    const PartAlone alone = part_alone(whole, part);
    Model model(alone.body);
    model.add(strategy.make(alone.body, material, {}));
    const auto expected = triangle_tensions(model, positions.middleCols(part.first, part.count));
    for (std::size_t cell = 0; cell < triangles; ++cell) {
      const Matrix3& own = found[cell + static_cast<std::size_t>(part.triangles.first)];
      CHECK((own - expected[cell]).norm() <= 1e-12 * expected[cell].norm());
    }
  }
}
