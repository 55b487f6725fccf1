#include "core/forces/pressure.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/load_table.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/parallel/threads.h"
#include "support/bodies.h"
#include "support/forces_of.h"

using namespace elastin;
using namespace elastin::testing;
using Catch::Matchers::Contains;
using std::numbers::pi;

namespace {

State deformed_state(const Body& body) {
  State state = state_at_rest(body);
  state.positions = deformed(body, 0.01);
  return state;
}

/// Central difference of something along a motion.
template <class Function>
auto difference(const State& state, const Positions& motion, Function&& value) {
  constexpr double h = 1e-6;
  State ahead = state, behind = state;
  ahead.positions += h * motion;
  behind.positions -= h * motion;
  using Value = decltype(value(state));
  return Value((value(ahead) - value(behind)) / (2 * h));
}

const PressureLaw kFillings[] = {constant_pressure(300), constant_pressure(-20), enclosed_gas(400, 1, 90),
                                 enclosed_gas(400, 1.4, 90), controlled_volume(4.5, 1000, 30)};

}  // namespace

TEST_CASE("volumes of known shapes", "[pressure]") {
  Body cube = listed_body({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}}, {});
  cube.triangles = {{1, 2, 3}};  // with the three coordinate planes: a corner of a cube, 2³/6
  CHECK(enclosed_volume(cube.triangles, cube.rest, Vector3::Zero()) == Approx(8. / 6).epsilon(1e-15));
  cube.triangles = {{1, 2, 3}, {0, 2, 1}, {0, 3, 2}, {0, 1, 3}};
  CHECK(enclosed_volume(cube.triangles, cube.rest, {7, -5, 3}) == Approx(8. / 6).epsilon(1e-14));
  std::array<double, 2> missing{};
  for (const int level : {0, 1}) {
    const Body ball = sphere(0.5, SphereMesh::icosahedron, 8 << level);
    missing[level] = pi / 6 - enclosed_volume(ball.triangles, ball.rest, {0, 0, 0});
  }
  CHECK(std::log2(missing[0] / missing[1]) == Approx(2).margin(0.03));
  const Body octant = sphere_octant(1, SphereMesh::type_2, 6), whole = sphere(1, SphereMesh::type_2, 6);
  CHECK(8 * enclosed_volume(octant.triangles, octant.rest, {0, 0, 0}) ==
        Approx(enclosed_volume(whole.triangles, whole.rest, {0, 0, 0})).epsilon(1e-13));
}

TEST_CASE("the pressure's force on a surface is p A n, and on a closed one nothing in all", "[pressure]") {
  const Body ball = sphere(1, SphereMesh::type_1, 4);
  const State state = deformed_state(ball);
  const Positions forces = forces_of(Pressure(ball, constant_pressure(70), {0, 0, 0}, false), state);
  CHECK(forces.rowwise().sum().norm() < 1e-13 * forces.norm());
  Vector3 torque = Vector3::Zero();
  for (int i = 0; i < ball.size(); ++i) torque += Vector3(state.positions.col(i)).cross(Vector3(forces.col(i)));
  CHECK(torque.norm() < 1e-13 * forces.norm());
  const Body sheet = rectangular_sheet({2, 3}, {3, 3}, SheetPattern::one_way);
  const Pressure wind(sheet, constant_pressure(70), {0, 0, 0}, false);
  const Positions lift = forces_of(wind, state_at_rest(sheet));
  CHECK((lift.rowwise().sum() - Vector3(0, 0, 70 * 6)).norm() < 1e-12);
  CHECK_FALSE(wind.has_energy());  // its rim is free: the forces of a pressure then have no potential
}

TEST_CASE("the pressure's force is −∂energy/∂x, and its tangent that of differences", "[pressure]") {
  const Body ball = sphere(1, SphereMesh::icosahedron, 2), sheet = elastin::testing::sheet(0.001);
  for (const PressureLaw& filling : kFillings) {
    const Pressure pressure(ball, filling, {0.1, 0.2, -0.3}, false);
    CHECK(pressure.energy(state_at_rest(ball)) == 0);
    const State state = deformed_state(ball);
    const Positions motion = random_motion(ball, 5), forces = forces_of(pressure, state);
    const double slope = difference(state, motion, [&](const State& s) { return pressure.energy(s); });
    CHECK(slope == Approx(-forces.cwiseProduct(motion).sum()).epsilon(1e-7));
  }
  for (const PressureLaw& filling : kFillings) {
    for (const Body* body : {&ball, &sheet}) {
      const Pressure pressure(*body, filling, {0.1, 0.2, -0.3}, false);
      State state = state_at_rest(*body);
      state.positions = deformed(*body, body == &ball ? 0.01 : 1e-4);
      if (!(pressure.volume(state.positions) > 0)) state.positions.row(2) *= -1;  // no gas has a volume below zero
      const Positions motion = random_motion(*body, 6);
      const Positions wanted = difference(state, motion, [&](const State& s) { return forces_of(pressure, s); });
      Positions change = Positions::Zero(3, body->size());
      pressure.add_change(state, motion, motion, change);
      CHECK((change - wanted).norm() < 1e-6 * wanted.norm());
      if (body == &sheet) continue;
      Positions blocks = Positions::Zero(3, body->size());
      pressure.visit_blocks(state, 0,
                            [&](int a, int b, const Matrix3& part) { blocks.col(a) -= part * motion.col(b); });
      for (const WideTerm& wide : pressure.wide_terms(state))
        blocks -= wide.factor * wide.direction.cwiseProduct(motion).sum() * wide.direction;
      CHECK((change - blocks).norm() < 1e-12 * change.norm());
    }
  }
}

TEST_CASE("small displacements have a pressure as it is at rest, but for its change with the volume", "[pressure]") {
  const Body ball = sphere(1, SphereMesh::icosahedron, 2);
  const State rest = state_at_rest(ball);
  const Positions motion = random_motion(ball, 7),
                  areas = forces_of(Pressure(ball, constant_pressure(1), {0, 0, 0}, false), rest);
  for (const PressureLaw& filling : kFillings) {
    Model model(ball);
    model.add(std::make_unique<Pressure>(ball, filling, Vector3(0.1, 0.2, -0.3), false));
    const auto& pressure = dynamic_cast<const Pressure&>(*model.loads().front());
    const Tangent tangent(model, rest, {}, true);
    Positions found(3, ball.size()), expected = areas;
    tangent.apply(motion, found);
    expected *= -pressure.pressure_state(rest.positions).slope * areas.cwiseProduct(motion).sum();
    CHECK((found - expected).norm() <= 1e-12 * expected.norm());
    for (const WideTerm& wide : tangent.wide_terms())
      found -= wide.factor * wide.direction.cwiseProduct(motion).sum() * wide.direction;
    CHECK(found.norm() <= 1e-12 * expected.norm());
    tangent.visit_blocks([](int, int, const Matrix3& block) { CHECK(block.isZero(0)); });
    CHECK(tangent.symmetric());
  }
}

TEST_CASE("a surface whose rim slides in planes through the apex has its energy too", "[pressure]") {
  const Body octant = sphere_octant(1, SphereMesh::type_1, 4);
  const Pressure pressure(octant, constant_pressure(50), {0, 0, 0}, true);
  CHECK(pressure.has_energy());
  const auto in_planes = [&](Positions motion) {
    motion.array() *= (octant.rest.array() > 0).cast<double>();
    return motion;
  };
  State state = state_at_rest(octant);
  state.positions += 0.02 * in_planes(random_motion(octant, 8));
  const Positions motion = in_planes(random_motion(octant, 9)), other = in_planes(random_motion(octant, 10));
  const double slope = difference(state, motion, [&](const State& s) { return pressure.energy(s); });
  CHECK(slope == Approx(-forces_of(pressure, state).cwiseProduct(motion).sum()).epsilon(1e-8));
  Positions one = Positions::Zero(3, octant.size()), two = one;
  pressure.add_change(state, motion, motion, one);
  pressure.add_change(state, other, other, two);
  CHECK(one.cwiseProduct(other).sum() == Approx(two.cwiseProduct(motion).sum()).epsilon(1e-12));
}

TEST_CASE("gas keeps its law, controlled volume its stiffness", "[pressure]") {
  const double volume = 3, rest = 2;
  const PressureState isothermal = enclosed_gas(500, 1, 100)(volume, rest),
                      air = enclosed_gas(500, 1.4, 100)(volume, rest);
  CHECK((isothermal.pressure + 100) * volume == Approx(500));
  CHECK((air.pressure + 100) * std::pow(volume, 1.4) == Approx(250 * std::pow(rest, 1.4)));
  CHECK(enclosed_gas(500, 1 + 1e-7, 100)(volume, rest).work == Approx(isothermal.work).epsilon(1e-6));
  CHECK(std::isinf(enclosed_gas(500, 1, 100)(0, rest).pressure));
  CHECK(controlled_volume(3.5, 20, 7)(volume, rest).pressure == Approx(17));
}

TEST_CASE("a pressure is bitwise identical on any number of threads", "[pressure]") {
  const Body ball = sphere(1, SphereMesh::type_1, 80);  // 51 200 triangles: enough for several threads
  const Pressure gas(ball, enclosed_gas(400, 1.4, 90), {0, 0, 0}, false);
  const State state = deformed_state(ball);
  const Positions motion = random_motion(ball, 3);
  const auto on = [&](int count) {
    set_threads(count);
    Positions sums = random_motion(ball, 4);
    gas.add_forces(state, sums);
    gas.add_change(state, motion, motion, sums);
    set_threads(0);
    return sums;
  };
  CHECK(on(1) == on(2));
}

TEST_CASE("triangles without a common outside are refused by number", "[pressure]") {
  Body body = listed_body({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}}, {});
  const auto make = [&] { Pressure(body, constant_pressure(1), {0, 0, 0}, true); };
  CHECK_THROWS_WITH(make(), "a pressure needs a body with triangles");
  body.triangles = {{0, 1, 2}, {1, 2, 3}};
  CHECK_THROWS_WITH(make(), Catch::Matchers::Contains("triangle 1 is turned against its neighbour"));
  body.triangles = {{0, 1, 2}, {2, 1, 3}, {1, 2, 4}};
  CHECK_THROWS_WITH(make(), Catch::Matchers::Contains("triangle 0 (and 2 more) shares a side with more than one"));
}

TEST_CASE("each closed surface has a gas of its own, as large as it is alone", "[pressure]") {
  const Body small = sphere(1, SphereMesh::icosahedron, 2), large = sphere(2, SphereMesh::icosahedron, 2);
  Body both = small;
  const int first = small.size();
  both.rest.conservativeResize(3, first + large.size());
  both.rest.rightCols(large.size()) = large.rest.colwise() + Vector3(5, 0, 0);
  both.mass = VectorX::Ones(both.rest.cols());
  both.radius = VectorX::Ones(both.rest.cols());
  for (auto triangle : large.triangles) {
    for (int& corner : triangle) corner += first;
    both.triangles.push_back(triangle);
  }
  const LoadKind& gas = *built_in_loads().find("gas");
  const auto forces = [&](const Body& body, LoadValues values, const Positions& positions) {
    Model model(body);
    add_load(model, gas, std::move(values));
    State state = state_at_rest(body);
    state.positions = positions;
    return Positions(model.load_forces(state));
  };
  Positions grown = both.rest;  // the small one is blown up, the large one is not
  grown.leftCols(first) *= 1.1;
  std::vector<int> of_small(static_cast<std::size_t>(first));
  std::iota(of_small.begin(), of_small.end(), 0);
  for (const char* stated : {"start_pressure", "amount"}) {
    const LoadValues values{.numbers = {{stated, 120e3}, {"exponent", 1.4}}};
    const Positions of_both = forces(both, values, grown), alone = forces(small, values, grown.leftCols(first)),
                    other = forces(large, values, large.rest);
    CHECK((of_both.leftCols(first) - alone).norm() < 1e-10 * alone.norm());
    CHECK((of_both.rightCols(large.size()) - other).norm() < 1e-10 * other.norm());
    LoadValues one = values;
    one.molecules["on"] = of_small;
    const Positions picked = forces(both, one, grown);
    CHECK((picked.leftCols(first) - alone).norm() < 1e-10 * alone.norm());
    CHECK(picked.rightCols(large.size()).isZero(0));
  }
  Model model(both);
  add_load(model, *built_in_loads().find("pressure"), {.numbers = {{"pressure", 7}}, .molecules = {{"on", of_small}}});
  const Positions pressed = model.load_forces(state_at_rest(both));
  CHECK(pressed.leftCols(first).norm() > 0);
  CHECK(pressed.rightCols(large.size()).isZero(0));
}

TEST_CASE("gases fill what is between closed surfaces, and an open sheet next to a balloon is named", "[pressure]") {
  const Body ball = sphere(1, SphereMesh::icosahedron, 2);
  const int first = ball.size();
  const auto with = [&](double scale, const Vector3& at, bool inwards) {
    Body body = ball;
    body.rest.conservativeResize(3, 2 * first);
    body.rest.rightCols(first) = (scale * ball.rest).colwise() + at;
    for (auto triangle : ball.triangles) {
      for (int& corner : triangle) corner += first;
      if (inwards) std::swap(triangle[0], triangle[1]);
      body.triangles.push_back(triangle);
    }
    return body;
  };
  const auto volumes = [](const Body& body) {
    std::vector<double> all;
    for (const Cells<3>& space : closed_spaces(body.triangles, body))
      all.push_back(enclosed_volume(space, body.rest, Vector3::Zero()));
    return all;
  };
  const double whole = enclosed_volume(ball.triangles, ball.rest, Vector3::Zero());
  CHECK_THAT(volumes(with(0.5, Vector3::Zero(), true)), Catch::Matchers::Approx(std::vector<double>{whole * 7 / 8}));
  CHECK_THAT(volumes(with(1, {5, 0, 0}, false)), Catch::Matchers::Approx(std::vector<double>{whole, whole}));
  // A balloon in a balloon, also one that touches it from within, and one that touches it from outside.
  CHECK_THAT(volumes(with(0.5, Vector3::Zero(), false)),
             Catch::Matchers::Approx(std::vector<double>{whole * 7 / 8, whole / 8}));
  CHECK_THAT(volumes(with(0.5, ball.rest.col(0) / 2, false)),
             Catch::Matchers::Approx(std::vector<double>{whole * 7 / 8, whole / 8}));
  CHECK_THAT(volumes(with(0.5, ball.rest.col(0) * 1.5, false)),
             Catch::Matchers::Approx(std::vector<double>{whole, whole / 8}));
  CHECK_THAT(volumes(with(2, Vector3::Zero(), false)), Catch::Matchers::Approx(std::vector<double>{whole, whole * 7}));
  const Body nested = with(0.5, Vector3::Zero(), false);
  CHECK(closed_spaces(ball.triangles, nested).front().size() == 2 * ball.triangles.size());  // picked alone
  CHECK_THROWS_WITH(volumes(with(1, {5, 0, 0}, true)), Contains("looks inwards and lies within no other"));
  Body open = with(1, {5, 0, 0}, false);
  open.triangles.pop_back();
  CHECK_THROWS_WITH(closed_spaces(open.triangles, open),
                    Contains("the one of molecule " + std::to_string(first)) && Contains("let `on` pick"));
}
