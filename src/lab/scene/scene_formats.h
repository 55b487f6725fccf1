#pragma once
#include <memory>
#include <string>

#include "elastin/core/base/table.h"
#include "lab/scene/scene.h"

namespace elastin::lab {

/// Files of another program, each of which is a whole scene: its name ("febio") and, as summary, what one of them is
/// ("model of FEBio").
struct SceneFormat : Descriptor {
  std::string ending;  ///< of its files, ".feb"
  /// Specimen, stiffness, experiment, warnings and notes of a file; a title if it has one. Throws InputError.
  std::unique_ptr<Scene> (*read)(const SceneSource& source) = nullptr;
};

/// The formats that load_scene reads in addition to Elastin's own. A program adds its rows before it reads scenes: see
/// febio::add_scene_format.
elastin::Table<SceneFormat>& scene_formats();

/// The row of a file by its ending; null: the file is a scene in YAML.
const SceneFormat* scene_format_of(const std::string& path);

}  // namespace elastin::lab
