#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "config/key_rows.h"
#include "config/reader.h"
#include "core/base/named.h"

namespace elastin::config {

/// Where a map's directions are read: each is turned by the rotation, which is the scene's.
struct Frame {
  Matrix3 rotation = Matrix3::Identity();
  const Body* body = nullptr;  ///< whose molecules a key may pick; null: none may be picked
};

/// One key of a map that is read into some object: what does not depend on the object's type, compiled once.
class AnyKey {
 public:
  using Read = std::function<void(const Reader& value, void* setup, const Frame&)>;
  using Absent = std::function<void(void* setup, const Frame&)>;
  using Fault = std::function<std::string(const void* setup)>;
  using Condition = std::function<bool(const void* setup)>;

  const std::string& name() const { return name_; }
  const std::vector<SceneKey>& rows() const { return *rows_; }
  bool is_needed(const void* setup) const { return needed_ && needed_(setup); }
  bool belongs_to(const void* setup) const { return !condition_ || condition_(setup); }
  std::string fault_of(const void* setup) const { return fault_ ? fault_(setup) : ""; }
  void read(const std::optional<Reader>& value, void* setup, const Frame& frame) const;

 protected:
  AnyKey(SceneKey row, Read read, Absent absent);
  AnyKey(std::string name, std::vector<SceneKey> rows, Read read);
  /// A key of a part of the object.
  AnyKey(AnyKey key, void* (*part)(void*));
  void set_fallback(std::string words);
  void read_first(std::function<void(const Reader& value)> check);
  void read_then(Read next);
  Fault fault_;
  Condition condition_, needed_;

 private:
  std::string name_;
  std::shared_ptr<std::vector<SceneKey>> rows_;  ///< copies share them, for they are most of a key
  Read read_;
  Absent absent_;
};

/// One key of a map. It sets a member of `Setup`, and is said once: its rows in the key reference, how its value is
/// read, and which values are refused.
template <class Setup>
class Key : public AnyKey {
 public:
  /// `reads(const Reader& value, Setup&, const Frame&)` may leave the frame out; `absent(Setup&, const Frame&)` is
  /// called where the key is missing.
  template <class Reads>
  Key(SceneKey row, Reads reads) : AnyKey(std::move(row), with_frame(std::move(reads)), {}) {}
  template <class Reads, class Missing>
  Key(SceneKey row, Reads reads, Missing absent)
      : AnyKey(std::move(row), with_frame(std::move(reads)),
               [absent = std::move(absent)](void* setup, const Frame& frame) {
                 absent(*static_cast<Setup*>(setup), frame);
               }) {}
  /// A key with keys of its own below it, in whose rows its name stands before theirs.
  template <class Reads>
  Key(std::string name, std::vector<SceneKey> rows, Reads reads)
      : AnyKey(std::move(name), std::move(rows), with_frame(std::move(reads))) {}
  /// A key of what this setup is made of.
  template <class Base>
  requires(std::derived_from<Setup, Base> && !std::same_as<Setup, Base>) Key(Key<Base> key)
      : AnyKey(std::move(key), [](void* setup) -> void* { return static_cast<Base*>(static_cast<Setup*>(setup)); }) {}

  /// A map without the key is refused.
  Key needed() && { return std::move(*this).needed("needed"); }
  /// The same, with other words for it in the reference.
  Key needed(std::string words) && {
    needed_ = [](const void*) { return true; };
    return std::move(*this).otherwise(std::move(words));
  }
  /// The same, of a map for which `condition(const Setup&)` holds for the keys before it.
  template <class Holds>
  Key needed_if(Holds condition, std::string words) && {
    needed_ = of_setup<bool>(std::move(condition));
    return std::move(*this).otherwise(std::move(words));
  }
  Key optional() && {
    needed_ = {};
    return std::move(*this);
  }
  /// What counts where the key is missing, in the reference's words.
  Key otherwise(std::string words) && {
    set_fallback(std::move(words));
    return std::move(*this);
  }
  /// A map for which the condition does not hold has no such key, and any other must have it.
  template <class Holds>
  Key needed_when(Holds condition, std::string words) && {
    condition_ = needed_ = of_setup<bool>(std::move(condition));
    return std::move(*this).otherwise(std::move(words));
  }
  /// Calls `check` before the value is read; it may fail at the value.
  Key first(std::function<void(const Reader& value)> check) && {
    read_first(std::move(check));
    return std::move(*this);
  }
  /// Calls `next` when the value has been read, as it is read; it may change the setup and fail at the value.
  template <class Next>
  Key then(Next next) && {
    read_then(with_frame(std::move(next)));
    return std::move(*this);
  }
  /// Keeps where the value stands, for messages when more is known.
  Key place(std::optional<Reader> Setup::*member) && {
    return std::move(*this).then([member](const Reader& value, Setup& setup) { setup.*member = value; });
  }
  /// The map has this key only where `condition(const Setup&)` holds for the keys before it.
  template <class Holds>
  Key when(Holds condition) && {
    condition_ = of_setup<bool>(std::move(condition));
    return std::move(*this);
  }
  /// The map has this key only together with another.
  template <class Value>
  Key when(std::optional<Value> Setup::*other) && {
    return std::move(*this).when([other](const Setup& setup) { return (setup.*other).has_value(); });
  }
  /// `fault(const Setup&)` says in words what is wrong with a setup of which all keys are read, "" if nothing is. Fails
  /// at the value if the key is given, and otherwise at the map.
  template <class Says>
  Key refused_for(Says fault) && {
    fault_ = of_setup<std::string>(std::move(fault));
    return std::move(*this);
  }

  void read(const std::optional<Reader>& value, Setup& setup, const Frame& frame) const {
    AnyKey::read(value, &setup, frame);
  }

 private:
  template <class Reads>
  static Read with_frame(Reads reads) {
    return [reads = std::move(reads)](const Reader& value, void* setup, const Frame& frame) {
      if constexpr (std::is_invocable_v<const Reads&, const Reader&, Setup&, const Frame&>)
        reads(value, *static_cast<Setup*>(setup), frame);
      else
        reads(value, *static_cast<Setup*>(setup));
    };
  }
  template <class Result, class Function>
  static std::function<Result(const void*)> of_setup(Function function) {
    return [function = std::move(function)](const void* setup) -> Result {
      return std::invoke(function, *static_cast<const Setup*>(setup));
    };
  }
};

/// Keys that stand in each other's place.
template <class Setup>
struct KeyGroup {
  std::vector<Key<Setup>> keys = {};
  std::string message = {};  ///< of a map with none of them
  bool only_one = true;
  std::string several = message;  ///< of a map with two of them; empty: the second one is refused for the first

  /// The second of two is refused for the first: the message does not name them all.
  KeyGroup naming_the_second() && {
    several.clear();
    return std::move(*this);
  }
};

/// What the reference has of a key that stands in the place of others: "this, or `molecules`", "one of three needed".
std::string one_of_words(std::size_t count, const std::string& other);

/// Exactly one of these keys is given.
template <class Setup>
KeyGroup<Setup> one_of(std::string message, std::vector<Key<Setup>> keys) {
  for (std::size_t i = 0; i < keys.size(); ++i)
    keys[i] = std::move(keys[i]).otherwise(one_of_words(keys.size(), keys[i == 0].name()));
  return {std::move(keys), std::move(message)};
}

/// One or both of two keys are given.
template <class Setup>
KeyGroup<Setup> any_of(std::string message, std::vector<Key<Setup>> keys) {
  for (std::size_t i = 0; i < keys.size(); ++i)
    keys[i] = std::move(keys[i]).otherwise("this, `" + keys[i == 0].name() + "` or both");
  return {std::move(keys), std::move(message), false};
}

/// All keys of a map that is read into some object, in the order of the reference: what does not depend on its type.
/// Copies share them.
class AnyKeys {
 public:
  /// A key, a group of keys, or all keys of another table.
  struct Entry {
    explicit Entry(AnyKey key);
    Entry(std::vector<AnyKey> all, std::string none_given, std::string several_given, bool only_one_may_be);
    std::shared_ptr<const std::vector<AnyKey>> keys;
    std::string message = {}, several = {};  ///< of a map with none of them, and with two
    bool only_one = false;
  };

  std::vector<SceneKey> rows() const;
  const std::string& first_name() const { return entries_->front().keys->front().name(); }
  std::vector<std::string> names() const;
  /// Lets `map.finish()` know all keys, where none is read.
  void add_to_known(Reader& map) const;

 protected:
  explicit AnyKeys(std::vector<Entry> entries)
      : entries_(std::make_shared<const std::vector<Entry>>(std::move(entries))) {}
  void read_any(Reader& map, void* setup, const Frame& frame) const;
  void check_any(Reader& map, const void* setup) const;

 private:
  std::shared_ptr<const std::vector<Entry>> entries_;
};

/// The same of a map that is read into a `Setup`.
template <class Setup>
class Keys : public AnyKeys {
 public:
  class Entry : public AnyKeys::Entry {
   public:
    Entry(Key<Setup> key) : AnyKeys::Entry(std::move(key)) {}
    template <class Base>
    requires(std::derived_from<Setup, Base> && !std::same_as<Setup, Base>) Entry(Key<Base> key)
        : Entry(Key<Setup>(std::move(key))) {}
    Entry(const std::vector<Key<Setup>>& list) : AnyKeys::Entry({list.begin(), list.end()}, "", "", false) {}
    Entry(const KeyGroup<Setup>& group)
        : AnyKeys::Entry({group.keys.begin(), group.keys.end()}, group.message, group.several, group.only_one) {}
  };

  Keys(std::initializer_list<Entry> entries) : AnyKeys({entries.begin(), entries.end()}) {}
  explicit Keys(const std::vector<Entry>& entries) : AnyKeys({entries.begin(), entries.end()}) {}

  /// Reads a whole map: what it does not say stays as `setup` has it. Throws InputError with place and key on a key
  /// that is not among these, on one that is missing, and on what a key refuses. A member `place` of the setup, a
  /// std::optional<Reader>, is where the map stands.
  Setup read(Reader map, const Frame& frame = {}, Setup setup = {}) const {
    if constexpr (requires { setup.place = map; }) setup.place = map;
    map.allow(names());
    read_into(map, setup, frame);
    map.finish();
    check(map, setup);
    return setup;
  }
  /// The same of a map that has other keys too: the caller finishes it, and then calls `check`.
  void read_into(Reader& map, Setup& setup, const Frame& frame = {}) const { read_any(map, &setup, frame); }
  void check(Reader& map, const Setup& setup) const { check_any(map, &setup); }
};

/// A map of one of several forms: of the one whose first key it has, or else of the last.
template <class Setup>
class Forms {
 public:
  Forms(std::initializer_list<Keys<Setup>> forms) : forms_(forms) {}

  std::vector<SceneKey> rows() const {
    std::vector<SceneKey> rows;
    for (const Keys<Setup>& form : forms_)
      for (SceneKey& row : form.rows()) rows.push_back(std::move(row));
    return rows;
  }
  Setup read(Reader map, const Frame& frame = {}, Setup setup = {}) const {
    const std::vector<std::string> given = map.keys();
    const auto own = std::find_if(forms_.begin(), forms_.end() - 1, [&](const Keys<Setup>& form) {
      return std::find(given.begin(), given.end(), form.first_name()) != given.end();
    });
    return own->read(std::move(map), frame, std::move(setup));
  }

 private:
  std::vector<Keys<Setup>> forms_;
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

/// "none" of a number out of its own range, which stands for no value.
inline std::string number_in_range(double value, const Range& range) {
  const bool in_range = value >= range.low && value <= range.high && !(range.open_low && value == range.low);
  return in_range ? number_text(value) : "none";
}

/// A number with a unit, or a plain number if it has no dimension.
template <class Setup, class Member>
Key<Setup> quantity(std::string name, Member Setup::*member, const Dimension& unit, std::string text,
                    const Range& range = {}) {
  return {{std::move(name), unit == dimension::none ? "number" : "quantity", si_unit(unit),
           range_text(range.low, range.high, range.open_low),
           default_of(member, [&](double value) { return number_in_range(value, range); }), std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame&) { setup.*member = value.quantity(unit, range); }};
}

/// Two or three of them.
template <class Setup, std::size_t size>
Key<Setup> quantities(std::string name, std::array<double, size> Setup::*member, const Dimension& unit,
                      std::string text, const Range& range = {}) {
  return {{std::move(name), size == 2 ? "two quantities" : "three quantities", si_unit(unit),
           range_text(range.low, range.high, range.open_low), "none", std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame&) {
            const std::vector<Reader> items = value.items(size);
            for (std::size_t i = 0; i < size; ++i) (setup.*member)[i] = items[i].quantity(unit, range);
          }};
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
  return {{std::move(name), "whole", "", whole_range_text(low, high),
           default_of(member, [&](int value) { return value < low || value > high ? "none" : number_text(value); }),
           std::move(text)},
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

/// A value that is read when more is known.
template <class Setup>
Key<Setup> later(SceneKey row, std::optional<Reader> Setup::*member) {
  return {std::move(row), [member](const Reader& value, Setup& setup, const Frame&) { setup.*member = value; }};
}

/// The name of a file that exists: its path, from the folder of the file that the value stands in.
template <class Setup>
Key<Setup> file(std::string name, std::string Setup::*member, std::string text) {
  return {{std::move(name), "file next to the scene", "", "", "none", std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame&) { setup.*member = value.existing_file(); }};
}

/// A row of a table by its name.
template <class Setup, class Member, class Rows>
Key<Setup> row(std::string name, Member Setup::*member, const Rows& rows, std::string text) {
  const auto name_of = [](const auto& row) { return "`" + row->name + "`"; };
  return {{std::move(name), words_text(rows.names()), "", "", default_of(member, name_of), std::move(text)},
          [member, &rows](const Reader& value, Setup& setup, const Frame&) {
            setup.*member = value.located([&] { return rows.find(value.text()); });
          }};
}

/// One of some words, each with what it means.
template <class Setup, class Member>
Key<Setup> choice(std::string name, Member Setup::*member,
                  std::vector<std::pair<std::string, typename value_type<Member>::type>> words, std::string text) {
  const auto word_of = [&](const auto& meant) {
    for (const auto& word : words)
      if (word.second == meant) return "`" + word.first + "`";
    return std::string("none");
  };
  return {{std::move(name), words_text(names_of(words, [](const auto& word) { return word.first; })), "", "",
           default_of(member, word_of), std::move(text)},
          [=](const Reader& value, Setup& setup, const Frame&) { setup.*member = value.choice(words); }};
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
  return {{std::move(name), "vector", si_unit(unit), range_text(range.low, range.high, range.open_low),
           default_of(member, vector_text), std::move(text)},
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

/// A list, which takes the place of the default one; `read` reads an item.
template <class Setup, class Item, class ReadItem>
Key<Setup> list(SceneKey row, std::vector<Item> Setup::*member, ReadItem read) {
  return {std::move(row), [=](const Reader& value, Setup& setup, const Frame&) {
            (setup.*member).clear();
            for (const Reader& item : value.items()) (setup.*member).push_back(read(item));
          }};
}

template <class Setup>
Key<Setup> quantities(std::string name, std::vector<double> Setup::*member, const Dimension& unit, std::string text,
                      const Range& range = {}) {
  return list({std::move(name), "list of quantities", si_unit(unit), range_text(range.low, range.high, range.open_low),
               "none", std::move(text)},
              member, [=](const Reader& item) { return item.quantity(unit, range); });
}

template <class Setup>
Key<Setup> wholes(std::string name, std::vector<int> Setup::*member, int low, int high, std::string text) {
  return list({std::move(name), "list of wholes", "", whole_range_text(low, high), "none", std::move(text)}, member,
              [=](const Reader& item) { return item.whole(low, high); });
}

template <class Setup>
Key<Setup> texts(std::string name, std::vector<std::string> Setup::*member, std::string text) {
  return list({std::move(name), "list", "", "", "none", std::move(text)}, member,
              [](const Reader& item) { return item.text(); });
}

/// Rows of a map, or of the items of a list of maps, with the key's name before theirs. No text: no row of its own.
template <class KeysOrForms>
std::vector<SceneKey> rows_below(const SceneKey& own, const KeysOrForms& keys) {
  std::vector<SceneKey> rows;
  if (!own.text.empty()) rows.push_back(own);
  for (SceneKey row : keys.rows()) {
    row.name = own.name + "." + row.name;
    rows.push_back(std::move(row));
  }
  return rows;
}

template <class KeysOrForms>
std::vector<SceneKey> rows_below(std::string name, std::string type, std::string text, const KeysOrForms& keys) {
  return rows_below({std::move(name), std::move(type), "", "", "none", std::move(text)}, keys);
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

/// A map of keys of another setup: `store` gets what is read. A text gives it a row of its own.
template <class Setup, class Inner, class Store>
Key<Setup> map_into(std::string name, const Keys<Inner>& keys, Store store, std::string text = "") {
  std::vector<SceneKey> rows = rows_below(name, "map", std::move(text), keys);
  return {std::move(name), std::move(rows),
          [=](const Reader& value, Setup& setup, const Frame& frame) { store(value, setup, keys.read(value, frame)); }};
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
