#include "lab/run/cell_stress.h"

#include <catch2/catch.hpp>
#include <string>

#include "lab/run/contact_measures.h"
#include "lab/run/specimen.h"
#include "lab/scene/scene.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

struct Pulled {
  std::unique_ptr<Scene> scene;
  Run run;
};

Pulled pulled(const std::string& text) {
  const TemporaryFolder folder;
  Pulled all{load_scene(folder.write("scene.yaml", text), built_in_catalog()), {}};
  RunOptions options{all.scene->statics, true, {}};
  options.time = all.scene->time;
  prepare(all.scene->specimen, all.scene->stiffness.strategy);
  all.run = run_strategy(all.scene->specimen, *all.scene->experiment, all.scene->stiffness, options);
  INFO(all.run.cause);
  REQUIRE(all.run.outcome == Outcome::converged);
  return all;
}

/// Present volume, of sheets area.
double size_of(const Body& body, const Positions& positions) {
  double size = 0;
  for (const auto& cell : body.tetrahedra) size += signed_volume(positions, cell);
  for (const auto& [a, b, c] : body.triangles)
    size += (positions.col(b) - positions.col(a)).cross(positions.col(c) - positions.col(a)).norm() / 2;
  return size;
}

/// In uniaxial tension along x each cell has the force over the present section, and nothing across.
void check_uniaxial(const Pulled& pulled, double tolerance) {
  const Body& body = pulled.scene->specimen.body;
  const Snapshot& end = pulled.run.snapshots.back();
  const double length = end.positions.row(0).maxCoeff() - end.positions.row(0).minCoeff();
  Matrix3 expected = Matrix3::Zero();
  expected(0, 0) = pulled.run.measures.get("force") * length / size_of(body, end.positions);
  REQUIRE(expected(0, 0) > 0);
  for (const CellState& state : cell_states(body, end)) {
    CHECK((state.stress - expected).norm() <= tolerance * expected(0, 0));
    const double stretch = length / (body.rest.row(0).maxCoeff() - body.rest.row(0).minCoeff());
    CHECK(state.strain(0, 0) == Approx((stretch * stretch - 1) / 2).epsilon(1e-4));
  }
}

}  // namespace

TEST_CASE("tetrahedra and triangles of a uniform field have the law's stress, alike in all", "[cell_stress]") {
  const std::string solid = "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\n";
  const std::string rubber = "material: {law: mooney_rivlin, c1: 2 kPa, c2: 1 kPa, bulk_modulus: 20 kPa}\n";
  const std::string sheet =
      "body: {sheet: {size: [30 mm, 20 mm], squares: [6, 4], pattern: crossed}}\n"
      "material: {youngs_modulus: 100 kPa, poissons_ratio: 0.4, thickness: 1 mm}\n";
  const auto text = GENERATE_COPY(values({
      solid + "body: {tetrahedra: {kind: body_centred, cubes: [3, 2, 2], size: [9 mm, 6 mm, 6 mm]}}\n"
              "stiffness: neo_hookean\n",
      solid + "body: {tetrahedra: {kind: alternating, cubes: [3, 2, 2], size: [9 mm, 6 mm, 6 mm]}}\n"
              "stiffness: st_venant_kirchhoff\n",
      solid + "body: {tetrahedra: {kind: alternating, cubes: [3, 2, 2], size: [9 mm, 6 mm, 6 mm]}}\n"
              "stiffness: neo_hookean+volume\n",
      rubber + "body: {tetrahedra: {kind: body_centred, cubes: [3, 2, 2], size: [9 mm, 6 mm, 6 mm]}}\n"
               "stiffness: mooney_rivlin\n",
      sheet + "stiffness: neo_hookean_membrane\n",
      sheet + "stiffness: st_venant_kirchhoff_membrane\n",
  }));
  INFO(text);
  check_uniaxial(pulled(text + "experiment: {kind: tension, axis: x, strain: 10 %}\n"), 1e-6);
}

TEST_CASE("what has relaxed is in the cells as their law's stress is", "[cell_stress]") {
  const std::string cells = GENERATE("alternating", "body_centred");
  const Pulled relaxed = pulled(
      "body: {tetrahedra: {kind: " + cells +
      ", cubes: [3, 2, 2], size: [9 mm, 6 mm, 6 mm]}}\n"
      "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1 kg/m3, relaxation: {terms: [[1, 0.5 s]]}}\n"
      "stiffness: prony:neo_hookean\n"
      "experiment: {kind: relaxation, ramp: 0.2 s, fixture: {kind: tension, axis: x, strain: 1 %}}\n"
      "time: {duration: 1 s, stepper: newmark, step: 20 ms, frames: 10}\n");
  check_uniaxial(relaxed, 0.005);  // the sides' changes of shape follow the law's to the order of the strain
}
