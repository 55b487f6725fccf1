// Cells of any shape: their functions, forces as pairs, patch tests, orders of convergence.

#include "elastin/core/forces/block_cells.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "core/model/block_geometry.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

const Material kSoft{.youngs_modulus = 2e4, .poissons_ratio = 0.3, .density = 1000, .thickness = 1e-3};

std::vector<const CellKind*> solid_kinds() {
  std::vector<const CellKind*> kinds;
  for (const CellKind& kind : cell_kinds())
    if (kind.dimensions == 3) kinds.push_back(&kind);
  return kinds;
}

double volume_of(const Body& body) {
  double sum = 0;
  for (const auto& cell : body.tetrahedra) sum += signed_volume(body.rest, cell);
  return sum;
}

/// Supports that hold the molecules on the surface of a box.
std::vector<Support> held_surface(const Body& body, const Vector3& size,
                                  const std::function<Vector3(const Vector3&)>& displacement) {
  std::vector<Support> supports;
  for (int a = 0; a < body.size(); ++a) {
    const Vector3 x = body.rest.col(a);
    const bool outside = (x.array().abs() < 1e-9).any() || ((x - size).array().abs() < 1e-9).any();
    if (outside) supports.push_back({.molecule = a, .displacement = displacement(x)});
  }
  return supports;
}

}  // namespace

TEST_CASE("shape functions: one at their node, none at the others, slopes by differences", "[cells][shapes]") {
  for (const CellKind& kind : cell_kinds()) {
    INFO(kind.name);
    for (int a = 0; a < kind.nodes; ++a) {
      VectorX unit = VectorX::Zero(kind.nodes);
      unit[a] = 1;
      CHECK((kind.functions(kind.reference.col(a)) - unit).norm() < 1e-14);
    }
    const VectorX at = VectorX::LinSpaced(kind.dimensions, 0.1, 0.3);
    CHECK(kind.functions(at).sum() == Approx(1).epsilon(1e-14));
    for (int i = 0; i < kind.dimensions; ++i) {
      const VectorX step = 1e-5 * VectorX::Unit(kind.dimensions, i);
      const VectorX measured = (kind.functions(at + step) - kind.functions(at - step)) / 2e-5;
      CHECK((measured - kind.function_slopes(at).row(i).transpose()).norm() < 1e-9);
    }
    // Complete to its order: a polynomial is met everywhere.
    const auto polynomial = [&](const VectorX& x) {
      const double linear = 1 + 2 * x[0] - x[1] + (x.size() > 2 ? 3 * x[2] : 0);
      return kind.order == 1 ? linear : linear * (1 - x[0] + 0.5 * x[x.size() - 1]);
    };
    double sum = 0;
    for (int a = 0; a < kind.nodes; ++a) sum += kind.functions(at)[a] * polynomial(kind.reference.col(a));
    CHECK(sum == Approx(polynomial(at)).epsilon(1e-13));
  }
}

TEST_CASE("the simplices of cells fill the body and fit together", "[cells][shapes]") {
  const Vector3 size(0.03, 0.02, 0.02);
  for (const CellKind* kind : solid_kinds()) {
    INFO(kind->name);
    const Body body = cell_box(*kind, {3, 2, 2}, size, 0);
    CHECK(volume_of(body) == Approx(size.prod()).epsilon(1e-12));
    for (const auto& cell : body.tetrahedra) CHECK(signed_volume(body.rest, cell) > 0);
    CHECK(body.mass.sum() == Approx(1000 * size.prod()).epsilon(1e-12));
    CHECK(body.mass.minCoeff() > 0);
    // Every face inside is between two of them: what is left is the surface of the box.
    double area = 0;
    for (const BlockFace& face : boundary_faces(body)) {
      const Eigen::MatrixXd own = positions_of(body.rest, face.nodes);
      Vector3 outward = Vector3::Zero();
      for (std::size_t g = 0; g < face.kind->slopes.size(); ++g) {
        const Eigen::MatrixXd edges = own * face.kind->slopes[g].transpose();
        outward +=
            face.kind->weights[static_cast<Eigen::Index>(g)] * Vector3(edges.col(0)).cross(Vector3(edges.col(1)));
      }
      area += outward.norm();
      CHECK(outward.dot(own.rowwise().mean() - Vector3(size / 2)) > 0);
    }
    const double whole = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
    CHECK(area == Approx(whole).epsilon(1e-12));
  }
}

TEST_CASE("forces of a cell are a sum over pairs of q (x_b - x_a)", "[cells][conformance]") {
  for (const CellKind* kind : solid_kinds()) {
    INFO(kind->name);
    const Body body = cell_box(*kind, {1, 1, 1}, {0.01, 0.01, 0.01}, 0.08, true);
    const ElasticTerms made = built_in_catalog().find("neo_hookean").make(body, kSoft, {});
    const auto& law = made.terms.front();
    const Positions positions = deformed(body, 3e-4);
    Model model(body);
    model.add(law->clone());
    const Positions forces = model.elastic_forces(positions);
    // By the definition: C from squared lengths alone, q_ab = −Σ w B_aᵀ S B_b.
    const auto [lambda, mu] = std::pair{kSoft.youngs_modulus * 0.3 / (1.3 * 0.4), kSoft.youngs_modulus / 2.6};
    Positions pairs = Positions::Zero(3, body.size());
    for (const CellBlock& block : body.blocks)
      for (int cell = 0; cell < block.size(); ++cell) {
        const auto nodes = block.cell(cell);
        const Eigen::MatrixXd rest = positions_of(body.rest, nodes), now = positions_of(positions, nodes);
        for (std::size_t g = 0; g < kind->slopes.size(); ++g) {
          const Matrix3 J = rest * kind->slopes[g].transpose();
          const Eigen::MatrixXd B = J.inverse().transpose() * kind->slopes[g];
          const double weight = kind->weights[static_cast<Eigen::Index>(g)] * J.determinant();
          Matrix3 C = Matrix3::Zero();
          for (int a = 0; a < kind->nodes; ++a)
            for (int b = a + 1; b < kind->nodes; ++b)
              C -= (now.col(a) - now.col(b)).squaredNorm() / 2 *
                   (B.col(a) * B.col(b).transpose() + B.col(b) * B.col(a).transpose());
          const double volume = std::sqrt(C.determinant());
          const Matrix3 S = lambda * volume * (volume - 1) * C.inverse() + mu * (Matrix3::Identity() - C.inverse());
          for (int a = 0; a < kind->nodes; ++a)
            for (int b = 0; b < kind->nodes; ++b)
              pairs.col(nodes[a]) -= weight * B.col(a).dot(S * B.col(b)) * (now.col(b) - now.col(a));
        }
      }
    CHECK((forces - pairs).norm() <= 1e-12 * forces.norm());
  }
}

TEST_CASE("patch test: distorted cells of any shape carry an even strain", "[cells][patch]") {
  const Vector3 size(0.03, 0.02, 0.02);
  Matrix3 strain;
  strain << 0.02, 0.01, -0.005, 0.003, -0.01, 0.004, 0, 0.006, 0.015;
  for (const CellKind* kind : solid_kinds())
    for (const char* name : {"neo_hookean", "neo_hookean+volume", "st_venant_kirchhoff"}) {
      const Body body = cell_box(*kind, {3, 2, 2}, size, 0.15, kind->corners == 8 && kind->order == 2);
      const Strategy strategy = built_in_catalog().find(name);
      // Curved tetrahedra pass only to the order of their quadrature.
      INFO(kind->name << ", " << name);
      for (const bool linear : {true, false}) {
        Model model(body);
        model.add(strategy.make(body, kSoft, {}));
        model.supports = held_surface(body, size, [&](const Vector3& x) { return strain * x; });
        REQUIRE(model.supports.size() < static_cast<std::size_t>(body.size()));
        State state{body.rest, Positions::Zero(3, body.size())};
        StaticOptions options;
        options.linear = linear;
        const StaticResult result = solve_static(model, state, options);
        REQUIRE(result.outcome == Outcome::converged);
        const Positions expected = body.rest + strain * body.rest;
        CHECK((state.positions - expected).norm() <= 1e-9 * (expected - body.rest).norm());
      }
    }
}

TEST_CASE("an even traction on a face is a load at its nodes that a bar bears evenly", "[cells][patch]") {
  const Vector3 size(0.03, 0.02, 0.02);
  for (const CellKind* kind : solid_kinds()) {
    INFO(kind->name);
    const Body body = cell_box(*kind, {3, 2, 2}, size, 0.15, kind->corners == 8 && kind->order == 2);
    std::vector<int> end;
    Model model(body);
    for (int a = 0; a < body.size(); ++a) {
      const Vector3 x = body.rest.col(a);
      if (x[0] > size[0] - 1e-9) end.push_back(a);
      Matrix3 free = Matrix3::Identity();
      for (int i = 0; i < 3; ++i)
        if (x[i] < 1e-9) free(i, i) = 0;
      if (free != Matrix3::Identity()) model.supports.push_back({.molecule = a, .free = free});
    }
    const VectorX areas = face_shares(body, end, Vector3::UnitX());
    CHECK(areas.sum() == Approx(size[1] * size[2]).epsilon(1e-12));
    const double traction = 200;  // 1 % of E
    Positions load = Positions::Zero(3, body.size());
    for (std::size_t i = 0; i < end.size(); ++i) load(0, end[i]) = traction * areas[static_cast<Eigen::Index>(i)];
    model.add(built_in_catalog().find("neo_hookean").make(body, kSoft, {}));
    const StaticResponse response = static_response(model, body.rest, load, Positions::Zero(3, body.size()));
    REQUIRE(response.result.outcome == Outcome::converged);
    const Matrix3 strain = Vector3(0.01, -0.003, -0.003).asDiagonal();
    const Positions expected = strain * body.rest;
    CHECK((response.motion - expected).norm() <= 1e-9 * expected.norm());
  }
}

namespace {

/// The error in L2, over the size, of a smooth displacement that body forces make: u = curl of a bubble (no change of
/// volume, so that ν → ½ has a limit) under small strains.
double error_of(const CellKind& kind, int cells, const char* strategy, double nu) {
  const Vector3 size(1, 1, 1);
  const Body body = cell_box(kind, {cells, cells, cells}, size,
                             kind.nodes == 20 ? 0 : 0.05);  // 20 nodes have their order on parallelepipeds alone
  const double pi = std::acos(-1.);
  // ψ = sin πx sin πy sin πz along z: u = (∂ψ/∂y, −∂ψ/∂x, 0), div u = 0, −μ Δu = 3 π² μ u.
  const auto exact = [&](const Vector3& x) -> Vector3 {
    const double sx = std::sin(pi * x[0]), sy = std::sin(pi * x[1]), sz = std::sin(pi * x[2]);
    return Vector3(sx * std::cos(pi * x[1]) * sz, -std::cos(pi * x[0]) * sy * sz, 0);
  };
  Material material = kSoft;
  material.poissons_ratio = nu;
  const double mu = material.youngs_modulus / (2 * (1 + nu));
  Model model(body);
  model.add(built_in_catalog().find(strategy).make(body, material, {}));
  model.supports = held_surface(body, size, exact);
  Positions load = Positions::Zero(3, body.size()), moves = Positions::Zero(3, body.size());
  for (const Support& support : model.supports) moves.col(support.molecule) = support.displacement;
  const auto integrate = [&](const auto& at_point) {
    for (const CellBlock& block : body.blocks)
      for (int cell = 0; cell < block.size(); ++cell) {
        const auto nodes = block.cell(cell);
        const Eigen::MatrixXd own = positions_of(body.rest, nodes);
        for (std::size_t g = 0; g < kind.slopes.size(); ++g) {
          const auto point = static_cast<Eigen::Index>(g);
          const double weight = kind.weights[point] * measure_of(own * kind.slopes[g].transpose());
          at_point(nodes, VectorX(kind.values.col(point)), Vector3(own * kind.values.col(point)), weight);
        }
      }
  };
  integrate([&](std::span<const int> nodes, const VectorX& values, const Vector3& x, double weight) {
    const Vector3 force = weight * 3 * pi * pi * mu * exact(x);
    for (std::size_t a = 0; a < nodes.size(); ++a) load.col(nodes[a]) += values[static_cast<Eigen::Index>(a)] * force;
  });
  StaticOptions options;
  options.linear = true;
  const StaticResponse response = static_response(model, body.rest, load, moves, options);
  REQUIRE(response.result.outcome == Outcome::converged);
  double error = 0, whole = 0;
  integrate([&](std::span<const int> nodes, const VectorX& values, const Vector3& x, double weight) {
    Vector3 found = Vector3::Zero();
    for (std::size_t a = 0; a < nodes.size(); ++a)
      found += values[static_cast<Eigen::Index>(a)] * response.motion.col(nodes[a]);
    error += weight * (found - exact(x)).squaredNorm(), whole += weight * exact(x).squaredNorm();
  });
  return std::sqrt(error / whole);
}

void check_order(const char* kind_name, const char* strategy, double nu, std::array<int, 2> cells, double least) {
  const CellKind& kind = cell_kind(kind_name);
  const double coarse = error_of(kind, cells[0], strategy, nu), fine = error_of(kind, cells[1], strategy, nu);
  const double order = std::log(coarse / fine) / std::log(static_cast<double>(cells[1]) / cells[0]);
  INFO(kind_name << " " << strategy << " nu " << nu << ": errors " << coarse << ", " << fine << ", order " << order);
  CHECK(order > least);
}

}  // namespace

TEST_CASE("orders of convergence on a smooth solution: 2 of first-order cells, 3 of second", "[cells][orders][slow]") {
  check_order("tetrahedron4", "neo_hookean", 0.3, {4, 8}, 1.8);
  check_order("prism6", "neo_hookean", 0.3, {5, 10}, 1.8);
  check_order("hexahedron8", "neo_hookean", 0.3, {4, 8}, 1.8);
  check_order("tetrahedron10", "neo_hookean", 0.3, {2, 4}, 2.7);
  check_order("hexahedron20", "neo_hookean", 0.3, {3, 6}, 2.7);
  check_order("hexahedron27", "neo_hookean", 0.3, {3, 6}, 2.7);
}

TEST_CASE("near nu = 1/2 cells whose volume is kept by pressures of their own do not lock", "[cells][orders][slow]") {
  check_order("hexahedron8", "neo_hookean+volume", 0.499, {4, 8}, 1.7);
  check_order("hexahedron27", "neo_hookean+volume", 0.499, {3, 6}, 2.7);
  check_order("tetrahedron10", "neo_hookean+volume", 0.499, {2, 4}, 1.7);  // P2/P0: the pressure's order is one less
}

TEST_CASE("hexahedra of one size share their stiffness, which is the slope of their forces", "[cells][conformance]") {
  // As many as a segmented image has: two sizes, and three materials that differ by a factor.
  Body body = cell_box(cell_kind("hexahedron8"), {20, 16, 16}, {0.20, 0.16, 0.16}, 0);
  for (int a = 0; a < body.size(); ++a)
    if (body.rest(0, a) > 0.105) body.rest(0, a) += 0.5 * (body.rest(0, a) - 0.1);
  CellBlock& block = body.blocks.front();
  block.stiffness = VectorX::Ones(block.size());
  for (int cell = 0; cell < block.size(); ++cell) block.stiffness[cell] = 1 + 0.5 * (cell % 3);
  const Positions motion = 1e-6 * random_motion(body, 7);
  for (const double nu : {0.3, 0.499}) {
    INFO("nu " << nu);
    Material material = kSoft;
    material.poissons_ratio = nu;
    Model model(body);
    model.add(built_in_catalog().find("neo_hookean+volume").make(body, material, {}));
    State state = state_at_rest(body);
    const Tangent tangent(model, state);
    Positions slope(3, body.size()), ahead, behind, by_blocks = Positions::Zero(3, body.size());
    tangent.apply(motion, slope);
    state.positions = body.rest + motion;
    model.set_forces(state, ahead);
    state.positions = body.rest - motion;
    model.set_forces(state, behind);
    CHECK((slope - (behind - ahead) / 2).norm() < 1e-6 * slope.norm());
    tangent.visit_blocks([&](int a, int b, const Matrix3& K) { by_blocks.col(a) += K * motion.col(b); });
    CHECK((slope - by_blocks).norm() < 1e-12 * slope.norm());
  }
}

TEST_CASE("cells of any shape are bitwise identical on any number of threads", "[cells][threads]") {
  const Body body = cell_box(cell_kind("hexahedron20"), {7, 7, 7}, {0.01, 0.01, 0.01}, 0.05);
  const Positions positions = deformed(body, 2e-6), motion = random_motion(body, 3);
  Positions forces, images;
  for (const int count : {1, 2, 3}) {
    set_threads(count);
    Model model(body);
    model.add(built_in_catalog().find("neo_hookean+volume").make(body, kSoft, {}));
    const Positions own = model.elastic_forces(positions);
    const State at{positions, Positions::Zero(3, body.size())};
    Positions image(3, body.size());
    Tangent(model, at).apply(motion, image);
    if (count == 1) forces = own, images = image;
    CHECK(own == forces);
    CHECK(image == images);
  }
  set_threads(0);
}
