#include "lab/scene/reader.h"

#include <yaml-cpp/eventhandler.h>
#include <string_view>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <utility>

#include "lab/scene/held_scene.h"

namespace elastin::lab {
namespace {

/// Keys and values that came from --set carry this tag: their marks are not places in the file.
constexpr const char* kOverrideTag = "\001override";  // no file can write this one

std::string kind_of(const YAML::Node& node) {
  return node.IsMap() ? "a map of keys" : node.IsSequence() ? "a list" : node.IsScalar() ? "a single value" : "nothing";
}

/// Refuses what YAML forbids or never ends, and yaml-cpp lets pass: a key that stands twice in a map, an alias inside
/// its own anchor, aliases that multiply without end.
class TreeCheck {
 public:
  /// `location_of` says where a value stands; `size` of the text in letters: a value of its own takes at least one.
  TreeCheck(std::function<SourceLocation(const YAML::Node&)> location_of, std::size_t size)
      : location_of_(std::move(location_of)), left_(size + 1000000) {}

  void check(const YAML::Node& node, int depth = 0) {
    if (depth > 40)
      throw InputError(location_of_(node), "nested too deeply; does an alias stand inside its own anchor?");
    if (left_-- == 0) throw InputError(location_of_(node), "too many values; do aliases stand in what aliases name?");
    if (node.IsMap()) {
      std::set<std::string> seen;
      for (const auto& entry : node) {
        const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
        if (key.empty()) throw InputError(location_of_(entry.first), "a key must be a word");
        if (!seen.insert(key).second)
          throw InputError(location_of_(entry.first), "key '" + key + "' stands here twice");
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

/// Which item of a list a key means: its `name`, or its number from 0.
std::size_t item_of(const YAML::Node& list, const std::string& key, const SourceLocation& location) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const bool named = list[i].IsMap() && list[i]["name"] && list[i]["name"].IsScalar();
    names.push_back(named ? list[i]["name"].Scalar() : std::to_string(i));
    if (key == names.back() || key == std::to_string(i)) return i;
  }
  throw InputError(location, "'" + key + "' is no item of the list" + suggestion(key, names));
}

void put_override(YAML::Node root, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  const SourceLocation location{"--set " + assignment};
  std::string path = assignment.substr(0, equals);
  if (equals == std::string::npos || ("." + path + ".").find("..") != std::string::npos)
    throw InputError(location, "write key=value, for example --set material.youngs_modulus='10 kPa'");
  YAML::Node value;
  try {
    value = YAML::Load(assignment.substr(equals + 1));
  } catch (const YAML::Exception& error) {
    throw InputError(location, "the value is not valid YAML: " + error.msg);
  }
  TreeCheck([&](const YAML::Node&) { return location; }, assignment.size()).check(value);
  mark_override(value);
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

/// A key that older scenes wrote under another name. The old name must not stand for anything else in that map.
struct RenamedKey {
  std::string_view old_name, name;
};
constexpr RenamedKey kRenamedKeys[] = {
    {"way", "method"},    // of the solver
    {"hold", "fixture"},  // of experiments in time: how the body is fixed and loaded
    {"hold", "fix"},      // of a press: the parts that stay
};

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

/// The only document of a scene's text. yaml-cpp's LoadAll finds documents without end in some texts that are none.
YAML::Node load_document(const std::string& path, const std::string& text) {
  const SourceLocation start{path, 1, 1};
  if (text.empty()) throw InputError(start, "the scene is empty");
  YAML::Node document;
  try {
    if (const auto second = SecondDocument().find(text))
      throw InputError(SourceLocation{path, second->line + 1, second->column + 1},
                       "a scene is one YAML document; a second one begins here");
    document = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw InputError(SourceLocation{path, error.mark.line + 1, error.mark.column + 1}, "not valid YAML: " + error.msg);
  }
  if (!document.IsMap()) throw InputError(start, "a scene is a map of keys (body, material, experiment, …)");
  const auto location_of = [&](const YAML::Node& node) {
    return SourceLocation{path, node.Mark().line + 1, node.Mark().column + 1};
  };
  TreeCheck(location_of, text.size()).check(document);
  return document;
}

/// "at least 0 m and at most 1 m"
std::string allowed_text(const Range& range, const Dimension& dimension) {
  const std::string unit = si_unit(dimension).empty() ? "" : " " + si_unit(dimension);
  const auto number = [](double value) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%g", value);
    return std::string(buffer);
  };
  std::string text;
  if (std::isfinite(range.low)) text = (range.open_low ? "above " : "at least ") + number(range.low) + unit;
  if (std::isfinite(range.high)) text += (text.empty() ? "at most " : " and at most ") + number(range.high) + unit;
  return text;
}

/// "experiment.force"
std::string below(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

}  // namespace

Reader::Reader(std::shared_ptr<SceneFile> file, YAML::Node node, std::string path,
               std::optional<SourceLocation> key_location)
    : file_(std::move(file)), node_(std::move(node)), path_(std::move(path)), key_location_(std::move(key_location)) {}

SourceLocation Reader::location_of(const YAML::Node& node) const {
  const YAML::Mark mark = node.Mark();
  if (node.Tag() == kOverrideTag || mark.is_null()) return {"--set"};
  return {file_->path, mark.line + 1, mark.column + 1};
}

SourceLocation Reader::location() const {
  if (node_.IsNull() && node_.Tag() != kOverrideTag) return key_location_.value_or(SourceLocation{file_->path, 1, 1});
  return location_of(node_);
}

void Reader::fail(const std::string& message) const {
  throw InputError(location(), (path_.empty() ? "" : path_ + ": ") + message);
}

bool Reader::has(const std::string& key) { return find(key).has_value(); }

std::optional<Reader> Reader::find(const std::string& key) {
  if (!node_.IsMap()) fail("expected a map of keys, found " + kind_of(node_));
  requested_->keys.push_back(key);
  if (file_->uses && section_) (*file_->uses)[below(*section_, key)];
  refuse_old_name(key);
  return value_of(key, key);
}

/// Fails where the map has this key under the name that it once had.
void Reader::refuse_old_name(const std::string& key) const {
  for (const RenamedKey& renamed : kRenamedKeys) {
    if (key != renamed.name) continue;
    for (const auto& entry : node_)
      if (entry.first.Scalar() == renamed.old_name)
        throw InputError(location_of(entry.first), (path_.empty() ? "" : path_ + ": ") + "key '" +
                                                       entry.first.Scalar() + "' has been renamed: write '" + key +
                                                       "'");
  }
}

/// The value that stands under the key `given`, as the one of `key`.
std::optional<Reader> Reader::value_of(const std::string& given, const std::string& key) const {
  for (const auto& entry : node_)
    if (entry.first.Scalar() == given) {
      Reader found(file_, entry.second, below(path_, key), location_of(entry.first));
      found.section_ = section_ ? std::optional(below(*section_, key)) : std::nullopt;
      if (entry.second.IsNull()) found.fail("has no value");
      return found;
    }
  return std::nullopt;
}

Reader Reader::at(const std::string& key) {
  if (auto found = find(key)) return *found;
  // A misspelt key is read as what it must be: finish() then names it beside every key that is known.
  std::vector<std::string> unknown;
  for (const std::string& given : keys())
    if (std::find(requested_->keys.begin(), requested_->keys.end(), given) == requested_->keys.end())
      unknown.push_back(given);
  const std::string misspelt = nearest_name(key, unknown);
  if (misspelt.empty()) fail("key '" + key + "' is missing");
  requested_->misspelt.emplace_back(misspelt, key);
  return *value_of(misspelt, key);
}

void Reader::finish() const {
  if (!node_.IsMap()) return;
  std::vector<std::string> known;
  for (const std::string& key : requested_->keys)
    if (std::find(known.begin(), known.end(), key) == known.end()) known.push_back(key);
  for (const auto& entry : node_) {
    const std::string key = entry.first.Scalar();
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    throw InputError(location_of(entry.first),
                     (path_.empty() ? "" : path_ + ": ") + "unknown key '" + key + "'" + suggestion(key, known));
  }
  for (const auto& [misspelt, key] : requested_->misspelt) fail("key '" + key + "' is missing");
}

std::vector<std::string> Reader::keys() const {
  std::vector<std::string> keys;
  if (node_.IsMap())
    for (const auto& entry : node_) keys.push_back(entry.first.Scalar());
  return keys;
}

/// What a map names in a list by `key: NUMBER`. The key is noted only where it stands: no message offers it.
template <class Thing>
std::shared_ptr<const Thing> Reader::given(const std::string& key,
                                           const std::vector<std::shared_ptr<const Thing>>& list) {
  const std::vector<std::string> there = keys();
  if (std::find(there.begin(), there.end(), key) == there.end()) return nullptr;
  return list[static_cast<std::size_t>(at(key).whole(0, static_cast<int>(list.size()) - 1))];
}

std::shared_ptr<const Body> Reader::given_body(const std::string& key) {
  return file_->held ? given(key, file_->held->bodies) : nullptr;
}

std::shared_ptr<const Material> Reader::given_material(const std::string& key) {
  return file_->held ? given(key, file_->held->materials) : nullptr;
}

std::vector<std::pair<std::string, Reader>> Reader::entries() const {
  std::vector<std::pair<std::string, Reader>> entries;
  for (const std::string& key : keys()) {
    entries.emplace_back(key, *value_of(key, key));
    entries.back().second.section_.reset();
  }
  return entries;
}

std::vector<Reader> Reader::items() const {
  if (!node_.IsSequence()) fail("expected a list, found " + kind_of(node_));
  std::vector<Reader> items;
  if (KeyUse* noted = use()) noted->kinds.insert("list");
  for (const auto& item : node_) {
    items.emplace_back(file_, item, path_ + "[" + std::to_string(items.size()) + "]", location());
    items.back().section_ = section_;
  }
  return items;
}

std::vector<Reader> Reader::items(std::size_t count) const {
  std::vector<Reader> list = items();
  if (list.size() != count) fail("expected " + std::to_string(count) + " values, found " + std::to_string(list.size()));
  return list;
}

std::string Reader::text() const {
  if (!node_.IsScalar()) fail("expected a single value, found " + kind_of(node_));
  return node_.Scalar();
}

std::string Reader::line() const {
  YAML::Emitter emitter;
  emitter << YAML::Flow << node_;
  return emitter.c_str();
}

std::string Reader::content() const {
  std::string text = line();
  const std::filesystem::path folder = std::filesystem::path(file_->path).parent_path();
  const std::function<void(const YAML::Node&)> add_files = [&](const YAML::Node& node) {
    if (!node.IsMap() && !node.IsSequence()) return;
    for (const auto& entry : node) {
      if (node.IsSequence()) {
        add_files(entry);
        continue;
      }
      add_files(entry.second);
      if (entry.first.Scalar() != "file" || !entry.second.IsScalar()) continue;
      std::ifstream stream(folder / entry.second.Scalar(), std::ios::binary);
      text += "\n" + std::string(std::istreambuf_iterator<char>(stream), {});
    }
  };
  add_files(node_);
  return text;
}

void Reader::check_size(double molecules) const {
  if (molecules <= file_->most_molecules) return;
  char text[100];
  std::snprintf(text, sizeof text, "that is %.3g molecules; at most %g are allowed", molecules, file_->most_molecules);
  fail(text);
}

KeyUse* Reader::use() const { return file_->uses && section_ ? &(*file_->uses)[*section_] : nullptr; }

void Reader::note_use(const std::string& kind, const Dimension& unit, const Range& range) const {
  KeyUse* noted = use();
  if (!noted) return;
  noted->kinds.insert(kind);
  if (const std::string name = si_unit(unit); !name.empty()) noted->units.insert(name);
  const std::string text = lab::range_text(range.low, range.high, range.open_low);
  if (!text.empty()) noted->ranges.insert(text);
}

void Reader::note_words(const std::vector<std::string>& words) const {
  if (KeyUse* noted = use()) noted->words.insert(words.begin(), words.end());
}

double Reader::quantity(const Dimension& dimension, const Range& range) const {
  note_use(dimension == dimension::none ? "number" : "quantity", dimension, range);
  return number(dimension, range);
}

double Reader::number(const Dimension& dimension, const Range& range) const {
  const std::string given = text();
  const Quantity quantity = located([&] { return parse_quantity(given, dimension); });
  if (quantity.value < range.low || quantity.value > range.high || (range.open_low && quantity.value == range.low))
    fail("'" + given + "' is out of range: must be " + allowed_text(range, dimension));
  if (dimension == dimension::none || is_override()) return quantity.value;
  if (quantity.has_unit)
    note_unit();
  else if (quantity.value != 0)
    note_plain(given, unit_examples(dimension));
  return quantity.value;
}

double Reader::angle(const Range& range) const {
  note_use("angle", dimension::none, range);
  const std::string given = text();
  const double value = number(dimension::none, range);
  if (given.ends_with('%')) fail("'" + given + "' is a ratio, no angle; write for example 30 deg, 0.5 rad");
  const bool has_unit = parse_quantity(given, dimension::none).has_unit;
  if (!has_unit && value != 0 && !is_override()) note_plain(given, "30 deg, 0.5 rad");
  return value;
}

bool Reader::is_override() const { return node_.Tag() == kOverrideTag; }

void Reader::note_unit() const {
  if (!file_->first_unit) file_->first_unit = location();
  check_units_agree();
}

void Reader::note_plain(const std::string& given, const std::string& examples) const {
  if (file_->held) return;
  if (!file_->first_plain)
    file_->first_plain = {location(), path_ + ": '" + given + "' has no unit; write for example " + examples};
  check_units_agree();
}

/// Throws if the file writes some dimensional values with units and others as plain numbers: one of them is a slip.
void Reader::check_units_agree() const {
  const auto& first_unit = file_->first_unit;
  const auto& first_plain = file_->first_plain;
  if (first_unit && first_plain)
    throw InputError(first_plain->first, first_plain->second +
                                             " (plain SI numbers are allowed only where no value has a unit, and " +
                                             first_unit->text() + " has one)");
}

int Reader::whole(int low, int high) const {
  constexpr double unlimited = std::numeric_limits<double>::infinity();
  const bool bounded = high < std::numeric_limits<int>::max();
  note_use("whole", dimension::none, {static_cast<double>(low), bounded ? high : unlimited});
  return whole_number(low, high);
}

int Reader::molecule(int count) const {
  if (KeyUse* noted = use()) noted->kinds.insert("molecule"), noted->ranges.insert("0 … last molecule");
  return whole_number(0, count - 1);
}

int Reader::whole_number(int low, int high) const {
  const std::string given = text();
  int value = 0;
  const auto [end, problem] = std::from_chars(given.data(), given.data() + given.size(), value);
  if (problem != std::errc() || end != given.data() + given.size() || value < low || value > high)
    fail("'" + given + "' is not a whole number of at least " + std::to_string(low) +
         (high < std::numeric_limits<int>::max() ? " and at most " + std::to_string(high) : ""));
  return value;
}

Vector3 Reader::vector(const Dimension& dimension, const Range& range) const {
  const auto list = items(3);
  if (KeyUse* noted = use()) noted->kinds.insert("vector");
  return {list[0].quantity(dimension, range), list[1].quantity(dimension, range), list[2].quantity(dimension, range)};
}

std::array<int, 3> Reader::wholes(int low) const {
  const auto list = items(3);
  return {list[0].whole(low), list[1].whole(low), list[2].whole(low)};
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

Reader open_scene_file(const std::string& path, const std::vector<std::string>& overrides, double most_molecules,
                       KeyUses* uses) {
  if (const auto held = held_scene(path)) {
    const YAML::Node root = load_document("scene", held->yaml);
    for (const std::string& assignment : overrides) put_override(root, assignment);
    return {std::make_shared<SceneFile>(SceneFile{"scene", {}, {}, most_molecules, uses, held}), root, ""};
  }
  const SourceLocation location{path};
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) throw InputError(location, missing_file(path));
  if (std::filesystem::is_directory(path, ignored)) throw InputError(location, "is a folder; name a scene file in it");
  if (std::filesystem::is_character_file(path, ignored) || std::filesystem::is_block_file(path, ignored))
    throw InputError(location, "is a device; a scene is a file or a pipe");
  std::ifstream stream(path);
  if (!stream) throw InputError(location, std::string("cannot read the scene: ") + std::strerror(errno));
  const std::string text((std::istreambuf_iterator<char>(stream)), {});
  return open_scene_text(path, text, overrides, most_molecules, uses);
}

Reader open_scene_text(const std::string& name, const std::string& text, const std::vector<std::string>& overrides,
                       double most_molecules, KeyUses* uses) {
  const YAML::Node root = load_document(name, text);
  for (const std::string& assignment : overrides) put_override(root, assignment);
  return {std::make_shared<SceneFile>(SceneFile{name, {}, {}, most_molecules, uses, {}}), root, ""};
}

}  // namespace elastin::lab
