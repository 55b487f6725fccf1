#include "config/keys.h"

namespace elastin::config {

AnyKey::AnyKey(SceneKey row, Read read, Absent absent)
    : name_(row.name),
      rows_(std::make_shared<std::vector<SceneKey>>()),
      read_(std::move(read)),
      absent_(std::move(absent)) {
  rows_->push_back(std::move(row));
}

AnyKey::AnyKey(std::string name, std::vector<SceneKey> rows, Read read)
    : name_(std::move(name)), rows_(std::make_shared<std::vector<SceneKey>>(std::move(rows))), read_(std::move(read)) {}

AnyKey::AnyKey(AnyKey key, void* (*part)(void*)) : AnyKey(std::move(key)) {
  const auto const_part = [part](const void* setup) -> const void* { return part(const_cast<void*>(setup)); };
  read_ = [read = std::move(read_), part](const Reader& value, void* setup, const Frame& frame) {
    read(value, part(setup), frame);
  };
  if (absent_)
    absent_ = [absent = std::move(absent_), part](void* setup, const Frame& frame) { absent(part(setup), frame); };
  if (fault_) fault_ = [own = std::move(fault_), const_part](const void* setup) { return own(const_part(setup)); };
  for (Condition* condition : {&condition_, &needed_})
    if (*condition)
      *condition = [own = std::move(*condition), const_part](const void* setup) { return own(const_part(setup)); };
}

void AnyKey::set_fallback(std::string words) {
  if (rows_.use_count() > 1) rows_ = std::make_shared<std::vector<SceneKey>>(*rows_);
  rows_->front().fallback = std::move(words);
}

void AnyKey::read_first(std::function<void(const Reader& value)> check) {
  read_ = [read = std::move(read_), check = std::move(check)](const Reader& value, void* setup, const Frame& frame) {
    check(value);
    read(value, setup, frame);
  };
}

void AnyKey::read_then(Read next) {
  read_ = [read = std::move(read_), next = std::move(next)](const Reader& value, void* setup, const Frame& frame) {
    read(value, setup, frame);
    next(value, setup, frame);
  };
}

void AnyKey::read(const std::optional<Reader>& value, void* setup, const Frame& frame) const {
  if (value)
    read_(*value, setup, frame);
  else if (absent_)
    absent_(setup, frame);
}

std::string one_of_words(std::size_t count, const std::string& other) {
  if (count == 2) return "this, or `" + other + "`";
  return std::string("one of ") + (count == 3 ? "three" : "four") + " needed";
}

AnyKeys::Entry::Entry(AnyKey key) : keys(std::make_shared<const std::vector<AnyKey>>(1, std::move(key))) {}

AnyKeys::Entry::Entry(std::vector<AnyKey> all, std::string none_given, std::string several_given, bool only_one_may_be)
    : keys(std::make_shared<const std::vector<AnyKey>>(std::move(all))),
      message(std::move(none_given)),
      several(std::move(several_given)),
      only_one(only_one_may_be) {}

std::vector<SceneKey> AnyKeys::rows() const {
  std::vector<SceneKey> rows;
  for (const Entry& entry : *entries_)
    for (const AnyKey& key : *entry.keys) rows.insert(rows.end(), key.rows().begin(), key.rows().end());
  return rows;
}

std::vector<std::string> AnyKeys::names() const {
  std::vector<std::string> names;
  for (const Entry& entry : *entries_)
    for (const AnyKey& key : *entry.keys) names.push_back(key.name());
  return names;
}

void AnyKeys::add_to_known(Reader& map) const {
  for (const std::string& name : names()) map.has(name);
}

void AnyKeys::read_any(Reader& map, void* setup, const Frame& frame) const {
  for (const Entry& entry : *entries_)
    for (const AnyKey& key : *entry.keys)
      if (key.belongs_to(setup))
        key.read(key.is_needed(setup) ? std::optional(map.at(key.name(), key.rows().front().fallback))
                                      : map.find(key.name()),
                 setup, frame);
}

void AnyKeys::check_any(Reader& map, const void* setup) const {
  for (const Entry& entry : *entries_) {
    std::string given;
    for (const AnyKey& key : *entry.keys) {
      if (!key.belongs_to(setup)) continue;
      const std::optional<Reader> value = map.find(key.name());
      if (value && entry.only_one && !given.empty()) {
        if (!entry.several.empty()) map.fail(entry.several);
        value->fail("there is a " + given + " already; give one of them");
      }
      if (value) given = key.name();
      if (const std::string fault = key.fault_of(setup); !fault.empty()) (value ? *value : map).fail(fault);
    }
    if (!entry.message.empty() && given.empty()) map.fail(entry.message);
  }
}

}  // namespace elastin::config
