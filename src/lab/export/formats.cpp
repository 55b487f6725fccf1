#include "lab/export/formats.h"

#include <algorithm>
#include <map>

#include "lab/report/files.h"
#include "mesh/gmsh_file.h"

namespace elastin::lab {
namespace {

/// Molecules that the experiment holds, and those that it moves or loads.
std::map<std::string, std::vector<int>> groups_of(const Scene& scene) {
  std::map<std::string, std::vector<int>> groups;
  ExportedBody test;
  set_test(scene, test);
  std::vector<char> loaded(static_cast<std::size_t>(scene.specimen.body.size()), 0);
  for (std::size_t molecule = 0; molecule < loaded.size(); ++molecule)
    loaded[molecule] = !test.forces.col(static_cast<Eigen::Index>(molecule)).isZero(0);
  for (const Support& support : test.supports)
    if (support.displacement.isZero(0))
      groups["held"].push_back(support.molecule);
    else
      loaded[support.molecule] = 1;
  for (std::size_t molecule = 0; molecule < loaded.size(); ++molecule)
    if (loaded[molecule]) groups["loaded"].push_back(static_cast<int>(molecule));
  for (auto& [name, molecules] : groups) std::sort(molecules.begin(), molecules.end());
  return groups;
}

std::string gmsh_text_of(const Scene& scene, std::vector<std::string>& notes) {
  notes.emplace_back("the body alone, with the groups `held` and `loaded` of points: Gmsh has no materials or loads");
  return mesh::gmsh_text(scene.specimen.body, groups_of(scene));
}

std::string vtu_text_of(const Scene& scene, std::vector<std::string>& notes) {
  notes.emplace_back("the body at rest alone; `elastin run --out` writes its states");
  return shape_vtu_text(scene.specimen.body, scene.specimen.body.rest);
}

}  // namespace

const elastin::Table<ExportFormat>& export_formats() {
  static const auto table = [] {
    elastin::Table<ExportFormat> rows("format");
    rows.add({{"calculix", "input of CalculiX: the whole problem", "CalculiX CrunchiX User's Manual"},
              ".inp",
              calculix_text});
    rows.add({{"febio", "model of FEBio 4.0: the whole problem", "FEBio User's Manual 4.0"}, ".feb", febio_text});
    rows.add({{"gmsh", "mesh of Gmsh, MSH 2.2: the body and what is held and loaded", "Gmsh reference manual"},
              ".msh",
              gmsh_text_of});
    rows.add(
        {{"vtu", "VTK's XML of unstructured grids, for ParaView: the body", "VTK File Formats"}, ".vtu", vtu_text_of});
    add_engine_formats(rows);
    return rows;
  }();
  return table;
}

}  // namespace elastin::lab
