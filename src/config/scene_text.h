#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "elastin/config/scene_source.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/units.h"

namespace elastin::config {

/// Refuses a text that is not UTF-8, is indented by tabs or leaves a quote open. Throws InputError: file:line:column,
/// and the line as it should be.
void check_scene_text(const std::string& path, const std::string& text);

/// What is wrong with a text that YAML refuses at a location (line and column from 1) for the `reason` of its parser:
/// the line that is wrong, and its correction. Where neither is known, the parser's reason.
InputError explain_yaml(const std::string& path, const std::string& text, const SourceLocation& refused,
                        const std::string& reason);

/// The name of today of a key in the map of this path, "time.stepper": scenes may write the former one.
std::string present_name(std::string_view map, const std::string& key);

/// Of the `known` keys the one that a key means which is written as a symbol ("E"), in other words ("elongation"), with
/// other capitals, blanks and hyphens, or nearly by its former name; "" where it means none of them.
std::string meant_key(const std::string& given, const std::vector<std::string>& known);

/// The tail of a message about a word that is not among `names`, as suggestion() has it, with synonyms too:
/// "fixed" means `clamped`.
std::string suggested_word(const std::string& word, const std::vector<std::string>& names);

/// What there is in place of a key that scenes do not have: "units stand behind each number"; "" of others.
std::string instead_of_key(const std::string& given);

/// "40 x 10 x 4 mm", "8x2x1", "8 2 1" as a list, "[40 mm, 10 mm, 4 mm]"; "" of a text that is no such thing.
std::string as_list(const std::string& text);

/// "write [4, 4.5 mm, …]": what a list of `given` values is that has a decimal comma and is to have `count`; "" where
/// it has none.
std::string with_decimal_points(const std::vector<std::string>& given, std::size_t count);

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

/// A number that a scene states under a path of keys, as of --set: "material.youngs_modulus", "loads.0.pressure.value".
struct StatedNumber {
  double value = 0;  ///< SI
  Dimension unit;
  /// Another value as --set takes it.
  std::string with(double other) const;
};
/// Throws InputError, with the nearest path of a number, where nothing or no number stands there.
StatedNumber stated_number(const SceneSource& source, const std::vector<std::string>& overrides,
                           const std::string& path);

/// A path as YAML writes it: in quotes where it needs them.
std::string path_text(const std::string& path);

}  // namespace elastin::config
