#include "config/scene_text.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>

#include "config/scene_tree.h"
#include "core/base/named.h"
#include "elastin/core/base/text.h"

namespace elastin::config {
namespace {

namespace fs = std::filesystem;

/// What stands at a place of a text, and what is to stand there.
struct Edit {
  std::size_t at, length;
  std::string text;
};

/// Where a node begins, a byte of the text; of a value with an anchor that.
std::size_t begin_of(const YAML::Node& node) { return static_cast<std::size_t>(std::max(0, node.Mark().pos)); }

bool is_quote(char character) { return character == '"' || character == '\''; }

/// Puts another text in the place of a single value, quotes and all; where its text is written in escapes it stays.
void replace(const std::string& text, const YAML::Node& node, const std::string& value, std::vector<Edit>& edits) {
  const std::string& written = node.Scalar();
  std::size_t at = text.find(written, begin_of(node)), length = written.size();
  if (at == std::string::npos) return;
  if (at > 0 && is_quote(text[at - 1]) && at + length < text.size() && text[at + length] == text[at - 1])
    --at, length += 2;
  edits.push_back({at, length, value});
}

std::string edited(std::string text, std::vector<Edit> edits) {
  std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.at > b.at; });
  for (std::size_t i = 0; i < edits.size(); ++i)
    if (i == 0 || edits[i].at != edits[i - 1].at)  // an alias stands where its anchor does
      text.replace(edits[i].at, edits[i].length, edits[i].text);
  return text;
}

/// Rewrites the path of each file next to the scene as seen from the other folder.
void move_files(const std::string& text, const YAML::Node& node, const fs::path& from, const fs::path& to,
                std::vector<Edit>& edits) {
  if (node.IsScalar()) {
    const std::string& name = node.Scalar();
    std::error_code ignored;
    if (!name.empty() && fs::path(name).is_relative() && fs::is_regular_file(from / name, ignored))
      replace(text, node, path_text((from / name).lexically_normal().lexically_relative(to).generic_string()), edits);
  }
  for (const auto& child : node) move_files(text, node.IsMap() ? child.second : child, from, to, edits);
}

/// Puts a key into a map at its beginning.
void insert(const std::string& text, const YAML::Node& map, const std::string& line, std::vector<Edit>& edits) {
  const std::size_t at = begin_of(map);
  if (at < text.size() && text[at] == '{')
    edits.push_back({at + 1, 0, line + (map.size() > 0 ? ", " : "")});
  else
    edits.push_back({at, 0, line + "\n" + std::string(static_cast<std::size_t>(map.Mark().column), ' ')});
}

/// Whether two texts say the same, whatever the order of keys in their maps.
template <class SameWord>
bool same(const YAML::Node& a, const YAML::Node& b, SameWord same_word) {
  if (a.Type() != b.Type() || (a.IsScalar() && !same_word(a, b)) || a.size() != b.size()) return false;
  if (a.IsSequence())
    for (std::size_t i = 0; i < a.size(); ++i)
      if (!same(a[i], b[i], same_word)) return false;
  if (a.IsMap())
    for (const auto& entry : a) {
      const YAML::Node other = b[entry.first.Scalar()];
      if (!other.IsDefined() || !same(entry.second, other, same_word)) return false;
    }
  return true;
}

/// The number that a single value is; none: it is a word or a formula of the place.
std::optional<FormulaValue> number_of(const YAML::Node& node) {
  try {
    return node.IsScalar() ? std::optional(formula_value(node.Scalar(),
                                                         [](const std::string& name) -> FormulaValue {
                                                           throw InputError(name + " is no number");
                                                         }))
                           : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

bool says(const std::string& text, const YAML::Node& wanted) {
  try {
    return same(YAML::Load(text), wanted,
                [](const YAML::Node& a, const YAML::Node& b) { return a.Scalar() == b.Scalar(); });
  } catch (const YAML::Exception&) {
    return false;
  }
}

/// The keys of its material that a scene has from the one that it extends.
std::vector<std::string> extended_keys(const YAML::Node& scene, const SceneSource& source) {
  std::vector<std::string> keys;
  const YAML::Node base = scene["extends"];
  if (!base.IsDefined() || !base.IsScalar()) return keys;
  const fs::path path = (fs::path(source.path()).parent_path() / base.Scalar()).lexically_normal();
  const SceneTree tree = load_scene_tree(source.other(path.string()), {});
  if (const YAML::Node material = std::as_const(tree.root)["material"]; material.IsDefined() && material.IsMap())
    for (const auto& entry : material) keys.push_back(entry.first.Scalar());
  return keys;
}

}  // namespace

bool same_value(const YAML::Node& first, const YAML::Node& second) {
  return same(first, second, [](const YAML::Node& a, const YAML::Node& b) {
    const auto one = number_of(a), other = number_of(b);
    if (!one || !other) return a.Scalar() == b.Scalar();
    const bool alike = one->unit == other->unit || one->unit == dimension::none || other->unit == dimension::none;
    return alike && std::abs(one->number - other->number) <= 1e-12 * std::abs(one->number);
  });
}

std::string path_text(const std::string& path) {
  if (path.find_first_of(" ,:[]{}#&*!|>'\"%@`") == std::string::npos) return path;
  YAML::Emitter quoted;
  quoted << YAML::DoubleQuoted << path;
  return quoted.c_str();
}

std::string moved_scene(const std::string& text, const std::string& from_folder, const std::string& to_folder) {
  std::vector<Edit> edits;
  move_files(text, YAML::Load(text), fs::absolute(from_folder.empty() ? "." : from_folder),
             fs::absolute(to_folder).lexically_normal(), edits);
  return edited(text, std::move(edits));
}

std::string with_section(const std::string& text, const std::string& key, const std::string& lines) {
  std::size_t begin = text.starts_with(key + ":") ? 0 : text.find("\n" + key + ":");
  if (begin == std::string::npos) return "";
  if (begin > 0) ++begin;
  std::size_t end = text.find('\n', begin);
  // What is indented below belongs to the block, as flow collections over several lines do.
  while (end != std::string::npos && end + 1 < text.size() &&
         std::string(" ]}").find(text[end + 1]) != std::string::npos)
    end = text.find('\n', end + 1);
  return text.substr(0, begin) + lines + (end == std::string::npos ? "" : text.substr(end + 1));
}

std::string with_values(const SceneSource& source, const std::vector<std::pair<std::string, std::string>>& values) {
  std::string result = source.text();
  for (auto [path, value] : values) {
    if (path == "material")
      for (const std::string& key : extended_keys(YAML::Load(result), source))
        if (!YAML::Load(value)[key].IsDefined()) value += "\n  " + key + ":";
    YAML::Node wanted = YAML::Load(result);
    put_value(wanted, path, YAML::Load(value), {path});
    const std::string lines = with_value(result, path, value);
    if (says(lines, wanted)) {
      result = lines;
      continue;
    }
    YAML::Emitter emitter;
    emitter << without_origin(wanted);
    result = std::string(emitter.c_str()) + "\n";
  }
  return result;
}

std::string with_value(const std::string& text, const std::string& path, const std::string& value) {
  if (path.find('.') == std::string::npos) {
    const std::string line = path + (value.starts_with('\n') ? ":" : ": ") + value + "\n",
                      found = with_section(text, path, line);
    return found.empty() ? text + (text.ends_with('\n') ? "" : "\n") + line : found;
  }
  std::vector<Edit> edits;
  YAML::Node node = YAML::Load(text);
  for (std::size_t from = 0; from < path.size();) {
    const std::size_t to = std::min(path.find('.', from), path.size());
    const std::string key = path.substr(from, to - from);
    const bool last = to == path.size();
    const auto item = node.IsSequence() ? item_of(node, key) : std::nullopt;
    const YAML::Node child = item           ? std::as_const(node)[*item]
                             : node.IsMap() ? std::as_const(node)[key]
                                            : YAML::Node(YAML::NodeType::Undefined);
    if (!child.IsDefined()) {
      if (last && node.IsMap()) insert(text, node, key + ": " + value, edits);
      break;
    }
    if (last && child.IsScalar()) replace(text, child, value, edits);
    node.reset(child);
    from = to + 1;
  }
  return edited(text, std::move(edits));
}

namespace {

void add_numbers(const YAML::Node& node, const std::string& path, std::vector<std::string>& paths) {
  if (number_of(node)) paths.push_back(path);
  std::size_t item = 0;
  for (const auto& entry : node) {
    const std::string key = node.IsMap() ? entry.first.Scalar() : std::to_string(item++);
    add_numbers(node.IsMap() ? entry.second : entry, path.empty() ? key : path + "." + key, paths);
  }
}

}  // namespace

std::string StatedNumber::with(double other) const {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", other);
  return unit == dimension::none ? text : text + (" " + si_unit(unit));
}

namespace {

/// The unit that the scene gives a number; none where it has no such number.
Dimension own_unit(const SceneSource& source, const std::string& path) {
  try {
    return stated_number(source, {}, path).unit;
  } catch (const InputError&) {
    return dimension::none;
  }
}

}  // namespace

StatedNumber stated_number(const SceneSource& source, const std::vector<std::string>& overrides,
                           const std::string& path) {
  const SceneTree tree = load_scene_tree(source, overrides);
  YAML::Node node = tree.root;
  bool there = true;
  for (std::size_t from = 0; from < path.size() && there;) {
    const std::size_t to = std::min(path.find('.', from), path.size());
    const std::string key = path.substr(from, to - from);
    const auto item = node.IsSequence() ? item_of(node, key) : std::nullopt;
    const YAML::Node child = item           ? std::as_const(node)[*item]
                             : node.IsMap() ? std::as_const(node)[key]
                                            : YAML::Node(YAML::NodeType::Undefined);
    if ((there = child.IsDefined())) node.reset(child);
    from = to + 1;
  }
  std::vector<std::string> paths;
  add_numbers(tree.root, "", paths);
  std::erase_if(paths, [](const std::string& other) { return other.starts_with("expect."); });
  if (!there)
    throw InputError(source.path() + ": the scene states no '" + path + "'" + suggestion(path, paths) +
                     "; a number that it leaves out is written into it first");
  const auto found = number_of(node);
  if (!found && node.IsScalar() && path.starts_with("values.") && tree.values.contains(path.substr(7)))
    return {tree.values.at(path.substr(7)).number, tree.values.at(path.substr(7)).unit};
  // A plain number of --set is in SI units, whatever unit the scene states.
  if (found && found->unit == dimension::none && is_override(node)) return {found->number, own_unit(source, path)};
  if (found) return {found->number, found->unit};
  std::erase_if(paths, [&](const std::string& other) { return !other.starts_with(path + "."); });
  throw InputError(source.path() + ": '" + path + "' is " +
                   (node.IsScalar() ? "'" + node.Scalar() + "'" : kind_of(node)) + ", and no number" +
                   (paths.empty() ? "" : "; those in it are " + joined(paths)));
}

}  // namespace elastin::config
