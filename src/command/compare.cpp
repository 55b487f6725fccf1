#include "lab/study/study.h"

#include "command/row.h"
#include "core/base/named.h"
#include "elastin/core/base/error.h"
#include "lab/export/formats.h"
#include "lab/study/plan.h"

namespace elastin::command {
namespace {

struct CompareCommand {
  SceneOptions scene;
  lab::Request request;
  std::string resumed, shard, engines, time_step, iterations, seconds;
  bool calibrate = false;

  void add_to(Options& options) {
    scene.add_to(options);
    add_run_options(options, request,
                    "Print every run in full as it is finished, before the tables, with every point of its curve");
    options
        .add("--vary", "KEY=VALUES", into(request.vary),
             "Change a key from run to run: KEY.PATH=[VALUE, …], or {KEY: […], KEY: […]} for keys that change "
             "together. May be repeated: every combination runs")
        .repeated = true;
    options.add("--steppers", "NAMES", into(request.steppers),
                "Compare steppers on the scene's own strategy: names separated by commas, or all");
    options.add("--against", lab::kCalculix, one_of({lab::kCalculix}, into(request.against)),
                "calculix: also run CalculiX, with its error and seconds, where ccx is installed");
    options.add("--engines", "NAMES", into(engines),
                "Also run the scene's own strategy in these engines: names separated by commas, of " +
                    joined(lab::engines(), [](const auto& row) { return row->name; }) + " and steppers");
    options
        .add("--engine", "COMMAND", into(request.engine_commands),
             "The same in an engine of your own: a command that reads a request and prints an answer, each one line of "
             "JSON. May be repeated")
        .repeated = true;
    options.add("--engine-dt", "TIME", into(time_step), "Time step of the engines; without it 1/60 s");
    options.add("--engine-iterations", "NUMBER", into(iterations),
                "Iterations of a step of the engines; without it each one's own number");
    options.add("--engine-seconds", "TIME", into(seconds),
                "When an engine that has not answered is ended; without it after 120 s");
    options.flag("--engine-calibrate", calibrate,
                 "Multiply an engine's constants by one factor until it shows the modulus that they have in Elastin");
    options.add("--repeats", "NUMBER", into(request.repeats, 1, 1000),
                "Run everything this often, 1 to 1000 times, in turn; the fastest run counts");
    options.add("--resume", "FOLDER", into(resumed), "Continue in a folder of --out: finished runs are not repeated");
    options.add("--shard", "N/M", into(shard),
                "Run share N of M of the runs, in a folder of its own; `merge` puts the shares together");
    add_baseline_option(options, request);
    add_table_options(options, request);
  }

  int run(const Call& call) {
    scene.fill(request, call);
    request.compare = true;
    const std::string names = engines.empty() ? "" : "[" + engines + "]", flag = calibrate ? "true" : "";
    for (const auto& [key, value] : {std::pair{"names", &names},
                                     {"dt", &time_step},
                                     {"iterations", &iterations},
                                     {"seconds", &seconds},
                                     {"calibrate", &flag}})
      if (!value->empty()) keys_into(request.overrides)(std::string("engines.") + key + "=" + *value);
    request.resume = continue_in(resumed, request.out);
    if (!shard.empty()) read_shard();
    const bool of_steppers = lab::compares_steppers(request);
    stop_on_interrupt();
    const bool good =
        of_steppers ? lab::compare_steppers(request, call.catalog) : lab::run_scenes(request, call.catalog);
    return good ? 0 : 1;
  }

  void read_shard() {
    request.shard = lab::read_shard(shard);
    if (request.out.empty())
      throw InputError(
          "--shard needs a folder of its own for its runs, which `merge` reads: --out FOLDER or --resume FOLDER");
    if (!request.peers.empty() || !request.baseline.empty())
      throw InputError("--shard prints no table for them: give --peers and --baseline to `merge`");
  }
};

}  // namespace

const CommandRow kCompare{
    "compare", "Run a scene with many strategies; print measured modulus, error and cost",
    R"(compare scenes/tension/cube-1000.yaml                 every stiffness strategy of the scene in one table
compare scenes/tension/*.yaml --strategies all        every strategy of the catalog, on every scene
compare scenes/zoo/*.yaml --summary                   ranks the strategies over all bodies
compare scenes/material/cantilever.yaml --out out     also a page: error against time, the body in 3D, tables
compare scenes/tension/cube-1000.yaml --vary 'solver.linear_solver=[pcg, direct]' --repeats 5
compare scenes/study/cantilever.yaml --shard 3/16 --resume study/3    the third of 16 jobs that share the runs
compare scenes/steppers/cube-1000.yaml --out out      modulus, error and milliseconds of each stepper
compare scenes/study/clamped-block.yaml --against calculix    also a run by CalculiX
compare scenes/engines/bar.yaml --engines mujoco,jolt --engine-iterations 20    its constants in engines
)",
    &declare<CompareCommand>};

}  // namespace elastin::command
