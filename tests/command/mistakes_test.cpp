// Mistakes on the command line: each is answered from what that command takes, in one sentence of the program's own.

#include <sstream>
#include <vector>

#include "command/said.h"

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::vector<std::string> kCommands{"run",  "compare", "merge", "verify", "check", "identify",
                                         "list", "plot",    "lab",   "export", "new"};

struct HelpOption {
  std::string name, value;  ///< value: the word that stands for it; empty for a flag
};

/// The options that the help of a command lists.
std::vector<HelpOption> options_of(const std::string& command) {
  std::istringstream help(say(command + " --help").out);
  std::vector<HelpOption> options;
  for (std::string line; std::getline(help, line);) {
    if (!line.starts_with("  --")) continue;
    std::istringstream words(line.substr(0, line.find("  ", 2)));
    HelpOption option;
    words >> option.name >> option.value;
    options.push_back(option);
  }
  return options;
}

void check_mistake(const std::string& arguments, const std::string& message) {
  INFO(arguments);
  const Said said = say(arguments);
  CHECK(said.code == 2);
  CHECK(said.out.empty());
  CHECK_THAT(said.err, StartsWith("elastin: " + message));
  CHECK(said.err.find('\n') == said.err.size() - 1);  // one line
}

}  // namespace

TEST_CASE("a mistake on the command line is answered from that command's options alone", "[command]") {
  check_mistake("",
                "name a command: run, compare, merge, verify, check, identify, list, plot, lab, export, new; "
                "elastin --help explains them\n");
  check_mistake("rum a.yaml", "unknown command 'rum'; did you mean 'run'? (allowed: run, compare, merge, verify, ");
  check_mistake("--verison", "unknown option '--verison'; did you mean '--version'? (allowed: --help, --version); ");
  for (const auto& [arguments, message] : std::vector<std::pair<std::string, std::string>>{
           {"run", "SCENE is missing; write elastin run SCENE... [OPTIONS]\n"},
           {"compare --summary", "SCENE is missing; write elastin compare SCENE... [OPTIONS]\n"},
           {"merge", "FOLDER is missing; write elastin merge FOLDER... [OPTIONS]\n"},
           {"plot --x a", "FILE is missing; write elastin plot FILE... [OPTIONS]\n"},
           {"list strategies steppers", "'steppers' is one argument too many; write elastin list [WORD] [OPTIONS]\n"},
           {"list stepers",
            "list: no strategy, stepper, solver, load, experiment, key or measure has 'stepers' in it; did you "
            "mean 'steppers'? elastin list prints all\n"},
           {"list newmrk",
            "list: no strategy, stepper, solver, load, experiment, key or measure has 'newmrk' in it; did you "
            "mean 'newmark'? "},
           {"bar.yaml", "name a command before the scene: elastin run bar.yaml, or one of run, compare, "},
           {"list qqq", "list: no strategy, stepper, solver, load, experiment, key or measure has 'qqq' in it; "},
           {"'my bar.yaml'", "name a command before the scene: elastin run 'my bar.yaml', or one of run, compare, "},
           {"plot a.yaml", "a.yaml: plot draws CSV files, and this is a scene: elastin run a.yaml --out out writes "},
           {"new strip organ", "'organ' is one argument too many; write elastin new [SPECIMEN] [OPTIONS]\n"},
           {"lab a.yaml", "--out FILE is missing; write elastin lab SCENE --out FILE [OPTIONS]\n"},
           {"lab a.yaml b.yaml --out o", "'b.yaml' is one argument too many; write elastin lab SCENE "},
           {"export a.yaml --out o", "--to FORMAT is missing; write elastin export SCENE --to FORMAT --out PATH "},
           {"export a.yaml --to vtk --out o", "format 'vtk' is not known here; did you mean 'vtu'?"},
           {"compare a.yaml --dry", "unknown option '--dry'; "},
           {"check a.yaml --out o",
            "unknown option '--out'; did you mean '--set'? (allowed: --set, --threads, --quiet, --help)\n"},
           {"run a.yaml -q", "unknown option '-q'; "},
           {"run a.yaml --threds 2", "unknown option '--threds'; did you mean '--threads'? (allowed: --set, "},
           {"run a.yaml --threads -1", "--threads: '-1' is not a whole number from 0 to 4096\n"},
           {"run a.yaml --threads=1.5", "--threads: '1.5' is not a whole number from 0 to 4096\n"},
           {"compare a.yaml --repeats 0", "--repeats: '0' is not a whole number from 1 to 1000\n"},
           {"compare a.yaml --against calculi", "--against: 'calculi' is not known; did you mean 'calculix'?"},
           {"run a.yaml --reference compute", "--reference: 'compute' is not known; did you mean 'computed'?"},
           {"plot material a.yaml --stretch 1", "--stretch: '1' is not a number from 1.001 to 100\n"},
           {"new strip --poissons-ratio half", "--poissons-ratio: 'half' is not a number\n"},
           {"new strip", "new strip: give --size, such as '40 x 10 x 4 mm'\n"},
           {"new strip --mesh a.msh", "new strip: --mesh is for other specimens; give --size\n"},
           {"new organ --image a.nrrd", "new organ: --image is for other specimens; give --mesh\n"},
           {"new scan --size 1", "new scan: --size is for other specimens; give --image\n"},
           {"run a.yaml --out o --out p", "--out is given twice; give it once\n"},
           {"compare a.yaml --shard 3", "--shard: "},
           {"run -1", "-1: no such file"},               // a negative number is no option
           {"run -- --odd.yaml", "--odd.yaml: no such"}  // nor is anything behind --
       })
    check_mistake(arguments, message);
}

TEST_CASE("every option of every command states what it needs, and knows no option of another command",
          "[command][slow]") {
  std::vector<std::vector<HelpOption>> options;
  for (const std::string& command : kCommands) options.push_back(options_of(command));
  for (std::size_t i = 0; i < kCommands.size(); ++i) {
    const std::string& command = kCommands[i];
    REQUIRE(!options[i].empty());
    const auto has = [&](const std::string& name) {
      return std::any_of(options[i].begin(), options[i].end(), [&](const auto& own) { return own.name == name; });
    };
    for (const auto& [name, value] : options[i]) {
      if (value.empty()) {
        check_mistake(command + " " + name + "=yes", name + " takes no value; write " + name + "\n");
        continue;
      }
      check_mistake(command + " a " + name, name + " needs a value; write " + name + " " + value + "\n");
      check_mistake(command + " a " + name + " --help-me", name + " needs a value; write " + name + " " + value);
      // As of a variable of the shell that is not set.
      for (const char* empty : {" ''", "= b", "=' '"})
        check_mistake(command + " a " + name + empty, name + " needs a value, not an empty one; write " + name);
    }
    const std::string offered = say(command + " --").err + say(command + " --zzzzzz").err;
    for (const auto& others : options)
      for (const auto& [name, value] : others)
        if (!has(name)) {
          INFO(command << ' ' << name);
          CHECK_THAT(offered, !Contains(name + ",") && !Contains(name + "\n"));
        }
  }
}

TEST_CASE("a section of the list is named by its title", "[command]") {
  for (const auto& [word, row] : {std::pair{"steppers", "velocity_verlet"},
                                  {"Loads", "stokes_drag"},
                                  {"strategies", "van_gelder"},
                                  {"solvers", "multigrid"},
                                  {"experiments", "torsion"},
                                  {"measures", "reaction_balance"}}) {
    INFO(word);
    const Said said = say(std::string("list ") + word);
    CHECK(said.code == 0);
    CHECK_THAT(said.out, Contains(row));
  }
}

TEST_CASE("a key is set once", "[command]") {
  for (const std::string command :
       {"run", "compare", "verify", "check", "identify", "lab", "export", "plot material"}) {
    check_mistake(command + " a.yaml --set a.b=1 --set c=3 --set 'a.b=2 mm'",
                  "--set: 'a.b' is set twice, by a.b=1 and by a.b=2 mm; leave one of them out\n");
    check_mistake(command + " a.yaml --set a.b=1 --set a={}", "--set: a={} would replace a.b=1: let it come first\n");
    check_mistake(command + " a.yaml --set time.integrator=xpbd --set time.stepper=newmark",
                  "--set: 'time.stepper' is set twice, by time.integrator=xpbd and by time.stepper=newmark");
  }
  const std::string scene = ELASTIN_SOURCE_DIR "/scenes/tension/cube-27-face.yaml";
  CHECK(say("check " + scene + " --set 'material={youngs_modulus: 1 kPa}' --set material.poissons_ratio=0.25").code ==
        0);
  check_mistake("compare " + scene + " --engines jolt --set engines.names=[mujoco]",
                "'engines.names' is set twice, by engines.names=[mujoco] and by engines.names=[jolt]");
}

TEST_CASE("an option that would change nothing is refused", "[command]") {
  const std::string scene = ELASTIN_SOURCE_DIR "/scenes/tension/cube-27-face.yaml";
  for (const std::string option : {"--vary 'material.youngs_modulus=[1 kPa]'", "--strategies lattice", "--repeats 2",
                                   "--gradient material.density", "--reference none", "--live", "--resume o",
                                   "--peers p", "--baseline b", "--summary", "--verbose", "--restart r"})
    check_mistake("compare " + scene + " --steppers newmark " + option,
                  option.substr(0, option.find(' ')) + ": is of a comparison of strategies");
  check_mistake("compare " + scene + " --vary 'material.poissons_ratio=[0.3, 0.4, 0.9]'",
                "--vary: material.poissons_ratio: '0.9' is out of range: must be at least -0.99 and at most 0.5");
  check_mistake("compare " + scene + " --steppers newmark --engines jolt",
                "--engines, --engine or --against: is of a comparison of strategies");
  check_mistake("compare " + scene + " --engine-iterations 5",
                "'engines.iterations=5' is for engines, and none is to run: name them by --engines or --engine");
  check_mistake("plot material " + scene + " --x strain", "--x and --y name columns of CSV files");
  check_mistake("plot runs.csv --stretch 2", "--stretch and --set are for the curves of a material");
  check_mistake("plot runs.csv --set a=2", "--stretch and --set are for the curves of a material");
}
