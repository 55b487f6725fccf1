#include "elastin/core/solve/sensitivity.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "core/forces/surface_load.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/solve/block_rows.h"
#include "elastin/core/solve/vibrations.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

/// A block clamped at its low end and guided across its axis at its high one, which is pulled.
struct Pulled {
  explicit Pulled(Body given, const std::function<ElasticTerms(const Body&)>& make) : body(std::move(given)) {
    model = std::make_unique<Model>(body);
    model->add(make(body));
    const double low = body.rest.row(0).minCoeff(), high = body.rest.row(0).maxCoeff();
    for (int i = 0; i < body.size(); ++i)
      if (body.rest(0, i) < low + 1e-3)
        model->supports.push_back({i});
      else if (body.rest(0, i) > high - 1e-3)
        model->supports.push_back({i, Vector3(0, 1, 1).asDiagonal(), Vector3(0.1 * (high - low), 0, 0)});
    forces = 1e-3 * random_motion(body, 5);
    add(forces);
  }
  void add(const Positions& loads) {
    std::vector<int> all(static_cast<std::size_t>(body.size()));
    for (int i = 0; i < body.size(); ++i) all[i] = i;
    model->add(std::make_unique<PointLoads>(body, all, loads));
  }
  /// Positions and reactions, the latter by molecule.
  std::pair<Positions, Positions> solve() {
    state = state_at_rest(body);
    const StaticResult result = solve_static(*model, state, {.tolerance = 1e-14});
    REQUIRE(result.outcome == Outcome::converged);
    Positions reactions = Positions::Zero(3, body.size());
    for (std::size_t i = 0; i < model->supports.size(); ++i)
      reactions.col(model->supports[i].molecule) = result.reactions.col(i);
    return {state.positions, reactions};
  }
  Positions fixed_part(const Positions& vectors) const {
    Positions part = Positions::Zero(3, body.size());
    for (const Support& support : model->supports) {
      const Vector3 own = vectors.col(support.molecule);
      part.col(support.molecule) = own - support.free * own;
    }
    return part;
  }
  Body body;
  std::unique_ptr<Model> model;
  Positions forces;
  State state;
};

double product(const Positions& a, const Positions& b) { return a.cwiseProduct(b).sum(); }

const Strategy& strategy(const std::string& name) {
  static const Catalog catalog = built_in_catalog();
  static std::map<std::string, Strategy> found;
  return found.try_emplace(name, catalog.find(name)).first->second;
}

Material soft() {
  Material material;
  material.youngs_modulus = 5000;
  material.poissons_ratio = 0.3;
  return material;
}

}  // namespace

TEST_CASE("what all parameters make of one function is what each makes of it: forward and adjoint agree", "[adjoint]") {
  for (const bool with_pressure : {false, true})
    for (const std::string name : {"patch", "neo_hookean", "neo_hookean+volume"}) {
      INFO(name << (with_pressure ? " with a pressure that follows the sides" : ""));
      Pulled pulled(jittered_block(), [&](const Body& body) { return strategy(name).make(body, soft(), {}); });
      if (with_pressure) {
        std::vector<int> low;
        for (int i = 0; i < pulled.body.size(); ++i)
          if (pulled.body.rest(2, i) < 1e-3) low.push_back(i);
        const SurfaceLoad load{outer_faces(pulled.body, low)};
        REQUIRE(load.faces.size() > 0);
        pulled.model->add(std::make_unique<SurfaceForces>(pulled.body, load, 200));
        REQUIRE(!pulled.model->symmetric());
      }
      pulled.solve();
      Sensitivity sensitivity(*pulled.model, pulled.state);
      const Positions force = 1e-3 * random_motion(pulled.body, 7), moved = 1e-3 * random_motion(pulled.body, 8),
                      of_positions = random_motion(pulled.body, 9), of_reactions = random_motion(pulled.body, 10);
      const StaticResponse forward = sensitivity.forward(force, moved);
      REQUIRE(forward.result.outcome == Outcome::converged);
      const Adjoint adjoint = sensitivity.adjoint(of_positions, of_reactions);
      REQUIRE(adjoint.result.outcome == Outcome::converged);
      if (const auto& law = *pulled.model->elasticity().front(); law.local()) {
        const VectorX stiffer =
            VectorX::NullaryExpr(law.local()->elements(), [](Eigen::Index i) { return std::sin(1. + 7 * i); });
        const StaticResponse by = sensitivity.forward(sensitivity.forces_by_stiffness(law, stiffer), 0 * moved);
        double change = product(of_positions, by.motion);
        for (std::size_t i = 0; i < pulled.model->supports.size(); ++i)
          change += of_reactions.col(pulled.model->supports[i].molecule).dot(by.result.reactions.col(i));
        const VectorX each = sensitivity.by_stiffness(law, adjoint);
        CHECK(std::abs(change - each.dot(stiffer)) < 1e-12 * each.norm() * stiffer.norm());
        CHECK_THROWS_AS(sensitivity.forces_by_stiffness(law, VectorX::Ones(3)), InputError);
      }
      double one = product(of_positions, forward.motion), size = of_positions.norm() * forward.motion.norm();
      for (std::size_t i = 0; i < pulled.model->supports.size(); ++i)
        one += of_reactions.col(pulled.model->supports[i].molecule).dot(forward.result.reactions.col(i));
      const double other = product(adjoint.forces, force) + product(adjoint.displacement, moved);
      size += of_reactions.norm() * forward.result.reactions.norm();
      CHECK(std::abs(one - other) < 1e-12 * size);
    }
}

TEST_CASE("what a solve leaves makes derivatives quicker and no others", "[adjoint]") {
  for (const bool by_force : {true, false})
    for (const std::string name : {"patch", "neo_hookean"}) {
      INFO(name << (by_force ? ", work of the loads" : ", force of the grip"));
      Pulled pulled(jittered_block(), [&](const Body& body) { return strategy(name).make(body, soft(), {}); });
      pulled.state = state_at_rest(pulled.body);
      for (Support& support : pulled.model->supports) support.displacement *= by_force ? 0 : 0.01;
      StaticOptions options{.method = "pcg", .tolerance = 1e-10};
      const std::shared_ptr<LastSolve> last = make_last_solve();
      REQUIRE(solve_static(*pulled.model, pulled.state, options, *last).outcome == Outcome::converged);
      const Positions none = Positions::Zero(3, pulled.body.size());
      Positions grip = none;
      for (const Support& support : pulled.model->supports)
        if (support.free != Matrix3::Zero()) grip(0, support.molecule) = 1;
      Sensitivity from_nothing(*pulled.model, pulled.state, options, 1e-10),
          from_last(*pulled.model, pulled.state, options, 1e-10, *last);
      const auto adjoint = [&](Sensitivity& at) {
        const Adjoint found = by_force ? at.adjoint(pulled.forces, none) : at.adjoint(none, grip);
        REQUIRE(found.result.outcome == Outcome::converged);
        return found;
      };
      const Adjoint slow = adjoint(from_nothing), quick = adjoint(from_last);
      CHECK(quick.result.linear_iterations < 0.9 * slow.result.linear_iterations);
      CHECK((quick.forces - slow.forces).norm() < 1e-8 * slow.forces.norm());
      CHECK((quick.displacement - slow.displacement).norm() < 1e-8 * slow.displacement.norm());
      // The next one has nothing to begin with.
      Sensitivity again(*pulled.model, pulled.state, options, 1e-10, *last);
      CHECK(adjoint(again).forces == slow.forces);
    }
}

TEST_CASE("derivatives by forces, supports and the stiffness of each element are differences of whole solutions",
          "[adjoint]") {
  const auto mean = [](const Positions& weights, const std::pair<Positions, Positions>& solved) {
    return product(weights, solved.first) + 1e-3 * product(weights.cwiseAbs(), solved.second);
  };
  for (const std::string name : {"springs", "neo_hookean"}) {
    INFO(name);
    const Body body = name == "springs" ? jittered_lattice() : jittered_block();
    VectorX constants;
    const auto make = [&](const Body& on) -> ElasticTerms {
      if (name != "springs") return strategy(name).make(on, soft(), {});
      if (constants.size() == 0) constants = VectorX::Constant(on.connections.size(), 40);
      return make_springs(on, constants);
    };
    Pulled pulled(body, make);
    const Positions weights = random_motion(body, 3);
    pulled.solve();
    Sensitivity sensitivity(*pulled.model, pulled.state);
    const Adjoint adjoint = sensitivity.adjoint(weights, 1e-3 * weights.cwiseAbs());
    // Second-order Taylor remainders over five decades, by forces and prescribed displacements at once.
    const Positions force = random_motion(body, 21), moved = pulled.fixed_part(random_motion(body, 22));
    const double base = mean(weights, pulled.solve());
    const double slope = product(adjoint.forces, force) + product(adjoint.displacement, moved);
    const auto changed = [&](double h) {
      Pulled other(body, make);
      other.add(h * force);
      for (Support& support : other.model->supports) support.displacement += h * moved.col(support.molecule);
      return mean(weights, other.solve());
    };
    double before = 0;
    for (const double h : {1e-4, 1e-5, 1e-6}) {
      const double remainder = std::abs(changed(h) - base - h * slope);
      if (before > 0) CHECK(remainder == Approx(before / 100).epsilon(0.2).margin(1e-13));
      before = remainder;
    }
    const double h = 5e-6;  // differences of fourth order
    CHECK((8 * (changed(h) - changed(-h)) - (changed(2 * h) - changed(-2 * h))) / (12 * h) ==
          Approx(slope).epsilon(1e-8));
    if (name != "springs") continue;
    const VectorX by_constant =
        sensitivity.by_stiffness(*pulled.model->elasticity()[0], adjoint).cwiseQuotient(constants);
    for (const int connection : {0, 17, 40}) {
      const double step = 1e-3 * constants[connection];
      const auto with = [&](double change) {
        constants[connection] += change;
        Pulled other(body, make);
        constants[connection] -= change;
        return mean(weights, other.solve());
      };
      CHECK((with(step) - with(-step)) / (2 * step) == Approx(by_constant[connection]).epsilon(1e-5));
    }
  }
}

TEST_CASE("a stiffness that leaves out how constants change is refused where the body is strained", "[adjoint]") {
  Body body = jittered_lattice();
  Model model(body);
  model.add(built_in_catalog().find("angles_update").make(body, {.youngs_modulus = 1e4, .poissons_ratio = 0.2}, {}));
  State state = state_at_rest(body);
  Sensitivity(model, state);  // there it leaves nothing out
  CHECK(stiffness_blocks(model, state).values.size() > 0);
  CHECK(find_vibrations(model, state, 1).outcome == Outcome::converged);
  state.positions *= 1.01;
  using Catch::Matchers::Contains;
  CHECK_THROWS_WITH(Sensitivity(model, state), Contains("as those of angles_update"));
  CHECK_THROWS_WITH(stiffness_blocks(model, state), Contains("as those of angles_update"));
  CHECK_THAT(find_vibrations(model, state, 1).cause, Contains("as those of angles_update"));
}

TEST_CASE("derivatives by all elements are bitwise identical on any number of threads", "[adjoint]") {
  std::vector<VectorX> found;
  for (const int count : {1, 3}) {
    set_threads(count);
    Pulled pulled(jittered_block(), [&](const Body& body) { return strategy("neo_hookean").make(body, soft(), {}); });
    pulled.solve();
    Sensitivity sensitivity(*pulled.model, pulled.state);
    const Adjoint adjoint = sensitivity.adjoint(random_motion(pulled.body, 3), Positions::Zero(3, pulled.body.size()));
    found.push_back(sensitivity.by_stiffness(*pulled.model->elasticity()[0], adjoint));
  }
  set_threads(0);
  CHECK(found[0] == found[1]);
  CHECK(found[0].norm() > 0);
}
