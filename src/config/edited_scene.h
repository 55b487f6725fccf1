#pragma once
#include <string>
#include <utility>
#include <vector>

#include "elastin/config/scene_source.h"

namespace elastin::config {

/// A scene's text for another folder: paths of the files that it names (data, meshes, `extends`) are relative to that.
std::string moved_scene(const std::string& text, const std::string& from_folder, const std::string& to_folder);

/// A scene's text with a key of the first level and all below it replaced by these lines; "" where it has none that
/// begins a line.
std::string with_section(const std::string& text, const std::string& key, const std::string& lines);

/// A scene's text with another value of a key, named as by --set: "contact.friction", "identify.tests.0.file". A key
/// that its map does not have is added; where there is no such map or item the text stays.
/// @param value as YAML writes it
std::string with_value(const std::string& text, const std::string& path, const std::string& value);

/// A scene's own text with other values of keys, (key, YAML) as of --set. The lines and remarks of the text stay where
/// they can take the values; otherwise all of it is written again, without remarks. A `material` replaces all that a
/// scene which this one extends has there. Throws InputError where a key names no item of a list of this text.
std::string with_values(const SceneSource& source, const std::vector<std::pair<std::string, std::string>>& values);

/// A path as YAML writes it: in quotes where it needs them.
std::string path_text(const std::string& path);

}  // namespace elastin::config
