#pragma once
#include <string>
#include <vector>

namespace elastin::lab {

/// A scene to begin with.
struct NewScene {
  std::string specimen;            ///< of new_specimens()
  std::string size;                ///< "40 x 10 x 4 mm": of a block, along x, y, z
  std::string mesh;                ///< file of a mesh or a surface
  std::string length_unit = "mm";  ///< of the file's coordinates
  std::string modulus = "10 kPa";  ///< E
  double poissons_ratio = 0.45;    ///< from 0 to below 0.5
};

struct NewSpecimen {
  const char *name, *summary;
  bool from_file;  ///< has a `mesh`; otherwise a `size`
};

/// What scenes can be begun with.
const std::vector<NewSpecimen>& new_specimens();

/// A whole scene with comments that say what each part is and what else it may be; its file will stand in `folder`, to
/// which the path of the mesh is relative. Cells are as small as lets all strategies run in seconds: some thousands.
/// Throws InputError: an unknown specimen, a size or a modulus that cannot be read, a mesh that cannot be loaded.
std::string new_scene_text(const NewScene& wanted, const std::string& folder);

}  // namespace elastin::lab
