// The rest of bodies that are described under stress: unloaded shapes and prestrain in place, of every strategy.

#include "core/solve/unloaded.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "core/simulation/fibres.h"
#include "elastin/core/forces/loads.h"
#include "elastin/core/model/rest.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/mesh/voronoi.h"
#include "support/bodies.h"
#include "support/law_constants.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

/// Calls test(body, make) for every strategy of solids that needs no memory, on every body and material that suit it:
/// fixed where x is least, with a weight along z and y that bends it by some per cent of its length.
template <class Test>
void for_each_hung(Test test) {
  std::vector<std::pair<std::string, Body>> bodies{{"lattice", jittered_lattice()}, {"block", jittered_block()}};
  for (const char* kind : {"hexahedron8", "hexahedron27", "tetrahedron10"})
    bodies.emplace_back(kind, cell_box(cell_kind(kind), {3, 2, 2}, {0.03, 0.02, 0.02}, 0.06, true));
  for (auto& [name, body] : bodies) body.voronoi = mesh::voronoi_cells(body);
  std::vector<Strategy> strategies = kCatalog.strategies();
  for (std::size_t i = 0, plain = strategies.size(); i < plain; ++i)
    if (strategies[i].make_without_volume || strategies[i].kind == StrategyKind::spring_rule)
      strategies.push_back(with_volume(strategies[i]));
  int tested = 0;
  for (const Strategy& strategy : strategies)
    for (const double nu : {0.3, 0.49})
      for (const auto& [name, body] : bodies) {
        if (strategy.kind == StrategyKind::wrapper || strategy.kind == StrategyKind::updated_spring_rule) continue;
        if (nu > 0.4 && strategy.kind == StrategyKind::spring_rule && !strategy.volume_modulus) continue;
        if (!body.blocks.empty() && strategy.kind != StrategyKind::cell_law) continue;
        Material material = material_of(5e3, nu);
        if (const auto constants = law_constants(); constants.contains(strategy.law) && !strategy.law.empty())
          material = with_law(*kCatalog.material_laws.find(strategy.law), constants.at(strategy.law), material);
        if (!strategy.unsuited(body).empty() || !material_unsuited(strategy, body, material).empty()) continue;
        // One's constant is given, not made from E; the other's springs are 3.75 times softer than their volume term.
        if (strategy.name.starts_with("uniform") || strategy.name.starts_with("divided")) continue;
        INFO(strategy.name << " on " << name << ", nu " << nu);
        const double low = body.rest.row(0).minCoeff() + 1e-3;
        const auto make = [&, &body = body](const Body& own) {
          struct Made {
            Body body;
            std::unique_ptr<Model> model;
          };
          const auto made = std::make_shared<Made>(Made{own, nullptr});
          made->model = std::make_unique<Model>(made->body);
          made->model->add(strategy.make(made->body, material, {}));
          made->model->add(make_gravity(made->body, {0, 1, -3}));
          for (int molecule = 0; molecule < own.size(); ++molecule)
            if (body.rest(0, molecule) < low) made->model->supports.push_back({molecule, Matrix3::Zero()});
          return std::shared_ptr<Model>(made, made->model.get());
        };
        State hung = state_at_rest(body);  // some rules leave mechanisms here, or hardly hold the weight
        if (solve_static(*make(body), hung, {}).outcome != Outcome::converged) continue;
        if ((hung.positions - body.rest).colwise().norm().maxCoeff() > 2e-3) continue;
        test(body, make);
        ++tested;
      }
  CHECK(tested > 60);
}

}  // namespace

TEST_CASE("every law and spring rule: the unloaded shape hangs to the given one", "[rest][conformance][slow]") {
  for_each_hung([](const Body& body, const auto& make) {
    const double size = (body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()).norm();
    const UnloadedShape found = find_unloaded(body, make);
    INFO(found.cause << " after " << found.steps << " steps");
    REQUIRE(found.outcome == Outcome::converged);
    CHECK((found.rest - body.rest).norm() > 1e-4 * size);
    const std::shared_ptr<Model> model = make(with_rest_shape(body, found.rest));
    State state = state_at_rest(model->body());
    REQUIRE(solve_static(*model, state, {}).outcome == Outcome::converged);
    CHECK((state.positions - body.rest).colwise().norm().maxCoeff() < 1e-8 * size);
  });
}

TEST_CASE("every law and spring rule: a prestrain keeps the body in its shape under its loads",
          "[rest][conformance][slow]") {
  for_each_hung([](const Body& plain, const auto& make) {
    Body body = plain;
    body.unstressed = std::make_shared<const Rest>(Rest{[](const Vector3& place, const Vector3&) {
      Matrix3 F;
      F << 1.02 + place.x(), 0.01, 0, 0, 0.98, 0.01 + place.y(), 0.01, 0, 1.01;
      return F;
    }});
    const double size = (body.rest.rowwise().maxCoeff() - body.rest.rowwise().minCoeff()).norm();
    const KeptShape kept = keep_in_place(body, make);
    INFO(kept.cause << " after " << kept.steps << " steps");
    REQUIRE(kept.outcome == Outcome::converged);
    CHECK(kept.error < 1e-10 * size);
    const std::shared_ptr<Model> model = make(kept.body);
    const Positions elastic = model->elastic_forces(body.rest), loads = model->load_forces(state_at_rest(body));
    Positions left = elastic + loads;
    for (const Support& support : model->supports) left.col(support.molecule).setZero();
    CHECK(left.norm() < 1e-6 * elastic.norm());
    CHECK(elastic.norm() > 0.5 * loads.norm());
  });
}
