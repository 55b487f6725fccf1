#pragma once
#include <string>
#include <utility>
#include <vector>

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

/// A scene's own text with other values of keys, (key, YAML) as of --set, in the lines that there are as far as these
/// can take them; otherwise all of it is written again, without its comments. A `material` takes the place of all that
/// a scene which this one extends has there. Throws InputError where a key names an item of no list of this text.
std::string with_values(const std::string& text, const std::string& folder,
                        const std::vector<std::pair<std::string, std::string>>& values);

/// A path as YAML writes it: in quotes where it needs them.
std::string path_text(const std::string& path);

}  // namespace elastin::config
