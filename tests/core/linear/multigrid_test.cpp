#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <string>

#include "core/base/disjoint_sets.h"
#include "core/forces/volume.h"
#include "core/linear/box_assembly.h"
#include "core/linear/linear_choice.h"
#include "core/linear/volume_smoother.h"
#include "elastin/core/linear/linear_solver.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/statics.h"
#include "hull/delaunay.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

constexpr double kSpacing = 0.01;  // m

Body lattice(std::array<int, 3> counts, bool space = false) {
  return cubic_lattice(counts, kSpacing, {.axis = true, .face = true, .space = space});
}

/// The same molecules, moved at random and in another order: no grid, no band, no box that fits.
Body scattered(const Body& ordered, double amount) {
  std::mt19937_64 generator(3);
  std::vector<int> positions(static_cast<std::size_t>(ordered.size()));
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = static_cast<int>(i);
  for (std::size_t i = positions.size(); i > 1; --i) std::swap(positions[i - 1], positions[generator() % i]);
  Body body = ordered;
  body.grid.reset();
  body.cubes.clear();
  const Positions moved = ordered.rest + amount * random_motion(ordered, 5);
  for (int i = 0; i < body.size(); ++i) body.rest.col(positions[i]) = moved.col(i);
  for (auto& ends : body.connections.ends)
    for (int& end : ends) end = positions[end];
  set_present_lengths(body);
  return body;
}

/// A body held at its lowest molecules along z (within a quarter of the spacing) and pulled askew at the others' top.
struct Fixed {
  explicit Fixed(Body a_body, double constant = 100) : body(std::move(a_body)), model(body) {
    constants = VectorX::Constant(body.connections.size(), constant);
    loads = Positions::Zero(3, body.size());
    const double low = body.rest.row(2).minCoeff(), high = body.rest.row(2).maxCoeff();
    for (int a = 0; a < body.size(); ++a) {
      if (body.rest(2, a) < low + 0.5 * kSpacing) model.supports.push_back({a});
      if (body.rest(2, a) > high - 0.5 * kSpacing) loads.col(a) = Vector3(1e-3, 2e-4, 3e-3);
    }
  }
  void add_springs() { model.add(make_springs(body, constants)); }

  LinearResult solve(std::unique_ptr<LinearSolver> solver, Positions& motion, double tolerance = 1e-9) {
    const State rest = state_at_rest(body);
    const Tangent tangent(model, rest);
    Positions rhs = loads;
    keep_free(model.supports, rhs);
    return solver->solve(tangent, model.supports, rhs, tolerance, motion);
  }
  int iterations() {
    Positions motion;
    const LinearResult result = solve(make_multigrid(), motion, 1e-8);
    REQUIRE(result.status == LinearStatus::solved);
    return result.iterations;
  }

  Body body;
  Model model;
  VectorX constants;
  Positions loads;
};

void check_against_factorisation(Fixed& fixed, double tolerance = 1e-6) {
  Positions motion, exact;
  const LinearResult result = fixed.solve(make_multigrid(), motion, 1e-11);
  REQUIRE(fixed.solve(make_direct(), exact, 1e-11).residual < 1e-9);
  CHECK(result.status == LinearStatus::solved);
  CHECK((motion - exact).norm() < tolerance * exact.norm());
}

/// A stiff lump in the middle, as of bone in fat.
void stiffen_middle(Fixed& fixed, double times) {
  const Vector3 middle = (fixed.body.rest.rowwise().minCoeff() + fixed.body.rest.rowwise().maxCoeff()) / 2;
  const double reach = 0.25 * (fixed.body.rest.rowwise().maxCoeff() - fixed.body.rest.rowwise().minCoeff()).maxCoeff();
  for (int c = 0; c < fixed.body.connections.size(); ++c) {
    const auto& [a, b] = fixed.body.connections.ends[c];
    if (((fixed.body.rest.col(a) + fixed.body.rest.col(b)) / 2 - middle).norm() < reach) fixed.constants[c] *= times;
  }
}

}  // namespace

TEST_CASE("multigrid's answer is the factorisation's, whatever the body", "[multigrid][slow]") {
  SECTION("lattice") {
    Fixed fixed(lattice({7, 6, 8}));
    fixed.add_springs();
    check_against_factorisation(fixed);
  }
  SECTION("lattice with space diagonals, an odd number of layers in every direction") {
    Fixed fixed(lattice({6, 8, 10}, true));
    fixed.add_springs();
    check_against_factorisation(fixed);
  }
  SECTION("no order and no grid") {
    Fixed fixed(scattered(lattice({7, 7, 7}), 0.2 * kSpacing));
    fixed.add_springs();
    check_against_factorisation(fixed);
  }
  SECTION("rod, 40 times as long as thick") {
    Fixed fixed(lattice({3, 3, 81}));
    fixed.add_springs();
    check_against_factorisation(fixed, 1e-5);
  }
  SECTION("sheet of one layer on edge") {
    Fixed fixed(lattice({12, 1, 14}));
    for (int a = 0; a < fixed.body.size(); ++a) fixed.loads(1, a) = 0;  // it has no stiffness across
    fixed.add_springs();
    check_against_factorisation(fixed);
  }
  SECTION("stiffness a million times as high in the middle") {
    Fixed fixed(lattice({7, 7, 7}));
    stiffen_middle(fixed, 1e6);
    fixed.add_springs();
    check_against_factorisation(fixed);
  }
  SECTION("a million times as high, no order, no grid") {
    Fixed fixed(scattered(lattice({7, 7, 7}), 0.2 * kSpacing));
    stiffen_middle(fixed, 1e6);
    fixed.add_springs();
    check_against_factorisation(fixed);
  }
  SECTION("nearly incompressible by a volume term") {
    Fixed fixed(lattice({6, 6, 6}));
    fixed.add_springs();
    fixed.model.add(make_volume(fixed.body, 100 * 100 / kSpacing));
    check_against_factorisation(fixed);
  }
  SECTION("supports that hold askew directions") {
    Fixed fixed(lattice({6, 6, 6}));
    const Vector3 across = Vector3(1, 2, 3).normalized();
    for (int a = 0; a < fixed.body.size(); a += 5)
      if (fixed.loads.col(a).isZero(0) && fixed.body.rest(2, a) > kSpacing)
        fixed.model.supports.push_back({a, Matrix3::Identity() - across * across.transpose()});
    fixed.add_springs();
    check_against_factorisation(fixed);
  }
  SECTION("tetrahedra of every law") {
    for (const char* law : {"st_venant_kirchhoff", "neo_hookean"})
      for (const double nu : {0.3, 0.499}) {
        Fixed fixed(tetrahedral_block(BlockKind::kuhn, {5, 5, 6}, {0.05, 0.05, 0.06}));
        fixed.model.add(
            built_in_catalog().find(law).make(fixed.body, {.youngs_modulus = 1e4, .poissons_ratio = nu}, {}));
        INFO(law << ", nu " << nu);
        check_against_factorisation(fixed);
      }
  }
}

TEST_CASE("multigrid's iterations do not grow with the body", "[multigrid][slow]") {
  // Conjugate gradients alone take 10 iterations for each connection from end to end: 88, 210, 466 at 10, 22, 47 a
  // side.
  for (const bool ordered : {true, false}) {
    std::vector<int> iterations;
    for (const int side : {8, 12, 18}) {
      Fixed fixed(ordered ? lattice({side, side, side}) : scattered(lattice({side, side, side}), 0.15 * kSpacing));
      fixed.add_springs();
      iterations.push_back(fixed.iterations());
    }
    INFO(iterations[0] << ", " << iterations[1] << ", " << iterations[2]);
    CHECK(iterations[2] <= (ordered ? 32 : 36));
    CHECK(iterations[2] <= iterations[0] + 8);
  }
}

TEST_CASE("multigrid serves bodies whose spacing grows towards a corner", "[multigrid][slow]") {
  // Boxes of twice the median spacing are shorter than the connections where the body is coarse.
  Body body = tetrahedral_block(BlockKind::body_centred, {12, 12, 12}, {0.12, 0.12, 0.12});
  for (int axis = 0; axis < 3; ++axis) grade(body, axis, 8);
  Fixed fixed(std::move(body));
  fixed.model.add(built_in_catalog().find("neo_hookean").make(fixed.body, {.youngs_modulus = 1e4}, {}));
  Positions motion;
  const LinearResult alone = fixed.solve(make_pcg(), motion, 1e-8);
  REQUIRE(alone.status == LinearStatus::solved);
  INFO(alone.iterations << " without boxes");
  CHECK(fixed.iterations() <= alone.iterations / 3);
}

TEST_CASE("multigrid takes rods a hundred times as long as thick in some forty iterations", "[multigrid]") {
  Fixed fixed(lattice({3, 3, 201}));
  fixed.add_springs();
  CHECK(fixed.iterations() <= 60);  // conjugate gradients alone: thousands
}

/// A sheet of four layers that is folded up with gaps between the folds no wider than between two layers.
Body folded_sheet(int side, int folds) {
  Body body = lattice({side, side, 4 * folds});
  std::vector<std::array<int, 2>> kept;
  std::vector<double> lengths;
  for (int c = 0; c < body.connections.size(); ++c) {
    std::array<int, 2> fold{}, along{};
    for (const int end : {0, 1}) {
      const Vector3 at = body.rest.col(body.connections.ends[c][end]) / kSpacing;
      fold[end] = static_cast<int>(std::lround(at.z())) / 4, along[end] = static_cast<int>(std::lround(at.x()));
    }
    const int from_turn =
        std::min(fold[0], fold[1]) % 2 ? std::max(along[0], along[1]) : side - 1 - std::min(along[0], along[1]);
    if (fold[0] != fold[1] && from_turn > 3) continue;
    kept.push_back(body.connections.ends[c]);
    lengths.push_back(body.connections.rest_length[c]);
  }
  body.connections.ends = kept, body.connections.rest_length = lengths;
  body.grid.reset();
  body.cubes.clear();
  return body;
}

TEST_CASE("multigrid keeps the sides of narrow gaps apart", "[multigrid][slow]") {
  // A grid that joins the folds takes thousands of iterations, as conjugate gradients alone do.
  Fixed fixed(folded_sheet(24, 6));
  fixed.add_springs();
  CHECK(fixed.iterations() <= 60);
}

/// A gyroid foam with walls of some three layers: the largest piece of what is near the surface.
Body foam(int side) {
  const Body solid = lattice({side, side, side});
  const auto filled = [&](int a) {
    const Vector3 at = 2 * M_PI / 14 / kSpacing * solid.rest.col(a);
    return std::abs(std::sin(at.x()) * std::cos(at.y()) + std::sin(at.y()) * std::cos(at.z()) +
                    std::sin(at.z()) * std::cos(at.x())) < 0.55;
  };
  DisjointSets pieces(solid.size());
  for (const auto& [a, b] : solid.connections.ends)
    if (filled(a) && filled(b)) pieces.join(a, b);
  std::map<int, int> sizes;
  for (int a = 0; a < solid.size(); ++a) ++sizes[pieces.set_of(a)];
  const int largest =
      std::max_element(sizes.begin(), sizes.end(), [](auto& a, auto& b) { return a.second < b.second; })->first;
  Body body = solid;
  body.grid.reset();
  body.cubes.clear();
  std::vector<int> number(solid.size(), -1);
  int count = 0;
  for (int a = 0; a < solid.size(); ++a)
    if (pieces.set_of(a) == largest) body.rest.col(number[a] = count++) = solid.rest.col(a);
  body.rest.conservativeResize(3, count);
  body.connections.ends.clear();
  for (const auto& [a, b] : solid.connections.ends)
    if (number[a] >= 0 && number[b] >= 0) body.connections.ends.push_back({number[a], number[b]});
  set_present_lengths(body);
  return body;
}

TEST_CASE("multigrid takes a foam in at most twice the iterations of a solid", "[multigrid][slow]") {
  Fixed porous(foam(28)), solid(lattice({20, 20, 20}));
  porous.add_springs(), solid.add_springs();
  const int of_solid = solid.iterations();
  CHECK(of_solid <= 20);
  CHECK(porous.iterations() <= 60);
}

TEST_CASE("multigrid keeps the sides of gaps apart in bodies of hexahedra", "[multigrid][slow]") {
  // Walls of two cells with gaps of one between them, joined in turn at either end: walls lie across the boxes' faces
  // anyhow, and some molecules are in boxes in which no cell has its middle.
  constexpr int side = 16, walls = 5;
  Body corners = cubic_lattice({side + 1, side + 1, 3 * walls}, kSpacing, {true, false, false});
  std::erase_if(corners.cubes, [&](const auto& cube) {
    const Vector3 at = corners.rest.col(cube[0]) / kSpacing;
    const int wall = static_cast<int>(std::lround(at.z())) / 3, along = static_cast<int>(std::lround(at.x()));
    return std::lround(at.z()) % 3 == 2 && (wall % 2 ? along > 1 : along < side - 2);
  });
  // Conjugate gradients alone take thousands.
  for (const auto& [ratio, most] : {std::pair(0.3, 60), std::pair(0.49, 80)}) {
    Fixed fixed(with_cells(corners, cell_kind("hexahedron8")));
    fixed.model.add(built_in_catalog()
                        .find("neo_hookean+volume")
                        .make(fixed.body, {.youngs_modulus = 1e4, .poissons_ratio = ratio}, {}));
    INFO(ratio);
    CHECK(fixed.iterations() <= most);
  }
}

TEST_CASE("multigrid takes cells of any shape turned any way against its boxes", "[multigrid][cells][slow]") {
  // Boxes are as large as cells of second order: along the axes each has its points, and turned some have hardly any.
  for (const char* kind : {"hexahedron8", "hexahedron20", "hexahedron27", "tetrahedron10", "prism6"})
    for (const double degrees : {0., 10., 25., 45.}) {
      const int cells = std::string(kind) == "hexahedron8" ? 12 : 6;
      Fixed fixed(cell_box(cell_kind(kind), {2 * cells, cells, cells}, {4 * kSpacing, 2 * kSpacing, 2 * kSpacing}, 0));
      const Matrix3 turn(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vector3(1, 2, 3).normalized()));
      fixed.body.rest = (turn * fixed.body.rest).eval();
      fixed.model.add(
          built_in_catalog().find("neo_hookean").make(fixed.body, {.youngs_modulus = 1e4, .poissons_ratio = 0.3}, {}));
      INFO(kind << " " << degrees);
      CHECK(fixed.iterations() <= 50);
    }
}

TEST_CASE("multigrid takes tetrahedra whose surface is stepped, and flat ones", "[multigrid][cells][slow]") {
  // Of the first, boxes at the surface have molecules and no cell's middle; of the others, stiffnesses of sides are
  // large and cancel out.
  const auto body_of = [](const Body& block, const auto& keeps) {
    std::vector<int> number(block.size(), -1);
    std::vector<Vector3> positions;
    Cells<4> cells;
    for (const auto& nodes : block.tetrahedra) {
      Vector3 middle = Vector3::Zero();
      for (const int node : nodes) middle += block.rest.col(node) / 4;
      if (!keeps(middle)) continue;
      for (const int node : nodes)
        if (number[node] < 0)
          number[node] = static_cast<int>(positions.size()), positions.push_back(block.rest.col(node));
      cells.push_back({number[nodes[0]], number[nodes[1]], number[nodes[2]], number[nodes[3]]});
    }
    Body body = listed_body(positions, sides_of(cells));
    body.tetrahedra = cells;
    return body;
  };
  const Body block = tetrahedral_block(BlockKind::kuhn, {16, 16, 16}, Vector3::Constant(16 * kSpacing));
  const Body ball = body_of(block, [](const Vector3& middle) {
    const Vector3 cube = (middle / kSpacing).array().floor() + 0.5;
    return (cube - Vector3::Constant(8)).norm() < 8.2;
  });
  const Body packing = random_packing(Vector3::Constant(14 * kSpacing), kSpacing, 1.5 * kSpacing, 1);
  Body flat = listed_body({packing.rest.colwise().begin(), packing.rest.colwise().end()}, {});
  flat.tetrahedra = hull::delaunay_tetrahedra(flat.rest);
  flat = body_of(flat, [](const Vector3&) { return true; });
  for (Body body : {ball, flat}) {
    Fixed fixed(std::move(body));
    fixed.model.add(
        built_in_catalog().find("neo_hookean").make(fixed.body, {.youngs_modulus = 1e4, .poissons_ratio = 0.3}, {}));
    CAPTURE(fixed.body.size());
    CHECK(fixed.iterations() <= 60);
  }
}

TEST_CASE("smoothing that keeps volumes is symmetric and positive, and soft bodies have no such smoothing",
          "[multigrid]") {
  for (const double ratio : {0.3, 0.45, 0.49, 0.4999}) {
    Fixed fixed(with_cells(cubic_lattice({6, 5, 7}, kSpacing, {true, false, false}), cell_kind("hexahedron8")));
    fixed.model.add(built_in_catalog()
                        .find("neo_hookean+volume")
                        .make(fixed.body, {.youngs_modulus = 1e4, .poissons_ratio = ratio}, {}));
    const State rest = state_at_rest(fixed.body);
    auto smoother = VolumeSmoother::of(Tangent(fixed.model, rest), fixed.model.supports);
    CAPTURE(ratio);
    REQUIRE(smoother.has_value() == (ratio > 0.4));
    if (!smoother) continue;
    Positions a = scattered_directions(fixed.body.size()), b = a.rowwise().reverse();
    keep_free(fixed.model.supports, a), keep_free(fixed.model.supports, b);
    Positions of_a = a, of_b = b;
    smoother->apply(of_a), smoother->apply(of_b);
    CHECK(ordered_dot(a, of_a) > 0);
    CHECK(ordered_dot(b, of_b) > 0);
    CHECK(std::abs(ordered_dot(a, of_b) - ordered_dot(b, of_a)) <
          1e-5 * std::sqrt(ordered_dot(a, of_a) * ordered_dot(b, of_b)));
  }
}

TEST_CASE("multigrid gives bitwise identical results on any number of threads", "[multigrid][slow]") {
  for (const char* kind : {"ordered", "scattered", "hexahedra"}) {
    const bool cells = std::string(kind) == "hexahedra";
    Fixed fixed(cells
                    ? with_cells(cubic_lattice({16, 16, 16}, kSpacing, {true, false, false}), cell_kind("hexahedron8"))
                : std::string(kind) == "ordered" ? lattice({20, 20, 20})
                                                 : scattered(lattice({20, 20, 20}), 0.2 * kSpacing));
    if (cells)
      fixed.model.add(built_in_catalog()
                          .find("neo_hookean+volume")
                          .make(fixed.body, {.youngs_modulus = 1e4, .poissons_ratio = 0.49}, {}));
    else
      fixed.add_springs();
    CAPTURE(kind);
    Positions first;
    for (const int count : {1, 2, 4}) {
      set_threads(count);
      Positions motion;
      const LinearResult result = fixed.solve(make_multigrid(), motion, 1e-5);
      set_threads(0);
      REQUIRE(result.status == LinearStatus::solved);
      if (count == 1) first = motion;
      CHECK((motion.array() == first.array()).all());
    }
  }
}

TEST_CASE("points of a lattice share what they have alike, and have it as where nothing is alike", "[multigrid]") {
  Fixed regular(lattice({40, 41, 42})), irregular(lattice({40, 41, 42}));
  regular.add_springs();
  // No two boxes are alike, and none is far from the lattice's.
  constexpr double change = 1e-3;
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> some(-change, change);
  for (double& constant : irregular.constants) constant *= 1 + some(generator);
  irregular.add_springs();
  const State rest = state_at_rest(regular.body), other_rest = state_at_rest(irregular.body);
  const auto level_of = [](const Fixed& fixed, const State& state) {
    return assemble_level(Tangent(fixed.model, state), fixed.model.supports).level;
  };
  std::unique_ptr<BoxLevel> shared = level_of(regular, rest), own = level_of(irregular, other_rest);
  for (const bool coarse : {false, true}) {
    CAPTURE(coarse);
    if (coarse) shared = shared->coarser(shared->grid().coarser()), own = own->coarser(own->grid().coarser());
    // Inside, on faces, edges and corners; at supports each has its own.
    CHECK(shared->kept_rows() < 4 * shared->points() / 10);
    CHECK(own->kept_rows() == own->points());
    REQUIRE(shared->points() == own->points());
    double error = 0, size = 0;
    for (int point = 0; point < own->points(); ++point) {
      REQUIRE(std::ranges::equal(shared->neighbours(point), own->neighbours(point)));
      for (int n = 0; n < static_cast<int>(own->neighbours(point).size()); ++n) {
        const Matrix3 block = own->block_to(point, n);
        error = std::max(error, (shared->block_to(point, n) - block).norm());
        size = std::max(size, block.norm());
      }
    }
    CHECK(error < change * size);
  }
}

TEST_CASE("multigrid says of what has no answer what conjugate gradients alone say", "[multigrid]") {
  SECTION("a pull on a mechanism: axis connections alone do not resist shear") {
    Fixed fixed(cubic_lattice({5, 5, 5}, kSpacing, {.axis = true, .face = false, .space = false}));
    fixed.add_springs();
    Positions motion;
    CHECK(fixed.solve(make_pcg(), motion).status == LinearStatus::zero_mode);
    CHECK(fixed.solve(make_multigrid(), motion).status == LinearStatus::zero_mode);
    CHECK(motion.allFinite());
  }
  SECTION("negative stiffness") {
    Fixed fixed(lattice({6, 6, 6}), -100);
    fixed.add_springs();
    Positions motion;
    CHECK(fixed.solve(make_pcg(), motion).status == LinearStatus::negative_mode);
    const LinearResult result = fixed.solve(make_multigrid(), motion);
    CHECK(result.status == LinearStatus::negative_mode);
    CHECK(result.negative_direction.allFinite());
  }
  SECTION("a free body under loads in balance keeps what it may do as a whole") {
    Fixed fixed(lattice({6, 7, 8}));
    fixed.model.supports.clear();
    fixed.add_springs();
    fixed.loads.setZero();
    for (int a = 0; a < fixed.body.size(); ++a) {
      if (fixed.body.rest(2, a) < 0.5 * kSpacing) fixed.loads(2, a) = -1e-3;
      if (fixed.body.rest(2, a) > 6.5 * kSpacing) fixed.loads(2, a) = 1e-3;
    }
    Positions motion;
    REQUIRE(fixed.solve(make_multigrid(), motion).status == LinearStatus::solved);
    Vector3 turn = Vector3::Zero();
    double size = 0;
    const Vector3 middle = fixed.body.rest.rowwise().mean();
    for (int a = 0; a < fixed.body.size(); ++a) {
      const Vector3 arm = fixed.body.rest.col(a) - middle;
      turn += arm.cross(Vector3(motion.col(a)));
      size += arm.norm() * motion.col(a).norm();
    }
    CHECK(motion.rowwise().mean().norm() < 1e-6 * std::sqrt(motion.squaredNorm() / fixed.body.size()));
    CHECK(turn.norm() < 1e-6 * size);
  }
}

TEST_CASE("the automatic choice factorises where iterations would take longer", "[multigrid]") {
  // A slender rod near nu = 1/2, bent: hundreds of iterations, and next to no fill in the factor.
  Fixed fixed(with_cells(cubic_lattice({3, 3, 101}, kSpacing, {true, false, false}), cell_kind("hexahedron8")));
  fixed.model.add(built_in_catalog()
                      .find("neo_hookean+volume")
                      .make(fixed.body, {.youngs_modulus = 1e4, .poissons_ratio = 0.4998}, {}));
  std::vector<int> all;
  for (int a = 0; a < fixed.body.size(); ++a) all.push_back(a);
  fixed.model.add(std::make_unique<PointLoads>(fixed.body, all, 1e-5 * fixed.loads));
  const auto solved = [&](LinearMethod method) {
    State state = state_at_rest(fixed.body);
    const StaticResult result = solve_static(fixed.model, state, {.method = method, .probe = false});
    REQUIRE(result.outcome == Outcome::converged);
    return std::pair(result, state.positions);
  };
  const auto [chosen, positions] = solved("automatic");
  const auto [by_boxes, same] = solved("multigrid");
  CHECK(chosen.solver == "newton direct");
  CHECK(chosen.reason == "iterations would take longer than a factorisation");
  CHECK(2 * chosen.linear_iterations < by_boxes.linear_iterations);
  // Loads that are met to 1e-8 leave as much of so soft a bending.
  CHECK((positions - same).norm() < 2e-3 * (same - fixed.body.rest).norm());
}

TEST_CASE("the automatic choice factorises a bundle of fibres that conjugate gradients alone are slow at",
          "[multigrid]") {
  // Bent in the middle, and drawn from one plate: then all are to conjugate gradients a single one.
  struct Bundle {
    int across, thick, length;
    double loaded;
    Vector3 load;
    const char* solver;
  };
  const auto [across, thick, length, loaded, load, solver] =
      GENERATE(Bundle{12, 2, 60, 30, {1e-3, 2e-4, 3e-3}, "direct"}, Bundle{24, 3, 24, 21, {0, 0, 1e-3}, "pcg"});
  constexpr int plate = 2;
  Body body = lattice({across, across, length});
  body.grid.reset();
  body.cubes.clear();
  std::erase_if(body.connections.ends, [&, thick = thick, length = length](const auto& ends) {
    const Vector3 a = body.rest.col(ends[0]) / kSpacing, b = body.rest.col(ends[1]) / kSpacing;
    const auto fibre = [&](double at) { return std::lround(at) / thick; };
    const bool one_fibre = fibre(a.x()) == fibre(b.x()) && fibre(a.y()) == fibre(b.y());
    return !one_fibre && std::max(a.z(), b.z()) > plate - 0.5 && std::min(a.z(), b.z()) < length - plate - 0.5;
  });
  set_present_lengths(body);
  Fixed fixed(std::move(body));
  fixed.add_springs();
  fixed.model.supports.clear();
  for (int a = 0; a < fixed.body.size(); ++a) {
    const double at = fixed.body.rest(2, a) / kSpacing;
    if (at < plate - 0.5 || at > length - plate - 0.5) fixed.model.supports.push_back({a});
    fixed.loads.col(a) = at > loaded - 0.5 && at < loaded + 0.5 ? load : Vector3(0, 0, 0);
  }
  Positions motion, exact;
  const std::unique_ptr<LinearSolver> automatic = make_multigrid_or_direct();
  const State rest = state_at_rest(fixed.body);
  const LinearResult result =
      automatic->solve(Tangent(fixed.model, rest), fixed.model.supports, fixed.loads, 1e-9, motion);
  CHECK(result.status == LinearStatus::solved);
  CHECK(std::string(automatic->name()) == solver);
  CHECK(result.iterations <= 50);
  REQUIRE(fixed.solve(make_pcg(), exact, 1e-11).status == LinearStatus::solved);
  CHECK((motion - exact).norm() < 1e-7 * exact.norm());
}

TEST_CASE("large displacements by multigrid end where conjugate gradients alone do", "[multigrid][slow]") {
  const auto bent = [](LinearMethod method) {
    Fixed fixed(lattice({4, 4, 24}));
    fixed.add_springs();
    std::vector<int> all;
    for (int a = 0; a < fixed.body.size(); ++a) all.push_back(a);
    fixed.model.add(std::make_unique<PointLoads>(fixed.body, all, 0.3 * fixed.loads));
    State state = state_at_rest(fixed.body);
    const StaticResult result = solve_static(fixed.model, state, {.method = method});
    REQUIRE(result.outcome == Outcome::converged);
    CHECK(result.solver == (method == "pcg" ? "newton pcg" : "newton multigrid"));
    return state.positions;
  };
  const Positions alone = bent("pcg"), coarse = bent("multigrid");
  CHECK((alone - coarse).norm() < 1e-7 * alone.norm());
}

TEST_CASE("the linear solver is chosen by the body's size and the requested digits", "[multigrid]") {
  const auto choice = [](std::array<int, 3> counts, double tolerance, Weights weights = {}) {
    Fixed fixed(lattice(counts));
    fixed.body.mass = VectorX::Ones(fixed.body.size());
    fixed.add_springs();
    const State rest = state_at_rest(fixed.body);
    return choose_linear_solver(Tangent(fixed.model, rest, weights), "automatic", tolerance);
  };
  CHECK(choice({3, 3, 3}, 1e-8).method == "direct");
  CHECK(choice({10, 10, 10}, 1e-8).method == "pcg");
  CHECK(choice({24, 24, 24}, 1e-8).method == "multigrid");
  CHECK(choice({4, 4, 100}, 1e-3).method == "multigrid");
  CHECK(choice({24, 24, 24}, 0.1).method == "pcg");
  CHECK(choice({24, 24, 24}, 1e-8, {1e3, 1e6}).method == "pcg");
  CHECK(choice({4, 4, 100}, 1e-8).reason.find("1600 molecules, ") == 0);
}
