#pragma once
#include <string>

namespace elastin::lab {

/// A scene's text for another folder: the files beside it that it names (data, meshes, `extends`) are named from there.
std::string moved_scene(const std::string& text, const std::string& from_folder, const std::string& to_folder);

}  // namespace elastin::lab
