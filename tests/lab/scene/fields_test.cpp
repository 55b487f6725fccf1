// Materials that differ from place to place: by a formula, and by the cells of a file.

#include <catch2/catch.hpp>
#include <cmath>

#include "lab/report/records.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

const Catalog kCatalog = built_in_catalog();

constexpr int kLayers = 4;  // along z, each 5 mm high, of 1 cm² section

std::string bar_of(const std::string& body, const std::string& material, const std::string& strategy = "neo_hookean") {
  return "title: A bar\nvalues: {high: 5 mm}\n"
         "body: {" +
         body + "}\nmaterial: {" + material + "}\nstiffness: " + strategy +
         "\nexperiment: {kind: tension, axis: z, force: 1 mN}\nsolver: {displacements: small}\nreference: none\n";
}

const std::string kBodies[] = {"tetrahedra: {kind: kuhn, cubes: [2, 2, 8], size: [1 cm, 1 cm, 2 cm]}",
                               "tetrahedra: {kind: kuhn, cubes: [1, 1, 4], size: [1 cm, 1 cm, 2 cm], order: 2}",
                               "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, order: 1}",
                               "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, order: 2}"};

/// Of the layers: 10, 20, 30 and 40 kPa, as data of a file of hexahedra in mm.
std::string layers_in_a_file() {
  std::string points, cells, types, values;
  for (int level = 0; level <= kLayers; ++level)
    for (const char* corner : {"0 0 ", "10 0 ", "10 10 ", "0 10 "}) points += corner + std::to_string(5 * level) + "\n";
  for (int layer = 0; layer < kLayers; ++layer) {
    cells += "8";
    for (int corner = 0; corner < 8; ++corner) cells += " " + std::to_string(4 * layer + corner);
    cells += "\n", types += "12\n", values += std::to_string(10 * (layer + 1)) + "\n";
  }
  return "# vtk DataFile Version 3.0\nlayers\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 20 float\n" + points +
         "CELLS 4 36\n" + cells + "CELL_TYPES 4\n" + types + "CELL_DATA 4\nSCALARS E double 1\nLOOKUP_TABLE default\n" +
         values;
}

std::unique_ptr<Scene> scene_of(const TemporaryFolder& folder, const std::string& text) {
  auto scene = load_scene(folder.write("scene.yaml", text), kCatalog);
  prepare(scene->specimen, scene->stiffness.strategy);
  return scene;
}

double measured(const TemporaryFolder& folder, const std::string& text, const std::string& measure) {
  const auto scene = scene_of(folder, text);
  const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
  INFO(text << run.cause);
  REQUIRE(run.outcome == Outcome::converged);
  return run.measures.get(measure);
}

std::string refusal(const std::string& material, const std::string& strategy = "neo_hookean") {
  const TemporaryFolder folder;
  folder.write("layers.vtk", layers_in_a_file());
  try {
    load_scene(folder.write("scene.yaml", bar_of(kBodies[0], material, strategy)), kCatalog);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("layers of a bar are springs in series, however their stiffness is said", "[scene][fields]") {
  // Without contraction across, the stress is the same everywhere: Δl = F/A Σ h/E.
  double expected = 0;
  for (int layer = 0; layer < kLayers; ++layer) expected += 1e-3 / 1e-4 * 5e-3 / (1e4 * (layer + 1));
  const TemporaryFolder folder;
  folder.write("layers.vtk", layers_in_a_file());
  for (const std::string& body : kBodies)
    for (const std::string& field :
         {std::string("youngs_modulus: {expression: 10 kPa * (1 + floor(z / 5 mm))}"),
          std::string("stiffness: {expression: 1 + floor(z / high)}"),
          std::string("youngs_modulus: {file: layers.vtk, data: E, unit: kPa, length_unit: mm}")}) {
      const std::string text = bar_of(body, "youngs_modulus: 10 kPa, poissons_ratio: 0, fields: {" + field + "}");
      INFO(text);
      CHECK(measured(folder, text, "elongation") == Approx(expected).epsilon(1e-9));
    }
}

TEST_CASE("a factor of all moduli that is the same everywhere is the law with such moduli", "[scene][fields]") {
  const auto rubber = [](int factor, const std::string& fields) {
    const std::string f = std::to_string(factor);
    return bar_of(
        kBodies[0],
        "law: ogden, terms: [[" + f + " kPa, 3], [-" + f + " kPa, -1]], bulk_modulus: " + f + "00 kPa" + fields,
        "ogden");
  };
  const TemporaryFolder folder;
  const double soft = measured(folder, rubber(2, ""), "elongation"),
               stiff = measured(folder, rubber(6, ""), "elongation");
  CHECK(measured(folder, rubber(2, ", fields: {stiffness: {expression: 3}}"), "elongation") ==
        Approx(stiff).epsilon(1e-9));
  CHECK(soft == Approx(3 * stiff).epsilon(1e-9));
}

TEST_CASE("springs are as stiff and molecules as heavy as the material is where they lie", "[scene][fields]") {
  const TemporaryFolder folder;
  const std::string body = "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, connections: [axis, face]}",
                    plain = "youngs_modulus: 10 kPa";
  const auto even = scene_of(folder, bar_of(body, plain, "lattice"));
  const auto graded = scene_of(folder, bar_of(body,
                                              plain + ", fields: {stiffness: {expression: 1 + z / 1 cm},"
                                                      " density: {expression: 1000 kg/m3 * (1 + z / 2 cm)}}",
                                              "lattice"));
  const auto constants = [](const Scene& scene) {
    return scene.stiffness.strategy.constants(scene.specimen.body, scene.specimen.material, {});
  };
  const VectorX one = constants(*even), other = constants(*graded);
  const Body& lattice = graded->specimen.body;
  for (int c = 0; c < lattice.connections.size(); ++c) {
    const auto& [a, b] = lattice.connections.ends[static_cast<std::size_t>(c)];
    const double z = (lattice.rest(2, a) + lattice.rest(2, b)) / 2;
    CHECK(other[c] == Approx(one[c] * (1 + z / 0.01)).epsilon(1e-12));
  }
  CHECK(lattice.mass.sum() == Approx(1.5 * even->specimen.body.mass.sum()).epsilon(1e-12));
  for (const char* strategy : {"calibrated:lattice", "lattice+volume"}) {
    INFO(strategy);
    CHECK(unsuited(even->specimen, *even->experiment, choose_strategy(kCatalog, strategy)).empty());
    CHECK_FALSE(unsuited(graded->specimen, *graded->experiment, choose_strategy(kCatalog, strategy)).empty());
  }
}

TEST_CASE("each of several bodies has its own fields", "[scene][fields]") {
  const TemporaryFolder folder;
  const std::string cube = "{name: NAME, lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 1 cm}AT}";
  const auto named = [&](const std::string& name, const std::string& rest) {
    std::string text = cube;
    text.replace(text.find("NAME"), 4, name);
    return text.replace(text.find("AT"), 2, rest);
  };
  // A body that is moved has its places where it was made.
  const std::string field = ", material: {fields: {stiffness: {expression: 1 + x / 1 cm}}}, at: [5 cm, 0, 0]";
  const auto scene = scene_of(folder, "bodies: [" + named("a", "") + ", " + named("b", field) +
                                          "]\nmaterial: {youngs_modulus: 10 kPa}\nstiffness: standard\n"
                                          "experiment: {kind: motion}\ntime: {duration: 1 s}\n");
  const Body& body = scene->specimen.body;
  REQUIRE(body.connection_stiffness.size() == body.connections.size());
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto& [a, b] = body.connections.ends[static_cast<std::size_t>(c)];
    const double x = (body.rest(0, a) + body.rest(0, b)) / 2;
    CHECK(body.connection_stiffness[c] == Approx(x < 0.03 ? 1 : 1 + (x - 0.05) / 0.01));
  }
}

TEST_CASE("slips in fields", "[scene][fields]") {
  const std::string E = "youngs_modulus: 10 kPa, ";
  const auto said = [&](const std::string& fields) { return refusal(E + "fields: {" + fields + "}"); };
  CHECK_THAT(said("stifness: {expression: 2}"), Contains("did you mean 'stiffness'?"));
  CHECK_THAT(said("stiffness: {expresion: 2}"), Contains("did you mean 'expression'?"));
  CHECK_THAT(said("stiffness: {expression: 1 + r / 1 cm}"), Contains("there is no value 'r'"));
  CHECK_THAT(said("stiffness: {expression: 1 + x}"), Contains("adds m to a plain number"));
  CHECK_THAT(said("stiffness: {expression: x}"), Contains("it must give a plain number"));
  CHECK_THAT(said("youngs_modulus: {expression: 1 + x / 1 cm}"), Contains("it must give Pa"));
  CHECK_THAT(said("youngs_modulus: {expression: 10 kPa * (1 - z / 1 cm)}"),
             Contains("must be above 0 Pa") && Contains("scene.yaml:4:"));
  CHECK_THAT(said("stiffness: {file: layer.vtk, data: E, length_unit: mm}"), Contains("did you mean 'layers.vtk'?"));
  CHECK_THAT(said("stiffness: {file: layers.vtk, data: F, length_unit: mm}"), Contains("has no data 'F' of its cells"));
  CHECK_THAT(said("youngs_modulus: {file: layers.vtk, data: E, length_unit: mm}"), Contains("key 'unit' is missing"));
  CHECK_THAT(said("youngs_modulus: {file: layers.vtk, data: E, unit: mm, length_unit: mm}"),
             Contains("cannot be converted to Pa"));
  CHECK_THAT(
      refusal("law: mooney_rivlin, c1: 1 kPa, bulk_modulus: 1 MPa, fields: {youngs_modulus: {expression: 1 kPa}}"),
      Contains("follows from the constants of the law; write `stiffness`"));
  CHECK_THAT(
      refusal("curve: {toe_strain: 0.1, toe_modulus: 1 kPa, modulus: 9 kPa}, fields: {stiffness: {expression: 2}}"),
      Contains("needs a material without curve or fibre"));
}
