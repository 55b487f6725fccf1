// A factor of the stiffness in each cell, from displacements of points and forces.

#include "lab/identify/field.h"

#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/base/random.h"
#include "core/model/solid_cells.h"
#include "core/shapes/orders.h"
#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"
#include "lab/identify/identify.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();
constexpr double kStrain = 1e-5;
constexpr std::array<double, 4> kLayers{1, 2, 4, 1};  // factors of 10 kPa, of layers of 5 mm along z

const char* const kTetrahedra = "tetrahedra: {kind: kuhn, cubes: [2, 2, 4], size: [10 mm, 10 mm, 20 mm]}";
const char* const kLattice = "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, connections: [axis]}";

std::string scene_of(const std::string& body, const std::string& stiffness, const std::string& field,
                     const std::string& tests) {
  return "title: layers\nbody: {" + body +
         "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: 0}\nstiffness: " + stiffness +
         "\nexperiment: {kind: tension, axis: z, strain: " + fmt::format("{}", kStrain) +
         "}\nidentify:\n  field: " + field + "\n  tests:\n" + tests;
}
const std::string kCamera = "    - {name: camera, kind: points, file: points.csv, sigma: 1e-8 mm}\n";
const std::string kForce = "    - {name: force, kind: specimen, file: force.csv, sigma: 1e-8 N}\n";

/// Layers in series with nu = 0: each is as much longer as it is softer.
double strain_of(std::size_t layer) {
  double soft = 0;
  for (const double factor : kLayers) soft += 1 / factor / kLayers.size();
  return kStrain / (soft * kLayers[layer]);
}

std::string points() {
  std::mt19937_64 generator(3);
  const auto uniform = [&] { return unit_random(generator); };
  std::string text = "x [mm],y [mm],z [mm],ux [mm],uy [mm],uz [mm]\n";
  for (int i = 0; i < 200; ++i) {
    const Vector3 at(10 * uniform(), 10 * uniform(), 20 * uniform());
    double moved = 0;
    for (std::size_t layer = 0; layer < kLayers.size(); ++layer)
      moved += strain_of(layer) * std::clamp(at.z() - 5. * static_cast<double>(layer), 0., 5.);
    text += fmt::format("{:.17g},{:.17g},{:.17g},0,0,{:.17g}\n", at.x(), at.y(), at.z(), moved);
  }
  return text;
}

/// Displacements determine what a layer bears; its tetrahedra may share that otherwise, by as much as the field says.
void check_layers(const FoundField& field, double over) {
  for (std::size_t layer = 0; layer < kLayers.size(); ++layer) {
    double sum = 0, count = 0;
    for (Eigen::Index cell = 0; cell < field.factors.size(); ++cell) {
      if (static_cast<std::size_t>(field.middles(2, cell) / 5e-3) != layer) continue;
      const double off = std::log(field.factors[cell] / kLayers[layer] * over);
      sum += off, count += 1;
      CHECK(std::abs(off) < 0.02 + 3 * field.deviations[cell]);
    }
    CHECK(std::abs(sum / count) < 0.01);
  }
}

Answer answer_of(const TemporaryFolder& folder, const std::string& scene) {
  folder.write("points.csv", points());
  const double force = 10e3 * kLayers[0] * strain_of(0) * 1e-4;
  folder.write("force.csv", fmt::format("displacement [mm],force [N]\n{:.17g},{:.17g}\n", 20 * kStrain, force));
  return identify(folder.write("scene.yaml", scene), kCatalog, {}).front();
}

}  // namespace

TEST_CASE("layers in series are found cell by cell, from points and a force", "[identify][field]") {
  const TemporaryFolder folder;
  const Answer answer = answer_of(folder, scene_of(kTetrahedra, "neo_hookean", "{}", kCamera + kForce));
  REQUIRE(answer.field);
  CHECK(answer.outcome == FitOutcome::converged);
  CHECK_FALSE(answer.field->only_ratios);
  check_layers(*answer.field, 1);
}

TEST_CASE("points alone give ratios of the stiffness between cells, which is said", "[identify][field]") {
  const TemporaryFolder folder;
  for (const auto& [body, stiffness] : {std::pair{kTetrahedra, "neo_hookean"}, {kLattice, "voronoi"}}) {
    INFO(body);
    const Answer answer = answer_of(folder, scene_of(body, stiffness, "{}", kCamera));
    REQUIRE(answer.field);
    CHECK(answer.field->only_ratios);
    CHECK_THAT(answer.warnings.front(), Contains("only ratios between cells are found"));
    CHECK(answer.field->factors.array().log().mean() == Approx(0).margin(1e-12));
    check_layers(*answer.field, std::pow(8., 0.25));
  }
}

TEST_CASE("a field is written where a scene takes it", "[identify][field][slow]") {
  const TemporaryFolder folder;
  const Answer answer = answer_of(folder, scene_of(kTetrahedra, "neo_hookean", "{smoothness: 1e-3}", kCamera + kForce));
  CHECK(answer.field->chosen_by == "stated");
  folder.write("field.vtu", field_vtu(answer));
  std::string scene = scene_of(kTetrahedra, "neo_hookean", "{}", kCamera + kForce);
  scene.replace(scene.find("ratio: 0}"), 9,
                "ratio: 0, fields: {stiffness: {file: field.vtu, data: stiffness, length_unit: m}}}");
  const Answer again = answer_of(folder, scene);  // begins there
  CHECK(again.field->equilibria < answer.field->equilibria);
  check_layers(*again.field, 1);
}

TEST_CASE("what a field needs is said at its place", "[identify][field]") {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& scene) -> std::string {
    try {
      answer_of(folder, scene);
    } catch (const InputError& error) {
      return error.what();
    }
    return "taken";
  };
  const std::string without = "    - {name: force, kind: specimen, file: force.csv}\n";
  CHECK_THAT(message(scene_of(kTetrahedra, "neo_hookean", "{}", kCamera + without)),
             Contains("give 'force' its `sigma`"));
  CHECK_THAT(message(scene_of(kTetrahedra, "neo_hookean", "{smothness: 1}", kCamera)),
             Contains("scene.yaml:7:") && Contains("smoothness"));
  CHECK_THAT(message(scene_of(kTetrahedra, "neo_hookean", "{}\n  unknowns: [youngs_modulus]", kCamera)),
             Contains("a field is found alone"));
}

TEST_CASE("solid cells have their volume and the area of the faces that they share", "[body]") {
  const Body block = tetrahedral_block(BlockKind::kuhn, {1, 1, 1}, Vector3(2, 3, 4));
  for (const int order : {1, 2}) {
    const Body body = with_order(block, order);
    double volume = 0, area = 0;
    for (const SolidCell& cell : solid_cells_of(body)) volume += volume_of(cell, body.rest);
    for (const CellBorder& border : borders_of(solid_cells_of(body), body.rest)) area += border.area;
    CHECK(volume == Approx(24));
    // Six tetrahedra around a diagonal: half of each of the three planes through it and a pair of edges.
    CHECK(area == Approx(2 * std::hypot(3, 4) + 3 * std::hypot(2, 4) + 4 * std::hypot(2, 3)));
  }
  const Body lattice = cubic_lattice({3, 2, 2}, 2, CubicPattern{});
  const std::vector<SolidCell> cubes = solid_cells_of(lattice);
  REQUIRE(cubes.size() == 2);
  CHECK(volume_of(cubes[1], lattice.rest) == Approx(8));
  const std::vector<CellBorder> borders = borders_of(cubes, lattice.rest);
  REQUIRE(borders.size() == 1);
  CHECK(borders[0].area == Approx(4));
}
