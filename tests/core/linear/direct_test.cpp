#include <Eigen/SparseCholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/linear/sparse_factor.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

constexpr double kLength = 0.06, kWidth = 0.015;  // m

/// A bar along z of cells moved by 5 % of their size at random, its upper half `contrast` times as stiff.
Body bar(BlockKind kind, double contrast) {
  Body body = tetrahedral_block(kind, {3, 3, 12}, {kWidth, kWidth, kLength});
  add_jitter(body, 0.05 * kWidth / 3, 1);
  set_matter(body, 0.002, 1000, 0, 0);
  set_region(body, {0, 0, kLength / 2}, {kWidth, kWidth, kLength}, contrast, 1);
  return body;
}

/// The bar's lower end on rollers, its upper end pulled by `force` [N], its molecules alike; with no stiffness across
/// there is nothing to hold but the bar as a whole.
struct Pulled {
  Pulled(const Body& a_body, double force, const Material& material) : body(a_body), model(body) {
    model.add(built_in_catalog().find("st_venant_kirchhoff").make(body, material, {}));
    std::vector<int> top;
    for (int i = 0; i < body.size(); ++i) {
      if (body.rest(2, i) == 0) model.supports.push_back({i, Matrix3(Eigen::Vector3d(1, 1, 0).asDiagonal())});
      if (body.rest(2, i) > kLength * (1 - 1e-9)) top.push_back(i);
    }
    model.supports[0].free.setZero();
    for (Support& support : model.supports)
      if (support.molecule != model.supports[0].molecule &&
          body.rest(1, support.molecule) == body.rest(1, model.supports[0].molecule))
        support.free = Vector3::UnitX() * Vector3::UnitX().transpose();
    const auto count = static_cast<Eigen::Index>(top.size());
    Positions forces = Positions::Zero(3, count);
    forces.row(2).setConstant(force / static_cast<double>(count));
    model.add(std::make_unique<PointLoads>(body, top, forces));
  }
  StaticResult solve(const LinearMethod& method, State& state) {
    state = state_at_rest(body);
    return solve_static(model, state, {.linear = true, .method = method});
  }
  double elongation(const State& state) const { return state.positions.row(2).maxCoeff() - kLength; }

  Body body;
  Model model;
};

}  // namespace

TEST_CASE("a factorisation solves a bar of soft and stiff halves and finds no mechanism in it", "[direct][slow]") {
  // F (L/2)/(A E) in the soft half; the stiff end keeps it from narrowing, and moved corners stiffen it, by some per
  // cent.
  const Material soft{.youngs_modulus = 1e4, .poissons_ratio = 0};
  const double force = 0.02, series = force * kLength / 2 / (kWidth * kWidth * 1e4);
  for (const BlockKind kind : {BlockKind::kuhn, BlockKind::body_centred})
    for (const double contrast : {1e5, 1e6, 1e8}) {
      CAPTURE(contrast);
      Pulled pulled(bar(kind, contrast), force, soft);
      State factorised, iterated;
      const StaticResult direct = pulled.solve("direct", factorised);
      INFO(direct.cause);
      REQUIRE(direct.outcome == Outcome::converged);
      // Positions of the stiff half round by 1e-16 of its stiffness: no solver leaves less.
      CHECK(direct.residual < 1e-14 * contrast + 1e-10);
      CHECK(pulled.elongation(factorised) == Approx(series).epsilon(0.06));
      if (contrast > 1e6) continue;
      REQUIRE(pulled.solve("pcg", iterated).residual < 1e-7);
      CHECK((factorised.positions - iterated.positions).norm() < 1e-5 * (iterated.positions - pulled.body.rest).norm());
    }
}

TEST_CASE("a factorisation still names a mechanism next to stiff parts", "[direct]") {
  // A molecule on one connection of its own, pushed across it: no row of it resists, however soft or stiff it is.
  const Material soft{.youngs_modulus = 1e4, .poissons_ratio = 0};
  for (const double constant : {1e-3, 1., 1e6}) {
    CAPTURE(constant);
    std::vector<Vector3> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}};
    Body body = listed_body(positions, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}, {3, 4}});
    set_matter(body, 0.1, 1000, 0, 1);
    Model model(body);
    VectorX constants = VectorX::Constant(7, 100);
    constants[6] = constant;
    model.add(make_springs(body, constants));
    model.supports = {{0}, {1, Vector3::UnitX() * Vector3::UnitX().transpose()}};
    model.supports.push_back({2, Matrix3(Eigen::Vector3d(1, 1, 0).asDiagonal())});
    model.add(std::make_unique<PointLoads>(body, std::vector<int>{4}, Positions(Vector3(1e-3, 0, 1e-3))));
    State state = state_at_rest(body);
    const StaticResult result = solve_static(model, state, {.linear = true, .method = "direct"});
    CHECK(result.outcome == Outcome::mechanism);
    CHECK(state.positions == body.rest);
  }
}

TEST_CASE("what a factorisation would take is what Eigen's factor holds", "[direct]") {
  std::mt19937 generator(7);
  for (const int blocks : {1, 40, 300}) {
    std::vector<std::array<int, 2>> pairs;
    std::uniform_int_distribution<int> any(0, blocks - 1);
    for (int pair = 0; pair < 2 * blocks; ++pair)
      if (const int a = any(generator), b = any(generator); a != b) pairs.push_back({a, b});
    Eigen::SparseMatrix<double> matrix(blocks, blocks);
    std::vector<Eigen::Triplet<double>> entries;
    for (int block = 0; block < blocks; ++block) entries.emplace_back(block, block, 100);
    for (const auto& [a, b] : pairs) entries.emplace_back(std::max(a, b), std::min(a, b), -1);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
    const Eigen::SparseMatrix<double> below = factor.matrixL().nestedExpression();
    double squares = 0;
    for (int column = 0; column < blocks; ++column) squares += std::pow(below.col(column).nonZeros(), 2);
    const FactorCost cost = factor_cost(blocks, pairs);
    CHECK(cost.numbers == 9. * static_cast<double>(below.nonZeros()));
    CHECK(cost.products == 27. / 2 * squares);
  }
}
