#pragma once
#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>
#include <vector>

#include "config/formula.h"
#include "elastin/config/scene_source.h"
#include "elastin/core/base/error.h"

namespace elastin::config {

/// The keys and values of a scene: its own file with those that it extends, what --set changed, and formulas put into
/// numbers.
struct SceneTree {
  YAML::Node root;
  std::vector<std::string> files;  ///< the scene's own, and those that it extends
  FormulaValues values = {};       ///< of the section `values`
};

/// Reads a scene with those that it extends. `overrides` are key.path=value. Throws InputError: file:line:column.
SceneTree load_scene_tree(const SceneSource& source, const std::vector<std::string>& overrides);

/// Puts a value under a key of a tree, "key.path.to", and the maps that are missing on the way. Throws InputError at
/// `location` where the path leads through no map or to no item of a list.
void put_value(const YAML::Node& root, const std::string& path, const YAML::Node& value,
               const SourceLocation& location);
/// A path of keys with their names of today in the place of former ones.
std::string present_path(const std::string& given);
/// Whether a value of the key replaces what the other key has set: it is that key, or the map or list around it.
bool replaces(const std::string& key, const std::string& other);
/// Throws InputError where one of these "key.path=value" replaces what another one before it has set.
void check_overrides(const std::vector<std::string>& overrides);
/// Whether two values say the same, whatever their units and the order of keys: 5 mm and 0.005 m.
bool same_value(const YAML::Node& a, const YAML::Node& b);
/// Which item of a list a key means: its `name`, or its number from 0; none: no item.
std::optional<std::size_t> item_of(const YAML::Node& list, const std::string& key);

/// The same value without the marks of where its parts came from.
YAML::Node without_origin(const YAML::Node& node);

/// "experiment.force"
std::string below(const std::string& path, const std::string& key);
/// "a map of keys", "a list", "a single value" or "nothing", for messages.
std::string kind_of(const YAML::Node& node);
/// Whether a key or value came from --set.
bool is_override(const YAML::Node& node);
/// Which of the tree's files a key or value stands in.
std::size_t file_of(const YAML::Node& node);

/// "no such file; did you mean 'x'?", of the files in its folder.
std::string missing_file(const std::string& path);

}  // namespace elastin::config
