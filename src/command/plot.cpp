#include <fmt/format.h>

#include <filesystem>

#include "command/row.h"
#include "core/base/shell_word.h"
#include "elastin/core/base/error.h"
#include "lab/run/run.h"
#include "lab/scene/scene.h"
#include "lab/study/study.h"

namespace elastin::command {
namespace {

using lab::Plot;
using NamedPlots = std::vector<std::pair<std::string, Plot>>;

struct PlotCommand {
  std::vector<std::string> words, overrides;
  std::string x, y;
  double stretch = 0;  // 0: not given

  void add_to(Options& options) {
    options.argument("FILE", into(words),
                     "CSV files: curves, time histories, runs, timings of benchmarks; or the word material, and scenes",
                     true, true);
    options.add("--x", "COLUMN", into(x),
                "Column of the horizontal axis, for example strain; default: the main one of the file");
    options.add("--y", "COLUMN", into(y),
                "Column of the vertical axis, for example stress; default: the main one of the file");
    options.add("--stretch", "NUMBER", into(stretch, 1.001, 100.),
                "plot material: the largest stretch, 1.001 to 100; the least is its inverse; default: 1.5");
    options
        .add("--set", "KEY=VALUE", keys_into(overrides),
             "plot material: set a key of the scenes: KEY.PATH=VALUE. May be repeated")
        .repeated = true;
  }

  /// One document, with all curves on the same axes.
  int run(const Call& call) {
    const bool material = words.front() == "material";
    if (material && !(x + y).empty()) throw InputError("--x and --y name columns of CSV files; plot material has none");
    if (!material && (stretch > 0 || !overrides.empty()))
      throw InputError("--stretch and --set are for the curves of a material: elastin plot material SCENE");
    const NamedPlots plots = material ? of_materials(call.catalog) : of_columns();
    fmt::print("{}", lab::svg_text(lab::overlaid(plots), 760, true));
    return 0;
  }

  NamedPlots of_columns() const {
    NamedPlots plots;
    std::string along = x, up = y;
    for (const std::string& path : words) {
      if (path.ends_with(".yaml") || path.ends_with(".yml") || std::filesystem::is_directory(path))
        throw InputError(path + ": plot draws CSV files, and this is " +
                         (std::filesystem::is_directory(path)
                              ? "a folder: name files in it"
                              : "a scene: elastin run " + shell_word(path) +
                                    " --out out writes out/*-curve.csv, and elastin plot "
                                    "material " +
                                    shell_word(path) + " draws the law of its material"));
      plots.emplace_back(path, lab::csv_plot(path, along, up));
      along = plots.front().second.x.title, up = plots.front().second.y.title;  // all others on the same axes
    }
    return plots;
  }

  NamedPlots of_materials(const Catalog& catalog) const {
    if (words.size() < 2) throw InputError("plot material: name a scene");
    NamedPlots plots;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto scene = lab::load_scene(words[i], catalog, overrides);
      std::vector<Material> materials = scene->specimen.materials;
      if (materials.empty()) materials.push_back(scene->specimen.material);
      const std::size_t before = plots.size();
      for (const Material& material : materials) {
        if (!material.law) continue;
        const std::string title =
            fmt::format("{}: {}, E = {} and nu = {:.4g} at rest", scene->name, material.law->law,
                        lab::readable(material.youngs_modulus, dimension::pressure), material.poissons_ratio);
        const auto law = catalog.material_laws.find(material.law->law);
        plots.emplace_back(title, lab::material_plot(title, *law, material, stretch > 0 ? stretch : 1.5));
      }
      if (plots.size() == before)
        throw InputError(words[i] + ": no material has a `law`; its curve is its E, or what it states itself");
    }
    return plots;
  }
};

}  // namespace

const CommandRow kPlot{
    "plot", "Draw two columns of CSV files, or the curves of scenes' materials, as one SVG",
    R"(plot out/cube-1000-lattice-curve.csv > curve.svg      stress–strain curve, or any two columns of a CSV file
plot out/*-curve.csv > curves.svg                     the curves of several runs on the same axes
)",
    &declare<PlotCommand>};

}  // namespace elastin::command
