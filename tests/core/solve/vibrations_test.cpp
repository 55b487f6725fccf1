#include "elastin/core/solve/vibrations.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/base/dense.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

Model model_of(const Body& body, const std::string& strategy, const Material& material) {
  static const Catalog catalog = built_in_catalog();
  Model model(body);
  model.add(catalog.find(strategy).make(body, material, {}));
  return model;
}

/// The whole eigenproblem, assembled by unit motions: frequencies [Hz] above the zero ones.
VectorX dense_frequencies(Model& model, int skipped) {
  const State state = state_at_rest(model.body());
  const Tangent tangent(model, state);
  const Eigen::Index size = 3 * model.body().size();
  Eigen::MatrixXd stiffness(size, size);
  Positions motion(3, model.body().size()), force = motion;
  for (Eigen::Index c = 0; c < size; ++c) {
    motion.setZero();
    motion.reshaped()[c] = 1;
    tangent.apply(motion, force);
    stiffness.col(c) = force.reshaped();
  }
  const VectorX root = model.body().mass.transpose().replicate(3, 1).reshaped().cwiseSqrt();
  const VectorX inverse = root.cwiseInverse();
  const Eigen::MatrixXd scaled = inverse.asDiagonal() * stiffness * inverse.asDiagonal();
  const VectorX values = symmetric_eigenvalues(scaled);
  return values.tail(size - skipped).cwiseSqrt() / (2 * M_PI);
}

}  // namespace

TEST_CASE("a chain of springs has the frequencies of the textbook", "[vibrations]") {
  // n masses between two held ends, along the chain: 2 √(k/m) sin(j π / (2 (n + 1))).
  constexpr int inner = 7;
  std::vector<Vector3> positions;
  std::vector<std::array<int, 2>> pairs;
  for (int i = 0; i < inner + 2; ++i) positions.emplace_back(0.1 * i, 0, 0);
  for (int i = 0; i <= inner; ++i) pairs.push_back({i, i + 1});
  Body body = listed_body(positions, pairs);
  set_matter(body, 0.01, 1000, 0, 1);
  body.mass.setConstant(0.2);
  Model model(body);
  model.add(make_springs(body, VectorX::Constant(inner + 1, 30.)));
  const Matrix3 along = Vector3::UnitX() * Vector3::UnitX().transpose();
  for (int i = 0; i < inner + 2; ++i)
    model.supports.push_back({i, i == 0 || i == inner + 1 ? Matrix3(Matrix3::Zero()) : along});
  const Vibrations found = find_vibrations(model, state_at_rest(body), 20);
  CHECK(found.rigid_motions == 0);
  REQUIRE(found.frequencies.size() == inner);  // no more than it has
  for (int j = 1; j <= inner; ++j)
    CHECK(found.frequencies[j - 1] ==
          Approx(std::sqrt(30 / 0.2) / M_PI * std::sin(j * M_PI / (2 * (inner + 1)))).epsilon(1e-10));
}

TEST_CASE("blocks of conjugate gradients find what the whole eigenproblem has", "[vibrations]") {
  Body body = tetrahedral_block(BlockKind::body_centred, {6, 3, 3}, {0.06, 0.03, 0.03});
  set_matter(body, 0.002, 1000, 0, 0);
  const Material material{.youngs_modulus = 1e4, .poissons_ratio = 0.35};
  REQUIRE(3 * body.size() > 450);  // else it would be solved as a whole, too
  Model model = model_of(body, "neo_hookean", material);
  const Vibrations found = find_vibrations(model, state_at_rest(body), 8);
  REQUIRE(found.outcome == Outcome::converged);
  CHECK(found.rigid_motions == 6);
  const VectorX all = dense_frequencies(model, 6);
  for (int k = 0; k < 8; ++k) {
    CHECK(found.frequencies[k] == Approx(all[k]).epsilon(1e-7));
    // Unit modal mass, and none moves as a whole.
    const Positions& shape = found.shapes[k];
    CHECK((shape.cwiseAbs2() * body.mass).sum() == Approx(1));
    CHECK((shape * body.mass).norm() < 1e-9 * body.mass.sum() * shape.norm());
  }
}

TEST_CASE("supports leave as many rigid motions as they must", "[vibrations]") {
  Body body = tetrahedral_block(BlockKind::kuhn, {3, 2, 2}, {0.03, 0.02, 0.02});
  set_matter(body, 0.002, 1000, 0, 0);
  Model model = model_of(body, "neo_hookean", {.youngs_modulus = 1e4, .poissons_ratio = 0.3});
  const Matrix3 plane = Matrix3::Identity() - Vector3::UnitX() * Vector3::UnitX().transpose();
  for (int i = 0; i < body.size(); ++i)
    if (body.rest(0, i) < 1e-9) model.supports.push_back({i, plane});
  CHECK(find_vibrations(model, state_at_rest(body), 3).rigid_motions == 3);  // two ways in the plane and a turn in it
  model.supports = {{0, Matrix3::Zero()}};
  CHECK(find_vibrations(model, state_at_rest(body), 3).rigid_motions == 3);  // the turns about the point
  model.supports.clear();
  CHECK(find_vibrations(model, state_at_rest(body), 3).rigid_motions == 6);
}

TEST_CASE("pieces that nothing joins move as wholes, each by itself", "[vibrations]") {
  Body body = tetrahedral_block(BlockKind::body_centred, {3, 3, 3}, {0.03, 0.03, 0.03});
  Body other = tetrahedral_block(BlockKind::body_centred, {5, 3, 2}, {0.05, 0.03, 0.02});
  other.rest.row(0).array() += 0.1;
  for (Body* piece : {&body, &other}) set_matter(*piece, 0.002, 1000, 0, 0);
  Part whole;
  whole.name = "other";
  add_part(body, other, whole);
  REQUIRE(3 * body.size() > 450);
  body.parts.clear();
  Model model = model_of(body, "neo_hookean", {.youngs_modulus = 1e4, .poissons_ratio = 0.35});
  const Vibrations found = find_vibrations(model, state_at_rest(body), 5);
  REQUIRE(found.outcome == Outcome::converged);
  CHECK(found.rigid_motions == 12);
  const VectorX all = dense_frequencies(model, 12);
  for (int k = 0; k < 5; ++k) CHECK(found.frequencies[k] == Approx(all[k]).epsilon(1e-7));
}

TEST_CASE("frequencies of a mechanism are zero, and its own", "[vibrations]") {
  Body body = cubic_lattice({2, 2, 2}, 0.01, {true, false, false});  // a cube of bars falls over in six ways
  set_matter(body, 0.005, 1000, 0, 1e-6);
  Model model(body);
  model.add(make_springs(body, VectorX::Constant(body.connections.size(), 10.)));
  const Vibrations found = find_vibrations(model, state_at_rest(body), 8);
  CHECK(found.rigid_motions == 6);
  for (int k = 0; k < 6; ++k) CHECK(found.frequencies[k] < 1e-3);
  CHECK(found.frequencies[6] > 1);
}
