#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>

#include "command/row.h"
#include "core/base/named.h"
#include "core/base/shell_word.h"
#include "elastin/core/base/error.h"
#include "elastin/core/shapes/shapes.h"
#include "lab/report/files.h"
#include "lab/report/screen.h"
#include "lab/scene/scene.h"
#include "lab/study/study.h"

namespace elastin::command {
namespace {

/// The answer to a question on the terminal; `otherwise` where it is empty.
std::string ask(const std::string& question, const std::string& otherwise) {
  lab::say(fmt::format("{}{}: ", question, otherwise.empty() ? "" : " [" + otherwise + "]"));
  std::string line;
  std::getline(std::cin, line);
  return line.empty() ? otherwise : line;
}

struct NewCommand {
  lab::NewScene scene;
  std::string modulus, image, out;
  bool quiet = false;

  void add_to(Options& options) {
    const std::string names = joined(
        lab::new_specimens(), [](const auto& row) { return fmt::format("{}: {}", row.name, row.summary); }, "; ");
    options.argument("SPECIMEN", into(scene.specimen), names, false, false);
    options.add("--size", "LENGTHS", into(scene.size), "Lengths of a block along x, y, z: '40 x 10 x 4 mm'");
    options.add("--mesh", "FILE", into(scene.mesh), "File of the mesh (dogbone) or of the closed surface (organ)");
    options.add("--image", "FILE", into(image), "File of the voxels (scan)");
    options.add("--voxel-size", "LENGTHS", into(scene.voxel_size),
                "Lengths of a voxel along the image's axes, where the file does not state them: '1 x 1 x 2 mm'");
    options.add("--length-unit", "UNIT", into(scene.length_unit),
                "Unit of the file's coordinates; default: what an image states, else mm");
    options.add("--modulus", "E", into(modulus), "Young's modulus; default: " + scene.modulus);
    options.add("--poissons-ratio", "NUMBER", into(scene.poissons_ratio),
                fmt::format("Poisson's ratio; default: {}", scene.poissons_ratio));
    options.add("--out", "FILE", into(out), "File to write, - for the terminal; default: SPECIMEN.yaml");
    options.flag("--quiet", quiet, "Print nothing but errors");
  }

  /// Writes a scene to begin with, reads it as any scene is read, and states how to go on.
  int run(const Call& call) {
    complete();
    if (out == "-") {
      fmt::print("{}", lab::new_scene_text(scene, ""));
      return 0;
    }
    const std::string path = out.empty() ? scene.specimen + ".yaml" : out;
    if (std::filesystem::exists(path)) throw InputError(path + ": already exists; choose another name with --out");
    lab::write_whole(path, lab::new_scene_text(scene, std::filesystem::path(path).parent_path().string()));
    try {
      const auto written = lab::load_scene(path, call.catalog);
      const Body& body = written->specimen.body;
      if (!quiet)
        fmt::print(
            "  {}: {} molecules, {} cells\n  elastin compare {} --out out    runs it and writes out/report.html\n",
            path, body.size(), count_cells(body), shell_word(path));
    } catch (...) {
      std::filesystem::remove(path);
      throw;
    }
    return 0;
  }

  /// Throws if an option is of other specimens than this one.
  void check_options(const lab::NewSpecimen& row) {
    const std::string file = row.file, own = file.empty() ? "size" : file == "image" ? file : "mesh";
    for (const auto& [name, value] : {std::pair{"size", &scene.size}, {"mesh", &scene.mesh}, {"image", &image}})
      if (!value->empty() && name != own && !(file == "image" && value == &scene.mesh))
        throw InputError(fmt::format("new {}: --{} is for other specimens; give --{}", row.name, name, own));
    if (file.empty() && !scene.length_unit.empty())
      throw InputError(fmt::format("new {}: --length-unit is of a file; a size states its unit itself", row.name));
    if (file != "image" && !scene.voxel_size.empty())
      throw InputError(fmt::format("new {}: --voxel-size is of an image", row.name));
    if (!image.empty()) scene.mesh = image;
  }

  /// Asks for what the options leave open, on a terminal only.
  void complete() {
    const bool can_ask = isatty(STDIN_FILENO) && isatty(STDERR_FILENO);
    if (scene.specimen.empty()) {
      if (!can_ask) throw InputError("new: name a specimen: " + joined(lab::new_specimens(), &lab::NewSpecimen::name));
      for (const lab::NewSpecimen& row : lab::new_specimens())
        lab::say(fmt::format("  {:12} {}\n", row.name, row.summary));
      scene.specimen = ask("specimen", "strip");
    }
    for (const lab::NewSpecimen& row : lab::new_specimens()) {
      if (scene.specimen == row.name) check_options(row);
      std::string& missing = row.from_file() ? scene.mesh : scene.size;
      if (scene.specimen != row.name || !missing.empty()) continue;
      if (!can_ask)
        throw InputError(fmt::format("new {}: give {}", row.name,
                                     !row.from_file()                   ? "--size, such as '40 x 10 x 4 mm'"
                                     : row.file == std::string("image") ? "--image FILE"
                                                                        : "--mesh FILE"));
      missing = ask(row.from_file() ? fmt::format("file of the {}", row.file) : "size along x, y, z",
                    row.from_file() ? "" : "40 x 10 x 4 mm");
      if (modulus.empty()) modulus = ask("Young's modulus", scene.modulus);
    }
    if (!modulus.empty()) scene.modulus = modulus;
  }
};

}  // namespace

const CommandRow kNew{
    "new", "Write a commented scene for a specimen, from options or three questions",
    R"(new strip --size '40 x 10 x 4 mm' --modulus '20 kPa'  a commented scene to begin with; new alone asks questions
)",
    &declare<NewCommand>};

}  // namespace elastin::command
