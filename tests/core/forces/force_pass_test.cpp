#include <catch2/catch.hpp>
#include <cstring>
#include <functional>
#include <memory>

#include "core/forces/grid_springs.h"
#include "core/forces/volume.h"
#include "elastin/core/forces/model.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "support/allocations.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

const Material kSoft{.youngs_modulus = 1e4};

VectorX uneven_constants(const Body& body) {
  VectorX constants(body.connections.size());
  for (int c = 0; c < constants.size(); ++c) constants[c] = 50 + c % 17 - (c % 13 == 0 ? 80 : 0);  // some negative
  return constants;
}

Model springs_on(const Body& body, const VectorX& constants) {
  Model model(body);
  model.add(make_springs(body, constants));
  return model;
}

/// Σ_b q_ab (x_b − x_a) by the force densities alone: what every shorter way must agree with.
Positions forces_by_force_densities(const Model& model, const Positions& positions) {
  const auto& ends = model.body().connections.ends;
  const VectorX q = model.force_densities(positions);
  Positions forces = Positions::Zero(3, positions.cols());
  for (int c = 0; c < q.size(); ++c) {
    const Vector3 f = q[c] * (positions.col(ends[c][1]) - positions.col(ends[c][0]));
    forces.col(ends[c][0]) += f;
    forces.col(ends[c][1]) -= f;
  }
  return forces;
}

Body without_grid(Body body) {
  body.grid.reset();
  return body;
}

/// The same body with its molecules renumbered, so that connections reach far and ascend by neither end.
Body shuffled(const Body& body) {
  Body other = without_grid(body);
  std::vector<int> number(static_cast<std::size_t>(body.size()));
  for (std::size_t i = 0; i < number.size(); ++i) number[i] = static_cast<int>(i);
  std::shuffle(number.begin(), number.end(), std::mt19937(5));
  for (int i = 0; i < body.size(); ++i) other.rest.col(number[i]) = body.rest.col(i);
  for (auto& [a, b] : other.connections.ends) a = number[a], b = number[b];
  other.cubes.clear();
  return other;
}

Body large_lattice() {
  Body body = cubic_lattice({21, 17, 23}, 0.01, {true, true, false});  // some 65 000 connections: several threads
  add_jitter(body, 1e-3, 3);
  return body;
}

}  // namespace

TEST_CASE("forces of springs are those of their force densities, on a grid and off it", "[force_pass]") {
  struct Lattice {
    std::array<int, 3> molecules;
    CubicPattern pattern;
  };
  const Lattice lattices[] = {
      {{10, 7, 6}, {true, true, false}}, {{5, 9, 4}, {true, true, true}},   {{18, 4, 5}, {true, true, true}},
      {{6, 5, 7}, {false, true, true}},  {{4, 3, 3}, {true, false, false}}, {{19, 1, 1}, {true, true, true}},
      {{1, 8, 1}, {true, true, true}},   {{1, 1, 9}, {true, true, true}},   {{9, 8, 1}, {true, true, true}},
      {{1, 5, 6}, {true, true, true}},   {{6, 1, 5}, {true, true, true}},   {{2, 2, 2}, {true, true, true}},
      {{1, 2, 3}, {true, true, false}}};
  for (const Lattice& lattice : lattices)
    for (const bool jitter : {false, true}) {
      Body body = cubic_lattice(lattice.molecules, 0.01, lattice.pattern);
      stretch(body, {1, 1.5, 0.7});
      if (jitter) add_jitter(body, 5e-4, 7);
      const VectorX constants = uneven_constants(body);
      CAPTURE(lattice.molecules, jitter);
      REQUIRE(GridSprings::make(body, constants, body.connections.rest_length.data()));
      const Positions positions = deformed(body, 1e-3);
      for (const Body& of : {body, without_grid(body)}) {
        const Model model = springs_on(of, constants);
        const Positions expected = forces_by_force_densities(model, positions);
        CHECK((model.elastic_forces(positions) - expected).cwiseAbs().maxCoeff() <=
              1e-13 * expected.cwiseAbs().maxCoeff());
      }
    }
}

TEST_CASE("stiffness of springs is the same on a grid and off it, on any number of threads", "[force_pass][threads]") {
  const int before = threads();
  for (const std::array<int, 3>& molecules :
       {std::array{10, 7, 6}, std::array{18, 14, 15}, std::array{19, 1, 1}, std::array{1, 8, 1}, std::array{2, 2, 2}})
    for (const bool jitter : {false, true})
      for (const double size : {0., 1e-3}) {
        Body body = cubic_lattice(molecules, 0.86 / 11, {true, true, true});
        if (jitter) add_jitter(body, 5e-4, 7);
        const Body off_grid = without_grid(body);
        const VectorX constants = uneven_constants(body);
        const Model model = springs_on(body, constants), same = springs_on(off_grid, constants);
        State state = state_at_rest(body);
        if (size > 0) state.positions = deformed(body, size);
        const Positions motion = scattered_directions(body.size());
        CAPTURE(molecules, jitter, size);
        Positions expected, result(3, body.size()), again(3, body.size());
        expected.setZero(3, body.size());
        Tangent(same, state).apply(motion, expected);
        for (const int count : {1, 2, 3}) {
          set_threads(count);
          Tangent(model, state).apply(motion, count == 1 ? result : again);
          CHECK((count == 1 || again == result));
        }
        set_threads(before);
        CHECK((result - expected).cwiseAbs().maxCoeff() <= 1e-13 * expected.cwiseAbs().maxCoeff());
      }
}

TEST_CASE("rows of a regular lattice share their constants to rounding only", "[force_pass]") {
  // 0.86/11 is no binary fraction: lengths that should be alike differ in their last digits.
  Body body = cubic_lattice({12, 12, 12}, 0.86 / 11, {true, true, false});
  const VectorX constants = built_in_catalog().find("lattice").constants(body, kSoft, {});
  const Model model = springs_on(body, constants);
  Positions positions = body.rest;
  positions.row(2) *= 1 + 1e-6;
  const double scale = kSoft.youngs_modulus * 0.86 * 0.86;  // rounding of places is rounding of strain
  CHECK((model.elastic_forces(positions) - forces_by_force_densities(model, positions)).cwiseAbs().maxCoeff() <=
        1e-14 * scale);
  CHECK((model.elastic_forces(body.rest)).cwiseAbs().maxCoeff() <= 1e-14 * scale);
}

TEST_CASE("springs on a grid: other springs are left to the list of connections", "[force_pass]") {
  const Body body = cubic_lattice({4, 3, 3}, 0.01, {true, true, false});
  const VectorX constants = uneven_constants(body);
  REQUIRE(GridSprings::make(body, constants, body.connections.rest_length.data()));
  CHECK(!GridSprings::make(Body(), VectorX(), nullptr));  // as engines ask whether they suit a law
  CHECK(!GridSprings::make(without_grid(body), constants, body.connections.rest_length.data()));
  Body other = body;
  other.grid = {{3, 4, 4}};  // another number of molecules
  CHECK(!GridSprings::make(other, constants, other.connections.rest_length.data()));
  other.grid = {{3, 4, 3}};  // the right number, but not its neighbours
  CHECK(!GridSprings::make(other, constants, other.connections.rest_length.data()));
  other = body;
  other.connections.ends.push_back(body.connections.ends.back());  // there twice
  other.connections.rest_length.push_back(0.01);
  VectorX more(constants.size() + 1);
  more << constants, 1;
  CHECK(!GridSprings::make(other, more, other.connections.rest_length.data()));
  more[constants.size()] = 0;  // no spring at all
  CHECK(GridSprings::make(other, more, other.connections.rest_length.data()));
  std::reverse(other.connections.ends.begin(), other.connections.ends.end());
  CHECK(!GridSprings::make(other, VectorX::Constant(more.size(), 1), other.connections.rest_length.data()));
}

TEST_CASE("springs on a grid: molecules in one place have no direction and no force", "[force_pass]") {
  const Body body = cubic_lattice({9, 3, 3}, 0.01, {true, true, true});
  const Model model = springs_on(body, uneven_constants(body));
  CHECK(model.elastic_forces(Positions::Zero(3, body.size())).isZero(0));
  Positions positions = deformed(body, 1e-3);
  positions.col(13) = positions.col(14);
  CHECK(model.elastic_forces(positions).allFinite());
}

TEST_CASE("springs: every vector width gives bitwise identical results", "[force_pass]") {
  constexpr int count = 37, pitch = 40;  // no multiple of any width
  const auto run = [&](const SpringKernel& kernel) {
    std::vector<double> numbers(15 * pitch);
    std::mt19937_64 generator(3);
    for (double& number : numbers) number = 1e-3 * static_cast<double>(generator() % 2000) - 1;
    double* k = numbers.data() + 12 * pitch;
    const auto row = [&](int i) { return RowOf3{numbers.data() + 3 * i * pitch, pitch}; };
    kernel.add_row_flows(row(0), row(1), k, k + pitch, count, 0, row(2), row(3));
    kernel.add_row_flows(row(0), row(0).from(2), k, k + pitch, count, 2, row(2), row(1));
    const double d[] = {0.3, -0.2, 0.7};
    kernel.add_row_changes(row(0), row(1), d, k, count, 0, row(2), row(3));
    kernel.add_row_changes(row(0), row(0).from(1), d, k, count, 1, row(2), row(1));
    kernel.set_force_densities(row(0), k, k + pitch, count, k + 2 * pitch);
    return numbers;
  };
  const std::vector<double> expected = run(spring_kernels().front());
  for (const SpringKernel& kernel : spring_kernels()) {
    const std::vector<double> found = run(kernel);
    CHECK(std::memcmp(found.data(), expected.data(), found.size() * sizeof(double)) == 0);
  }
}

TEST_CASE("rows of a lattice: changes of force are those of each connection by itself, in one row and between two",
          "[force_pass]") {
  constexpr int count = 21, pitch = 24;
  for (const SpringKernel& kernel : spring_kernels())
    for (const Vector3& d : {Vector3(0.3, -0.2, 0.7), Vector3(0.3, 0, 0.7), Vector3(0, 0.5, 0)})
      for (const int shift : {0, 2}) {
        std::mt19937_64 generator(5);
        std::vector<double> numbers(13 * pitch);
        for (double& number : numbers) number = 1e-3 * static_cast<double>(generator() % 2000) - 1;
        std::vector<double> expected = numbers;
        const auto row = [&](std::vector<double>& in, int i) { return RowOf3{in.data() + 3 * i * pitch, pitch}; };
        const auto motion = [&](int of, int i) {
          const RowOf3 own = row(numbers, of);
          return Vector3(own.x[i], own.y()[i], own.z()[i]);
        };
        const double* slopes = numbers.data() + 12 * pitch;
        std::array<Vector3, count> flows;
        for (int i = 0; i < count; ++i) {
          const Vector3 delta = motion(0, i) - (shift == 0 ? motion(1, i) : motion(0, i + shift));
          flows[i] = slopes[i] * (d.x() * delta.x() + d.y() * delta.y() + d.z() * delta.z()) * d;
        }
        for (const int end : {0, 1})
          for (int i = 0; i < count; ++i)
            for (int axis = 0; axis < 3; ++axis) {
              double* on = row(expected, shift == 0 ? 2 + end : 2).along(axis);
              on[i + end * shift] += end == 0 ? flows[i][axis] : -flows[i][axis];
            }
        const RowOf3 from = row(numbers, 0), to = shift == 0 ? row(numbers, 1) : from.from(shift);
        kernel.add_row_changes(from, to, d.data(), slopes, count, shift, row(numbers, 2), row(numbers, 3));
        const int compared = (shift == 0 ? 4 : 3) * 3 * pitch;  // behind it is the workspace of a row
        CAPTURE(d.transpose(), shift);
        CHECK(std::equal(numbers.begin(), numbers.begin() + compared, expected.begin()));
      }
}

TEST_CASE("springs of a list: every vector width adds them one after the other, to the molecules of its range alone",
          "[force_pass]") {
  constexpr int molecules = 40;
  std::mt19937_64 generator(11);
  const auto number = [&] { return 1e-3 * static_cast<double>(generator() % 2000) - 1; };
  std::vector<double> positions(3 * molecules), constants, rest_lengths;
  for (double& one : positions) one = number();
  std::copy_n(positions.begin(), 3, positions.begin() + 3);  // the molecules 0 and 1 in one place
  std::vector<std::array<int, 2>> ends{{0, 1}};
  for (int molecule = 0; molecule < molecules; ++molecule)  // some in order, with many springs in a row
    for (int other = molecule + 1; other < std::min(molecules, molecule + 2 + molecule % 6); ++other)
      ends.push_back({molecule, other});
  for (int more = 0; more < 57; ++more) {  // and some in none, from either end
    const int one = static_cast<int>(generator() % molecules), on = 1 + static_cast<int>(generator() % (molecules - 1));
    ends.push_back({one, (one + on) % molecules});
  }
  for (std::size_t spring = 0; spring < ends.size(); ++spring)
    constants.push_back(number()), rest_lengths.push_back(number() + 1);
  const int count = static_cast<int>(ends.size());
  const auto from_29 = std::find_if(ends.begin(), ends.end(), [](const auto& of) { return of[0] >= 29; });
  const int before_29 = static_cast<int>(from_29 - ends.begin());
  for (const auto& [first, last, begin, end] :
       {std::array{0, count, 0, molecules}, {3, before_29, 7, 29}, {5, 6, 0, molecules}, {9, 9, 0, molecules}}) {
    std::vector<double> expected(3 * molecules, 0.1);
    for (int spring = first; spring < last; ++spring) {
      const auto& [a, b] = ends[spring];
      double d[3];
      for (int axis = 0; axis < 3; ++axis) d[axis] = positions[3 * b + axis] - positions[3 * a + axis];
      const double l = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      const double q = l > 0 ? constants[spring] * (l - rest_lengths[spring]) / l : 0;
      for (int axis = 0; axis < 3; ++axis) {
        if (a >= begin && a < end) expected[3 * a + axis] += q * d[axis];
        if (b >= begin && b < end) expected[3 * b + axis] -= q * d[axis];
      }
    }
    for (const SpringKernel& kernel : spring_kernels()) {
      std::vector<double> forces(3 * molecules, 0.1);
      kernel.add_listed_flows({ends.data(), constants.data(), rest_lengths.data()}, first, last, begin, end,
                              positions.data(), forces.data());
      CAPTURE(first, last, begin, end);
      CHECK(forces == expected);
    }
  }
}

TEST_CASE("springs: every vector width adds the changes of connections one after the other", "[force_pass]") {
  constexpr int molecules = 20;
  std::mt19937_64 generator(5);
  const auto number = [&] { return 1e-3 * static_cast<double>(generator() % 2000) - 1; };
  Positions positions(3, molecules), motion(3, molecules);
  for (Positions* vectors : {&positions, &motion})
    for (double& one : vectors->reshaped()) one = number();
  std::vector<std::array<int, 2>> ends;
  for (int a = 0; a < molecules; ++a)
    for (int b = a + 1; b < std::min(molecules, a + 2 + a % 6); ++b) ends.push_back({a, b});
  const int count = static_cast<int>(ends.size());
  std::vector<double> slopes, densities;
  for (int c = 0; c < count; ++c) slopes.push_back(number()), densities.push_back(number());
  for (const bool stressed : {false, true}) {
    Positions expected = Positions::Constant(3, molecules, 0.1);
    for (int c = 0; c < count; ++c) {
      const auto& [a, b] = ends[c];
      const Vector3 d = positions.col(b) - positions.col(a), delta = motion.col(a) - motion.col(b);
      const Vector3 along = (2 * slopes[c] * (d.x() * delta.x() + d.y() * delta.y() + d.z() * delta.z())) * d;
      const Vector3 flow = stressed ? Vector3(densities[c] * delta + along) : along;
      if (a >= 4 && a < 15) expected.col(a) += flow;
      if (b >= 4 && b < 15) expected.col(b) -= flow;
    }
    const int last = static_cast<int>(
        std::find_if(ends.begin(), ends.end(), [](const auto& of) { return of[0] >= 15; }) - ends.begin());
    for (const SpringKernel& kernel : spring_kernels()) {
      Positions forces = Positions::Constant(3, molecules, 0.1);
      kernel.add_listed_changes({ends.data(), slopes.data(), stressed ? densities.data() : nullptr}, 0, last, 4, 15,
                                positions.data(), motion.data(), forces.data());
      CHECK(forces == expected);
    }
  }
}

TEST_CASE("forces are bitwise identical on any number of threads", "[force_pass][threads]") {
  const Body lattice = large_lattice(), list = without_grid(lattice), mixed = shuffled(lattice);
  Body block = tetrahedral_block(BlockKind::kuhn, {21, 21, 21}, {0.21, 0.21, 0.21});  // 55 566 cells
  const Catalog catalog = built_in_catalog();
  for (const Body* body : {&lattice, &list, &mixed, static_cast<const Body*>(&block)}) {
    Model model(*body);
    if (body == &block)
      model.add(catalog.find("neo_hookean").make(block, {.youngs_modulus = 1e4, .poissons_ratio = 0.3}, {}));
    model.add(make_springs(*body, uneven_constants(*body)));
    const Positions positions = deformed(*body, 5e-4);
    Workspace workspace;
    Positions expected;
    for (const int count : {1, 2, 3, 5}) {
      set_threads(count);
      Positions forces = Positions::Constant(3, body->size(), 0.1);
      model.add_elastic_forces(positions, forces, workspace);
      if (count == 1) expected = forces;
      CHECK(forces == expected);
    }
    set_threads(0);
    if (body != &block) {
      const Positions oracle = forces_by_force_densities(model, positions).array() + 0.1;
      CHECK((expected - oracle).cwiseAbs().maxCoeff() <= 1e-13 * oracle.cwiseAbs().maxCoeff());
    }
  }
}

TEST_CASE("a force pass allocates nothing after the first", "[force_pass][slow]") {
  const Body lattice = large_lattice(), list = without_grid(lattice), mixed = shuffled(lattice);
  Body block = tetrahedral_block(BlockKind::kuhn, {21, 21, 21}, {0.21, 0.21, 0.21});
  const Catalog catalog = built_in_catalog();
  for (const Body* body : {&lattice, &list, &mixed, static_cast<const Body*>(&block)}) {
    Model model(*body);
    model.add(make_springs(*body, uneven_constants(*body)));
    if (body != &mixed) model.add(make_volume(*body, 1e4));
    if (body == &block)
      model.add(catalog.find("neo_hookean").make(block, {.youngs_modulus = 1e4, .poissons_ratio = 0.3}, {}));
    const Positions positions = deformed(*body, 5e-4);
    Positions forces = Positions::Zero(3, body->size());
    for (const int count : {1, 2}) {
      set_threads(count);
      Workspace workspace;
      const long before_first = allocations();
      model.add_elastic_forces(positions, forces, workspace);
      const long before = allocations();
      model.add_elastic_forces(positions, forces, workspace);
      CHECK(allocations() == before);
      if (body != &mixed && allocations() > 0) CHECK(before > before_first);  // they are counted
    }
    set_threads(0);
  }
}
