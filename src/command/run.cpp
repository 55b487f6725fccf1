#include "command/row.h"
#include "lab/study/study.h"

namespace elastin::command {
namespace {

struct RunCommand {
  SceneOptions scene;
  lab::Request request;
  std::string image_spacing;

  void add_to(Options& options) {
    scene.add_to(options);
    add_run_options(options, request, "Print every point of the response curve, with all its measures");
    add_baseline_option(options, request);
    options.add(
        "--image", "FILE", into(request.image),
        "Write the last displacement as an image (.nii, .nii.gz, .nrrd) on the grid of the body's own image, and "
        "strain and label next to it");
    options.add("--image-spacing", "LENGTH", into(image_spacing), "The same on a grid along the axes: '1 mm'");
  }

  int run(const Call& call) {
    scene.fill(request, call);
    if (!image_spacing.empty()) {
      if (request.image.empty()) throw InputError("--image-spacing: needs --image");
      request.image_spacing = parse_quantity(image_spacing, dimension::length).value;
      if (!(request.image_spacing > 0)) throw InputError("--image-spacing: must be above 0, '1 mm' for example");
    }
    if (!request.image.empty() &&
        (scene.scenes.size() > 1 || request.strategies.find(',') != std::string::npos || request.strategies == "all"))
      throw InputError("--image: one file takes one scene with one strategy");
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
