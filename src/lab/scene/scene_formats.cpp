#include "lab/scene/scene_formats.h"

namespace elastin::lab {

elastin::Table<SceneFormat>& scene_formats() {
  static elastin::Table<SceneFormat> formats("scene format");
  return formats;
}

const SceneFormat* scene_format_of(const std::string& path) {
  for (const auto& format : scene_formats())
    if (path.ends_with(format->ending)) return format.get();
  return nullptr;
}

}  // namespace elastin::lab
