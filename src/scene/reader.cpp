#include "scene/reader.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <cerrno>
#include <fstream>
#include <utility>

namespace elastin {
namespace {

/// Values that came from --set carry this tag and no place of their own.
constexpr const char* kOverrideTag = "!override";

std::string kind_of(const YAML::Node& node) {
  return node.IsMap() ? "a map of keys" : node.IsSequence() ? "a list" : node.IsScalar() ? "a single value" : "nothing";
}

void put_override(YAML::Node root, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string place = "--set " + assignment;
  if (equals == std::string::npos || equals == 0)
    throw InputError(place + ": write key=value, for example --set material.youngs_modulus='10 kPa'");
  YAML::Node value;
  try {
    value = YAML::Load(assignment.substr(equals + 1));
  } catch (const YAML::Exception& error) {
    throw InputError(place + ": the value is not valid YAML: " + error.msg);
  }
  if (value.IsScalar()) value.SetTag(kOverrideTag);
  std::string path = assignment.substr(0, equals);
  YAML::Node node = root;
  for (std::size_t dot; (dot = path.find('.')) != std::string::npos; path = path.substr(dot + 1)) {
    YAML::Node next = node[path.substr(0, dot)];
    if (next.IsDefined() && !next.IsMap())
      throw InputError(place + ": '" + path.substr(0, dot) + "' is " + kind_of(next) + " in the scene, not a map of keys");
    if (!next.IsDefined()) node[path.substr(0, dot)] = next = YAML::Node(YAML::NodeType::Map);
    node.reset(next);
  }
  node[path] = value;
}

/// The first key that stands twice in a map, which YAML forbids and yaml-cpp lets pass.
void refuse_double_keys(const SceneFile& file, const YAML::Node& node) {
  if (node.IsMap()) {
    std::vector<std::string> seen;
    for (const auto& entry : node) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
      const YAML::Mark mark = entry.first.Mark();
      const Place place{file.path, mark.line + 1, mark.column + 1};
      if (key.empty()) throw InputError(place, "a key must be a word");
      if (std::find(seen.begin(), seen.end(), key) != seen.end()) throw InputError(place, "key '" + key + "' stands here twice");
      seen.push_back(key);
      refuse_double_keys(file, entry.second);
    }
  } else if (node.IsSequence()) {
    for (const auto& item : node) refuse_double_keys(file, item);
  }
}

std::string range_text(const Range& range, const Dimension& dimension) {
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

}  // namespace

Reader::Reader(std::shared_ptr<SceneFile> file, YAML::Node node, std::string path, std::optional<Place> key_place)
    : file_(std::move(file)), node_(std::move(node)), path_(std::move(path)), key_place_(std::move(key_place)) {}

Place Reader::place() const {
  if (node_.Tag() == kOverrideTag) return {"--set", 0, 0};
  const YAML::Mark mark = node_.Mark();
  if (!mark.is_null() && !node_.IsNull()) return {file_->path, mark.line + 1, mark.column + 1};
  return key_place_.value_or(Place{file_->path, 1, 1});
}

void Reader::fail(const std::string& message) const {
  throw InputError(place(), (path_.empty() ? "" : path_ + ": ") + message);
}

bool Reader::has(const std::string& key) { return find(key).has_value(); }

std::optional<Reader> Reader::find(const std::string& key) {
  if (!node_.IsMap()) fail("expected a map of keys, found " + kind_of(node_));
  asked_->push_back(key);
  const std::string path = path_.empty() ? key : path_ + "." + key;
  for (const auto& entry : node_)
    if (entry.first.Scalar() == key) {
      const YAML::Mark mark = entry.first.Mark();
      Reader found(file_, entry.second, path, mark.is_null() ? Place{"--set"} : Place{file_->path, mark.line + 1, mark.column + 1});
      if (entry.second.IsNull()) found.fail("has no value");
      return found;
    }
  return std::nullopt;
}

Reader Reader::at(const std::string& key) {
  if (auto found = find(key)) return *found;
  // A misspelt key is better named than a missing one.
  for (const std::string& given : keys())
    if (std::find(asked_->begin(), asked_->end(), given) == asked_->end() && nearest_name(given, {key}) == key) finish();
  fail("key '" + key + "' is missing");
}

void Reader::finish() const {
  if (!node_.IsMap()) return;
  std::vector<std::string> known;
  for (const std::string& key : *asked_)
    if (std::find(known.begin(), known.end(), key) == known.end()) known.push_back(key);
  for (const auto& entry : node_) {
    const std::string key = entry.first.Scalar();
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const YAML::Mark mark = entry.first.Mark();
    const Place place = mark.is_null() ? Place{"--set"} : Place{file_->path, mark.line + 1, mark.column + 1};
    throw InputError(place, (path_.empty() ? "" : path_ + ": ") + "unknown key '" + key + "'" + suggestion(key, known));
  }
}

std::vector<std::string> Reader::keys() const {
  std::vector<std::string> keys;
  if (node_.IsMap())
    for (const auto& entry : node_) keys.push_back(entry.first.Scalar());
  return keys;
}

std::vector<Reader> Reader::items() const {
  if (!node_.IsSequence()) fail("expected a list, found " + kind_of(node_));
  std::vector<Reader> items;
  for (const auto& item : node_) items.emplace_back(file_, item, path_ + "[" + std::to_string(items.size()) + "]", place());
  return items;
}

std::vector<Reader> Reader::items(std::size_t count) const {
  std::vector<Reader> list = items();
  if (list.size() != count)
    fail("expected " + std::to_string(count) + " values, found " + std::to_string(list.size()));
  return list;
}

std::string Reader::text() const {
  if (!node_.IsScalar()) fail("expected a single value, found " + kind_of(node_));
  return node_.Scalar();
}

double Reader::quantity(const Dimension& dimension, const Range& range) const {
  const std::string given = text();
  const Quantity quantity = located([&] { return parse_quantity(given, dimension); });
  if (quantity.value < range.low || quantity.value > range.high || (range.open_low && quantity.value == range.low))
    fail("'" + given + "' is out of range: must be " + range_text(range, dimension));
  if (dimension != dimension::none && node_.Tag() != kOverrideTag) {
    if (quantity.has_unit && !file_->first_unit) file_->first_unit = place();
    if (!quantity.has_unit && quantity.value != 0 && !file_->first_plain)
      file_->first_plain = InputError(place(), path_ + ": '" + given + "' has no unit; write for example " +
                                                   unit_examples(dimension));
  }
  return quantity.value;
}

int Reader::whole(int low, int high) const {
  const std::string given = text();
  int value = 0;
  const auto [end, problem] = std::from_chars(given.data(), given.data() + given.size(), value);
  if (problem != std::errc() || end != given.data() + given.size() || value < low || value > high)
    fail("'" + given + "' is not a whole number of at least " + std::to_string(low) +
         (high < std::numeric_limits<int>::max() ? " and at most " + std::to_string(high) : ""));
  return value;
}

bool Reader::yes_or_no() const { return choice<bool>({{"true", true}, {"false", false}, {"yes", true}, {"no", false}}); }

Vector3 Reader::vector(const Dimension& dimension, const Range& range) const {
  const auto list = items(3);
  return {list[0].quantity(dimension, range), list[1].quantity(dimension, range), list[2].quantity(dimension, range)};
}

std::array<int, 3> Reader::wholes(int low) const {
  const auto list = items(3);
  return {list[0].whole(low), list[1].whole(low), list[2].whole(low)};
}

void Reader::check_units() const {
  if (!file_->first_unit || !file_->first_plain) return;
  throw InputError(std::string(file_->first_plain->what()) + " (plain SI numbers are taken only where no value has a unit, and " +
                   file_->first_unit->text() + " has one)");
}

Reader open_scene_file(const std::string& path, const std::vector<std::string>& overrides) {
  auto file = std::make_shared<SceneFile>(SceneFile{path, {}, {}});
  std::ifstream stream(path);
  std::string text((std::istreambuf_iterator<char>(stream)), {});
  if (!stream.good() && !stream.eof()) throw InputError(path + ": cannot read the scene: " + std::strerror(errno));
  if (text.empty()) throw InputError(Place{path, 1, 1}, "the scene is empty");
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw InputError(Place{path, error.mark.line + 1, error.mark.column + 1}, "not valid YAML: " + error.msg);
  }
  if (!root.IsMap()) throw InputError(Place{path, 1, 1}, "a scene is a map of keys (body, material, experiment, …)");
  refuse_double_keys(*file, root);
  for (const std::string& assignment : overrides) put_override(root, assignment);
  return {file, root, ""};
}

}  // namespace elastin
