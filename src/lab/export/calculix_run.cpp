#include "lab/export/calculix_run.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>

#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/core/shapes/orders.h"
#include "lab/export/calculix.h"

namespace elastin::lab {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// A folder that nobody else can read or foresee, and that goes with its owner.
class JobFolder {
 public:
  JobFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "elastin-calculix-XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw InputError("CalculiX: cannot make a folder " + pattern + " for its files");
    path_ = pattern;
  }
  ~JobFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  JobFolder(const JobFolder&) = delete;
  JobFolder& operator=(const JobFolder&) = delete;
  std::string file(const char* name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

Body second_order(const Body& body) {
  if (has_blocks(body, 3)) return body;
  return with_cells(body, cell_kind(body.cubes.empty() ? "tetrahedron10" : "hexahedron20"));
}

/// What CalculiX has printed at the end of the last step.
struct Printed {
  Positions displacements, forces;  ///< [m], [N]; forces on the held molecules, loads included
  bool complete = false;
};

Printed read_printed(const std::string& path, int molecules) {
  Printed result{Positions::Zero(3, molecules), Positions::Zero(3, molecules)};
  std::ifstream file(path);
  Positions* target = nullptr;
  int read = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.find("displacements") != std::string::npos) target = &result.displacements, read = 0;
    if (line.find("forces") != std::string::npos) target = &result.forces;
    std::istringstream numbers(line);
    int number = 0;
    Vector3 values;
    if (!(target && numbers >> number >> values[0] >> values[1] >> values[2])) continue;
    if (number < 1 || number > molecules || !values.allFinite()) return result;
    target->col(number - 1) = values;
    if (target == &result.displacements) ++read;
  }
  result.complete = read == molecules;
  return result;
}

/// The last line of what it said that names an error, or the last of all.
std::string complaint(const std::string& path) {
  std::ifstream file(path);
  std::string last, error;
  for (std::string line; std::getline(file, line);) {
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    last = line.substr(line.find_first_not_of(" \t"));
    if (last.find("ERROR") != std::string::npos) error = last;
  }
  return error.empty() ? last : error;
}

/// Reads the experiment's measures off a state that another program has found.
void measure(const Scene& scene, const StaticProblem& problem, const Printed& printed, Run& run) {
  const Specimen& specimen = scene.specimen;
  Model model(specimen.body);
  model.add(scene.stiffness.strategy.make(specimen.body, specimen.material, scene.stiffness.values));
  const auto rig = scene.experiment->at_rest()->static_rig(model);
  State state = state_at_rest(specimen.body);
  const Start start{state.positions, Positions::Zero(3, static_cast<Eigen::Index>(model.supports.size()))};
  rig->set_load(problem.steps.back());
  state.positions += printed.displacements;
  StaticResult solved;
  solved.linear = scene.statics.linear;
  solved.reactions = start.reactions;
  const Positions reactions = printed.forces - problem.forces.back();
  for (std::size_t i = 0; i < model.supports.size(); ++i) {
    const Support& support = model.supports[i];
    solved.reactions.col(static_cast<Eigen::Index>(i)) =
        (Matrix3::Identity() - support.free) * reactions.col(support.molecule);
  }
  solved.scale = solved.reactions.norm();
  run.measures = rig->measure(start, state, scene.statics, solved);
  run.curve.push_back({problem.steps.back(), run.measures, 0, 0, 0});
}

/// Runs `ccx` on the folder's job.inp; what it prints goes to job.log. Ends it where `stop` says so. Returns the status
/// of waitpid.
int run_ccx(const JobFolder& folder, const std::function<bool()>& stop) {
  const std::string threads_text = std::to_string(threads()), path = folder.path();
  const char* const words[] = {"sh",
                               "-c",
                               R"(cd "$0" && OMP_NUM_THREADS=$1 exec ccx -i job > job.log 2>&1)",
                               path.c_str(),
                               threads_text.c_str(),
                               nullptr};
  pid_t process = 0;
  if (posix_spawn(&process, "/bin/sh", nullptr, nullptr, const_cast<char* const*>(words), environ) != 0)
    throw InputError("CalculiX: no process could be started");
  int status = 0;
  for (pid_t ended = 0; ended != process;) {
    ended = waitpid(process, &status, WNOHANG);
    if (ended < 0 && errno != EINTR) throw InputError("CalculiX: its process was lost");
    if (ended == process) break;
    if (stop && stop()) kill(process, SIGTERM);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return status;
}

void solve(const Scene& scene, const std::function<bool()>& stop, Run& run) {
  const auto begin = Clock::now();
  if (!scene.specimen.loads.empty())
    throw InputError("loads in addition to the experiment's are not measured separately");
  StaticProblem problem = problem_of(scene);
  const std::string deck = calculix_deck(problem, {true, false});
  const JobFolder folder;
  std::ofstream(folder.file("job.inp")) << deck;
  run.warnings = problem.notes;
  run.build_seconds = seconds_since(begin);
  const auto start = Clock::now();
  const int status = run_ccx(folder, stop);
  run.solve_seconds = seconds_since(start);
  const Printed printed = read_printed(folder.file("job.dat"), scene.specimen.body.size());
  if (status != 0 || !printed.complete) {
    const bool stopped = stop && stop();
    run.outcome = stopped ? Outcome::interrupted : Outcome::diverged;
    run.cause = "CalculiX: " + (stopped               ? "interrupted"
                                : WIFSIGNALED(status) ? std::string("ended by signal ") + strsignal(WTERMSIG(status))
                                                      : complaint(folder.file("job.log")));
    return;
  }
  measure(scene, problem, printed, run);
}

}  // namespace

void check_calculix() {
  if (std::system("command -v ccx > /dev/null 2>&1") != 0)
    throw InputError(
        "--against calculix: there is no `ccx` on the PATH; apt-get install calculix-ccx, or leave it out");
}

OtherRun run_calculix(const Scene& scene, const Catalog& catalog, const std::vector<std::string>& overrides,
                      const std::function<bool()>& stop) {
  OtherRun result;
  Run& run = result.run;
  try {
    result.scene = load_scene_on(scene.source, catalog, overrides, [](Body& body, const Material&) {
      if (has_blocks(body, 3) || !body.tetrahedra.empty() || !body.cubes.empty()) body = second_order(body);
    });
    Scene& own = *result.scene;
    own.specimen.references = scene.specimen.references;
    const Material& material = own.specimen.material;
    const std::string& stated = scene.stiffness.strategy.name;
    own.stiffness = choose_strategy(catalog, material.law                      ? material.law->law
                                             : stated == "st_venant_kirchhoff" ? stated
                                                                               : "neo_hookean");
    run.solver =
        "ccx on " +
        std::string(own.specimen.body.blocks.empty() ? "cells" : own.specimen.body.blocks.front().kind->plural);
    solve(own, stop, run);
  } catch (const InputError& error) {
    run.suited = false;
    run.cause = error.what();
  }
  run.strategy = kCalculix;
  run.warnings.emplace_back("computed by CalculiX: shown with the others, never recommended");
  return result;
}

}  // namespace elastin::lab
