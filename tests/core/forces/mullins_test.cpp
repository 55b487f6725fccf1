// Softening after Ogden and Roxburgh against its closed form in uniaxial stress, and how its history is kept.

#include "elastin/core/forces/mullins.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "elastin/core/base/error.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/core/simulation/simulation.h"
#include "elastin/core/solve/statics.h"
#include "support/bodies.h"
#include "support/slopes.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

const Softening kSoftening{1.6, 300, 0.2};
const Vector3 kSize(0.01, 0.01, 0.02);

/// η as it is printed in [Ogden & Roxburgh 1999].
double eta(double energy, double most) {
  return 1 - std::erf((most - energy) / (kSoftening.m + kSoftening.beta * most)) / kSoftening.r;
}

/// A body in uniaxial stress: positions along z are prescribed, the rest stays. With ν = 0 that is the equilibrium of
/// neo_hookean_log, μ/2 (tr C − 3) − μ ln J: P = μ (λ − 1/λ), W = μ/2 (λ² − 1) − μ ln λ.
struct Bar {
  static constexpr double mu = 1e4;
  Body body;
  Model model;
  State state;

  Bar(Body whole, const std::string& strategy, const Material& material)
      : body(std::move(whole)), model(body), state(state_at_rest(body)) {
    model.add(built_in_catalog().find(strategy).make(body, material, {}));
    model.declare_history(state);
    model.commit_step(state);
  }
  void begin(double stretch) {
    model.begin_step(state, std::numeric_limits<double>::infinity());
    state.positions = body.rest;
    state.positions.row(2) *= stretch;
  }
  /// Force on the lower end [N] at a stretch that is then reached.
  double pull(double stretch) {
    begin(stretch);
    const double force = end_force();
    CHECK(end_force() == force);
    model.commit_step(state);
    CHECK(end_force() == Approx(force).epsilon(1e-12));
    return force;
  }
  double end_force() const {
    const Positions forces = model.elastic_forces(state.positions);
    double sum = 0;
    for (int a = 0; a < body.size(); ++a)
      if (body.rest(2, a) < 1e-9) sum += forces(2, a);
    return sum;
  }

  static double stress(double l) { return mu * (l - 1 / l); }
  static double energy(double l) { return mu / 2 * (l * l - 1) - mu * std::log(l); }
};

Material soft() {
  Material material{.youngs_modulus = 2 * Bar::mu, .poissons_ratio = 0, .thickness = 0.001};
  material.law = LawConstants{.law = "neo_hookean_log"};
  material.softening = kSoftening;
  return material;
}

/// Stretches of a test with growing cycles.
const std::vector<double> kCycles{1.1, 1.3, 1.2, 1.05, 1, 0.95, 1.1, 1.25, 1.3, 1.5, 1.35, 1.3, 1.1, 1.45, 1.6};

}  // namespace

TEST_CASE("softened energy: its slope is eta, and eta's slope the next", "[mullins]") {
  for (const double most : {0., 10., 1e3, 5e4})
    for (const double part : {0.01, 0.3, 0.9, 1.2}) {
      const double energy = part * std::max(most, 1.), h = 1e-4 * energy;
      const SoftenedEnergy now = softened_energy(kSoftening, energy, most);
      const auto at = [&](double w) { return softened_energy(kSoftening, w, most); };
      INFO(most << " " << energy);
      CHECK((at(energy + h).energy - at(energy - h).energy) / (2 * h) == Approx(now.factor).epsilon(1e-7));
      CHECK((at(energy + h).factor - at(energy - h).factor) / (2 * h) == Approx(now.slope).epsilon(1e-6).margin(1e-12));
      CHECK(now.factor == Approx(energy >= most ? 1 : eta(energy, most)).epsilon(1e-14));
      CHECK(softened_energy(kSoftening, 0, most).energy == Approx(0).margin(1e-9));
    }
}

TEST_CASE("cells of every shape soften as the closed form says", "[mullins][cells]") {
  std::vector<std::pair<std::string, Body>> bodies{
      {"tetrahedra", tetrahedral_block(BlockKind::body_centred, {1, 1, 2}, kSize)}};
  for (const CellKind& kind : cell_kinds())
    if (kind.dimensions == 3) bodies.emplace_back(kind.name, cell_box(kind, {1, 1, 2}, kSize, 0));
  REQUIRE(bodies.size() > 4);
  const double area = kSize[0] * kSize[1];
  for (auto& [name, body] : bodies) {
    INFO(name);
    Bar bar(body, "mullins:neo_hookean_log", soft());
    double most = 0;
    for (const double stretch : kCycles) {
      const double energy = Bar::energy(stretch);
      most = std::max(most, energy);
      CHECK(bar.pull(stretch) == Approx(eta(energy, most) * Bar::stress(stretch) * area).epsilon(1e-9).margin(1e-12));
    }
  }
}

TEST_CASE("springs soften as rods of the material", "[mullins]") {
  Body pair = cubic_lattice({1, 1, 2}, 0.02, {true, false, false});
  set_matter(pair, 0.001, 1000, 0, 0);
  const double E = 2 * Bar::mu, k = E * 1e-4 / 0.02;  // a rod of 1 cm²
  Model model(pair);
  Material material = soft();
  material.law.reset();
  Strategy rule = make_spring_rule("rods", [k](const Body& body, const Material&, const ParameterValues&) -> VectorX {
    return VectorX::Constant(body.connections.size(), k);
  });
  model.add(with_softening(rule).make(pair, material, {}));
  State state = state_at_rest(pair);
  model.declare_history(state);
  double most = 0;
  for (const double stretch : kCycles) {
    model.begin_step(state, std::numeric_limits<double>::infinity());
    state.positions.row(2) = stretch * pair.rest.row(2);
    const double strain = stretch - 1, energy = E * strain * strain / 2;
    most = std::max(most, energy);
    CHECK(model.elastic_forces(state.positions)(2, 0) ==
          Approx(eta(energy, most) * E * strain * 1e-4).epsilon(1e-9).margin(1e-14));
    model.commit_step(state);
  }
}

TEST_CASE("membranes soften by their energy over the thickness", "[mullins][membranes]") {
  const Body body = sheet(0.001);
  Material material = soft();
  material.law.reset();
  Model softening(body), virgin(body);
  softening.add(built_in_catalog().find("mullins:neo_hookean_membrane").make(body, material, {}));
  virgin.add(built_in_catalog().find("neo_hookean_membrane").make(body, material, {}));
  State state = state_at_rest(body);
  softening.declare_history(state);
  const auto spread = [&](double stretch) -> Positions { return stretch * body.rest; };
  double size = 0;
  for (const auto& [a, b, c] : body.triangles)
    size += Vector3(body.rest.col(b) - body.rest.col(a)).cross(Vector3(body.rest.col(c) - body.rest.col(a))).norm() / 2;
  state.positions = spread(1.3);
  const double most = virgin.elastic_energy(state.positions) / (size * material.thickness);
  softening.begin_step(state, std::numeric_limits<double>::infinity());
  softening.commit_step(state);
  const double energy = virgin.elastic_energy(spread(1.15)) / (size * material.thickness);
  const Positions full = virgin.elastic_forces(spread(1.15));
  CHECK((softening.elastic_forces(spread(1.15)) - eta(energy, most) * full).norm() <= 1e-9 * full.norm());
}

TEST_CASE("softened forces are those of an energy, with its tangent", "[mullins]") {
  const Catalog catalog = built_in_catalog();
  Material material = soft();
  material.poissons_ratio = 0.3;
  std::vector<std::pair<std::string, Body>> cases{{"mullins:lattice", jittered_lattice()},
                                                  {"mullins:neo_hookean", jittered_block()},
                                                  {"prony:mullins:neo_hookean", jittered_block()}};
  for (const CellKind& kind : cell_kinds())
    if (kind.dimensions == 3)
      for (const char* name :
           {"mullins:neo_hookean_log", "prony:mullins:neo_hookean_log", "mullins:neo_hookean+volume"})
        cases.emplace_back(name, cell_box(kind, {2, 1, 1}, {0.02, 0.01, 0.01}, 0.1));
  material.relaxation = Relaxation{{{0.5, 0.2}, {0.3, 3}}};
  for (const auto& [name, body] : cases) {
    INFO(name << (body.blocks.empty() ? "" : body.blocks[0].kind->name));
    Model model(body);
    model.add(catalog.find(name).make(body, material, {}));
    State state = state_at_rest(body);
    model.declare_history(state);
    model.commit_step(state);
    state.positions = deformed(body, 2e-4), state.time = 0.4;
    model.commit_step(state);
    model.begin_step(state, 0.5);
    const Positions positions = body.rest + 0.6 * (deformed(body, 3e-4, 5) - body.rest);
    check_slopes(model, positions, random_motion(body, 21));
  }
}

TEST_CASE("an equilibrium on the way down has the softened force, and the first way up does not know of it",
          "[mullins]") {
  const Catalog catalog = built_in_catalog();
  for (const char* name : {"mullins:neo_hookean_log", "neo_hookean_log"}) {
    Body body = cell_box(cell_kind("hexahedron8"), {1, 1, 2}, kSize, 0);
    Model model(body);
    model.add(catalog.find(name).make(body, soft(), {}));
    for (int a = 0; a < body.size(); ++a) {
      const double z = body.rest(2, a);
      Matrix3 free = Matrix3::Zero();
      if (z > 1e-9 && z < kSize[2] - 1e-9) free = Matrix3::Identity();
      model.supports.push_back({a, free, Vector3::Zero()});
    }
    State state = state_at_rest(body);
    for (const double stretch : {1.4, 1.2}) {
      for (auto& support : model.supports)
        support.displacement = Vector3(0, 0, (stretch - 1) * body.rest(2, support.molecule));
      const StaticResult solved = solve_static(model, state, {});
      REQUIRE(solved.outcome == Outcome::converged);
      const double factor = std::string(name).starts_with("mullins") ? eta(Bar::energy(stretch), Bar::energy(1.4)) : 1;
      double force = 0;
      for (int a = 0; a < body.size(); ++a)
        if (body.rest(2, a) < 1e-9) force -= solved.reactions(2, a);
      CHECK(force == Approx(factor * Bar::stress(stretch) * 1e-4).epsilon(1e-7));
      model.commit_step(state);
    }
  }
}

TEST_CASE("a saved state softens on, and a fresh one is virgin", "[mullins]") {
  Bar first(cell_box(cell_kind("tetrahedron10"), {1, 1, 1}, kSize, 0), "mullins:neo_hookean_log", soft());
  first.pull(1.5);
  Bar second(cell_box(cell_kind("tetrahedron10"), {1, 1, 1}, kSize, 0), "mullins:neo_hookean_log", soft());
  const double fresh = second.pull(1.2);
  second.state = first.state;
  CHECK(second.pull(1.2) == first.pull(1.2));
  CHECK(second.pull(1.2) < 0.9 * fresh);
}

TEST_CASE("softening that cannot be is refused", "[mullins]") {
  CHECK_THROWS_WITH(check_softening({1, 1, 1}), Catch::Contains("above 1"));
  CHECK_THROWS_WITH(check_softening({2, -1, 1}), Catch::Contains("below 0"));
  CHECK_THROWS_WITH(check_softening({2, 0, 0}), Catch::Contains("one of m and beta"));
  const Catalog catalog = built_in_catalog();
  CHECK_THROWS_WITH(catalog.find("mullins:angles_update"), Catch::Contains("has none"));
  CHECK_THROWS_WITH(catalog.find("mullins:prony:lattice"), Catch::Contains("prony:mullins:"));
  CHECK_THROWS_WITH(catalog.find("mullins:mullins:lattice"), Catch::Contains("'mullins:' is repeated or misplaced"));
  CHECK_THROWS_WITH(catalog.find("calibrated:mullins:lattice"), Catch::Contains("mullins:calibrated:"));
  CHECK_THROWS_WITH(catalog.find("mulins:lattice"), Catch::Contains("did you mean 'mullins:'"));
  CHECK(catalog.find("mullins:lattice").unsuited_material(Material{}) == "needs `softening` in the material");
}
