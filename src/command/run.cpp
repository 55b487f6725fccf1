#include "command/row.h"
#include "lab/study/study.h"

namespace elastin::command {
namespace {

struct RunCommand {
  SceneOptions scene;
  lab::Request request;

  void add_to(Options& options) {
    scene.add_to(options);
    add_run_options(options, request, "Print every point of the response curve, with all its measures");
    add_baseline_option(options, request);
  }

  int run(const Call& call) {
    scene.fill(request, call);
    stop_on_interrupt();
    return lab::run_scenes(request, call.catalog) ? 0 : 1;
  }
};

}  // namespace

const CommandRow kRun{
    "run", "Run a scene with its own stiffness strategy; print every measure",
    R"(run scenes/tension/dogbone.yaml --out out             one strategy, all measures; files for ParaView in out/
run scenes/tension/cube-27-face.yaml --set stiffness=lattice --set material.youngs_modulus='10 kPa'
run scenes/tension/cube-1000.yaml --json - | jq .runs[0].measures
)",
    &declare<RunCommand>};

}  // namespace elastin::command
