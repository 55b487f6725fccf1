#pragma once
#include <array>
#include <concepts>
#include <functional>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "config/key_rows.h"
#include "config/reader.h"

namespace elastin::config {

/// Where a map's directions are read: each is turned by the rotation, which is the scene's.
struct Frame {
  Matrix3 rotation = Matrix3::Identity();
  const Body* body = nullptr;  ///< whose molecules a key may pick; null: none may be picked
};

/// One key of a map. It sets a member of `Setup`, and is said once: its rows in the key reference, how its value is
/// read, and which values are refused.
template <class Setup>
class Key {
 public:
  using Read = std::function<void(const Reader& value, Setup&, const Frame&)>;
  /// Says in words what is wrong with a setup of which all keys are read; "" if nothing is.
  using Fault = std::function<std::string(const Setup&)>;
  using Condition = std::function<bool(const Setup&)>;

  Key(SceneKey row, Read read, std::function<void(Setup&, const Frame&)> absent = {})
      : name_(row.name), rows_{std::move(row)}, read_(std::move(read)), absent_(std::move(absent)) {}
  /// A key with keys of its own below it, in whose rows its name stands before theirs.
  Key(std::string name, std::vector<SceneKey> rows, Read read)
      : name_(std::move(name)), rows_(std::move(rows)), read_(std::move(read)) {}
  /// A key of what this setup is made of.
  template <class Base>
  requires(std::derived_from<Setup, Base> && !std::same_as<Setup, Base>) Key(const Key<Base>& other)
      : name_(other.name()),
        rows_(other.rows()),
        read_([other](const Reader& value, Setup& setup, const Frame& frame) { other.read(value, setup, frame); }),
        absent_([other](Setup& setup, const Frame& frame) { other.read(std::nullopt, setup, frame); }),
        needed_(other.is_needed()) {
    if (other.fault()) fault_ = other.fault();
    if (other.condition()) condition_ = other.condition();
  }

  /// A map without the key is refused.
  Key needed() && { return std::move(*this).needed("needed"); }
  /// The same, with other words for it in the reference.
  Key needed(std::string words) && {
    needed_ = true;
    return std::move(*this).otherwise(std::move(words));
  }
  /// What counts where the key is missing, in the reference's words.
  Key otherwise(std::string words) && {
    rows_.front().fallback = std::move(words);
    return std::move(*this);
  }
  /// Calls `check` before the value is read; it may fail at the value.
  Key first(std::function<void(const Reader& value)> check) && {
    read_ = [read = std::move(read_), check = std::move(check)](const Reader& value, Setup& setup, const Frame& frame) {
      check(value);
      read(value, setup, frame);
    };
    return std::move(*this);
  }
  /// Calls `next` when the value has been read; it may change the setup and fail at the value.
  Key then(std::function<void(const Reader& value, Setup&)> next) && {
    read_ = [read = std::move(read_), next = std::move(next)](const Reader& value, Setup& setup, const Frame& frame) {
      read(value, setup, frame);
      next(value, setup);
    };
    return std::move(*this);
  }
  /// Keeps where the value stands, for messages when more is known.
  Key place(std::optional<Reader> Setup::*member) && {
    return std::move(*this).then([member](const Reader& value, Setup& setup) { setup.*member = value; });
  }
  /// The map has this key only where the condition holds for the keys before it.
  Key when(Condition condition) && {
    condition_ = std::move(condition);
    return std::move(*this);
  }
  /// Fails at the value if the key is given, and otherwise at the map, where the whole setup has this fault.
  Key refused_for(Fault fault) && {
    fault_ = std::move(fault);
    return std::move(*this);
  }

  const std::string& name() const { return name_; }
  bool is_needed() const { return needed_; }
  const std::vector<SceneKey>& rows() const { return rows_; }
  const Fault& fault() const { return fault_; }
  const Condition& condition() const { return condition_; }
  bool belongs_to(const Setup& setup) const { return !condition_ || condition_(setup); }
  void read(const std::optional<Reader>& value, Setup& setup, const Frame& frame) const {
    if (value)
      read_(*value, setup, frame);
    else if (absent_)
      absent_(setup, frame);
  }

 private:
  std::string name_;
  std::vector<SceneKey> rows_;
  Read read_;
  std::function<void(Setup&, const Frame&)> absent_;
  Fault fault_;
  Condition condition_;
  bool needed_ = false;
};

/// Keys that stand in each other's place.
template <class Setup>
struct KeyGroup {
  std::vector<Key<Setup>> keys;
  std::string message;  ///< where none of them is given
  bool only_one = true;
};

/// Exactly one of these keys is given.
template <class Setup>
KeyGroup<Setup> one_of(std::string message, std::vector<Key<Setup>> keys) {
  std::vector<Key<Setup>> group;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::string words = keys.size() == 2
                                  ? "this, or `" + keys[1 - i].name() + "`"
                                  : std::string("one of ") + (keys.size() == 3 ? "three" : "four") + " needed";
    group.push_back(Key<Setup>(keys[i]).otherwise(words));
  }
  return {std::move(group), std::move(message)};
}

/// One or both of two keys are given.
template <class Setup>
KeyGroup<Setup> any_of(std::string message, std::vector<Key<Setup>> keys) {
  std::vector<Key<Setup>> group;
  for (std::size_t i = 0; i < keys.size(); ++i)
    group.push_back(Key<Setup>(keys[i]).otherwise("this, `" + keys[1 - i].name() + "` or both"));
  return {std::move(group), std::move(message), false};
}

/// All keys of a map that is read into a `Setup`, in the order of the reference.
template <class Setup>
class Keys {
 public:
  /// A key, a group of keys, or all keys of another table.
  class Entry {
   public:
    Entry(Key<Setup> key) : keys_{std::move(key)} {}
    template <class Base>
    requires(std::derived_from<Setup, Base> && !std::same_as<Setup, Base>) Entry(const Key<Base>& key)
        : keys_{Key<Setup>(key)} {}
    Entry(KeyGroup<Setup> group)
        : keys_(std::move(group.keys)), message_(std::move(group.message)), only_one_(group.only_one) {}

   private:
    friend class Keys;
    std::vector<Key<Setup>> keys_;
    std::string message_ = {};
    bool only_one_ = false;
  };

  Keys(std::initializer_list<Entry> entries) : entries_(entries) {}
  explicit Keys(std::vector<Entry> entries) : entries_(std::move(entries)) {}

  std::vector<SceneKey> rows() const {
    std::vector<SceneKey> rows;
    for (const Entry& entry : entries_)
      for (const Key<Setup>& key : entry.keys_) rows.insert(rows.end(), key.rows().begin(), key.rows().end());
    return rows;
  }

  /// Reads a whole map: what it does not say stays as `setup` has it. Throws InputError with place and key on a key
  /// that is not among these, on one that is missing, and on what a key refuses. A member `place` of the setup, a
  /// std::optional<Reader>, is where the map stands.
  Setup read(Reader map, const Frame& frame = {}, Setup setup = {}) const {
    if constexpr (requires { setup.place = map; }) setup.place = map;
    read_into(map, setup, frame);
    map.finish();
    check(map, setup);
    return setup;
  }
  /// The same of a map that has other keys too: the caller finishes it, and then calls `check`.
  void read_into(Reader& map, Setup& setup, const Frame& frame = {}) const {
    for (const Entry& entry : entries_)
      for (const Key<Setup>& key : entry.keys_)
        if (key.belongs_to(setup))
          key.read(key.is_needed() ? std::optional(map.at(key.name())) : map.find(key.name()), setup, frame);
  }
  /// Lets `map.finish()` know all keys, where none is read.
  void add_to_known(Reader& map) const {
    for (const Entry& entry : entries_)
      for (const Key<Setup>& key : entry.keys_) map.has(key.name());
  }
  void check(Reader& map, const Setup& setup) const {
    for (const Entry& entry : entries_) {
      std::string given;
      for (const Key<Setup>& key : entry.keys_) {
        if (!key.belongs_to(setup)) continue;
        const std::optional<Reader> value = map.find(key.name());
        if (value && entry.only_one_ && !given.empty())
          value->fail("there is a " + given + " already; give one of them");
        if (value) given = key.name();
        if (!key.fault()) continue;
        if (const std::string fault = key.fault()(setup); !fault.empty()) (value ? *value : map).fail(fault);
      }
      if (!entry.message_.empty() && given.empty()) map.fail(entry.message_);
    }
  }

 private:
  std::vector<Entry> entries_;
};

/// The kinds of keys. `member` may be a std::optional of what is read. Defaults in the reference are those of Setup{}.
namespace key {

template <class Value>
struct value_type {
  using type = Value;
  static constexpr bool optional = false;
};
template <class Value>
struct value_type<std::optional<Value>> {
  using type = Value;
  static constexpr bool optional = true;
};

/// The reference's words for the value that a new Setup has: "none" of an empty std::optional.
template <class Setup, class Member, class Words>
std::string default_of(Member Setup::*member, const Words& words) {
  const Setup setup{};
  if constexpr (value_type<Member>::optional)
    return setup.*member ? words(*(setup.*member)) : "none";
  else
    return words(setup.*member);
}

/// A number with a unit, or a plain number if it has no dimension.
template <class Setup, class Member>
Key<Setup> quantity(std::string name, Member Setup::*member, const Dimension& unit, std::string text,
                    const Range& range = {}) {
  return {{std::move(name), unit == dimension::none ? "number" : "quantity", si_unit(unit),
           range_text(range.low, range.high, range.open_low), default_of(member, number_text), std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame&) { setup.*member = value.quantity(unit, range); }};
}

/// A plane angle [rad].
template <class Setup, class Member>
Key<Setup> angle(std::string name, Member Setup::*member, std::string text, const Range& range = {}) {
  return {{std::move(name), "angle", "", range_text(range.low, range.high, range.open_low),
           default_of(member, number_text), std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame&) { setup.*member = value.angle(range); }};
}

/// Without an upper limit where `high` is the largest int.
inline std::string whole_range_text(int low, int high) {
  const bool bounded = high < std::numeric_limits<int>::max();
  return range_text(low, bounded ? high : std::numeric_limits<double>::infinity(), false);
}

template <class Setup, class Member>
Key<Setup> whole(std::string name, Member Setup::*member, int low, int high, std::string text) {
  return {{std::move(name), "whole", "", whole_range_text(low, high), default_of(member, number_text), std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame&) { setup.*member = value.whole(low, high); }};
}
/// A whole number without an upper limit.
template <class Setup, class Member>
Key<Setup> whole(std::string name, Member Setup::*member, int low, std::string text) {
  return whole(std::move(name), member, low, std::numeric_limits<int>::max(), std::move(text));
}

/// Two or three whole numbers.
template <class Setup, std::size_t size>
Key<Setup> wholes(std::string name, std::array<int, size> Setup::*member, int low, int high, std::string text) {
  return {{std::move(name), size == 2 ? "two wholes" : "three wholes", "", whole_range_text(low, high), "none",
           std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame&) {
            const std::vector<Reader> items = value.items(size);
            for (std::size_t i = 0; i < size; ++i) (setup.*member)[i] = items[i].whole(low, high);
          }};
}
template <class Setup, std::size_t size>
Key<Setup> wholes(std::string name, std::array<int, size> Setup::*member, int low, std::string text) {
  return wholes(std::move(name), member, low, std::numeric_limits<int>::max(), std::move(text));
}

template <class Setup, class Member>
Key<Setup> text(std::string name, Member Setup::*member, std::string text) {
  return {{std::move(name), "text", "", "", "none", std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame&) { setup.*member = value.text(); }};
}

/// The name of a file that exists: its path, from the folder of the file that the value stands in.
template <class Setup>
Key<Setup> file(std::string name, std::string Setup::*member, std::string text) {
  return {{std::move(name), "file next to the scene", "", "", "none", std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame&) { setup.*member = value.existing_file(); }};
}

/// One of some words, each with what it means.
template <class Setup, class Member>
Key<Setup> choice(std::string name, Member Setup::*member,
                  std::vector<std::pair<std::string, typename value_type<Member>::type>> words, std::string text) {
  std::vector<std::string> names;
  for (const auto& word : words) names.push_back(word.first);
  const auto word_of = [&](const auto& meant) {
    for (const auto& word : words)
      if (word.second == meant) return "`" + word.first + "`";
    return std::string("none");
  };
  return {{std::move(name), words_text(names), "", "", default_of(member, word_of), std::move(text)},
          [=, words = std::move(words)](const Reader& value, Setup& setup, const Frame&) {
            setup.*member = value.choice(words);
          }};
}

template <class Setup, class Member>
Key<Setup> flag(std::string name, Member Setup::*member, std::string text) {
  return choice(std::move(name), member, {{"true", true}, {"false", false}}, std::move(text));
}

/// A unit vector, turned with the scene: "x", "-y" or three numbers.
template <class Setup, class Member>
Key<Setup> direction(std::string name, Member Setup::*member, std::string text) {
  return {{std::move(name), "direction", "", "", default_of(member, direction_text), std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame& frame) {
            setup.*member = Vector3(frame.rotation * value.direction());
          },
          [=](Setup& setup, const Frame& frame) {  // the default is a direction of the scene, too
            if constexpr (!value_type<Member>::optional)
              setup.*member = Vector3(frame.rotation * setup.*member);
            else if (setup.*member)
              setup.*member = Vector3(frame.rotation * *(setup.*member));
          }};
}

/// Three values along x, y, z, turned with the scene.
template <class Setup, class Member>
Key<Setup> vector(std::string name, Member Setup::*member, const Dimension& unit, std::string text,
                  const Range& range = {}) {
  return {{std::move(name), "vector", si_unit(unit), range_text(range.low, range.high, range.open_low), "none",
           std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame& frame) {
            setup.*member = Vector3(frame.rotation * value.vector(unit, range));
          }};
}

/// {axis: DIRECTION, angle: ANGLE}, turned with the scene.
template <class Setup, class Member>
Key<Setup> rotation(std::string name, Member Setup::*member, std::string text) {
  return {{std::move(name), "rotation", "", "", "none", std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame& frame) {
            setup.*member = Matrix3(frame.rotation * value.rotation() * frame.rotation.transpose());
          }};
}

/// Rows of a map, or of the items of a list of maps, with the key's name before theirs. No text: no row of its own.
template <class Inner>
std::vector<SceneKey> rows_below(const std::string& name, std::string type, std::string text, const Keys<Inner>& keys) {
  std::vector<SceneKey> rows;
  if (!text.empty()) rows.push_back({name, std::move(type), "", "", "none", std::move(text)});
  for (SceneKey row : keys.rows()) {
    row.name = name + "." + row.name;
    rows.push_back(std::move(row));
  }
  return rows;
}

template <class Setup, class Member>
Key<Setup> map(std::string name, Member Setup::*member, Keys<typename value_type<Member>::type> keys,
               std::string text = "") {
  std::vector<SceneKey> rows = rows_below(name, "map", std::move(text), keys);
  return {std::move(name), std::move(rows),
          [=, keys = std::move(keys)](const Reader& value, Setup& setup, const Frame& frame) {
            setup.*member = keys.read(value, frame);
          }};
}

template <class Setup, class Inner>
Key<Setup> maps(std::string name, std::vector<Inner> Setup::*member, Keys<Inner> keys, std::string text) {
  std::vector<SceneKey> rows = rows_below(name, "list of maps", std::move(text), keys);
  return {std::move(name), std::move(rows),
          [=, keys = std::move(keys)](const Reader& value, Setup& setup, const Frame& frame) {
            for (const Reader& item : value.items()) (setup.*member).push_back(keys.read(item, frame));
          }};
}

/// A map that sets members of the same setup.
template <class Setup>
Key<Setup> below(std::string name, Keys<Setup> keys, std::string text = "") {
  std::vector<SceneKey> rows = rows_below(name, "map", std::move(text), keys);
  return {std::move(name), std::move(rows),
          [keys = std::move(keys)](const Reader& value, Setup& setup, const Frame& frame) {
            Reader map = value;
            keys.read_into(map, setup, frame);
            map.finish();
            keys.check(map, setup);
          }};
}

}  // namespace key

}  // namespace elastin::config
