// Whole bodies of st_venant_kirchhoff and neo_hookean against finite elements and closed forms written here
// independently: nothing below uses lengths, force densities or the laws' own formulas.

#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/forces/model.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "lab/experiment/tension/tension.h"
#include "lab/run/specimen.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::lab;
using namespace elastin::testing;

namespace {

const Catalog kCatalog = built_in_catalog();
constexpr double kModulus = 5000;

Material material_of(double nu) {
  Material material;
  material.youngs_modulus = kModulus;
  material.poissons_ratio = nu;
  return material;
}

Body jittered(BlockKind kind) {
  Body body = tetrahedral_block(kind, {3, 3, 3}, {0.03, 0.03, 0.03});
  add_jitter(body, 0.0015, 5);
  set_matter(body, 0.003, 1000, 0, 0);
  REQUIRE(flat_or_inverted_cells(body, body.rest).empty());
  return body;
}

Model model_of(const Body& body, const std::string& law, double nu) {
  Model model(body);
  model.add(kCatalog.find(law).make(body, material_of(nu), {}));
  return model;
}

/// First Piola–Kirchhoff stress [Pa], by the derivative of the energy density with respect to F:
/// St Venant–Kirchhoff ½ λ (tr E)² + μ E : E; neo-Hookean ½ μ (F : F − 3) − μ ln J + ½ λ (J − 1)².
Matrix3 first_stress(const std::string& law, const Matrix3& F, double nu) {
  const double lambda = kModulus * nu / ((1 + nu) * (1 - 2 * nu)), mu = kModulus / (2 * (1 + nu));
  if (law == "st_venant_kirchhoff") {
    const Matrix3 strain = 0.5 * (F.transpose() * F - Matrix3::Identity());
    return F * (lambda * strain.trace() * Matrix3::Identity() + 2 * mu * strain);
  }
  const Matrix3 turned = F.inverse().transpose();
  const double J = F.determinant();
  return mu * (F - turned) + lambda * J * (J - 1) * turned;
}

/// Forces of linear tetrahedra [N]: −V P ∇N_a summed over the cells, ∇N by cross products of the cell's sides.
Positions finite_element_forces(const Body& body, const Positions& positions, const std::string& law, double nu) {
  Positions forces = Positions::Zero(3, body.size());
  for (const auto& cell : body.tetrahedra) {
    Eigen::Matrix<double, 3, 4> gradient;
    double six_volumes = 0;
    for (int a = 0; a < 4; ++a) {
      const Vector3 b = body.rest.col(cell[(a + 1) % 4]), c = body.rest.col(cell[(a + 2) % 4]),
                    d = body.rest.col(cell[(a + 3) % 4]);
      const Vector3 area = (c - b).cross(d - b);
      six_volumes = area.dot(body.rest.col(cell[a]) - b);  // N_a is 0 on face bcd and 1 in a
      gradient.col(a) = area / six_volumes;
    }
    Matrix3 F = Matrix3::Zero();
    for (int a = 0; a < 4; ++a) F += positions.col(cell[a]) * gradient.col(a).transpose();
    const Matrix3 P = first_stress(law, F, nu);
    for (int a = 0; a < 4; ++a) forces.col(cell[a]) -= std::abs(six_volumes) / 6 * P * gradient.col(a);
  }
  return forces;
}

std::vector<int> on_the_surface(const Body& body) {
  std::vector<int> molecules;
  const Vector3 low = body.rest.rowwise().minCoeff(), high = body.rest.rowwise().maxCoeff();
  for (int molecule = 0; molecule < body.size(); ++molecule)
    if ((body.rest.col(molecule) - low).minCoeff() < 1e-9 || (high - body.rest.col(molecule)).minCoeff() < 1e-9)
      molecules.push_back(molecule);
  return molecules;
}

/// A stretch of 10 to 40 %, sheared and turned.
Matrix3 finite_map() {
  Matrix3 F;
  F << 1.3, 0.2, -0.1, 0.05, 0.8, 0.15, -0.2, 0.1, 1.1;
  return F;
}

/// Square of the lateral stretch of a bar of the law at stretch l under no lateral stress, found by halving.
double lateral_square(const std::string& law, double nu, double stretch) {
  double low = 1e-9, high = 100;
  for (int halving = 0; halving < 200; ++halving) {
    const double middle = (low + high) / 2, lateral = std::sqrt(middle);
    (first_stress(law, Vector3(lateral, lateral, stretch).asDiagonal(), nu)(0, 0) < 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

TEST_CASE("a body of cells has the forces of finite elements to 1e-12", "[cell_law]") {
  const std::string law = GENERATE("st_venant_kirchhoff", "neo_hookean");
  const BlockKind kind = GENERATE(BlockKind::kuhn, BlockKind::alternating, BlockKind::body_centred);
  const double nu = GENERATE(0., 0.3, 0.45);
  const Body body = jittered(kind);
  const Positions positions = deformed(body, 0.0005);
  REQUIRE(flat_or_inverted_cells(body, positions).empty());
  const Positions expected = finite_element_forces(body, positions, law, nu);
  const Positions here = model_of(body, law, nu).elastic_forces(positions);
  CHECK((here - expected).norm() < 1e-12 * expected.norm());
}

TEST_CASE("jittered cells pass the patch test to rounding", "[cell_law]") {
  const std::string law = GENERATE("st_venant_kirchhoff", "neo_hookean");
  const BlockKind kind = GENERATE(BlockKind::kuhn, BlockKind::alternating, BlockKind::body_centred);
  const double nu = GENERATE(0.3, 0.45);
  const Body body = jittered(kind);
  Model model = model_of(body, law, nu);
  const Positions affine = finite_map() * body.rest;

  // In the affine state no molecule inside is pulled.
  Positions forces = model.elastic_forces(affine);
  const double scale = forces.norm();
  const std::vector<int> surface = on_the_surface(body);
  for (const int molecule : surface) forces.col(molecule).setZero();
  CHECK(forces.norm() < 1e-13 * scale);

  // And with the surface held there, the inside finds it. First order: the same under small displacements.
  for (const bool linear : {false, true}) {
    Model held = model_of(body, law, nu);
    for (const int molecule : surface)
      held.supports.push_back({molecule, Matrix3::Zero(), affine.col(molecule) - body.rest.col(molecule)});
    State state = state_at_rest(body);
    const StaticResult solved = solve_static(held, state, {.linear = linear, .tolerance = 1e-13});
    INFO(law << ", linear " << linear << ": " << solved.cause << " residual " << solved.residual);
    CHECK(solved.outcome == Outcome::converged);
    CHECK((state.positions - affine).cwiseAbs().maxCoeff() < 1e-12 * 0.03 / 1e-2);  // a hundredth of a residual's size
  }
}

TEST_CASE("an affine body follows the uniaxial curves of its law to 1e-10", "[cell_law]") {
  const std::string law = GENERATE("st_venant_kirchhoff", "neo_hookean");
  const double nu = GENERATE(0.3, 0.45);
  const double stretch = GENERATE(0.2, 0.35, 0.5, 0.8, 0.95, 1.05, 1.2, 1.5, 2., 3., 4., 5.);
  // No lateral stress in St Venant–Kirchhoff is E_11 = −ν E_33: from l² = 1 + 1/ν on the bar has no width left.
  if (law == "st_venant_kirchhoff" && stretch * stretch >= 1 + 1 / nu) return;
  const double square = lateral_square(law, nu, stretch);
  const double lambda = kModulus * nu / ((1 + nu) * (1 - 2 * nu)), mu = kModulus / (2 * (1 + nu));
  // Closed forms: 1 − ν (l² − 1), and the root of λ l² y² + (μ − λ l) y − μ = 0.
  const double b = mu - lambda * stretch, a = lambda * stretch * stretch;
  const double closed =
      law == "neo_hookean" ? (-b + std::sqrt(b * b + 4 * a * mu)) / (2 * a) : 1 - nu * (stretch * stretch - 1);
  CHECK(square == Approx(closed).epsilon(1e-12));
  const double nominal = law == "neo_hookean" ? mu * (stretch - 1 / stretch) + lambda * closed * (stretch * closed - 1)
                                              : kModulus * stretch * (stretch * stretch - 1) / 2;

  const Body body = jittered(BlockKind::body_centred);
  const double lateral = std::sqrt(square);
  const Positions positions = Vector3(lateral, lateral, stretch).asDiagonal() * body.rest;
  const Positions forces = model_of(body, law, nu).elastic_forces(positions);
  // Across the end face goes area times nominal stress; across the side face nothing.
  Vector3 side = Vector3::Zero(), end = Vector3::Zero();
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    if (body.rest(0, molecule) > 0.03 - 1e-9) side += forces.col(molecule);
    if (body.rest(2, molecule) > 0.03 - 1e-9) end += forces.col(molecule);
  }
  const double area = 9e-4, size = std::abs(nominal) * area;
  CHECK(std::abs(-end.z() - nominal * area) < 1e-10 * size);
  CHECK(end.head<2>().norm() < 1e-10 * size);
  CHECK(side.head<2>().norm() < 1e-10 * std::max(size, kModulus * area * std::abs(stretch - 1)));
}

TEST_CASE("a bar solved from rest follows the uniaxial curve of its law", "[cell_law][tension]") {
  const double nu = GENERATE(0.3, 0.45);
  const double stretch = GENERATE(0.6, 5.);  // pressed further, a bar of this law is not stable
  Specimen specimen{jittered(BlockKind::body_centred), material_of(nu), {}};
  TensionSetup setup;
  setup.displacement = 0.03 * (stretch - 1);
  setup.load_steps = 8;
  const auto experiment = make_tension(specimen.body, setup);
  const Run run = run_strategy(specimen, *experiment, choose_strategy(kCatalog, "neo_hookean"), {});
  INFO(run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  for (const CurvePoint& point : run.curve) {
    const double l = 1 + point.measures.get("strain"), y = lateral_square("neo_hookean", nu, l), w = std::sqrt(y);
    const Matrix3 P = first_stress("neo_hookean", Vector3(w, w, l).asDiagonal(), nu);
    CHECK(point.measures.get("stress") == Approx(P(2, 2)).epsilon(1e-9));  // the solver stops at 1e-10
    CHECK(std::abs(point.measures.get("lateral_strain") - (w - 1)) < 1e-8);
  }
}
