#include "config/scene_tree.h"

#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <functional>
#include <set>
#include <sstream>

#include "config/scene_text.h"
#include "elastin/mesh/mesh_file.h"

namespace elastin::config {
namespace {

/// Keys and values that came from --set carry this tag: their marks are not places in the file.
constexpr const char* kOverrideTag = "\001override";  // no file can write this one
/// Before the number of the file, in the tags of those that came from a file that the scene extends.
constexpr const char* kFileTag = "\001file ";

/// Maps and lists inside each other.
constexpr int kDeepestTree = 40;

/// Gives keys of a map, and of those in it, their names of today. Items of lists are not named in the path.
void take_present_names(const YAML::Node& node, const std::string& path,
                        const std::function<SourceLocation(const YAML::Node&)>& location_of) {
  if (node.IsSequence())
    for (const auto& item : node) take_present_names(item, path, location_of);
  if (!node.IsMap()) return;
  for (const auto& entry : node) {
    YAML::Node key = entry.first;
    const std::string given = key.Scalar(), name = present_name(path, given);
    if (name != given) {
      if (node[name].IsDefined())
        throw InputError(location_of(key), below(path, given) + " is the former name of " + below(path, name) +
                                               ", which stands here too; leave one of them out");
      key = name;
    }
    take_present_names(entry.second, below(path, name), location_of);
  }
}

/// Refuses what YAML forbids or never ends, and yaml-cpp lets pass: a key that stands twice in a map, an alias inside
/// its own anchor, aliases that multiply without end.
class TreeCheck {
 public:
  /// `location_of` says where a value stands; `size` of the text in letters: a value of its own takes at least one.
  TreeCheck(std::function<SourceLocation(const YAML::Node&)> location_of, std::size_t size)
      : location_of_(std::move(location_of)), left_(size + 1000000) {}

  void check(const YAML::Node& node, int depth = 0) {
    if (depth > kDeepestTree)
      throw InputError(location_of_(node), "nested too deeply; does an alias stand inside its own anchor?");
    if (left_-- == 0) throw InputError(location_of_(node), "too many values; do aliases stand in what aliases name?");
    if (node.IsMap()) {
      std::set<std::string> seen;
      std::string before;  // the entry before this one, "key: value"
      for (const auto& entry : node) {
        const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
        if (key.empty()) throw InputError(location_of_(entry.first), "a key must be a word");
        if (!seen.insert(key).second)
          throw InputError(location_of_(entry.first), "key '" + key + "' stands here twice; leave one of them out");
        if (entry.second.IsNull() && key.front() >= '0' && key.front() <= '9' && !before.empty())
          throw InputError(location_of_(entry.first), "a decimal point is needed where the comma before '" + key +
                                                          "' stands: write " + before + "." + key);
        before = entry.second.IsScalar() ? key + ": " + entry.second.Scalar() : "";
        check(entry.second, depth + 1);
      }
    } else if (node.IsSequence()) {
      for (const auto& item : node) check(item, depth + 1);
    }
  }

 private:
  std::function<SourceLocation(const YAML::Node&)> location_of_;
  std::size_t left_;
};

void mark_override(YAML::Node node) {
  node.SetTag(kOverrideTag);
  for (auto entry : node) {
    if (!node.IsMap()) {
      mark_override(entry);
      continue;
    }
    entry.first.SetTag(kOverrideTag);
    mark_override(entry.second);
  }
}

/// How --set calls the items of a list.
std::vector<std::string> names_of_items(const YAML::Node& list) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const bool named = list[i].IsMap() && list[i]["name"] && list[i]["name"].IsScalar();
    names.push_back(named ? list[i]["name"].Scalar() : std::to_string(i));
  }
  return names;
}

std::size_t item_of(const YAML::Node& list, const std::string& key, const SourceLocation& location) {
  if (const auto item = config::item_of(list, key)) return *item;
  throw InputError(location, "'" + key + "' is no item of the list" + suggestion(key, names_of_items(list)));
}

void put_override(const YAML::Node& root, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  const SourceLocation location{"--set " + assignment};
  const std::string path = assignment.substr(0, equals);
  if (equals == std::string::npos || ("." + path + ".").find("..") != std::string::npos)
    throw InputError(location, "write key=value, for example --set material.youngs_modulus='10 kPa'");
  if (std::count(path.begin(), path.end(), '.') > kDeepestTree)
    throw InputError({"--set " + path.substr(0, 80) + "…"},
                     "the path leads through more than " + std::to_string(kDeepestTree) + " keys");
  YAML::Node value;
  try {
    value = YAML::Load(assignment.substr(equals + 1));
  } catch (const YAML::Exception& error) {
    throw InputError(location, "the value is not valid YAML: " + error.msg);
  }
  TreeCheck([&](const YAML::Node&) { return location; }, assignment.size()).check(value);
  const std::string present = present_path(path);
  take_present_names(value, present, [&](const YAML::Node&) { return location; });
  mark_override(value);
  put_value(root, present, value, location);
}

/// Where a text's second YAML document begins.
class SecondDocument final : public YAML::EventHandler {
 public:
  std::optional<YAML::Mark> find(const std::string& text) {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (begun_ < 2 && parser.HandleNextDocument(*this)) {
    }
    return begun_ < 2 ? std::nullopt : std::optional(second_);
  }
  void OnDocumentStart(const YAML::Mark& mark) override { ++begun_, second_ = mark; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}

 private:
  int begun_ = 0;
  YAML::Mark second_;
};

/// Whether a text may go on behind its first document. A map from the first column on ends at a line with a sign of
/// YAML's own, or with the text.
bool may_go_on(const YAML::Node& first, const std::string& text) {
  if (!first.IsMap() || first.Style() != YAML::EmitterStyle::Block || first.Mark().column > 0) return true;
  for (const std::string sign : {"---", "...", "%"})
    if (text.starts_with(sign) || text.find("\n" + sign) != std::string::npos ||
        text.find("\r" + sign) != std::string::npos)
      return true;
  return false;
}

/// The only document of a scene's text. yaml-cpp's LoadAll finds documents without end in some texts that are no
/// documents.
YAML::Node load_document(const std::string& path, const std::string& text) {
  const SourceLocation start{path, 1, 1};
  if (mesh::is_mesh_file(path))
    throw InputError(SourceLocation{path, 0, 0},
                     "a mesh is not a scene, but a scene's body may be one: `body: {mesh: {file: " +
                         std::filesystem::path(path).filename().string() +
                         ", length_unit: mm}}`, or `fill` in place of `mesh` for a closed surface; `elastin new` "
                         "writes such a scene");
  if (text.empty()) throw InputError(start, "the scene is empty");
  check_scene_text(path, text);
  YAML::Node document;
  try {
    document = YAML::Load(text);
    if (const auto second = may_go_on(document, text) ? SecondDocument().find(text) : std::nullopt)
      throw InputError(SourceLocation{path, second->line + 1, second->column + 1},
                       "a scene is one YAML document; a second one begins here");
  } catch (const YAML::Exception& error) {
    throw explain_yaml(path, text, SourceLocation{path, error.mark.line + 1, error.mark.column + 1}, error.msg);
  }
  if (!document.IsMap()) throw InputError(start, "a scene is a map of keys (body, material, experiment, …)");
  const auto location_of = [&](const YAML::Node& node) {
    return SourceLocation{path, node.Mark().line + 1, node.Mark().column + 1};
  };
  TreeCheck(location_of, text.size()).check(document);
  take_present_names(document, "", location_of);
  return document;
}

/// Says of every key and value which file it stands in; those of files that this one extends say so already.
void mark_file(YAML::Node node, std::size_t file) {
  if (node.Tag().starts_with(kFileTag)) return;
  const bool quoted = node.Tag() == "!";
  node.SetTag(kFileTag + std::to_string(file) + (quoted ? "!" : ""));
  for (auto entry : node) {
    if (!node.IsMap()) {
      mark_file(entry, file);
      continue;
    }
    entry.first.SetTag(kFileTag + std::to_string(file));
    mark_file(entry.second, file);
  }
}

/// Adds to a map what it leaves out of another. Maps in maps are joined too, unless they state another `kind`; an empty
/// value takes the other's key away.
void extend(YAML::Node own, const YAML::Node& base) {
  for (const auto& entry : base) {
    const std::string& key = entry.first.Scalar();
    const YAML::Node there = std::as_const(own)[key];
    if (!there.IsDefined()) {
      own.force_insert(entry.first, entry.second);
      continue;
    }
    if (there.IsNull()) {
      own.remove(key);
      continue;
    }
    if (!there.IsMap() || !entry.second.IsMap()) continue;
    const YAML::Node kind = std::as_const(there)["kind"], other = entry.second["kind"];
    const bool same = !kind || !other || !kind.IsScalar() || !other.IsScalar() || kind.Scalar() == other.Scalar();
    if (same) extend(there, entry.second);
  }
}

SourceLocation place_of(const YAML::Node& node, const std::vector<std::string>& files) {
  const YAML::Mark mark = node.Mark();
  if (is_override(node) || mark.is_null()) return {"--set"};
  return {files[file_of(node)], mark.line + 1, mark.column + 1};
}

/// The map of one file with all that it extends; its own number is that of the last of `files`.
YAML::Node load_extended(const SceneSource& source, std::vector<std::string>& files) {
  const std::size_t own = files.size() - 1;
  YAML::Node root = load_document(files[own], source.text());
  if (own > 0) mark_file(root, own);
  const YAML::Node other = std::as_const(root)["extends"];
  if (!other.IsDefined()) return root;
  const SourceLocation location = place_of(other, files);
  if (!other.IsScalar()) throw InputError(location, "extends: name one file, for example extends: strip.yaml");
  const std::string path =
      (std::filesystem::path(files[own]).parent_path() / other.Scalar()).lexically_normal().string();
  for (const std::string& file : files)
    if (std::filesystem::path(file).lexically_normal() == path)
      throw InputError(location, "extends: '" + other.Scalar() + "' is extended already; a scene cannot extend itself");
  if (files.size() > kDeepestTree)
    throw InputError(location, "extends: more than " + std::to_string(kDeepestTree) + " files extend each other");
  files.push_back(path);
  const SceneSource base = source.other(path);
  try {
    base.text();
  } catch (const InputError& error) {
    throw InputError(location, std::string("extends: ") + error.what());
  }
  extend(root, load_extended(base, files));
  return root;
}

}  // namespace

std::string present_path(const std::string& given) {
  std::string present;
  std::istringstream keys(given);
  for (std::string key; std::getline(keys, key, '.');) present = below(present, present_name(present, key));
  return present;
}

bool replaces(const std::string& given, const std::string& given_other) {
  const std::string key = present_path(given), other = present_path(given_other);
  return other.starts_with(key) && (other.size() == key.size() || other[key.size()] == '.');
}

void check_overrides(const std::vector<std::string>& overrides) {
  const auto key_of = [](const std::string& assignment) { return assignment.substr(0, assignment.find('=')); };
  for (std::size_t i = 0; i < overrides.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const std::string &later = overrides[i], &earlier = overrides[j];
      if (!replaces(key_of(later), key_of(earlier))) continue;
      const bool same_key = replaces(key_of(earlier), key_of(later));
      throw InputError(same_key ? "'" + key_of(later) + "' is set twice, by " + earlier + " and by " + later +
                                      "; leave one of them out"
                                : later + " would replace " + earlier + ": let it come first");
    }
}

std::string kind_of(const YAML::Node& node) {
  return node.IsMap() ? "a map of keys" : node.IsSequence() ? "a list" : node.IsScalar() ? "a single value" : "nothing";
}

bool is_override(const YAML::Node& node) { return node.Tag() == kOverrideTag; }

std::string below(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

std::size_t file_of(const YAML::Node& node) {
  const std::string& tag = node.Tag();
  return tag.starts_with(kFileTag) ? std::stoul(tag.substr(std::strlen(kFileTag))) : 0;
}

void put_value(const YAML::Node& root, const std::string& whole_path, const YAML::Node& value,
               const SourceLocation& location) {
  std::string path = whole_path;
  YAML::Node node = root;
  for (std::size_t dot; (dot = path.find('.')) != std::string::npos; path = path.substr(dot + 1)) {
    const std::string key = path.substr(0, dot);
    YAML::Node next = node.IsSequence() ? node[item_of(node, key, location)] : node[key];
    if (next.IsDefined() && !next.IsMap() && !next.IsSequence())
      throw InputError(location, "'" + key + "' is " + kind_of(next) + " in the scene, not a map of keys");
    if (!next.IsDefined()) node[key] = next = YAML::Node(YAML::NodeType::Map);
    node.reset(next);
  }
  if (node.IsSequence())
    node[item_of(node, path, location)] = value;
  else
    node[path] = value;
}

std::optional<std::size_t> item_of(const YAML::Node& list, const std::string& key) {
  const std::vector<std::string> names = names_of_items(list);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (key == names[i] || key == std::to_string(i)) return i;
  return std::nullopt;
}

YAML::Node without_origin(const YAML::Node& node) {
  if (node.IsScalar()) return YAML::Node(node.Scalar());
  YAML::Node plain(node.Type());
  plain.SetStyle(node.Style());
  for (const auto& entry : node)
    if (node.IsSequence())
      plain.push_back(without_origin(entry));
    else
      plain.force_insert(entry.first.Scalar(), without_origin(entry.second));
  return plain;
}

std::string missing_file(const std::string& path) {
  const std::filesystem::path wanted(path);
  std::vector<std::string> names;
  std::error_code ignored;
  const auto folder = wanted.has_parent_path() ? wanted.parent_path() : std::filesystem::path(".");
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  const std::string near = nearest_name(wanted.filename().string(), names);
  return "no such file" + (near.empty() ? "" : "; did you mean '" + near + "'?");
}

namespace {

/// Whether a value or formula below a node names this, as a word of its own.
bool names_word(const YAML::Node& node, const std::string& word) {
  if (node.IsScalar()) {
    const std::string& text = node.Scalar();
    const auto is_of_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
      const std::size_t end = at + word.size();
      if ((at == 0 || !is_of_word(text[at - 1])) && (end == text.size() || !is_of_word(text[end]))) return true;
    }
    return false;
  }
  return std::any_of(node.begin(), node.end(), [&](const auto& entry) {
    return names_word(node.IsSequence() ? YAML::Node(entry) : entry.second, word);
  });
}

/// What --set or a study states under `values` has to be named by something.
void check_used(const YAML::Node& root, const std::string& assignment) {
  const std::string key = assignment.substr(0, assignment.find('='));
  if (!key.starts_with("values.")) return;
  const std::string name = key.substr(7);
  if (names_word(root, name)) return;
  std::vector<std::string> others;
  for (const auto& entry : root["values"])
    if (entry.first.Scalar() != name) others.push_back(entry.first.Scalar());
  throw InputError("--set " + assignment + ": no formula of the scene names '" + name + "'" +
                   (others.empty() ? "" : suggestion(name, others)));
}

}  // namespace

SceneTree load_scene_tree(const SceneSource& source, const std::vector<std::string>& overrides) {
  SceneTree tree{{}, {source.path()}};
  tree.root = load_extended(source, tree.files);
  for (const std::string& assignment : overrides) put_override(tree.root, assignment);
  for (const std::string& assignment : overrides) check_used(tree.root, assignment);
  tree.values = put_in_formulas(tree.root, [&](const YAML::Node& node) { return place_of(node, tree.files); });
  return tree;
}

}  // namespace elastin::config
