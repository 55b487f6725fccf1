#include "elastin/core/solve/trajectory.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/solve/stable_step.h"
#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

double product(const Positions& a, const Positions& b) { return a.cwiseProduct(b).sum(); }

/// Everything by which a run is differentiated at once.
struct Change {
  Positions positions, velocities, forces;
  std::vector<VectorX> stiffness = {};
  double number = 0;
};

/// A body that is held at its low end and set in motion.
struct Case {
  std::string name;
  Body body;
  /// Laws with each element's stiffness times exp(changes), and a number.
  std::function<void(Model&, const VectorX& stiffness, double number)> add;
  int elements = 0;
  bool by_number = false, held = true;
  double implicit_step = 3;  ///< over the longest stable one of explicit steps
};

VectorX exponentials(const VectorX& changes) { return changes.array().exp(); }

Case springs(const std::string& name, const std::function<void(Model&)>& more) {
  Case one{name, jittered_lattice(), {}, 0};
  one.elements = one.body.connections.size();
  one.add = [more](Model& model, const VectorX& stiffness, double) {
    model.add(make_springs(model.body(), 40 * exponentials(stiffness)));
    more(model);
  };
  return one;
}

Case cells(const std::string& name, Body body, const std::string& law, const std::function<void(Model&)>& more) {
  Case one{name, std::move(body), {}, 0, true};
  one.add = [law, more](Model& model, const VectorX&, double number) {
    Material material;
    material.youngs_modulus = 5000 * (1 + number);
    material.poissons_ratio = 0.3;
    model.add(built_in_catalog().find(law).make(model.body(), material, {}));
    more(model);
  };
  return one;
}

/// A strategy with a history: of two terms and a dashpot, or of softening from the first motion on. The number changes
/// E and a constant of the history.
Case with_past(const std::string& strategy, Body body, double poissons_ratio = 0.3) {
  Case one{strategy + " on " + std::to_string(body.size()) + " molecules", std::move(body), {}, 0, true};
  one.add = [=](Model& model, const VectorX&, double number) {
    Material material;
    material.youngs_modulus = 5000 * (1 + number);
    material.poissons_ratio = poissons_ratio;
    material.thickness = 0.001;
    material.relaxation = Relaxation{{{0.3, 0.004 * (1 + number)}, {0.2, 0.03}}, false, 1e-5};
    material.softening = Softening{1.5, 2 * (1 + number), 0.1};
    model.add(built_in_catalog().find(strategy).make(model.body(), material, {}));
  };
  if (strategy.starts_with("prony")) one.implicit_step *= std::sqrt(1.5);  // of the long-term stiffness
  if (strategy.ends_with("membrane")) one.implicit_step = 1;               // folds fast, which nothing resists
  return one;
}

struct Problem {
  Problem(const Case& one, const Change* change, double amount) : body(one.body), model(body) {
    const VectorX stiffness =
        change && one.elements ? VectorX(amount * change->stiffness[0]) : VectorX::Zero(one.elements);
    one.add(model, stiffness, change ? amount * change->number : 0);
    const double low = body.rest.row(0).minCoeff();
    for (int i = 0; i < body.size() && one.held; ++i)
      if (body.rest(0, i) < low + 2e-3)
        model.supports.push_back({i, i % 2 ? Matrix3(Vector3(0, 0, 1).asDiagonal()) : Matrix3::Zero()});
    start = state_at_rest(body);
    start.velocities = 0.02 * random_motion(body, 31);
    start.positions += 2e-4 * random_motion(body, 32);
    if (change) start.positions += amount * change->positions, start.velocities += amount * change->velocities;
    for (Positions* each : {&start.velocities, &start.positions}) {
      const bool places = each == &start.positions;
      Positions motion = places ? Positions(*each - body.rest) : *each;
      keep_free(model.supports, motion);
      *each = places ? Positions(body.rest + motion) : motion;
    }
    std::vector<int> all(static_cast<std::size_t>(body.size()));
    for (int i = 0; i < body.size(); ++i) all[i] = i;
    Positions forces = 1e-4 * random_motion(body, 33);
    if (change) forces += amount * change->forces;
    model.add(std::make_unique<PointLoads>(body, all, forces));
  }
  Body body;
  Model model;
  State start;
};

struct MeasureWeights {
  Positions x, v;
};

/// A function of the end and of the state in the middle.
double measure(const MeasureWeights& weights, int number, int steps, const State& state) {
  double sum = 0;
  if (number == steps) sum += product(weights.x, state.positions) + 0.01 * product(weights.v, state.velocities);
  if (number == steps / 2) sum += product(weights.v, state.positions.cwiseProduct(state.positions)) / 0.01;
  return sum;
}

struct Steps {
  StepperOptions options;
  int steps;
  double tolerance;
};

StepperOptions method(const std::string& name, ParameterValues parameters = {}) {
  StepperOptions options{name, std::move(parameters)};
  options.newton.tolerance = 1e-14;
  return options;
}

/// Derivative along a change: by the sweep, and by differences of whole runs of order 4.
std::pair<double, double> both(const Case& one, const Steps& by, double dt) {
  const MeasureWeights weights{random_motion(one.body, 41), random_motion(one.body, 42)};
  Change along{0.1 * random_motion(one.body, 43), random_motion(one.body, 44), 0.1 * random_motion(one.body, 45)};
  along.positions *= 1e-2, along.velocities *= 1e-1, along.forces *= 1e-2;
  along.stiffness = {VectorX::NullaryExpr(one.elements, [](Eigen::Index i) { return std::sin(1. + 7 * i); })};
  along.number = one.by_number ? 1 : 0;
  const auto value = [&](double amount) {
    Problem problem(one, &along, amount);
    const auto stepper = make_stepper(by.options);
    State state = problem.start;
    problem.model.declare_history(state);
    problem.model.begin_step(state, state.time);
    double sum = measure(weights, 0, by.steps, state);
    for (int step = 1; step <= by.steps; ++step) {
      REQUIRE(stepper->advance(problem.model, state, dt).outcome == Outcome::converged);
      sum += measure(weights, step, by.steps, state);
    }
    return sum;
  };
  Problem problem(one, nullptr, 0);
  Change number_alone;
  number_alone.positions = number_alone.velocities = number_alone.forces = Positions::Zero(3, one.body.size());
  number_alone.stiffness = {VectorX::Zero(one.elements)}, number_alone.number = 1;
  Problem below(one, &number_alone, -1e-5), above(one, &number_alone, 1e-5);
  std::vector<VariedModels> varied;
  if (one.by_number) varied.push_back({&below.model, &above.model, 2e-5});
  Trajectory run(problem.model, problem.start, dt, by.steps, by.options);
  const TrajectoryAdjoint found = run.adjoint(
      [&](int number, const State& state, Positions& of_x, Positions& of_v) {
        if (number == by.steps) of_x += weights.x, of_v += 0.01 * weights.v;
        if (number == by.steps / 2) of_x += 2 / 0.01 * weights.v.cwiseProduct(state.positions);
      },
      varied);
  double sum = product(found.positions, along.positions) + product(found.velocities, along.velocities) +
               product(found.forces, along.forces);
  if (one.elements && found.stiffness[0].size()) sum += found.stiffness[0].dot(along.stiffness[0]);
  if (one.by_number) sum += found.numbers[0];
  const double h = 1e-6;  // what softens has kinks where it turns back
  const double near = (value(h) - value(-h)) / (2 * h), far = (value(2 * h) - value(-2 * h)) / (4 * h);
  return {sum, (4 * near - far) / 3};
}

}  // namespace

TEST_CASE("derivatives of a run in time by one sweep backward are differences of whole runs",
          "[adjoint][trajectory][slow]") {
  const auto nothing = [](Model&) {};
  const auto damped = [](Model& model) {
    model.add(make_gravity(model.body(), {0, -1, -9.81}));
    model.add(make_mass_damping(model.body(), 2));
    model.add(make_damping(0.003));
  };
  const auto damped_cells = [](Model& model) {
    model.add(make_quadratic_drag(model.body(), 1000, 1));
    model.add(make_cell_damping(model.body(), 1, 2));
  };
  const Body hexahedra = cell_box(cell_kind("hexahedron8"), {2, 2, 2}, {0.02, 0.02, 0.02}, 0.1),
             quadratic = cell_box(cell_kind("hexahedron27"), {1, 1, 1}, {0.02, 0.02, 0.02}, 0.1);
  const std::vector<Case> cases{springs("springs", nothing),
                                springs("damped springs", damped),
                                cells("tetrahedra", jittered_block(), "neo_hookean", nothing),
                                cells("damped tetrahedra", jittered_block(), "neo_hookean", damped_cells),
                                cells("hexahedra", hexahedra, "neo_hookean", nothing),
                                with_past("prony:standard", jittered_lattice()),
                                with_past("prony:neo_hookean", jittered_block()),
                                with_past("prony:neo_hookean", hexahedra),
                                with_past("prony:neo_hookean+volume", quadratic, 0.45),
                                with_past("prony:neo_hookean_membrane", quadratic_sheet(0.001)),
                                with_past("mullins:standard", jittered_lattice()),
                                with_past("mullins:neo_hookean", jittered_block()),
                                with_past("mullins:neo_hookean", hexahedra),
                                with_past("mullins:neo_hookean+volume", hexahedra, 0.45),
                                with_past("mullins:neo_hookean_membrane", sheet(0.001))};
  const std::vector<Steps> methods{{method("symplectic_euler"), 1000, 1e-6},
                                   {method("velocity_verlet"), 1000, 1e-6},
                                   {method("backward_euler"), 20, 1e-6},
                                   {method("newmark"), 20, 1e-6},
                                   {method("newmark", {{"beta", 0.3}, {"gamma", 0.6}}), 10, 1e-6},
                                   {method("generalized_alpha"), 20, 1e-6}};
  [[maybe_unused]] int met = 0;
  for (Case one : cases)
    for (Steps by : methods) {
#ifdef __SANITIZE_ADDRESS__
      if (++met % 5) continue;  // no divisor of the steppers' number: each of them is met
#endif
      if (one.name.starts_with("mullins")) one.by_number = by.options.method->name != "symplectic_euler";
      if (one.name != cases[0].name) by.steps = std::min(by.steps, 40);  // each is run five times
      Problem problem(one, nullptr, 0);
      const double stable = find_stable_step(problem.model, problem.start).step;
      const double dt = by.options.method->is_explicit ? 0.2 * stable : one.implicit_step * stable;
      const auto [sweep, differences] = both(one, by, dt);
      INFO(one.name << " by " << by.options.method->name << ": " << sweep << " and " << differences);
      CHECK(sweep == Approx(differences).epsilon(by.tolerance));
    }
}

TEST_CASE("of a linear body the sweep is the transpose of the run to rounding", "[adjoint][trajectory]") {
  // Springs without a rest length pull in proportion: states are linear in start and forces.
  Case one = springs("linear", [](Model& model) { model.add(make_mass_damping(model.body(), 2)); });
  one.body.connections.rest_length.assign(one.body.connections.rest_length.size(), 1e-300);
  for (const std::string name :
       {"symplectic_euler", "velocity_verlet", "backward_euler", "newmark", "generalized_alpha"}) {
    INFO(name);
    Problem problem(one, nullptr, 0);
    const double dt = 0.2 * find_stable_step(problem.model, problem.start).step;
    const Positions by_x = random_motion(one.body, 51), by_v = random_motion(one.body, 52);
    Trajectory run(problem.model, problem.start, dt, 200, method(name));
    const TrajectoryAdjoint found = run.adjoint([&](int number, const State&, Positions& of_x, Positions& of_v) {
      if (number == run.steps()) of_x += by_x, of_v += by_v;
    });
    Change along{random_motion(one.body, 53),
                 random_motion(one.body, 54),
                 random_motion(one.body, 55),
                 {VectorX::Zero(one.elements)}};
    for (const double size : {1., 1e-3}) {
      Problem other(one, &along, size);
      const Trajectory moved(other.model, other.start, dt, 200, method(name));
      const double change = product(by_x, moved.end().positions - run.end().positions) +
                            product(by_v, moved.end().velocities - run.end().velocities),
                   sum = product(found.positions, along.positions) + product(found.velocities, along.velocities) +
                         product(found.forces, along.forces),
                   most = found.positions.norm() * along.positions.norm() +
                          found.velocities.norm() * along.velocities.norm() + found.forces.norm() * along.forces.norm();
      CHECK(std::abs(change - size * sum) < 1e-12 * most);
    }
  }
}

TEST_CASE("a sweep stores about two square roots of its steps, and is bitwise identical on any threads",
          "[adjoint][trajectory]") {
  const Case one = cells("tetrahedra", jittered_block(), "neo_hookean", [](Model&) {});
  Positions first;
  for (const int threads : {1, 2, 3}) {
    const ThreadScope scope(nullptr, threads);
    Problem problem(one, nullptr, 0);
    Trajectory run(problem.model, problem.start, 1e-5, 1000, method("velocity_verlet"));
    CHECK(run.stored_numbers() == 64u * 9u * static_cast<std::size_t>(one.body.size()));
    const TrajectoryAdjoint found = run.adjoint([&](int number, const State& state, Positions& of_x, Positions&) {
      if (number == 1000) of_x += state.positions;
    });
    if (threads == 1) first = found.positions;
    CHECK(found.positions == first);
  }
}

TEST_CASE("what damping by the stiffness makes of each element's share is not said", "[adjoint][trajectory]") {
  for (const bool damps : {false, true}) {
    Problem problem(springs("springs",
                            [&](Model& model) {
                              const auto law = model.elasticity().front()->clone();
                              if (damps) model.add(make_stiffness_damping(model.body(), *law, 1e-3));
                            }),
                    nullptr, 0);
    Trajectory run(problem.model, problem.start, 1e-4, 3, method("newmark"));
    const auto found = run.adjoint([](int, const State&, Positions& positions, Positions&) { positions.setOnes(); });
    REQUIRE(found.stiffness.size() == 1);
    CHECK((found.stiffness[0].size() == 0) == damps);
  }
}

TEST_CASE("a run without a transpose is refused by name", "[adjoint][trajectory]") {
  const Case one = springs("springs", [](Model&) {});
  Problem problem(one, nullptr, 0);
  const auto refused = [&](const StepperOptions& by, const std::string& why) {
    CHECK_THROWS_WITH(Trajectory(problem.model, problem.start, 1e-4, 3, by), Catch::Contains(why));
  };
  refused(method("xpbd"), "stepper 'xpbd' has no transpose");
  const double longest = find_stable_step(problem.model, problem.start).step;
  CHECK_THROWS_WITH(Trajectory(problem.model, problem.start, 1.01 * longest, 3, method("velocity_verlet")),
                    Catch::Contains("are not stable"));
  CHECK_NOTHROW(Trajectory(problem.model, problem.start, 0.99 * longest, 3, method("velocity_verlet")));
  problem.model.add(
      make_updated_springs(problem.body, [&](const Positions&) { return VectorX::Constant(one.elements, 1); }));
  refused(method("newmark"), "constants that change");

  const Case softens = with_past("mullins:standard", jittered_lattice());
  Problem soft(softens, nullptr, 0), below(softens, nullptr, 0), above(softens, nullptr, 0);
  Trajectory run(soft.model, soft.start, 1e-5, 3, method("symplectic_euler"));
  const auto nothing = [](int, const State&, Positions&, Positions&) {};
  CHECK_NOTHROW(run.adjoint(nothing));
  CHECK_THROWS_WITH(run.adjoint(nothing, {{&below.model, &above.model, 1}}), Catch::Contains("take velocity_verlet"));
}
