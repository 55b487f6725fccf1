// What a page of the lab takes of a scene.

#include "lab/live/parcel.h"

#include <catch2/catch.hpp>

#include "core/base/archive.h"
#include "elastin/core/simulation/catalog.h"
#include "lab/live/live.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

Parcel parcel_of(const std::string& experiment, const std::string& stiffness = "neo_hookean") {
  const TemporaryFolder folder;
  const std::string scene = R"(title: A block
body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [2 cm, 2 cm, 2 cm]}}
material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}
stiffness: )";
  return make_parcel(*load_scene(folder.write("scene.yaml", scene + stiffness + "\nexperiment: " + experiment + "\n"),
                                 built_in_catalog()),
                     built_in_catalog());
}

/// As the page's module reads it.
Parcel sent(Parcel parcel) {
  ByteWriter writer;
  visit(writer, parcel);
  const std::vector<char> bytes = writer.take();
  ByteReader reader(bytes.data(), bytes.size(), "parcel");
  Parcel read;
  visit(reader, read);
  return read;
}

}  // namespace

TEST_CASE("a page takes the load of a scene's experiment where it is the same wherever the body goes") {
  const Parcel hanging = parcel_of("{kind: bending, axis: x, gravity: 9.81 m/s2, direction: -z}");
  REQUIRE(hanging.own_load.cols() == hanging.body.size());
  CHECK(hanging.own_load.row(2).sum() == Approx(-9.81 * 1000 * 8e-6).epsilon(1e-9));
  CHECK(hanging.own_load.topRows(2).isZero(1e-15));
  CHECK(hanging.own_load_share == 1);
  // In time it is the fixture's: put on at time 0, or taken away then.
  for (const auto& [load, share] : {std::pair("applied", 1.), std::pair("removed", 0.)}) {
    const Parcel swinging = parcel_of(
        std::string("{kind: release, fixture: {kind: bending, axis: x, gravity: 9.81 m/s2, direction: -z}, load: ") +
        load + "}\ntime: {duration: 1 s, stepper: newmark, step: 5 ms}");
    REQUIRE(swinging.own_load.cols() == hanging.body.size());
    CHECK(swinging.own_load.isApprox(hanging.own_load, 1e-12));
    CHECK(swinging.own_load_share == Approx(share).margin(1e-9));
  }
  // A tool in the middle of a body that has not moved yet would push it away for ever.
  CHECK(parcel_of("{kind: indentation, indenter: {sphere: {radius: 1 cm}}, depth: 5 mm}\ncontact: {friction: 0}")
            .own_load.cols() == 0);
  CHECK(parcel_of("{kind: tension, axis: z, force: 1 mN}").own_load.cols() == 0);
}

TEST_CASE("a page pulls a body as the scene does, held by the scene's supports") {
  const std::string supports = "\nsupports: [{molecules: {side: -y}, fix: [y]}]";
  const Parcel own = sent(parcel_of("{kind: tension, axis: z, strain: 0.1, cycle: [1, 0.5]}" + supports));
  CHECK(own.own_test);
  REQUIRE(own.further_supports.size() == 9);  // corners of 2 x 2 cubes
  CHECK(own.further_supports.front().free.isApprox(Vector3(1, 0, 1).asDiagonal().toDenseMatrix()));
  CHECK(own.tension.cycle == std::vector<double>{1, 0.5});
  CHECK(own.tension.density == 1000);
  const Parcel other = sent(parcel_of("{kind: bending, axis: x, direction: -z, force: 1 mN}" + supports));
  CHECK(!other.own_test);
  CHECK(other.further_supports.empty());
}

TEST_CASE("bodies of a page have the Voronoi cells of their molecules each") {
  const TemporaryFolder folder;
  const std::string cube = "tetrahedra: {kind: kuhn, cubes: [2, 2, 2], size: [1 cm, 1 cm, 1 cm]}";
  const auto scene = load_scene(
      folder.write("scene.yaml", "bodies:\n  - {name: low, " + cube + ", material: {youngs_modulus: 30 kPa}}\n" +
                                     "  - {name: high, " + cube + ", at: [0, 0, 1 cm]}\n" +
                                     "ties: [{between: [low, high], within: 0.1 mm}]\n"
                                     "material: {youngs_modulus: 10 kPa}\nstiffness: voronoi\n"
                                     "experiment: {kind: tension, axis: z, strain: 0.01}\n"),
      built_in_catalog());
  const Parcel parcel = make_parcel(*scene, built_in_catalog());
  REQUIRE(parcel.body.parts.size() == 2);
  for (const Part& part : parcel.body.parts) CHECK(part.voronoi.has_value());
}

TEST_CASE("a page of a body that cannot be pulled has no test") {
  const TemporaryFolder folder;
  const auto of = [&](const std::string& body) {
    const auto scene = load_scene(
        folder.write("scene.yaml", body + "\nmaterial: {youngs_modulus: 10 kPa}\nstiffness: lattice\n"
                                          "experiment: {kind: loads, read: [{name: tip, molecules: {side: x}}]}\n"
                                          "supports: [{molecules: {side: -x}}]\n"),
        built_in_catalog());
    return make_parcel(*scene, built_in_catalog());
  };
  CHECK_THAT(of("body: {lattice: {kind: cubic, molecules: [9, 1, 1], spacing: 1 mm, connections: [axis]}}").no_test,
             Catch::Contains("span no cross-section"));
  CHECK(of("body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 1 mm, connections: [axis, face]}}")
            .no_test.empty());
}

TEST_CASE("a page says what it leaves out of a scene") {
  using Words = std::vector<std::string>;
  CHECK(parcel_of("{kind: tension, axis: z, force: 1 mN}").left_out.empty());
  CHECK(parcel_of("{kind: indentation, indenter: {sphere: {radius: 1 cm}}, depth: 5 mm}\ncontact: {friction: 0}")
            .left_out == Words{"contact and its obstacles"});
  const std::string clamped = "{kind: tension, axis: z, strain: 0.01, fixed_grip: clamped}\nreference: none\n";
  const Parcel calibrated = parcel_of(clamped + "calibrate: {experiment: {kind: material}}", "calibrated:van_gelder");
  CHECK(calibrated.strategies.front().label == "van_gelder");
  CHECK(calibrated.left_out ==
        Words{"calibration, of calibrated:van_gelder: the page begins with van_gelder as it is"});
  CHECK(parcel_of("{kind: drop, gravity: 9.81 m/s2, height: 10 cm}\ntime: {duration: 0.1 s}").left_out ==
        Words{"what acts in its experiment `drop`"});
  const std::string motion = "{kind: motion, fixture: {kind: bending, axis: x, direction: -z, force: 1 mN}}\n";
  const Parcel moving = parcel_of(motion +
                                  "time: {duration: 1 s, stepper: newmark, step: 5 ms}\nloads:\n"
                                  "  - {rayleigh: {mass: 20 1/s, stiffness: 1 ms}}\n"
                                  "  - {gravity: [0, 0, 1 m/s2], in_time: {ramp: {duration: 1 s}}}");
  CHECK(moving.left_out ==
        Words{"1 load in time or on a part of the surface", "the damping by stiffness of `rayleigh`"});
}

TEST_CASE("a page gets the rest of a body as numbers, and finds none itself") {
  const auto with = [](const std::string& rest) {
    return "{kind: tension, axis: z, displacement: 0 mm}\nrest: " + rest;
  };
  const Parcel parcel = parcel_of(with("{swelling: 1.1, factor: 0.5}"));
  REQUIRE(parcel.rest.points.size() == parcel.body.tetrahedra.size());
  CHECK(parcel.rest.points.back().growth.isApprox(1.05 * Matrix3::Identity(), 1e-12));
  CHECK(parcel.rest.factors.front() == Approx(1.05));
  Body sent = parcel.body;
  sent.unstressed = std::make_shared<const Rest>(rest_of(sent, parcel.rest));
  Model model(sent);
  model.add(built_in_catalog().find("neo_hookean").make(sent, parcel.material, {}));
  CHECK(model.elastic_forces(1.05 * sent.rest).norm() < 1e-9 * model.elastic_forces(sent.rest).norm());
  CHECK_THROWS_WITH(parcel_of(with("{prestrain_in_place: 1.1}")), Catch::Contains("cannot find a rest"));
}

TEST_CASE("a strategy with a label of its own goes into the page by its name") {
  const TemporaryFolder folder;
  const auto scene = load_scene(
      folder.write("scene.yaml",
                   "body: {lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 1 mm, connections: [axis, face]}}\n"
                   "material: {youngs_modulus: 10 kPa}\nstiffness: {strategy: lattice, label: mine}\n"
                   "experiment: {kind: tension, axis: z, force: 1 mN}\n"),
      built_in_catalog());
  const Parcel parcel = make_parcel(*scene, built_in_catalog());
  CHECK(parcel.strategies.front().label == "mine");
  CHECK(parcel.strategies.front().name == "lattice");
  CHECK(live_page(*scene, built_in_catalog(), parcel, {"script", "module"}).find("\"mine\"") != std::string::npos);
}

TEST_CASE("a page takes no material that is a function, and says so", "[refusal]") {
  const auto with = [](const std::string& material) {
    const TemporaryFolder folder;
    const std::string scene =
        "body: {tetrahedra: {kind: body_centred, cubes: [2, 2, 2], size: [2 cm, 2 cm, 2 cm]}}\n"
        "material: " +
        material +
        "\nstiffness: neo_hookean\n"
        "experiment: {kind: tension, axis: z, force: 1 mN}\n";
    return make_parcel(*load_scene(folder.write("scene.yaml", scene), built_in_catalog()), built_in_catalog());
  };
  CHECK_THROWS_WITH(with("{youngs_modulus: 10 kPa, fields: {poissons_ratio: {expression: 0.2 + 0.1 * z / 2 cm}}}"),
                    Catch::Contains("varies over the body"));
  const Material known = with("{youngs_modulus: 10 kPa, softening: {r: 2, m: 1 kPa, beta: 0.1}}").material;
  REQUIRE(known.softening);
}
