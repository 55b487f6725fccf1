#pragma once
#include <algorithm>
#include <functional>
#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "elastin/core/base/error.h"

/// Lists of things that have a name, and lists of words in a sentence.
namespace elastin {

/// The names of a list's items, in order: what suggestion() offers.
template <class List, class Name>
std::vector<std::string> names_of(const List& list, Name name) {
  std::vector<std::string> names;
  for (const auto& item : list) names.emplace_back(std::invoke(name, item));
  return names;
}
template <class List>
std::vector<std::string> names_of(const List& list) {
  return names_of(list, [](const auto& item) { return std::string_view(item.name); });
}

/// The first item of this name; null: there is no such item.
template <class List>
auto* find_named(List& list, std::string_view name) {
  const auto found = std::find_if(std::begin(list), std::end(list),
                                  [&](const auto& item) { return std::string_view(item.name) == name; });
  return found == std::end(list) ? nullptr : &*found;
}

/// The same. Throws InputError with `unknown`, the nearest name and all names where there is no such item.
template <class List>
auto& named(List& list, std::string_view name, const std::string& unknown) {
  if (auto* item = find_named(list, name)) return *item;
  throw InputError(unknown + suggestion(name, names_of(list)));
}

/// "a, b, c": what `text` gives of each item.
template <class List, class Text>
requires(!std::is_convertible_v<Text, std::string_view>) std::string
    joined(const List& list, Text text, std::string_view between = ", ") {
  std::string all;
  for (const auto& item : list) all.append(all.empty() ? "" : between).append(std::invoke(text, item));
  return all;
}
inline std::string joined(const std::vector<std::string>& words, std::string_view between = ", ") {
  return joined(
      words, [](const std::string& word) -> const std::string& { return word; }, between);
}

}  // namespace elastin
