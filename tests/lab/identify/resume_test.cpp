// Identification that is interrupted, goes on, and leaves scenes that work where they are put.

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "lab/identify/identify.h"
#include "lab/run/config_names.h"
#include "support/shell.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

const Catalog kCatalog = built_in_catalog();
const std::string kTreloar = std::string(ELASTIN_SOURCE_DIR) + "/scenes/identify/treloar-ogden.yaml";

}  // namespace

TEST_CASE("an interrupted search says so, keeps its best, and goes on from there", "[identify]") {
  const TemporaryFolder folder;
  const Answer whole = identify(kTreloar, kCatalog, {.laws = "yeoh/3"}).front();
  {
    FitJournal journal(folder.path("o"), false);
    int told = 0;
    const Answer half = identify(kTreloar, kCatalog,
                                 {.laws = "yeoh/3",
                                  .progress = [&](const std::string&) { ++told; },
                                  .stop = [&] { return told > 3; },
                                  .journal = &journal})
                            .front();
    CHECK(half.outcome == FitOutcome::not_converged);
    CHECK(half.cause == "the search did not end: interrupted");
    REQUIRE(half.numbers.size() == 3);
  }
  for (const bool again : {false, true}) {
    FitJournal journal(folder.path("o"), true);
    int iterations = 0;
    const Answer rest =
        identify(
            kTreloar, kCatalog,
            {.laws = "yeoh/3",
             .progress = [&](const std::string& doing) { iterations += doing.find("iteration") != std::string::npos; },
             .journal = &journal})
            .front();
    CHECK(rest.outcome == FitOutcome::converged);
    for (std::size_t i = 0; i < 3; ++i) CHECK(rest.numbers[i].value == Approx(whole.numbers[i].value).epsilon(1e-6));
    CHECK((iterations == 0) == again);  // what has ended is not searched again
  }
  CHECK(lines_of(folder.path("o/fits.jsonl")).size() == 2);
}

TEST_CASE("another scene, data or --set is another search", "[identify]") {
  const TemporaryFolder folder;
  folder.write("data.csv", "stretch,nominal_stress [Pa]\n1.1,270\n1.2,520\n1.3,710\n1.4,900\n");
  const std::string scene = folder.write(
      "scene.yaml", "material: {law: yeoh, terms: [300 Pa]}\nidentify: {tests: [{kind: uniaxial, file: data.csv}]}\n");
  const auto lines_after = [&](IdentifyRequest request) {
    FitJournal journal(folder.path("o"), true);
    request.journal = &journal;
    identify(scene, kCatalog, request);
    return lines_of(folder.path("o/fits.jsonl")).size();
  };
  CHECK(lines_after({}) == 1);
  CHECK(lines_after({}) == 1);
  CHECK(lines_after({.overrides = {"identify.residuals=absolute"}}) == 2);
  folder.write("data.csv", "stretch,nominal_stress [Pa]\n1.1,270\n1.2,520\n1.3,710\n1.4,901\n");
  CHECK(lines_after({}) == 3);
}

TEST_CASE("searches over what scatter shows are not done twice", "[identify]") {
  const TemporaryFolder folder;
  std::string data = "stretch,nominal_stress [Pa]\n";  // 300 Pa (λ − 1/λ²) and, by turns, 8 Pa more and less
  for (int i = 1; i <= 12; ++i) {
    const double stretch = 1 + 0.05 * i;
    data += std::to_string(stretch) + "," +
            std::to_string(300 * (stretch - 1 / (stretch * stretch)) + (i % 2 == 0 ? 8 : -8)) + "\n";
  }
  folder.write("data.csv", data);
  const std::string scene = folder.write(
      "scene.yaml", "material: {law: yeoh, terms: [100 Pa]}\nidentify: {tests: [{kind: uniaxial, file: data.csv}]}\n");
  std::vector<double> values;
  for (const bool again : {false, true}) {
    FitJournal journal(folder.path("o"), again);
    int iterations = 0;
    const Answer answer =
        identify(
            scene, kCatalog,
            {.progress = [&](const std::string& doing) { iterations += doing.find("iteration") != std::string::npos; },
             .journal = &journal})
            .front();
    CHECK((iterations == 0) == again);
    CHECK(std::isinf(answer.tests.front().constant));
    CHECK(answer.starts == 8);
    values.push_back(answer.numbers.front().value);
    CHECK(lines_of(folder.path("o/fits.jsonl")).size() == 2);  // the whole search, and the one from its end
  }
  CHECK(values[0] == values[1]);
}

TEST_CASE("a line that is no search is named", "[identify]") {
  const TemporaryFolder folder;
  folder.write("fits.jsonl", "{\"key\": 1}\n");
  const std::string path = folder.path("fits.jsonl");
  CHECK_THROWS_WITH(FitJournal(std::filesystem::path(path).parent_path().string(), true),
                    Catch::Matchers::Contains("fits.jsonl:1") && Catch::Matchers::Contains("no") &&
                        Catch::Matchers::Contains("search of `identify`"));
}

TEST_CASE("the scene that identify writes finds its data from where it lies", "[identify][command]") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("lab/data"));
  folder.write("lab/data/pull.csv", "stretch,nominal_stress [Pa]\n1.1,270\n1.2,520\n1.3,710\n1.4,900\n");
  folder.write(
      "lab/scene.yaml",
      "title: Ähnlich wie data/pull.csv\nmaterial: {law: yeoh, terms: [300 Pa], softening: {r: 2, beta: 0.1}}\n"
      "identify: {tests: [{kind: uniaxial, file: data/pull.csv, name: pull}]}\n");
  REQUIRE(shell(folder, "$elastin identify lab/scene.yaml --quiet --out found") == 0);
  REQUIRE(shell(folder, "$elastin identify found/scene.yaml --quiet --json again.json") == 0);
  const auto first = nlohmann::json::parse(text_of_file(folder.path("found/identify.json"))),
             again = nlohmann::json::parse(text_of_file(folder.path("again.json")));
  CHECK(again["parameters"][0]["value"].get<double>() ==
        Approx(first["parameters"][0]["value"].get<double>()).epsilon(1e-6));
  const std::string scene = text_of_file(folder.path("found/scene.yaml"));
  CHECK(scene.find("file: ../lab/data/pull.csv, name: pull}") != std::string::npos);
  CHECK(scene.find("title: Ähnlich wie data/pull.csv") != std::string::npos);  // a title is no file
  CHECK(scene.find("softening: {r: 2, beta: 0.1}") != std::string::npos);      // what is not searched stays
}

TEST_CASE("the scene that identify writes has the data, the strategy and the numbers that were used, in its own units",
          "[identify][command]") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("my data"));
  folder.write("none.csv", "displacement [mm],force [N]\n1,1\n2,2\n");
  folder.write("my data/pull.csv", "displacement [mm],force [N]\n0.5,0.1\n1,0.21\n1.5,0.33\n2,0.46\n");
  folder.write("scene.yaml",
               "# plain numbers\nbody: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [0.01, 0.01, 0.02]}}\n"
               "material: {youngs_modulus: 10000, poissons_ratio: 0.25}\nstiffness: {strategy: angles, exponent: 0.4}\n"
               "experiment: {kind: tension, axis: z, displacement: 0.002}\n"
               "identify:\n  unknowns: {youngs_modulus: {}, exponent: {low: 0.1, high: 4}}\n"
               "  tests: [{kind: specimen, name: pull, file: none.csv}]\n");
  for (const auto& [more, stiffness] :
       {std::pair<std::string, std::string>{"", "stiffness: {strategy: angles, exponent: "},
        {"--strategies calibrated:van_gelder --set identify.unknowns=[youngs_modulus]",
         "stiffness: calibrated:van_gelder\n"}}) {
    INFO(more);
    const std::string out = more.empty() ? "found" : "springs",
                      scene = more.empty() ? "found/scene.yaml" : "springs/scene-calibrated-van_gelder.yaml";
    const int code = shell(
        folder, "$elastin identify scene.yaml --quiet " + more + " --data \"pull=my data/pull.csv\" --out " + out);
    INFO(text_of_file(folder.path("err")));
    REQUIRE(code == 0);
    const std::string written = text_of_file(folder.path(scene));
    INFO(written);
    CHECK(written.find("file: \"../my data/pull.csv\"}") != std::string::npos);
    CHECK(written.find(stiffness) != std::string::npos);
    CHECK(written.find("exponent: 0.4}") == std::string::npos);
    const int again = shell(folder, "$elastin identify " + scene + " --quiet --json again.json" +
                                        (more.empty() ? "" : " --set identify.unknowns=[youngs_modulus]"));
    INFO(text_of_file(folder.path("err")));
    REQUIRE(again == 0);
    const auto first = nlohmann::json::parse(text_of_file(folder.path(out + "/identify.json"))),
               second = nlohmann::json::parse(text_of_file(folder.path("again.json")));
    for (std::size_t i = 0; i < first["parameters"].size(); ++i)
      CHECK(second["parameters"][i]["value"].get<double>() ==
            Approx(first["parameters"][i]["value"].get<double>()).epsilon(1e-6));
  }
}

TEST_CASE(
    "the scene that identify writes has what it had from a file of materials, from the scene that it extends, and "
    "from --set",
    "[identify][command]") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("lab"));
  std::filesystem::create_directories(folder.path("lib"));
  folder.write("lib/tissues.yaml",
               "gel:\n  youngs_modulus: 10 kPa\n  poissons_ratio: 0.3\n  density: 1100 kg/m3\n"
               "  fibre: {direction: z, youngs_modulus: 5 kPa}\n  softening: {r: 2, beta: 0.1}\n");
  folder.write("lab/pull.csv", "displacement [mm],force [N]\n0.5,0.1\n1,0.21\n1.5,0.33\n2,0.46\n");
  folder.write("lab/base.yaml",
               "body: {tetrahedra: {kind: kuhn, cubes: [1, 1, 2], size: [10 mm, 10 mm, 20 mm]}}\n"
               "material: {file: ../lib/tissues.yaml, name: gel}\nstiffness: neo_hookean\n"
               "experiment: {kind: tension, axis: z, displacement: 2 mm}\n");
  folder.write("lab/scene.yaml",
               "# mine\nextends: base.yaml\nidentify: {tests: [{kind: specimen, name: pull, file: pull.csv}]}\n");
  REQUIRE(shell(folder,
                "$elastin identify lab/scene.yaml --quiet --set identify.residuals=absolute --set "
                "identify.tests.pull.to=\"1.5 mm\" --set experiment.fixed_grip=clamped --set "
                "material.poissons_ratio=0.35 --out found") == 0);
  const std::string written = text_of_file(folder.path("found/scene.yaml"));
  INFO(written);
  CHECK(written.find("file: ../lib/tissues.yaml") != std::string::npos);
  CHECK(written.find("poissons_ratio: 0.35") != std::string::npos);
  CHECK(shell(folder, "$elastin identify found/scene.yaml --quiet --json again.json") == 0);
  INFO(text_of_file(folder.path("err")));
  const auto first = nlohmann::json::parse(text_of_file(folder.path("found/identify.json"))),
             again = nlohmann::json::parse(text_of_file(folder.path("again.json")));
  CHECK(again["parameters"][0]["value"].get<double>() ==
        Approx(first["parameters"][0]["value"].get<double>()).epsilon(1e-6));
  CHECK(again["relative_rms"]["pull"].get<double>() ==
        Approx(first["relative_rms"]["pull"].get<double>()).epsilon(1e-4));
  // Its material is the whole one.
  const IdentifyTask task = load_identify_task(folder.path("found/scene.yaml"), kCatalog);
  CHECK(task.material.density == 1100);
  CHECK(task.material.fibre.has_value());
  CHECK(task.material.softening.has_value());
  CHECK(task.tests.front().residuals == ResidualScale::absolute);
}

TEST_CASE("files of a scene are named from its new folder", "[identify]") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("a/b"));
  folder.write("a/d.csv", "");
  folder.write("a/b.yaml", "");
  const std::string from = folder.path("a"), to = folder.path("a/b/c d");
  CHECK(moved_scene("x: {file: d.csv}\nextends: 'b.yaml'\n", from, to) ==
        "x: {file: ../../d.csv}\nextends: ../../b.yaml\n");
  CHECK(moved_scene("files: [other.csv, d.csv]", from, folder.path("z")) == "files: [other.csv, ../a/d.csv]");
  CHECK(moved_scene("ä: {d: 'd.csv', file: d.csv}\r\n", folder.path("a"), folder.path("ü z")) ==
        "ä: {d: ../a/d.csv, file: ../a/d.csv}\r\n");
}

TEST_CASE("a value of a scene is put in where it stands, or into its map", "[identify]") {
  CHECK(with_value("a: {b: 1, c: [{f: x}, {f: 'x y'}]}\n", "a.c.1.f", "z") == "a: {b: 1, c: [{f: x}, {f: z}]}\n");
  CHECK(with_value("a:\n  # why\n  b: 1  # so\n", "a.b", "2") == "a:\n  # why\n  b: 2  # so\n");
  CHECK(with_value("a: {}\n", "a.b", "2") == "a: {b: 2}\n");
  CHECK(with_value("a:\n  c: 1\n", "a.b", "2") == "a:\n  b: 2\n  c: 1\n");
  CHECK(with_value("a:\n  - c: 1\nd: 2\n", "a", "3") == "a: 3\nd: 2\n");
  CHECK(with_value("a: 1", "b", "3") == "a: 1\nb: 3\n");
  CHECK(with_value("a: [{f: x}]\n", "a.1.f", "z") == "a: [{f: x}]\n");
  CHECK(with_value("a: 1\n", "b.0.f", "z") == "a: 1\n");
  CHECK(with_values(SceneSource::of_text("a.yaml", "a: {b: 1}  # so\n"), {{"a.b", "2"}}) == "a: {b: 2}  # so\n");
  CHECK(with_values(SceneSource::of_text("a.yaml", "a: [{name: x, f: 1}]\n"), {{"a.x.f", "3"}}) ==
        "a: [{name: x, f: 3}]\n");
  // What no line takes: a map that is missing, a list in the place of a value.
  CHECK(with_values(SceneSource::of_text("a.yaml", "a: {b: 1}  # so\n"), {{"c.d", "2"}, {"a.b", "[1, 2]"}}) ==
        "a: {b: [1, 2]}\nc:\n  d: 2\n");
  CHECK_THROWS_WITH(with_values(SceneSource::of_text("a.yaml", "a: [{name: x}]\n"), {{"a.y.f", "3"}}),
                    Catch::Matchers::Contains("no item of the list"));
}
