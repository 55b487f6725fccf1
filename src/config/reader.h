#pragma once
#include <yaml-cpp/yaml.h>

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/key_rows.h"
#include "config/scene_text.h"
#include "config/scene_tree.h"
#include "core/base/named.h"
#include "elastin/config/scene_source.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/types.h"
#include "elastin/core/base/units.h"
#include "elastin/core/forces/time_function.h"

namespace elastin::config {

/// What all keys of one scene file share: its path, and how its dimensional values are written.
struct SceneFile {
  std::string path;
  std::optional<SourceLocation> first_unit;  ///< first dimensional value written with a unit
  /// First one written as a plain number, and the message that it is if units are used.
  std::optional<std::pair<SourceLocation, std::string>> first_plain;
  double most_molecules = std::numeric_limits<double>::infinity();  ///< that a body may have
  SceneSource source = {};
  std::map<std::string, std::vector<int>> sets = {};  ///< of molecules, ascending, as the body's mesh names them
  std::vector<std::string> files = {};                ///< the scene's own, and those that it extends
  FormulaValues values = {};                          ///< of the section `values`
  std::vector<TimeFunction> time_functions = {};      ///< those that were read
  /// The sections of the key reference that have a key; none where nobody knows.
  std::function<std::vector<std::string>(const std::string& key)> owners = {};
};

struct Range {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool open_low = false;  ///< low itself is not allowed
};
inline constexpr Range kPositive{0, std::numeric_limits<double>::infinity(), true};
inline constexpr Range kNotNegative{0, std::numeric_limits<double>::infinity(), false};

/// One value of a scene with its path of keys and its position in the file. Maps note which keys were requested, so
/// that finish() can name the ones that no reader knows.
class Reader {
 public:
  Reader(std::shared_ptr<SceneFile> file, const YAML::Node& node, std::string path,
         std::optional<SourceLocation> key_location = {});
  /// Who knows which sections have which keys: for messages about a key in the wrong place.
  void set_owners(std::function<std::vector<std::string>(const std::string& key)> owners) {
    file_->owners = std::move(owners);
  }

  bool has(const std::string& key);
  /// The value of a key that must be there; throws InputError if it is not. A misspelt one is read too: finish() names
  /// it. `needed`: the reference's words for that, of which the message has what stands in the key's place: "needed, or
  /// `molecules`".
  Reader at(const std::string& key, const std::string& needed = "");
  std::optional<Reader> find(const std::string& key);
  /// The section of the key reference that lists this map's keys: of maps that stand under several keys, or whose keys
  /// depend on their kind. Without it the section is the path of keys.
  void set_section(const std::string& section) { section_ = section; }
  /// States all keys that the map may have, so that a message about a missing one names what stands there instead.
  void allow(std::vector<std::string> keys) { requested_->allowed = std::move(keys); }
  /// Throws InputError on the first key that was never requested, with the nearest one that was.
  void finish() const;

  bool is_map() const { return node_.IsMap(); }
  bool is_list() const { return node_.IsSequence(); }
  bool is_text() const { return node_.IsScalar(); }
  std::vector<std::string> keys() const;
  /// Of a scene in memory: what `key: NUMBER` of this map names in its list; null where the map has no such key.
  std::shared_ptr<const Body> given_body(const std::string& key);
  std::shared_ptr<const Material> given_material(const std::string& key);
  /// All keys with their values, of a map whose keys are free.
  std::vector<std::pair<std::string, Reader>> entries() const;
  std::vector<Reader> items() const;
  std::vector<Reader> items(std::size_t count) const;
  /// Whether it says the same as another value, whatever their units: 5 mm and 0.005 m.
  bool same_as(const Reader& other) const { return same_value(node_, other.node_); }
  /// Fails where two items of this list say the same.
  void refuse_repeated_items() const;

  std::string text() const;
  /// The path of the file that this value names, from the folder of the file that it stands in. Throws InputError if
  /// it does not exist.
  std::string existing_file() const;
  /// The value as one line of YAML, whatever it is: what --set can put elsewhere.
  std::string line() const;
  /// The value as a text with the bytes of the files that are named under `file` in it: equal texts mean the same.
  std::string content() const;
  /// In SI units. Throws if it has no unit although other values of the file have one, or vice versa.
  double quantity(const Dimension& dimension, const Range& range = {}) const;
  /// A plane angle [rad]. It has a unit where other values of the file have one; a scene of plain numbers may write
  /// both radians and "30 deg".
  double angle(const Range& range = {}) const;
  int whole(int low, int high = std::numeric_limits<int>::max()) const;
  /// The number of a molecule: 0 to count - 1.
  int molecule(int count) const;
  Vector3 vector(const Dimension& dimension, const Range& range = {}) const;
  /// A unit vector: "x", "-y", or a list of three numbers that are not all 0.
  Vector3 direction() const;
  /// {axis: DIRECTION, angle: ANGLE}, right-handed.
  Matrix3 rotation() const;
  /// A formula of the place x, y, z at rest [m]: its value in SI units. The function throws InputError where that is
  /// not in range.
  std::function<double(const Vector3& place)> of_place(const Dimension& dimension, const Range& range = {}) const;
  /// A formula of `value`, a plain number, in the same way.
  std::function<double(double value)> of_value(const Dimension& dimension, const Range& range = {}) const;
  /// A word out of a fixed set.
  template <class Value>
  Value choice(const std::vector<std::pair<std::string, Value>>& choices) const {
    const std::string word = text();
    for (const auto& [name, value] : choices)
      if (name == word) return value;
    fail("'" + word + "' is not known here" +
         suggested_word(word, names_of(choices, [](const auto& choice) { return choice.first; })));
  }

  /// The molecules of the mesh's set of this name; a scene has that of its one body.
  const std::vector<int>& mesh_set() const;
  const std::map<std::string, std::vector<int>>& mesh_sets() const { return file_->sets; }
  void set_mesh_sets(std::map<std::string, std::vector<int>> sets) { file_->sets = std::move(sets); }

  /// Fails where a body would have more molecules than are allowed, before memory is allocated for them.
  void check_size(double molecules) const;
  double most_molecules() const { return file_->most_molecules; }
  /// Throws InputError with this value's position and key.
  [[noreturn]] void fail(const std::string& message) const;
  /// Runs build() and puts this value's position and key before an error that has none.
  template <class Build>
  auto located(Build&& build) const {
    try {
      return build();
    } catch (const InputError& error) {
      if (error.has_location()) throw;
      fail(error.what());
    }
  }
  const std::string& path() const { return path_; }
  /// The file that this value stands in: the scene's, or one that it extends.
  const std::string& file_path() const;
  const SceneSource& source() const { return file_->source; }
  /// Notes a function of time that something of the scene follows, so that steps see how it changes.
  void note(const TimeFunction& function) const { file_->time_functions.push_back(function); }
  /// All that were noted in this file.
  const std::vector<TimeFunction>& time_functions() const { return file_->time_functions; }
  /// A scene file that this one names.
  Reader open(const std::string& path) const;
  /// Whether the values read so far were plain SI numbers; a scene has these or units.
  bool plain() const { return file_->first_plain.has_value(); }

 private:
  /// Keys that were requested, those that the map may have as far as that is known beforehand, and those that stood in
  /// for a missing one: as written, and as meant.
  struct Requested {
    std::vector<std::string> keys;
    std::vector<std::string> allowed;
    std::vector<std::pair<std::string, std::string>> misspelt;
  };
  template <class Thing>
  std::shared_ptr<const Thing> given(const std::string& key, const std::vector<std::shared_ptr<const Thing>>& list);
  SourceLocation location() const;
  SourceLocation location_of_key(const std::string& key) const;
  std::string instead_of(const std::string& key, const YAML::Node& value, const std::vector<std::string>& known) const;
  SourceLocation location_of(const YAML::Node& node) const;
  std::optional<Reader> value_of(const std::string& given, const std::string& key) const;
  bool is_override() const;
  void note_unit() const;
  void note_plain(const std::string& given, const std::string& examples) const;
  void check_units_agree() const;
  std::shared_ptr<SceneFile> file_;
  YAML::Node node_;
  std::string path_;  ///< "experiment.force"
  std::optional<std::string> section_ =
      "";  ///< "experiment.tension.force": in the key reference; none where keys are free
  std::optional<SourceLocation> key_location_;
  std::shared_ptr<Requested> requested_ = std::make_shared<Requested>();
};

/// Reads a scene's YAML and puts `key.path=value` overrides in. Throws InputError: file:line:column.
Reader open_scene(const SceneSource& source, const std::vector<std::string>& overrides, double most_molecules);

}  // namespace elastin::config
