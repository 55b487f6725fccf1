#pragma once
#include <string>

namespace elastin::lab {

/// A scene's text for another folder: the files beside it that it names (data, meshes, `extends`) are named from there.
std::string moved_scene(const std::string& text, const std::string& from_folder, const std::string& to_folder);

/// A scene's text with a key of the first level and all below it replaced by these lines; "" where it has none that
/// begins a line.
std::string with_section(const std::string& text, const std::string& key, const std::string& lines);

/// A scene's text with another value of a key, named as by --set: "contact.friction", "identify.tests.0.file". A key
/// that its map does not have is added; where there is no such map or item the text stays.
/// @param value as YAML writes it
std::string with_value(const std::string& text, const std::string& path, const std::string& value);

/// A path as YAML writes it: in quotes where it needs them.
std::string path_text(const std::string& path);

}  // namespace elastin::lab
