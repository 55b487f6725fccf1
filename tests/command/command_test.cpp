// The command as a process: what it prints, where, and with which exit code.

#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <set>
#include <string>
#include <vector>

#include "command/said.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/lab/run/measures.h"
#include "support/shell.h"
#include "support/temporary_folder.h"

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using elastin::shell;

namespace {

const std::string kTension = std::string(ELASTIN_SOURCE_DIR) + "/scenes/tension/";

const std::string kCube = R"(title: A small cube
body:
  lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 7.5 mm, connections: [axis, face]}
material: {youngs_modulus: 5 kPa}
stiffness: lattice
strategies: [standard, lattice, van_gelder]
experiment: {kind: tension, axis: z, force: 11.25 uN, load_steps: 2}
expect:
  - {strategy: lattice, measure: effective_modulus, value: 5 kPa, tolerance: 0.01 %, source: the material itself}
)";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), by);
}

}  // namespace

TEST_CASE("exit code 0: everything ran and is as expected", "[command]") {
  const TemporaryFolder folder;
  const std::string cube = folder.write("cube.yaml", kCube);
  const Said run = say("run " + cube);
  CHECK(run.code == 0);
  CHECK(run.err.empty());
  CHECK_THAT(run.out,
             StartsWith("cube  A small cube\n  27 molecules, 126 connections; target: E = 5.0000 kPa, nu = 0.25"));
  CHECK_THAT(run.out, Contains("lattice: converged\n") && Contains("effective_modulus  5.0000") && Contains("passed"));
  CHECK_THAT(run.out, !Contains("\033"));  // not a terminal
  const Said compare = say("compare " + cube);
  CHECK(compare.code == 0);  // a strategy that cannot run on the body is a row of a comparison
  CHECK_THAT(compare.out,
             Contains("not suited: needs tetrahedra or triangles") && Contains("recommended: lattice: E "));
}

TEST_CASE("the option --version gives name and version", "[command]") {
  const Said said = say("--version");
  CHECK(said.code == 0);
  CHECK(said.err.empty());
  CHECK(said.out.substr(0, 8) == "elastin ");
  CHECK(std::count(said.out.begin(), said.out.end(), '.') == 2);  // 0.2.0
  CHECK(std::count(said.out.begin(), said.out.end(), '\n') == 1);
}

TEST_CASE("verify: a scene that expects nothing is not judged, and fails only where its run does", "[command]") {
  const TemporaryFolder folder;
  const std::string plain = folder.write("plain.yaml", kCube.substr(0, kCube.find("expect:")));
  const Said said = say("verify " + plain);
  CHECK(said.code == 0);
  CHECK_THAT(said.out, Contains("no expectation") && Contains("0 of 1 passed, 1 not judged\n"));
  CHECK(say("verify " + plain + " --set solver.newton_limit=1 --set experiment.force=0.1").code == 1);
}

TEST_CASE("plot draws every CSV that Elastin writes, with axes of its own choice", "[command][plot]") {
  const TemporaryFolder folder;
  const std::string cube = folder.write("cube.yaml", kCube), out = folder.path("out");
  REQUIRE(say("compare " + cube + " --out " + out).code == 0);
  const auto drawn = [](const Said& said) {
    REQUIRE(said.code == 0);
    pugi::xml_document document;
    REQUIRE(document.load_string(said.out.c_str()));
    std::string text;  // all that stands on the plot
    for (const auto& found : document.select_nodes("//text")) text += found.node().text().get() + std::string("|");
    return text;
  };
  const std::string curve = "plot " + out + "/cube-lattice-curve.csv";
  CHECK_THAT(drawn(say(curve)), Contains("strain →") && Contains("↑ stress|"));
  CHECK_THAT(drawn(say(curve + " --x load_factor --y elongation")),
             Contains("load_factor →") && Contains("↑ elongation|") && Contains(" nm|"));
  CHECK_THAT(drawn(say("plot " + out + "/runs.csv")),
             Contains("solve →") && Contains("↑ error effective_modulus|") && Contains("standard|lattice|"));
  const Said unknown = say(curve + " --y elongatio");
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Contains("cube-lattice-curve.csv:1: no column 'elongatio'; did you mean 'elongation'?"));
  // Several curves are one document, on the axes of the first.
  const std::string other = out + "/cube-standard-curve.csv";
  CHECK_THAT(drawn(say(curve + " " + other)),
             Contains("cube-lattice-curve.csv|") && Contains("cube-standard-curve.csv|"));
  const Said apart = say("plot " + out + "/runs.csv " + other);
  CHECK(apart.code == 2);
  CHECK(apart.out.empty());
  CHECK_THAT(apart.err, Contains("cube-standard-curve.csv:1: no column 'solve'"));
  const std::string text = folder.write("words.csv", "a,b\nx,y\n");
  CHECK_THAT(say("plot " + text).err, Contains("words.csv:1: no columns that are drawn by themselves; choose some"));
}

TEST_CASE("exit code 1: an expectation or the run failed", "[command]") {
  const TemporaryFolder folder;
  const std::string wrong = folder.write("wrong.yaml", replaced(kCube, "value: 5 kPa", "value: 6 kPa"));
  const Said failed = say("run " + wrong);
  CHECK(failed.code == 1);
  CHECK(failed.err.empty());
  CHECK_THAT(failed.out, Contains("failed"));
  CHECK(say("compare " + wrong).code == 1);
  CHECK(say("compare " + wrong + " --strategies standard").code == 0);  // it is about lattice

  const std::string cube = folder.write("cube.yaml", kCube);
  const Said unsuited = say("run " + cube + " --strategies van_gelder");
  CHECK(unsuited.code == 1);
  CHECK_THAT(unsuited.out, Contains("van_gelder: not suited: needs tetrahedra or triangles"));
  // A comparison fails where nothing of it can run, and not for a row that cannot; an empty share is none that fails.
  CHECK(say("compare " + cube + " --strategies van_gelder,neo_hookean").code == 1);
  CHECK(say("compare " + cube + " --strategies van_gelder,standard").code == 0);
  const Said stopped = say("run " + cube + " --set solver.newton_limit=1 --set experiment.force=0.1");
  CHECK(stopped.code == 1);
  CHECK_THAT(stopped.out, Contains("lattice: limit reached: no equilibrium within 1 Newton iteration"));
}

TEST_CASE("what rounding alone makes of the load is no equilibrium", "[command]") {
  // Next to an end 10¹² times as stiff, forces are known no better than the load is large: the body did not move at
  // all.
  const TemporaryFolder folder;
  const std::string contrast = text_of_file(ELASTIN_SOURCE_DIR "/scenes/hard/contrast.yaml");
  const Said said = say("run " + folder.write("contrast.yaml", replaced(contrast, "1e6", "1e12")));
  CHECK(said.code == 1);
  CHECK_THAT(said.out, Catch::Contains("limit reached: the unbalanced force is") && Catch::Contains("rounding"));
}

TEST_CASE("run says how many steps were cut, and which cells are inverted at rest", "[command]") {
  const TemporaryFolder folder;
  const std::string block = folder.write("block.yaml", R"(body:
  tetrahedra: {kind: kuhn, cubes: [4, 4, 2], size: [6 cm, 6 cm, 1.5 cm]}
material: {youngs_modulus: 5 kPa, poissons_ratio: 0.3}
stiffness: neo_hookean
experiment: {kind: compression, axis: z, force: 27 N}
)");
  const Said cut = say("run " + block);
  CHECK(cut.code == 0);
  CHECK_THAT(cut.out, Contains("cut: a cell would have inverted\n"));
  CHECK(nlohmann::json::parse(say("run --json - " + block).out)["runs"][0]["cut_steps"] > 0);
  const Said gentle = say("run " + block + " --set experiment.force=0.001");
  CHECK_THAT(gentle.out, !Contains("cut"));
  const Said turned = say("run " + block + " --set 'body.tetrahedra.cubes=[8,8,4]' --set body.jitter.amount=0.5");
  CHECK(turned.code == 1);
  CHECK_THAT(turned.out, Contains("neo_hookean: inverted: cells ") && Contains(" are flat or inverted at rest\n"));
}

TEST_CASE("exit code 2: wrong use or input, reported on standard error alone", "[command][slow]") {
  const TemporaryFolder folder;
  const std::string cube = folder.write("cube.yaml", kCube);
  const std::string slip = folder.write("slip.yaml", replaced(kCube, "spacing", "spacng"));
  struct Row {
    std::string arguments, message;
  };
  for (const Row& row : std::vector<Row>{
           {"run " + slip, "elastin: " + slip + ":3:48: body.lattice: unknown key 'spacng'; did you mean 'spacing'?"},
           {"check " + slip, "elastin: " + slip + ":3:48: body.lattice: unknown key 'spacng'"},
           {"compare " + cube + " " + slip, "elastin: " + slip + ":3:48: "},  // before anything runs
           {"run " + folder.path("cub.yaml"),
            "elastin: " + folder.path("cub.yaml") + ": no such file; did you mean 'cube.y"},
           {"run " + folder.path(""), "elastin: " + slip + ":3:48: "},  // all scenes below the folder
           {"export " + folder.path("") + " --to csv --out out", "elastin: " + folder.path("") + ": is a folder"},
           {"run " + cube + " --set body.radius=-1", "elastin: --set: body.radius: '-1' is out of range"},
           {"run --set body.radios=1 " + cube, "elastin: --set: body: unknown key 'radios'; did you mean 'radius'?"},
           {"run " + cube + " --strategies latice",
            "elastin: --strategies: unknown strategy 'latice'; did you mean 'lattice'?"},
           {"run " + cube + " --strategies standard,,",
            "elastin: --strategies: unknown strategy ''; allowed: standard, "},
           {"run " + cube + " --out " + cube,
            "elastin: " + cube + "/runs.jsonl: cannot make its folder: Not a directory"},
           {"run " + cube + " --json " + folder.path(""), "elastin: " + folder.path("") + ": cannot "},
       }) {
    INFO(row.arguments);
    const Said said = say(row.arguments);
    CHECK(said.code == 2);
    CHECK(said.out.empty());
    CHECK_THAT(said.err, StartsWith(row.message));
    CHECK_THAT(said.err, !Contains("internal error"));
  }
}

TEST_CASE("the option --json - gives JSON and nothing else", "[command]") {
  const Said said = say("compare '" + kTension + "table1-a.yaml' '" + kTension + "table1-b.yaml' --json -");
  CHECK(said.code == 0);
  CHECK(said.err.empty());
  const auto json = nlohmann::json::parse(said.out);
  REQUIRE(json["runs"].size() == 8);
  CHECK(json["runs"][0]["scene"] == "table1-a");
  CHECK(json["runs"][7]["scene"] == "table1-b");
  CHECK(json["runs"][7]["zero_energy_modes"] == 12);
}

TEST_CASE("a pipe gets one JSON, and a link to a file stays one", "[command]") {
  const TemporaryFolder folder;
  const std::string link = folder.path("link.json"), file = folder.path("real.json"), piped = folder.path("piped.json");
  const std::string run = "run --quiet '" + kTension + "table1-a.yaml' --json ";
  CHECK(say(run + "/dev/stderr 2>&1 | cat > '" + piped + "'; true").code == 0);
  CHECK(nlohmann::json::parse(text_of_file(piped))["runs"].size() == 1);
  folder.write("real.json", "{}");
  std::filesystem::create_symlink(file, link);
  CHECK(say(run + "'" + link + "'").code == 0);
  CHECK(std::filesystem::is_symlink(link));
  CHECK(nlohmann::json::parse(text_of_file(file))["runs"].size() == 1);
}

TEST_CASE("output that cannot be written is an error", "[command]") {
  for (const std::string& arguments : {std::string("list"), "run '" + kTension + "table1-a.yaml' --json -"}) {
    const Said said = say("--version; (" ELASTIN_COMMAND " " + arguments + " > /dev/full)");
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Catch::Contains("standard output could not be written"));
  }
}

// [slow]: under the sanitizers, which claim far more addresses than that, nothing could begin.
TEST_CASE("a body that does not fit into memory is named as such", "[command][slow]") {
  const TemporaryFolder folder;
  const std::string large = folder.write("large.yaml", replaced(kCube, "[3, 3, 3]", "[90, 90, 90]"));
  for (const char* kilobytes : {"400000", "800000"}) {
    const Said said =
        say("--version; (ulimit -v " + std::string(kilobytes) + "; " ELASTIN_COMMAND " run " + large + ")");
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains("the scene does not fit into this machine's memory") ||
                             Contains("there is not enough memory for this body"));
    CHECK_THAT(said.err, !Contains("internal error"));
  }
}

TEST_CASE("the option --json FILE and --quiet print nothing", "[command]") {
  const TemporaryFolder folder;
  const std::string cube = folder.write("cube.yaml", kCube), file = folder.path("runs.json");
  const Said said = say("compare " + cube + " --quiet --json " + file);
  CHECK(said.code == 0);
  CHECK((said.out + said.err).empty());
  CHECK(nlohmann::json::parse(text_of_file(file))["runs"].size() == 3);
  const Said checked = say("check --quiet " + cube);
  CHECK(checked.code == 0);
  CHECK((checked.out + checked.err).empty());
  // What failed is still in the exit code.
  const Said failed = say("run --quiet --set experiment.axis=[1,1,1] --set experiment.reading=corner " + cube);
  CHECK(failed.code == 1);
  CHECK((failed.out + failed.err).empty());
}

TEST_CASE("the option --verbose prints runs in full, and every point of their curves", "[command]") {
  const TemporaryFolder folder;
  const std::string cube = folder.write("cube.yaml", kCube);
  const auto count = [](const std::string& text, const std::string& word) {
    int found = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
    return found;
  };
  const std::string steps = " --set experiment.load_steps=3 " + cube;
  const std::string brief = say("run" + steps).out, whole = say("run --verbose" + steps).out;
  CHECK_THAT(brief, !Contains("reaction balance"));
  CHECK_THAT(whole, Contains("reaction balance"));
  CHECK(count(say("compare" + steps).out, "; target: ") == 1);
  CHECK(count(say("compare --verbose" + steps).out, "; target: ") == 1 + 3);  // three strategies
  CHECK_THAT(say("verify" + steps).out, !Contains("Newton iterations"));
  CHECK_THAT(say("verify --verbose" + steps).out, Contains("Newton iterations"));
}

TEST_CASE("the option --help explains with examples", "[command]") {
  for (const std::string command : {"", "run ", "compare ", "merge ", "verify ", "check ", "identify ", "list ",
                                    "plot ", "lab ", "export ", "new "}) {
    INFO(command);
    const Said said = say(command + "--help");
    CHECK(said.code == 0);
    CHECK(said.err.empty());
    CHECK_THAT(said.out, Contains("Examples:\n  elastin " + (command.empty() ? "run " : command)) &&
                             Contains("Exit codes: 0 all expectations hold"));
    for (const std::string other : {"verify ", "merge "})  // each command has its own examples
      if (!command.empty() && command != other) CHECK_THAT(said.out, !Contains("elastin " + other));
    CHECK_THAT(said.out, Contains("Usage: elastin"));
  }
  CHECK_THAT(say("run --help").out, Contains("--set") && Contains("--strategies") && Contains("--out") &&
                                        Contains("--json") && Contains("--threads") && Contains("--quiet") &&
                                        Contains("--verbose"));
}

TEST_CASE("list names every strategy, parameter and measure", "[command]") {
  const Said said = say("list");
  CHECK(said.code == 0);
  const elastin::Catalog catalog = elastin::built_in_catalog();
  for (const elastin::Strategy& strategy : catalog.strategies()) {
    CHECK_THAT(said.out, Contains("\n  " + strategy.name + "  ") && Contains(strategy.summary));
    for (const elastin::ParameterInfo& info : strategy.parameters)
      CHECK_THAT(said.out, Contains("\n  " + strategy.name + "." + info.name + " ") && Contains(info.text));
  }
  for (const elastin::lab::MeasureInfo& info : elastin::lab::built_in_measures())
    CHECK_THAT(said.out, Contains("\n  " + info.name + " ") && Contains(info.text));
  CHECK_THAT(said.out, Contains("tangent_modulus            Pa  ") && Contains("torque                     N m  "));
}

TEST_CASE("list finds the keys of all maps of a scene", "[command]") {
  for (const auto& [word, key] : std::vector<std::pair<std::string, std::string>>{{"adhesion", "contact.adhesion"},
                                                                                  {"swelling", "rest.swelling"},
                                                                                  {"friction", "contact.friction"},
                                                                                  {"ramp", "relaxation.ramp"},
                                                                                  {"title", "title"}}) {
    const Said said = say("list " + word);
    INFO(word << ": " << said.out << said.err);
    CHECK(said.code == 0);
    CHECK_THAT(said.out, Contains("\n  " + key + " "));
  }
  CHECK_THAT(say("list").out, !Contains("Keys of a scene"));
}

TEST_CASE("check names zero-energy modes and how many", "[command]") {
  const Said said = say("check '" + kTension + "table1-b.yaml'");
  CHECK(said.code == 0);  // a mechanism is no fault of the body
  CHECK_THAT(said.out, Contains("mechanism: 12 zero-energy modes in 12 groups\n"));
  CHECK_THAT(said.out, Contains("  molecules 9, 10, 11 slide together along x\n"));
  CHECK_THAT(said.out, Contains("27, radius 5.0000 mm, mass ") && Contains("54, 7.5000 mm long; 3 to 6 a molecule"));
  std::size_t modes = 0;
  for (std::size_t at = 0; (at = said.out.find("slide together along", at)) != std::string::npos; ++at) ++modes;
  CHECK(modes == 12);
  const Said stiff = say("check '" + kTension + "cube-27-face.yaml'");
  CHECK(stiff.code == 0);
  CHECK_THAT(stiff.out, Contains("zero-energy modes     0\n") && !Contains("mechanism:"));
}

TEST_CASE("check names isolated molecules and separate pieces", "[command]") {
  const TemporaryFolder folder;
  const std::string scene = folder.write("apart.yaml", R"(body:
  molecules: [[0, 0, 0], [1 cm, 0, 0], [0, 1 cm, 0], [0, 0, 1 cm], [5 cm, 0, 0], [5 cm, 0, 1 cm], [8 cm, 0, 1 cm]]
  connections: [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3], [4, 5], [3, 0]]
material: {youngs_modulus: 5 kPa}
stiffness: standard
experiment: {kind: tension, axis: z, force: 1 mN}
)");
  const Said said = say("check " + scene);
  CHECK(said.code == 1);
  CHECK(said.err.empty());
  CHECK_THAT(said.out, Contains("PIECES                3: the body is not connected\n"));
  CHECK_THAT(said.out, Contains("piece 0: 4 molecules: 0, 1, 2, 3\n") && Contains("piece 1: 2 molecules: 4, 5\n"));
  CHECK_THAT(said.out, Contains("ISOLATED MOLECULES    1: 6\n"));
  CHECK_THAT(said.out, Contains("DUPLICATE CONNECTIONS 1: 7 (3–0)\n"));
  CHECK_THAT(said.out, !Contains("overlapping spheres"));
  CHECK_THAT(say("check " + scene + " --set body.radius=0.0155").out,
             Contains("overlapping spheres   1 pair not joined by a connection, up to 1.0000 mm deep: 5–6"));
  // One fault alone is enough.
  const std::string twice = folder.write("twice.yaml", R"(body:
  molecules: [[0, 0, 0], [1 cm, 0, 0], [0, 1 cm, 0], [0, 0, 1 cm], [0, 0, 1 cm]]
  connections: [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3], [3, 4]]
material: {youngs_modulus: 5 kPa}
stiffness: standard
experiment: {kind: tension, axis: z, force: 1 mN}
)");
  const Said length = say("check " + twice);
  CHECK(length.code == 1);
  CHECK_THAT(length.out, Contains("NO LENGTH             1: 6 (3–4)\n") && Contains("pieces                1\n"));
}

TEST_CASE("several scenes are reported one after the other", "[command]") {
  const Said said = say("compare '" + kTension + "table1-a.yaml' '" + kTension + "table1-c.yaml'");
  CHECK(said.code == 0);
  const std::size_t first = said.out.find("table1-a  "), second = said.out.find("table1-c  ");
  REQUIRE(first != std::string::npos);
  REQUIRE(second != std::string::npos);
  CHECK(first < second);
  CHECK_THAT(said.out, Contains("2 molecules, 1 connection;"));
  const Said checked = say("check '" + kTension + "table1-a.yaml' '" + kTension + "table1-c.yaml'");
  CHECK_THAT(checked.out, Contains("table1-a  ") && Contains("table1-c  "));
}

TEST_CASE("several scenes end with a summary, and the option --summary gives nothing else", "[command]") {
  const std::string scenes = "'" + kTension + "table1-c.yaml' '" + kTension + "cube-27-face.yaml'";
  const Said all = say("compare " + scenes), only = say("compare --summary " + scenes);
  CHECK(all.code == only.code);
  CHECK_THAT(all.out, StartsWith("table1-c  ") && Contains("Summary  2 bodies\n"));
  CHECK_THAT(only.out, StartsWith("Summary  2 bodies\n") && Contains("  table1-c ") && Contains("  cube-27-face "));
  CHECK(only.err.empty());
  CHECK_THAT(say("compare '" + kTension + "table1-a.yaml'").out, !Contains("Summary"));
  // JSON hides nothing.
  CHECK(nlohmann::json::parse(say("compare --summary --json - " + scenes).out)["runs"].size() ==
        nlohmann::json::parse(say("compare --json - " + scenes).out)["runs"].size());
}

TEST_CASE("the option --out leaves every file whole", "[command]") {
  const TemporaryFolder folder;
  const std::string cube =
      folder.write("cube.yaml", replaced(kCube, "lattice, van", "{strategy: divided, label: 'a/b & c'}, van"));
  const std::string out = folder.path("deep/out");
  const Said said = say("compare " + cube + " --out " + out);
  CHECK(said.code == 0);
  CHECK_THAT(said.out, Contains("files in " + out + "/: report.html, runs.csv, runs.json, curves"));
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(out)) files.insert(entry.path().filename().string());
  std::set<std::string> expected{"runs.csv",   "runs.json",   "runs.jsonl",     "views.jsonl",
                                 "study.json", "report.html", "cube-error.svg", "cube-response.svg"};
  for (const std::string run : {"cube-standard", "cube-a~2fb~20~26~20c"})  // what cannot run leaves no curve
    for (const char* end : {"-curve.csv", ".pvd", "-000.vtu", "-001.vtu", "-002.vtu"}) expected.insert(run + end);
  CHECK(files == expected);
  for (const std::string& file : files) {
    const std::string text = text_of_file(out + "/" + file);
    INFO(file);
    CHECK_FALSE(text.empty());
    if (file.ends_with(".vtu") || file.ends_with(".pvd")) {
      pugi::xml_document document;
      REQUIRE(document.load_string(text.c_str()));
      for (const pugi::xml_node set : document.child("VTKFile").child("Collection").children())
        CHECK(files.count(set.attribute("file").value()) == 1);
    }
  }
  const auto json = nlohmann::json::parse(text_of_file(out + "/runs.json"));
  REQUIRE(json["runs"].size() == 3);
  CHECK(json["runs"][1]["strategy"] == "a/b & c");
  const std::string csv = text_of_file(out + "/runs.csv");
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 4);
}

TEST_CASE("the option --strategies takes names of the catalog and labels of the scene, with the scene's parameters",
          "[command]") {
  const TemporaryFolder folder;
  const std::string cube = folder.write(
      "cube.yaml",
      replaced(kCube, "lattice, van_gelder",
               "{strategy: uniform, constant: 2 N/m}, {strategy: uniform, constant: 6 N/m, label: stiff}"));
  const Said said = say("compare " + cube + " --strategies 'uniform, stiff,calibrated:angles,stiff' --json -");
  const auto json = nlohmann::json::parse(said.out);
  REQUIRE(json["runs"].size() == 3);
  CHECK(json["runs"][2]["strategy"] == "calibrated:angles");
  const double soft = json["runs"][0]["measures"]["effective_modulus"],
               stiff = json["runs"][1]["measures"]["effective_modulus"];
  CHECK(stiff == Approx(3 * soft).epsilon(1e-3));  // of constants 6 and 2; the strain itself is of order 1e-4
  const auto all = nlohmann::json::parse(say("compare " + cube + " --strategies all --json -").out);
  CHECK(all["runs"].size() > elastin::built_in_catalog().strategies().size());
}

TEST_CASE("threads change no bit of what is measured", "[command]") {
  const auto measured = [](int threads) {
    const Said said = say("run '" + kTension + "table1-c.yaml' --json - --threads " + std::to_string(threads));
    auto run = nlohmann::json::parse(said.out)["runs"][0];
    CHECK(run["threads"] <= threads);  // 1 in a build without OpenMP
    return run["measures"];
  };
  CHECK(measured(1) == measured(3));
}

TEST_CASE("on a terminal of 80 columns no row of a table is longer", "[command][screen]") {
  const TemporaryFolder folder;
  const std::string cube = folder.write("cube.yaml", kCube);
  for (const std::string& command : {"compare " + cube, "run " + cube, std::string("list")}) {
    INFO(command);
    int master = 0, slave = 0;
    winsize size{};
    size.ws_col = 80;
    size.ws_row = 24;
    REQUIRE(openpty(&master, &slave, nullptr, nullptr, &size) == 0);
    const pid_t child = fork();
    if (child == 0) {
      dup2(slave, STDOUT_FILENO);
      close(master);
      const std::string line = "NO_COLOR=1 exec '" ELASTIN_COMMAND "' " + command;
      execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
      _exit(127);
    }
    close(slave);
    std::string text;
    char buffer[4096];
    for (ssize_t got; (got = read(master, buffer, sizeof buffer)) > 0;)
      text.append(buffer, static_cast<std::size_t>(got));
    close(master);
    waitpid(child, nullptr, 0);
    // The first table, from its head to the empty line below.
    std::size_t from = text.find(command == "list"            ? "\n  name"
                                 : command.starts_with("run") ? "\n  measure"
                                                              : "\n  strategy");
    REQUIRE(from != std::string::npos);
    for (std::size_t end; from != std::string::npos && (end = text.find('\n', from + 1)) != std::string::npos;
         from = end) {
      const std::string row = text.substr(from + 1, end - from - 1);
      if (row.size() < 3) break;
      CHECK(std::count_if(row.begin(), row.end(), [](char c) { return (c & 0xC0) != 0x80 && c != '\r'; }) <= 80);
    }
  }
}

TEST_CASE("labels that differ have files that differ", "[command]") {
  const TemporaryFolder folder;
  const std::string out = folder.path("out");
  const std::string cube =
      folder.write("cube.yaml", replaced(kCube, "lattice, van_gelder",
                                         "{strategy: lattice, label: my law}, {strategy: standard, label: my-law}, "
                                         "{strategy: divided, label: 'my:law'}"));
  CHECK(say("compare " + cube + " --out " + out).code == 0);
  for (const std::string label : {"my~20law", "my~2dlaw", "my-law"})
    CHECK(std::filesystem::exists(out + "/cube-" + label + "-curve.csv"));
  // A scene's name and a label may make one name together.
  folder.write("a.yaml", replaced(kCube, "strategies: ", "strategies: [{strategy: lattice, label: 'b:c'}]\n# "));
  folder.write("a-b.yaml", replaced(kCube, "strategies: ", "strategies: [{strategy: lattice, label: c}]\n# "));
  const Said said = say("compare " + folder.path("a.yaml") + " " + folder.path("a-b.yaml") + " --out " + out);
  CHECK(said.code == 2);
  CHECK_THAT(said.err, Contains("would have the same name, a-b-c"));
}

TEST_CASE("scenes of one name in two folders are told apart, and one given twice runs once", "[command]") {
  const TemporaryFolder folder;
  for (const char* of : {"first", "second"}) std::filesystem::create_directory(folder.path(of));
  const std::string first = folder.write("first/cube.yaml", kCube), second = folder.write("second/cube.yaml", kCube);
  const Said said =
      say("compare " + first + " " + second + " " + first + " --strategies lattice --out " + folder.path("out"));
  CHECK(said.code == 0);
  CHECK_THAT(said.out, Contains("first/cube") && Contains("second/cube") && Contains("2 bodies"));
  for (const char* of : {"first", "second"})
    CHECK(std::filesystem::exists(folder.path("out") + "/" + of + "~2fcube-lattice-curve.csv"));
}

TEST_CASE("a standard error that is closed or full does not end the command", "[command]") {
  const TemporaryFolder folder;
  folder.write("cube.yaml", kCube);
  for (const std::string where : {"2>&-", "2>/dev/full"}) {
    INFO(where);
    CHECK(shell(folder, "$elastin run cube.yaml --out o " + where) == 0);
    CHECK(shell(folder, "$elastin run nothing.yaml " + where) == 2);
    CHECK(shell(folder, "$elastin no_command " + where) == 2);
    CHECK(text_of_file(folder.path("o/runs.jsonl")).starts_with("{\"key\":"));
  }
  CHECK(shell(folder, "$elastin run cube.yaml >&-") == 2);
}

TEST_CASE("each file of a folder of curves is an answer of its own", "[command][identify]") {
  const TemporaryFolder folder;
  const std::string curve = "nominal strain,nominal stress [kPa]\n0.01,0.1\n0.02,0.2\n0.03,0.3\n";
  std::filesystem::create_directory(folder.path("curves"));
  folder.write("curves/first.csv", curve);
  folder.write("curves/second.csv", "nominal strain,nominal stress [kPa]\n0.01,0.2\n0.02,0.4\n0.03,0.6\n");
  folder.write("curves/torn.csv", "nominal strain,nominal stress\n0.01,0.2\n");
  const std::string scene =
      folder.write("scene.yaml",
                   "material: {curve: {points: [[0, 0 Pa], [0.05, 1 kPa]]}, poissons_ratio: 0.3}\n"
                   "identify: {tests: [{kind: uniaxial, file: curves/first.csv}]}\n");
  const Said said = say("identify " + scene + " --each " + folder.path("curves") + " --out " + folder.path("out"));
  CHECK(said.code == 1);  // of the torn one
  const std::string numbers = text_of_file(folder.path("out/numbers.csv"));
  CHECK_THAT(numbers, Contains("curve,stress_1 [Pa],stress_1 [Pa] from,stress_1 [Pa] to"));
  CHECK_THAT(numbers, Contains("\nfirst,500"));
  CHECK_THAT(numbers, Contains("\nsecond,1000"));
  CHECK_THAT(numbers, Contains("\ntorn,,,") && Contains("has no unit"));
  CHECK_THAT(say("identify " + scene + " --each " + folder.path("out/none")).err, Contains("out/none"));
}

TEST_CASE("of a folder, scenes for other commands are left out", "[command]") {
  const TemporaryFolder folder;
  folder.write("curve.csv", "nominal strain,nominal stress [kPa]\n0.01,0.1\n0.02,0.2\n0.03,0.3\n");
  const std::string fit =
                        "material: {curve: {points: [[0, 0 Pa], [0.05, 1 kPa]]}, poissons_ratio: 0.3}\n"
                        "identify: {tests: [{kind: uniaxial, file: curve.csv}]}\n",
                    place = folder.path("");
  folder.write("fit.yaml", fit);
  CHECK_THAT(say("check " + place).err, Contains("this folder has no scene but those for `elastin identify`"));
  folder.write("run.yaml",
               "body: {lattice: {kind: cubic, molecules: [2, 2, 2], spacing: 1 mm}}\n"
               "material: {youngs_modulus: 1 kPa}\nstiffness: standard\n"
               "experiment: {kind: tension, displacement: 1 um}\n");
  const Said checked = say("check " + place), fitted = say("identify " + place);
  CHECK(checked.code == 0);
  CHECK_THAT(checked.err, Contains("1 scene for `elastin identify` is left out"));
  CHECK(fitted.code == 0);
  CHECK_THAT(fitted.err, Contains("1 scene without `identify` is left out"));
  CHECK(say("verify " + place + " --quiet").err.empty());
  folder.write("run.yaml", "body: {lattice: [\n");  // is named, not left out
  CHECK_THAT(say("check " + place).err, Contains("run.yaml:"));
}
