// Materials that differ from place to place: by a formula, and by the cells of a file.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/simulation/warnings.h"
#include "lab/report/records.h"
#include "lab/run/specimen.h"
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

/// The same by boxes.
std::string layers_picked() {
  std::string regions;
  for (int layer = 1; layer < kLayers; ++layer)
    regions += (layer > 1 ? ", " : "") + std::string("{molecules: {box: {from: [0, 0, ") + std::to_string(5 * layer) +
               " mm], to: [1 cm, 1 cm, " + std::to_string(5 * (layer + 1)) +
               " mm]}}, youngs_modulus: " + std::to_string(10 * (layer + 1)) + " kPa}";
  return "regions: [" + regions + "]";
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
          std::string("stiffness: {expression: 1 + floor(z / high)}"), layers_picked(),
          std::string("youngs_modulus: {file: layers.vtk, data: E, unit: kPa, length_unit: mm}")}) {
      const std::string text = bar_of(body, "youngs_modulus: 10 kPa, poissons_ratio: 0, fields: {" + field + "}");
      INFO(text);
      CHECK(measured(folder, text, "elongation") == Approx(expected).epsilon(1e-9));
    }
}

TEST_CASE("a region of all cells is the material that it names", "[scene][fields]") {
  const TemporaryFolder folder;
  const std::string all = "{molecules: {box: {from: [0, 0, 0], to: [1 cm, 1 cm, 2 cm]}}, ";
  for (const std::string& body : kBodies) {
    const std::string other = bar_of(body,
                                     "youngs_modulus: 10 kPa, poissons_ratio: 0, density: 800 kg/m3, fields: "
                                     "{regions: [" +
                                         all + "youngs_modulus: 30 kPa, poissons_ratio: 0.35, density: 1200 kg/m3}]}"),
                      same = bar_of(body, "youngs_modulus: 30 kPa, poissons_ratio: 0.35, density: 1200 kg/m3");
    for (const std::string measure : {"elongation", "poissons_ratio"})
      CHECK(measured(folder, other, measure) == Approx(measured(folder, same, measure)).epsilon(1e-8));
    CHECK((scene_of(folder, other)->specimen.body.mass - scene_of(folder, same)->specimen.body.mass).norm() < 1e-12);
  }
  const auto law = [&](const std::string& numbers, const std::string& rest) {
    return bar_of(kBodies[0], "law: mooney_rivlin, " + numbers + ", bulk_modulus: 500 kPa" + rest, "mooney_rivlin");
  };
  CHECK(measured(folder, law("c1: 2 kPa, c2: 1 kPa", ", fields: {regions: [" + all + "constants: {c1: 6 kPa}}]}"),
                 "elongation") ==
        Approx(measured(folder, law("c1: 6 kPa, c2: 1 kPa", ""), "elongation")).epsilon(1e-8));
  const auto yeoh = [&](const std::string& terms, const std::string& rest) {
    return bar_of(kBodies[0], "law: yeoh, terms: " + terms + ", bulk_modulus: 50 kPa" + rest, "yeoh");
  };
  const auto in_region = [&](const std::string& constants) {
    return yeoh("[1 kPa, 200 Pa]", ", fields: {regions: [" + all + "constants: {" + constants + "}}]}");
  };
  CHECK(measured(folder, in_region("terms: [4 kPa, 800 Pa, 10 Pa]"), "elongation") ==
        Approx(measured(folder, yeoh("[4 kPa, 800 Pa, 10 Pa]", ""), "elongation")).epsilon(1e-8));
  CHECK_THROWS_WITH(scene_of(folder, in_region("c_1: 4 kPa")), Contains("is no number of yeoh") && Contains("terms"));
  CHECK_THROWS_WITH(scene_of(folder, in_region("terms: []")), Contains("has 0 terms; allowed: 1 to 6"));
  CHECK_THAT(
      refusal("youngs_modulus: 10 kPa, poissons_ratio: 0, fields: {regions: [" + all + "constants: {c1: 1 Pa}}]}"),
      Contains("are those of a `law`"));
  CHECK_THAT(refusal("youngs_modulus: 10 kPa, poissons_ratio: 0, fields: {regions: [{molecules: [0, 1], density: 1 "
                     "kg/m3}]}"),
             Contains("no cell has all its molecules among these"));
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
    const auto& [a, b] = lattice.connections.ends[c];
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

TEST_CASE("a region's density is that of its cells of any kind, or of its molecules", "[scene][fields]") {
  const TemporaryFolder folder;
  const std::string half = "{molecules: {box: {from: [-1 m, -1 m, -1 m], to: [1 m, 1 m, 10.001 mm]}}, density: ";
  for (const char* body : {"tetrahedra: {kind: kuhn, cubes: [2, 2, 4], size: [1 cm, 1 cm, 2 cm], order: 2}",
                           "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, order: 2}",
                           "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, connections: [axis, face]}"}) {
    INFO(body);
    const auto mass = [&](const std::string& fields) {
      return scene_of(folder, bar_of(body, "youngs_modulus: 10 kPa, density: 1000 kg/m3" + fields, "standard"))
          ->specimen.body.mass;
    };
    const VectorX even = mass(""), other = mass(", fields: {regions: [" + half + "3000 kg/m3}]}");
    CHECK(other.sum() == Approx(2 * even.sum()).epsilon(1e-9));
    CHECK(other.maxCoeff() <= 3.0000001 * even.maxCoeff());
  }
}

TEST_CASE("springs on the border of two materials have the mean of the cells around them", "[scene][fields]") {
  // Two layers side by side: (10 + 40)/2 of what the homogeneous piece has, however the scene says it.
  const TemporaryFolder folder;
  const auto modulus = [&](const std::string& shape, const std::string& body, const std::string& fields) {
    const bool lattice = shape.find("connections") != std::string::npos;
    const auto scene =
        scene_of(folder, "title: A laminate\nbody: {" + shape + body +
                             "}\nmaterial: {youngs_modulus: 10 kPa, poissons_ratio: " + (lattice ? "0.25" : "0") +
                             fields + "}\nstiffness: " + (lattice ? "lattice" : "van_gelder") +
                             "\nsolver: {displacements: small}\n"
                             "experiment: {kind: tension, axis: x, strain: 0.1 %}\n");
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    INFO(run.cause);
    REQUIRE(run.outcome == Outcome::converged);
    return run.measures.get("effective_modulus");
  };
  for (const std::string shape :
       {"tetrahedra: {kind: kuhn, cubes: [2, 2, 4], size: [2 cm, 2 cm, 4 cm]}",
        "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 1 cm, order: 1}",
        "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 1 cm, connections: [axis, face]}"}) {
    INFO(shape);
    const double even = modulus(shape, "", "");
    const std::string upper = "{box: {from: [-1 cm, -1 cm, 2 cm], to: [3 cm, 3 cm, 5 cm]}}";
    for (const auto& [body, fields] : std::vector<std::pair<std::string, std::string>>{
             {", regions: [{from: [0, 0, 2 cm], to: [2 cm, 2 cm, 4 cm], stiffness: 4}]", ""},
             {", regions: [{molecules: " + upper + ", stiffness: 4}]", ""},
             {"", ", fields: {regions: [{molecules: " + upper + ", youngs_modulus: 40 kPa}]}"},
             {"", ", fields: {stiffness: {expression: \"1 + 3 * min(1, max(0, (z - 2 cm) / 1 nm))\"}}"}}) {
      if (shape.find("connections") != std::string::npos && fields.find("expression") != std::string::npos) continue;
      INFO(body << fields);
      CHECK(modulus(shape, body, fields) == Approx(2.5 * even).epsilon(0.02));
    }
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
    const auto& [a, b] = body.connections.ends[c];
    const double x = (body.rest(0, a) + body.rest(0, b)) / 2;
    CHECK(body.connection_stiffness[c] == Approx(x < 0.03 ? 1 : 1 + (x - 0.05) / 0.01));
  }
}

TEST_CASE("mistakes in fields", "[scene][fields]") {
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
  // The bar of 20 mm lies in the lowest layer of a file in m, and beyond one in um.
  CHECK_THAT(said("youngs_modulus: {file: layers.vtk, data: E, unit: kPa, length_unit: m}"),
             Contains("gives all") && Contains("the value of one of the file's 4 cells"));
  CHECK_THAT(said("youngs_modulus: {file: layers.vtk, data: E, unit: kPa, length_unit: um}"),
             Contains("does not cover the body: ") && Contains("`length_unit`"));
  CHECK_THAT(
      refusal("law: mooney_rivlin, c1: 1 kPa, bulk_modulus: 1 MPa, fields: {youngs_modulus: {expression: 1 kPa}}"),
      Contains("follows from the constants of the law; write `stiffness`"));
  CHECK_THAT(
      refusal("curve: {toe_strain: 0.1, toe_modulus: 1 kPa, modulus: 9 kPa}, fields: {stiffness: {expression: 2}}"),
      Contains("needs a material without curve or fibre"));
}

namespace {

const std::string kRubber = "law: mooney_rivlin, c1: 2 kPa, c2: 1 kPa, bulk_modulus: 60 kPa",
                  kTendon =
                      "law: transversely_isotropic, c1: 2 kPa, c4: 10, c5: 90 kPa, lambda_max: 1.1, "
                      "bulk_modulus: 60 kPa, direction: ",
                  kWedge = "around: {axis: z, through: [-1 cm, -1 cm, 0]}";

/// The unit directions around the axis of kWedge at the middles of the cells of a file.
std::string turns_in_a_file(const Body& body) {
  const std::size_t count = body.tetrahedra.size();
  std::string points, cells, types, values;
  for (std::size_t cell = 0; cell < count; ++cell) {
    cells += "4";
    Vector3 middle = Vector3::Zero();
    for (const int molecule : body.tetrahedra[cell]) middle += body.rest.col(molecule) / 4;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Vector3 at = 1e3 * body.rest.col(body.tetrahedra[cell][corner]);
      points += std::to_string(at.x()) + " " + std::to_string(at.y()) + " " + std::to_string(at.z()) + "\n";
      cells += " " + std::to_string(4 * cell + corner);
    }
    cells += "\n", types += "10\n";
    values += std::to_string(-(middle.y() + 0.01) * 1e4) + " " + std::to_string((middle.x() + 0.01) * 1e4) + " 0\n";
  }
  const std::string number = std::to_string(count);
  return "# vtk DataFile Version 3.0\nturns\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS " + std::to_string(4 * count) +
         " double\n" + points + "CELLS " + number + " " + std::to_string(5 * count) + "\n" + cells + "CELL_TYPES " +
         number + "\n" + types + "CELL_DATA " + number + "\nVECTORS turn double\n" + values;
}

}  // namespace

TEST_CASE("constants of a law that differ from place to place", "[scene][fields]") {
  // All constants by the same factor are `stiffness`, which is tested against layers in series above.
  const TemporaryFolder folder;
  const std::string factor = " * (1 + floor(z / 5 mm))\"}",
                    all = ", fields: {constants: {c1: {expression: \"2 kPa" + factor + ", c2: {expression: \"1 kPa" +
                          factor + ", bulk_modulus: {expression: \"60 kPa" + factor + "}}",
                    stiffness = ", fields: {stiffness: {expression: 1 + floor(z / 5 mm)}}";
  for (const std::string& body : kBodies) {
    INFO(body);
    CHECK(measured(folder, bar_of(body, kRubber + all, "mooney_rivlin"), "elongation") ==
          Approx(measured(folder, bar_of(body, kRubber + stiffness, "mooney_rivlin"), "elongation")).epsilon(1e-10));
  }
  const std::string lattice = "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, connections: [axis, face]}";
  CHECK(measured(folder, bar_of(lattice, kRubber + all, "lattice"), "elongation") ==
        Approx(measured(folder, bar_of(lattice, kRubber + stiffness, "lattice"), "elongation")).epsilon(1e-10));
  const std::string terms = "law: ogden, terms: [[2 kPa, 3], [-1 kPa, -1]], bulk_modulus: 200 kPa",
                    twice = "law: ogden, terms: [[6 kPa, 3], [-2 kPa, -2]], bulk_modulus: 200 kPa";
  CHECK(measured(folder,
                 bar_of(kBodies[0], terms + ", fields: {constants: {terms: {expression: [[6 kPa, 3], [-2 kPa, -2]]}}}",
                        "ogden"),
                 "elongation") == Approx(measured(folder, bar_of(kBodies[0], twice, "ogden"), "elongation")));
  const std::string plain = "youngs_modulus: 10 kPa, poissons_ratio: ";
  CHECK(measured(folder, bar_of(kBodies[1], plain + "0.1, fields: {poissons_ratio: {expression: 0.4}}"),
                 "poissons_ratio") ==
        Approx(measured(folder, bar_of(kBodies[1], plain + "0.4"), "poissons_ratio")).epsilon(1e-10));
}

TEST_CASE("a Poisson's ratio that differs from place to place reaches the volume term, or is refused there",
          "[scene][fields]") {
  const TemporaryFolder folder;
  const std::string plain = "youngs_modulus: 10 kPa, poissons_ratio: ",
                    field = ", fields: {poissons_ratio: {expression: ";
  for (const std::string& body : {kBodies[1], kBodies[2], kBodies[3]})
    CHECK(
        measured(folder, bar_of(body, plain + "0.1" + field + "0.45}}", "neo_hookean+volume"), "poissons_ratio") ==
        Approx(measured(folder, bar_of(body, plain + "0.45", "neo_hookean+volume"), "poissons_ratio")).epsilon(1e-10));
  const std::string lattice = "lattice: {kind: cubic, molecules: [3, 3, 5], spacing: 5 mm, connections: [axis, face]}";
  for (const auto& [body, strategy] : {std::pair{kBodies[0], "neo_hookean+volume"}, {lattice, "lattice+volume"}}) {
    const auto scene =
        scene_of(folder, bar_of(body, plain + "0.1" + field + "0.1 + 0.3 * floor(z / 1.2 cm)}}", strategy));
    const Run run = run_strategy(scene->specimen, *scene->experiment, scene->stiffness, {.statics = scene->statics});
    CHECK_FALSE(run.suited);
    CHECK_THAT(run.cause, Contains("needs one Poisson's ratio for its volumes"));
  }
  // One that is the same at every place is one.
  CHECK(measured(folder, bar_of(kBodies[0], plain + "0.4" + field + "0.4}}", "neo_hookean+volume"), "elongation") ==
        measured(folder, bar_of(kBodies[0], plain + "0.4", "neo_hookean+volume"), "elongation"));
  const auto scene = scene_of(folder, bar_of(kBodies[0], plain + "0.1" + field + "0.1 + 0.35 * floor(z / 1.2 cm)}}"));
  CHECK(may_lock(scene->specimen.body, {scene->specimen.material}, kCatalog.find("neo_hookean")));
}

TEST_CASE("directions that differ from place to place", "[scene][fields]") {
  // Around an axis by `around`, and the same by a formula, by a file of the cells and by an angle; turned too.
  const TemporaryFolder folder;
  const std::string around = kTendon + "y, " + kWedge,
                    formula = "{expression: [\"-(y + 1 cm) / 1 mm\", \"(x + 1 cm) / 1 mm\", 0]}",
                    by_formula = kTendon + "x, fields: {constants: {direction: " + formula + "}}",
                    by_file = kTendon +
                              "x, fields: {constants: {direction: {file: turns.vtk, data: turn, "
                              "length_unit: mm}}}";
  const std::string& body = kBodies[0];
  const auto scene = scene_of(folder, bar_of(body, around, "transversely_isotropic"));
  folder.write("turns.vtk", turns_in_a_file(scene->specimen.body));
  const auto elongation = [&](const std::string& material, const std::string& turn = "",
                              const std::string& axis = "axis: x") {
    std::string text = bar_of(body, material, "transversely_isotropic");
    const std::string along = "axis: z, force: 1 mN", small = "solver: {displacements: small}\n";
    text.replace(text.find(along), along.size(), axis + ", force: 30 mN");
    return measured(folder, text.replace(text.find(small), small.size(), turn), "elongation");
  };
  const double expected = elongation(around);
  CHECK(std::abs(elongation(kTendon + "y") / expected - 1) > 1e-3);
  CHECK(elongation(by_formula) == Approx(expected).epsilon(1e-9));
  CHECK(elongation(by_file) == Approx(expected).epsilon(1e-4));  // the file's places have six decimals of a millimetre
  const std::string turn = "rotate: {axis: [1, 2, 3], angle: 50 deg}\n";
  CHECK(elongation(by_formula, turn) == Approx(expected).epsilon(1e-9));

  const std::string z = kTendon + "z", slanted = kTendon + "[0, -0.5, 0.8660254037844386]",
                    by_angle = z + ", fields: {constants: {direction: {angle: 30 deg, about: x}}}",
                    fibre = "youngs_modulus: 10 kPa, fibre: {youngs_modulus: 50 kPa, direction: ";
  CHECK(elongation(by_angle, "", "axis: z") == Approx(elongation(slanted, "", "axis: z")).epsilon(1e-9));
  CHECK(std::abs(elongation(by_angle, "", "axis: z") / elongation(z, "", "axis: z") - 1) > 1e-3);
  const auto of_fibre = [&](const std::string& material) {
    return measured(folder, bar_of(body, material), "elongation");
  };
  CHECK(of_fibre(fibre + "z}, fields: {fibre_direction: {expression: [0, 1, 1]}}") ==
        Approx(of_fibre(fibre + "[0, 1, 1]}")).epsilon(1e-9));
}

TEST_CASE("mistakes in fields of constants and directions", "[scene][fields]") {
  const auto rubber = [](const std::string& fields) { return refusal(kRubber + ", fields: {" + fields + "}"); };
  const auto tendon = [](const std::string& field) {
    return refusal(kTendon + "z, fields: {constants: {direction: " + field + "}}");
  };
  CHECK_THAT(rubber("constants: {c3: {expression: 1 kPa}}"), Contains("is no constant of mooney_rivlin"));
  CHECK_THAT(rubber("constants: {c1: {expression: 1 + x / 1 cm}}"), Contains("it must give Pa"));
  CHECK_THAT(rubber("constants: {c1: {expression: 2 kPa - 4 kPa * z / 1 cm}}"),
             Contains("unstable at rest") && Contains("at (") && Contains("scene.yaml:4:"));
  CHECK_THAT(rubber("poissons_ratio: {expression: 0.3}"), Contains("follows from the constants of the law"));
  CHECK_THAT(refusal("youngs_modulus: 1 kPa, fields: {constants: {c1: {expression: 1 kPa}}}"), Contains("of a `law`"));
  CHECK_THAT(refusal("youngs_modulus: 1 kPa, fields: {fibre_direction: {expression: [0, 0, 1]}}"),
             Contains("the material has no `fibre`"));
  CHECK_THAT(tendon("{expression: [0, 0, 0]}"), Contains("is no direction at ("));
  CHECK_THAT(tendon("{expression: [x, 0, 1]}"), Contains("it must give a plain number"));
  CHECK_THAT(tendon("{angle: 30 deg}"), Contains("key 'about' is missing"));
  CHECK_THAT(tendon("{file: layers.vtk, data: E, length_unit: mm}"), Contains("has 1 value a cell; needed: 3"));
}
