// Active fibres: their force by length and time, and a muscle that contracts against a spring.

#include "elastin/core/forces/muscle.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/simulation/fibres.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/tangent.h"
#include "elastin/core/simulation/parts.h"
#include "elastin/core/solve/statics.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

constexpr double kShear = 1e4, kTension = 3e4;
const Vector3 kSize(0.01, 0.01, 0.02);

Material muscle() {
  Material material{.youngs_modulus = 2 * kShear, .poissons_ratio = 0};
  material.law = LawConstants{.law = "neo_hookean_log"};
  material.active = ActiveFibre{.direction = Vector3::UnitZ(), .stress = kTension};
  return material;
}

/// f as physics states it.
double force_at(double r) {
  if (r <= 0.4 || r >= 1.6) return 0;
  if (r <= 0.6) return 9 * std::pow(r - 0.4, 2);
  if (r >= 1.4) return 9 * std::pow(r - 1.6, 2);
  return 1 - 4 * std::pow(1 - r, 2);
}

std::vector<std::pair<std::string, Body>> solids() {
  std::vector<std::pair<std::string, Body>> bodies{
      {"tetrahedra", tetrahedral_block(BlockKind::body_centred, {1, 1, 2}, kSize)}};
  for (const CellKind& kind : cell_kinds())
    if (kind.dimensions == 3) bodies.emplace_back(kind.name, cell_box(kind, {1, 1, 2}, kSize, 0));
  return bodies;
}

double lower_end_force(const Model& model, const Positions& positions) {
  const Positions forces = model.elastic_forces(positions);
  double sum = 0;
  for (int a = 0; a < model.body().size(); ++a)
    if (model.body().rest(2, a) < 1e-9) sum += forces(2, a);
  return sum;
}

/// Springs along z from the molecules of the upper end to where they are at rest, one constant a molecule.
class EndSprings final : public Load {
 public:
  EndSprings(const Body& body, VectorX constants) : body_(body), constants_(std::move(constants)) {}
  void add_forces(const State& state, Positions& forces) const override {
    each([&](int a) { forces(2, a) -= constants_[a] * (state.positions(2, a) - body_.rest(2, a)); });
  }
  double energy(const State& state) const override {
    double sum = 0;
    each([&](int a) { sum += constants_[a] / 2 * std::pow(state.positions(2, a) - body_.rest(2, a), 2); });
    return sum;
  }
  bool changes() const override { return true; }
  bool feels_velocity() const override { return false; }
  void add_change(const State&, const Positions& motion, const Positions&, Positions& change) const override {
    each([&](int a) { change(2, a) -= constants_[a] * motion(2, a); });
  }
  void visit_blocks(const State&, double, const BlockVisitor& visit) const override {
    each([&](int a) { visit(a, a, constants_[a] * Vector3::UnitZ() * Vector3::UnitZ().transpose()); });
  }

 private:
  template <class Work>
  void each(Work work) const {
    for (int a = 0; a < body_.size(); ++a)
      if (body_.rest(2, a) > kSize[2] - 1e-9) work(a);
  }
  const Body& body_;
  VectorX constants_;
};

}  // namespace

TEST_CASE("force by length: pieces that fit together, with slope and work", "[muscle]") {
  for (const double r : {0.3, 0.4, 0.45, 0.6, 0.61, 0.9, 1., 1.3, 1.4, 1.5, 1.6, 2.}) {
    INFO(r);
    CHECK(force_length(r).value == Approx(force_at(r)).epsilon(1e-13).margin(1e-15));
    const double h = 1e-6;
    const double slope = (force_length(r + h).value - force_length(r - h).value) / (2 * h);
    if (r != 0.6 && r != 1.4)  // where the pieces meet at an angle
      CHECK(force_length(r).slope == Approx(slope).epsilon(1e-5).margin(2e-5));
    CHECK((force_length(r + h).work - force_length(r - h).work) / (2 * h) ==
          Approx(force_at(r) / r).epsilon(1e-6).margin(1e-8));
  }
}

TEST_CASE("a muscle that is held pulls with T f A/lambda, in cells of every shape, as its activation says",
          "[muscle]") {
  const double area = kSize[0] * kSize[1];
  for (const auto& [name, body] : solids()) {
    INFO(name);
    Material material = muscle();
    material.active->optimal_stretch = 1.1;
    material.active->activation = [](double time) { return std::min(time, 1.); };
    Model model(body);
    model.add(make_muscle(body, material));
    State state = state_at_rest(body);
    model.declare_history(state);
    for (const double stretch : {0.55, 0.8, 1., 1.2, 1.6}) {
      state.positions = body.rest;
      state.positions.row(2) *= stretch;
      for (const double time : {0., 0.25, 1., 3.}) {
        const double exact = std::min(time, 1.) * kTension * force_at(stretch / 1.1) / stretch * area;
        model.begin_step(state, time);
        CHECK(lower_end_force(model, state.positions) == Approx(exact).epsilon(1e-11).margin(1e-15));
        State then = state;
        then.time = time;
        model.begin_step(then, std::numeric_limits<double>::infinity());
        CHECK(lower_end_force(model, state.positions) == Approx(exact).epsilon(1e-11).margin(1e-15));
      }
    }
  }
}

TEST_CASE("a muscle takes its constants from the material again when the rest changes", "[muscle][rest]") {
  for (const auto& [name, body] : solids()) {
    INFO(name);
    Body grown = body;
    grown.unstressed = std::make_shared<const Rest>(
        Rest{[](const Vector3&, const Vector3&) { return Matrix3(1.05 * Matrix3::Identity()); }});
    const Material material = muscle();
    Model model(body), of_grown(grown);
    model.add(make_muscle(body, material));
    of_grown.add(make_muscle(grown, material));
    const Positions positions = deformed(body, 1e-3);
    const Positions plain = model.elastic_forces(positions);
    of_grown.set_rest(1);
    of_grown.set_rest(0);
    CHECK((of_grown.elastic_forces(positions) - plain).norm() <= 1e-12 * plain.norm());
  }
}

TEST_CASE("active forces are those of an energy, with its tangent", "[muscle]") {
  for (const auto& [name, body] : solids()) {
    INFO(name);
    Material material = muscle();
    material.active->direction = Vector3(1, 2, 2) / 3;
    Model model(body);
    model.add(make_muscle(body, material));
    const Positions positions = deformed(body, 3e-4), motion = random_motion(body, 3);
    const double h = 1e-7, k = 1e-8;
    const auto energy = [&](double step) { return model.elastic_energy(positions + step * motion); };
    const double measured = (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h);
    CHECK(measured == Approx(-model.elastic_forces(positions).cwiseProduct(motion).sum()).epsilon(1e-6));
    const State at{positions, Positions::Zero(3, positions.cols())};
    const Tangent tangent(model, at);
    Positions predicted(3, body.size());
    tangent.apply(motion, predicted);
    const Positions change =
        -(model.elastic_forces(positions + k * motion) - model.elastic_forces(positions - k * motion)) / (2 * k);
    CHECK((predicted - change).norm() <= 1e-5 * change.norm());
  }
}

TEST_CASE("a muscle shortens a spring by the exact amount", "[muscle]") {
  // mu (l - 1/l) + T f(l)/l = k L (1 - l)/A with nu = 0.
  const double area = kSize[0] * kSize[1], length = kSize[2], constant = 200;
  for (const auto& [name, body] : solids()) {
    INFO(name);
    const Material material = muscle();
    const Strategy law = built_in_catalog().find("neo_hookean_log");
    Model model(body);
    model.add(law.make(body, material, {}));
    // Each molecule's share of the end is its share of a uniform stress.
    Positions stretched = body.rest;
    stretched.row(2) *= 1.1;
    VectorX shares = model.elastic_forces(stretched).row(2).transpose();
    for (int a = 0; a < body.size(); ++a)
      if (!(body.rest(2, a) > length - 1e-9)) shares[a] = 0;
    shares /= shares.sum();
    add_companions(model, law, material);
    model.add(std::make_unique<EndSprings>(body, constant * shares));
    for (int a = 0; a < body.size(); ++a)
      if (body.rest(2, a) < 1e-9) {
        Matrix3 free = Matrix3::Identity();
        free(2, 2) = 0;
        if (body.rest(0, a) < 1e-9) free(0, 0) = 0;
        if (body.rest(1, a) < 1e-9) free(1, 1) = 0;
        model.supports.push_back({a, free, Vector3::Zero()});
      }
    double low = 0.4, high = 1;
    for (int i = 0; i < 60; ++i) {
      const double l = (low + high) / 2;
      const double pull = kShear * (l - 1 / l) + kTension * force_at(l) / l - constant * length * (1 - l) / area;
      (pull > 0 ? high : low) = l;
    }
    State state = state_at_rest(body);
    const StaticResult solved = solve_static(model, state, {});
    REQUIRE(solved.outcome == Outcome::converged);
    CHECK(low < 0.9);
    for (int a = 0; a < body.size(); ++a)
      CHECK(state.positions(2, a) == Approx(low * body.rest(2, a)).epsilon(1e-7).margin(1e-10));
  }
}

TEST_CASE("directions around an axis: a ring of circumferential fibres resists its own widening", "[muscle][fibres]") {
  // A square ring's cells, each seen from the axis: radial, circumferential and axial components become those of space.
  Material material = muscle();
  material.around = RoundAxis{.point = Vector3(1, 2, 0), .direction = Vector3::UnitZ()};
  material.active->direction = Vector3::UnitY();
  for (const double angle : {0., 0.7, 2., 4.}) {
    const Vector3 radius(std::cos(angle), std::sin(angle), 0);
    const Material local = local_material(material, Vector3(1, 2, 5) + 0.3 * radius);
    CHECK((local.active->direction - Vector3(-std::sin(angle), std::cos(angle), 0)).norm() < 1e-14);
    CHECK_FALSE(local.around);
  }
  const Matrix3 turn = Eigen::AngleAxisd(0.4, Vector3(1, 1, 0).normalized()).toRotationMatrix();
  Material turned = material;
  rotate(turned, turn);
  const Vector3 place(1.2, 2.3, 0.4);
  CHECK((local_material(turned, turn * place).active->direction -
         turn * local_material(material, place).active->direction)
            .norm() < 1e-14);
}

TEST_CASE("muscle that cannot be is refused", "[muscle]") {
  CHECK_THROWS_WITH(check_active_fibre({.stress = 0}), Catch::Contains("above 0"));
  CHECK_THROWS_WITH(check_active_fibre({.stress = 1, .optimal_stretch = 0}), Catch::Contains("optimal_stretch"));
  const Catalog catalog = built_in_catalog();
  CHECK_THAT(fibres_unsuited(catalog.find("lattice"), jittered_lattice(), muscle()), Catch::Contains("not springs"));
  CHECK_THAT(fibres_unsuited(catalog.find("neo_hookean_membrane"), sheet(0.001), muscle()),
             Catch::Contains("not springs or membranes"));
  CHECK(fibres_unsuited(catalog.find("neo_hookean"), jittered_block(), muscle()).empty());
}
