#include "config/reader.h"

#include <Eigen/Geometry>

#include <string_view>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>

#include "core/base/named.h"
#include "elastin/core/base/text.h"

namespace elastin::config {
namespace {

/// Of any number of a scene, in SI: squares and products of a few of them are numbers still.
constexpr double kLargest = 1e30;

/// "at least 0 m and at most 1 m"
std::string allowed_text(const Range& range, const Dimension& dimension) {
  const std::string unit = si_unit(dimension).empty() ? "" : " " + si_unit(dimension);
  std::string text;
  if (std::isfinite(range.low)) text = (range.open_low ? "above " : "at least ") + number(range.low) + unit;
  if (std::isfinite(range.high)) text += (text.empty() ? "at most " : " and at most ") + number(range.high) + unit;
  return text;
}

}  // namespace

Reader::Reader(std::shared_ptr<SceneFile> file, const YAML::Node& node, std::string path,
               std::optional<SourceLocation> key_location)
    : file_(std::move(file)), node_(node), path_(std::move(path)), key_location_(std::move(key_location)) {
  if (file_->files.empty()) file_->files = {file_->path};
}

SourceLocation Reader::location_of(const YAML::Node& node) const {
  const YAML::Mark mark = node.Mark();
  if (config::is_override(node) || mark.is_null()) return {"--set"};
  const std::string& file = file_->files[file_of(node)];
  if (file.starts_with("--")) return {file};  // an option's value
  return {file, mark.line + 1, mark.column + 1};
}

SourceLocation Reader::location() const {
  if (node_.IsNull() && !is_override()) return key_location_.value_or(SourceLocation{file_->path, 1, 1});
  return location_of(node_);
}

void Reader::fail(const std::string& message) const {
  throw InputError(location(), (path_.empty() ? "" : path_ + ": ") + message);
}

bool Reader::has(const std::string& key) { return find(key).has_value(); }

std::optional<Reader> Reader::find(const std::string& key) {
  if (!node_.IsMap()) {
    const std::string own = path_.substr(path_.find_last_of('.') + 1);
    fail("expected a map of keys, found " + kind_of(node_) +
         (own.empty() || own.ends_with(']') ? "" : "; write " + own + ": {" + key + ": …}"));
  }
  requested_->keys.push_back(key);
  return value_of(key, key);
}

/// The value that stands under the key `given`, as the one of `key`.
std::optional<Reader> Reader::value_of(const std::string& given, const std::string& key) const {
  for (const auto& entry : node_)
    if (entry.first.Scalar() == given) {
      Reader found(file_, entry.second, below(path_, key), location_of(entry.first));
      found.section_ = section_ ? std::optional(below(*section_, key)) : std::nullopt;
      if (entry.second.IsNull())
        found.fail("has no value; write it behind the colon, or its own keys below it, two blanks further in");
      return found;
    }
  return std::nullopt;
}

Reader Reader::at(const std::string& key, const std::string& needed) {
  if (auto found = find(key)) return *found;
  // A misspelt key is read as what it must be: finish() then reports it together with all known keys.
  std::vector<std::string> unknown;
  for (const std::string& given : keys())
    if (std::find(requested_->keys.begin(), requested_->keys.end(), given) == requested_->keys.end())
      unknown.push_back(given);
  std::string misspelt;
  for (const std::string& given : unknown) {
    if (given.starts_with(key + ":") && given.size() > key.size() + 1)
      throw InputError(location_of_key(given), (path_.empty() ? "" : path_ + ": ") +
                                                   "a blank stands behind the colon of a key: write " + key + ": " +
                                                   given.substr(key.size() + 1));
    if (misspelt.empty() && meant_key(given, {key}) == key) misspelt = given;
  }
  if (misspelt.empty()) misspelt = nearest_name(key, unknown);
  if (misspelt.empty()) {
    for (const std::string& given : unknown)
      if (const std::string instead = instead_of_key(given); !instead.empty())
        throw InputError(location_of_key(given),
                         (path_.empty() ? "" : path_ + ": ") + "unknown key '" + given + "'; " + instead);
    const std::vector<std::string>& allowed = requested_->allowed;
    std::string other;
    for (const std::string& given : unknown)
      if (std::find(allowed.begin(), allowed.end(), given) == allowed.end() && !allowed.empty() && other.empty())
        other = "; unknown key '" + given + "' (allowed: " + joined(allowed) + ")";
    fail("key '" + key + "' is missing" + (needed.starts_with("needed, ") ? needed.substr(6) : "") + other);
  }
  requested_->misspelt.emplace_back(misspelt, key);
  return *value_of(misspelt, key);
}

void Reader::finish() const {
  if (!node_.IsMap()) return;
  std::vector<std::string> known;
  for (const std::string& key : requested_->keys)
    if (std::find(known.begin(), known.end(), key) == known.end()) known.push_back(key);
  std::vector<std::pair<YAML::Node, YAML::Node>> unknown;
  for (const auto& entry : node_)
    if (std::find(known.begin(), known.end(), entry.first.Scalar()) == known.end())
      unknown.emplace_back(entry.first, entry.second);
  if (!unknown.empty()) {
    const auto& [first, value] = unknown.front();
    std::string message = (path_.empty() ? "" : path_ + ": ") + "unknown key '" + first.Scalar() + "'" +
                          instead_of(first.Scalar(), value, known);
    for (std::size_t i = 1; i < unknown.size(); ++i) {
      const SourceLocation place = location_of(unknown[i].first);
      message += (i == 1 ? "; unknown, too: '" : ", '") + unknown[i].first.Scalar() + "'" +
                 (place.line > 0 ? " in line " + std::to_string(place.line) : "");
    }
    throw InputError(location_of(first), message);
  }
  for (const auto& [misspelt, key] : requested_->misspelt) fail("key '" + key + "' is missing");
}

/// "; write density: 1000 kg/m3 (allowed: …)": what a key that nobody knows should be, or where it belongs.
std::string Reader::instead_of(const std::string& key, const YAML::Node& value,
                               const std::vector<std::string>& known) const {
  const std::string allowed = joined(known);
  const bool short_value = value.IsScalar() && value.Scalar().size() < 40;
  if (const std::string meant = meant_key(key, known); !meant.empty())
    return "; did you mean '" + meant + "'? Write " + meant + ": " + (short_value ? value.Scalar() : "…") +
           " (allowed: " + allowed + ")";
  if (const std::string instead = instead_of_key(key); !instead.empty()) return "; " + instead;
  if (nearest_name(key, known).empty() && file_->owners) {
    const std::vector<std::string> maps = file_->owners(key);
    // A parameter of another strategy or kind has its place here already.
    const bool here = section_ && std::any_of(maps.begin(), maps.end(), [&](const std::string& map) {
                        return *section_ == map || section_->starts_with(map + ".");
                      });
    if (!here && !maps.empty())
      return "; it is a key of `" + joined(maps, "` or `") + "`: write it there (allowed here: " + allowed + ")";
  }
  return suggestion(key, known);
}

SourceLocation Reader::location_of_key(const std::string& key) const {
  for (const auto& entry : node_)
    if (entry.first.Scalar() == key) return location_of(entry.first);
  return location();
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
  return file_->source.held() ? given(key, file_->source.held()->bodies) : nullptr;
}

std::shared_ptr<const Material> Reader::given_material(const std::string& key) {
  return file_->source.held() ? given(key, file_->source.held()->materials) : nullptr;
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
  if (!node_.IsSequence()) {
    const std::string own = path_.substr(path_.find_last_of('.') + 1) + ": ";
    const std::string list = node_.IsScalar() ? as_list(node_.Scalar()) : "";
    fail("expected a list, found " + kind_of(node_) +
         (!list.empty()      ? "; write " + own + list
          : node_.IsMap()    ? "; begin each item with '- ' below the key, or write " + own + "[{…}]"
          : node_.IsScalar() ? "; write " + own + "[" + node_.Scalar() + "]"
                             : ""));
  }
  std::vector<Reader> items;
  for (const auto& item : node_) {
    items.emplace_back(file_, item, path_ + "[" + std::to_string(items.size()) + "]", location());
    items.back().section_ = section_;
  }
  return items;
}

void Reader::refuse_repeated_items() const {
  const std::vector<Reader> list = items();
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (list[i].same_as(list[j])) {
        const std::string one = list[j].line(), other = list[i].line();
        fail(one == other ? "names " + one + " twice; leave one of them out"
                          : "names " + one + " and " + other + ", which are the same; leave one of them out");
      }
}

std::vector<Reader> Reader::items(std::size_t count) const {
  std::vector<Reader> list = items();
  if (list.size() == count) return list;
  std::vector<std::string> given;
  for (const Reader& item : list) given.push_back(item.is_text() ? item.text() : "");
  std::string hint = with_decimal_points(given, count);
  if (const std::string several = given.size() == 1 ? as_list(given[0]) : ""; !several.empty())
    hint = "; commas stand between them: write " + several;
  fail("expected " + std::to_string(count) + " values, found " + std::to_string(list.size()) + hint);
}

std::string Reader::text() const {
  if (!node_.IsScalar())
    fail("expected a single value, found " + kind_of(node_) +
         (node_.IsSequence() && node_.size() > 0 && node_[0].IsScalar() ? "; write for example " + node_[0].Scalar()
                                                                        : ""));
  return node_.Scalar();
}

std::string Reader::existing_file() const {
  const std::string name = text();
  std::string path = (std::filesystem::path(file_path()).parent_path() / name).string();
  if (std::error_code ignored; !std::filesystem::exists(path, ignored))
    fail("'" + name + "': " + missing_file(path) +
         (name.find('\\') != std::string::npos ? "; folders are set apart by /" : ""));
  return path;
}

std::string Reader::line() const {
  YAML::Emitter emitter;
  emitter << YAML::Flow << without_origin(node_);
  return emitter.c_str();
}

std::string Reader::content() const {
  std::string text;
  const std::function<void(const YAML::Node&)> add = [&](const YAML::Node& node) {
    if (!node.IsMap() && !node.IsSequence()) {
      text += std::to_string(node.Scalar().size()) + " " + node.Scalar();  // the size: where it ends
      return;
    }
    text += node.IsMap() ? "{" : "[";
    for (const auto& entry : node) {
      if (node.IsSequence()) {
        add(entry);
        continue;
      }
      add(entry.first);
      add(entry.second);
      if (entry.first.Scalar() != "file" || !entry.second.IsScalar()) continue;
      const auto folder = std::filesystem::path(file_->files[file_of(entry.second)]).parent_path();
      std::ifstream stream(folder / entry.second.Scalar(), std::ios::binary);
      text += std::string(std::istreambuf_iterator<char>(stream), {});
    }
    text += node.IsMap() ? "}" : "]";
  };
  add(node_);
  return text;
}

void Reader::check_size(double molecules) const {
  if (molecules <= file_->most_molecules) return;
  char text[100];
  std::snprintf(text, sizeof text, "that is %.3g molecules; at most %g are allowed", molecules, file_->most_molecules);
  fail(text);
}

const std::vector<int>& Reader::mesh_set() const {
  const std::string name = text();
  const auto in_small_letters = [](std::string letters) {
    for (char& letter : letters) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    return letters;
  };
  std::vector<std::string> names, alike;
  for (const auto& [known, members] : file_->sets) {
    names.push_back(known);
    if (in_small_letters(known) == in_small_letters(name)) alike.push_back(known);
  }
  if (names.empty())
    fail(
        "the body has no sets: a `mesh` has those that its file names, and an `image` of cells or a lattice its "
        "labels");
  if (file_->sets.contains(name)) return file_->sets.at(name);
  if (alike.size() != 1) fail("the mesh has no set '" + name + "'" + suggestion(name, names));
  return file_->sets.at(alike[0]);
}

double Reader::quantity(const Dimension& dimension, const Range& range) const {
  const std::string given = text();
  const Quantity quantity = located([&] { return parse_quantity(given, dimension); });
  if (quantity.value < range.low || quantity.value > range.high || (range.open_low && quantity.value == range.low))
    fail("'" + given + "' is out of range: must be " + allowed_text(range, dimension) +
         (dimension == dimension::none && !quantity.has_unit && quantity.value > 1 && quantity.value > range.high &&
                  quantity.value / 100 <= range.high && range.high <= 1
              ? "; is " + given + " % meant?"
              : ""));
  if (std::abs(quantity.value) > kLargest) {
    char text[80];
    std::snprintf(text, sizeof text, "' is %.3g%s%s: values must not exceed %g", quantity.value,
                  si_unit(dimension).empty() ? "" : " ", si_unit(dimension).c_str(), kLargest);
    fail("'" + given + text);
  }
  if (dimension == dimension::none || is_override()) return quantity.value;
  if (quantity.has_unit)
    note_unit();
  else if (quantity.value != 0)
    note_plain(given, unit_examples(dimension));
  return quantity.value;
}

double Reader::angle(const Range& range) const {
  const std::string given = text();
  const double value = quantity(dimension::none, range);
  if (given.ends_with('%')) fail("'" + given + "' is a ratio, no angle; write for example 30 deg, 0.5 rad");
  const bool has_unit = parse_quantity(given, dimension::none).has_unit;
  if (!has_unit && value != 0 && !is_override()) note_plain(given, "30 deg, 0.5 rad");
  return value;
}

bool Reader::is_override() const { return config::is_override(node_); }

const std::string& Reader::file_path() const { return file_->files[file_of(node_)]; }

void Reader::note_unit() const {
  if (!file_->first_unit) file_->first_unit = location();
  check_units_agree();
}

void Reader::note_plain(const std::string& given, const std::string& examples) const {
  if (file_->source.held()) return;
  if (!file_->first_plain)
    file_->first_plain = {location(), path_ + ": '" + given + "' has no unit; write for example " + examples};
  check_units_agree();
}

/// Throws if the file writes some dimensional values with units and others as plain numbers: one of them is a mistake.
void Reader::check_units_agree() const {
  const auto& first_unit = file_->first_unit;
  const auto& first_plain = file_->first_plain;
  if (first_unit && first_plain)
    throw InputError(first_plain->first, first_plain->second +
                                             " (plain SI numbers are allowed only where no value has a unit, and " +
                                             first_unit->text() + " has one)");
}

int Reader::molecule(int count) const { return whole(0, count - 1); }

int Reader::whole(int low, int high) const {
  const std::string given = text();
  int value = 0;
  const auto [end, problem] = std::from_chars(given.data(), given.data() + given.size(), value);
  if (problem != std::errc() || end != given.data() + given.size() || value < low || value > high)
    fail("'" + given + "' is not a whole number of at least " + std::to_string(low) +
         (high < std::numeric_limits<int>::max() ? " and at most " + std::to_string(high) : "") +
         (end != given.data() && std::string_view(end).find_first_not_of(".0") == std::string_view::npos &&
                  value >= low && value <= high && *end
              ? "; write " + std::to_string(value)
              : ""));
  return value;
}

Vector3 Reader::vector(const Dimension& dimension, const Range& range) const {
  if (is_text() && as_list(text()).empty())
    fail("expected a list of three values along x, y, z, found a single value; write for example [0, 0, " + text() +
         "]");
  const auto list = items(3);
  return {list[0].quantity(dimension, range), list[1].quantity(dimension, range), list[2].quantity(dimension, range)};
}

Vector3 Reader::direction() const {
  if (!is_text()) {
    const Vector3 direction = vector(dimension::none);
    if (!(direction.norm() > 0)) fail("a direction must not be zero");
    return direction.normalized();
  }
  return choice<Vector3>({{"x", Vector3::UnitX()},
                          {"y", Vector3::UnitY()},
                          {"z", Vector3::UnitZ()},
                          {"-x", -Vector3::UnitX()},
                          {"-y", -Vector3::UnitY()},
                          {"-z", -Vector3::UnitZ()}});
}

Matrix3 Reader::rotation() const {
  Reader map = *this;
  map.set_section("rotation");
  const Vector3 axis = map.at("axis").direction();
  const double angle = map.at("angle").angle();
  map.finish();
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

std::function<double(double)> Reader::of_value(const Dimension& dimension, const Range& range) const {
  std::string given = text();
  if (given.starts_with('=')) given.erase(0, 1);
  if (!(dimension == dimension::none)) file_->first_unit ? note_unit() : note_plain(given, "value * 2 kPa");
  return [own = *this, given, range, dimension](double grey) {
    const FormulaValue result = own.located([&] {
      return formula_value(given, [&](const std::string& name) -> FormulaValue {
        if (name == "value") return {grey, dimension::none};
        const auto found = own.file_->values.find(name);
        if (found == own.file_->values.end()) throw InputError("'" + name + "' is no name here; a formula has `value`");
        return found->second;
      });
    });
    const bool plain = !own.file_->first_unit && result.unit == dimension::none;
    if (!(result.unit == dimension) && !plain) own.fail("'" + given + "' must give " + si_unit(dimension));
    if (std::isfinite(result.number) && result.number >= range.low && result.number <= range.high &&
        !(range.open_low && result.number == range.low))
      return result.number;
    own.fail("'" + given + "' is " + number_text(result.number) + " where the value is " + number_text(grey) +
             "; must be " + (allowed_text(range, dimension).empty() ? "finite" : allowed_text(range, dimension)));
  };
}

std::function<double(const Vector3&)> Reader::of_place(const Dimension& dimension, const Range& range) const {
  std::string given = text();
  if (given.starts_with('=')) given.erase(0, 1);
  const FormulaValues& values = file_->values;
  const auto unit_with = [&](const Dimension& of_place) {
    return formula_at(given, Vector3(1.3e-3, 1.7e-3, 1.9e-3), of_place, values).unit;
  };
  const auto expected = [&](const Dimension& found) {
    const auto name = [](const Dimension& unit) { return unit == dimension::none ? "a plain number" : si_unit(unit); };
    fail("'" + given + "' gives " + name(found) + ", and it must give " + name(dimension) + "; x, y and z are lengths" +
         (dimension == dimension::none ? ", for example x / 10 mm" : ""));
  };
  // x, y and z are lengths; in a scene of plain numbers they are those.
  Dimension place = dimension::length;
  if (file_->first_unit) {
    if (const Dimension found = located([&] { return unit_with(place); }); !(found == dimension)) expected(found);
  } else {
    bool lengths = false;
    try {
      lengths = unit_with(place) == dimension;
    } catch (const InputError&) {  // it may be of plain numbers
    }
    if (!lengths) place = dimension::none;
    const Dimension found = located([&] { return unit_with(place); });
    if (!(found == dimension) && !(found == dimension::none)) expected(found);
    if (!(dimension == dimension::none)) lengths ? note_unit() : note_plain(given, "(1 + x / 10 mm) * 2 kPa");
  }
  return [own = *this, given, values, place, range, dimension](const Vector3& at) {
    const double value = own.located([&] { return formula_at(given, at, place, values).number; });
    if (std::isfinite(value) && value >= range.low && value <= range.high && !(range.open_low && value == range.low))
      return value;
    char text[120] = "is out of range: must be ";
    if (own.located([&] { return formula_at(given, 2 * at + Vector3::Ones(), place, values).number; }) != value)
      std::snprintf(text, sizeof text, "is %.6g at (%.6g, %.6g, %.6g) m; must be ", value, at.x(), at.y(), at.z());
    const std::string allowed = allowed_text(range, dimension);
    own.fail("'" + given + "' " + text + (allowed.empty() ? "finite" : allowed));
  };
}

Reader Reader::open(const std::string& path) const {
  return open_scene(file_->source.other(path), {}, file_->most_molecules);
}

Reader open_scene(const SceneSource& source, const std::vector<std::string>& overrides, double most_molecules) {
  SceneTree tree = load_scene_tree(source, overrides);
  SceneFile file{source.path(), {}, {}, most_molecules, source};
  file.files = std::move(tree.files);
  file.values = std::move(tree.values);
  return {std::make_shared<SceneFile>(std::move(file)), tree.root, ""};
}

}  // namespace elastin::config
