#pragma once
#include <array>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "elastin/core/model/state.h"

/// The one description of what a state is made of, for restart files and saved states; see base/archive. A structure is
/// described by `members`, which ties what is kept of it, in order.
namespace elastin {

template <class Archive>
void visit(Archive& archive, double& number) {
  archive.numbers(&number, 1);
}
template <class Archive>
void visit(Archive& archive, int& number) {
  archive.whole(number);
}
template <class Archive>
void visit(Archive& archive, std::string& word) {
  archive.word(word);
}

/// Enumerations and yes or no, as whole numbers.
template <class Archive, class Choice>
requires(std::is_enum_v<Choice> || std::is_same_v<Choice, bool>) void visit(Archive& archive, Choice& choice) {
  int number = static_cast<int>(choice);
  archive.whole(number);
  choice = static_cast<Choice>(number);
}

template <class Archive, int rows, int columns>
requires(rows > 0 && columns > 0) void visit(Archive& archive, Eigen::Matrix<double, rows, columns>& matrix) {
  archive.numbers(matrix.data(), rows * columns);
}
template <class Archive>
void visit(Archive& archive, Positions& positions) {
  const auto columns = static_cast<std::size_t>(positions.cols());
  positions.resize(3, static_cast<Eigen::Index>(archive.count(columns, 3 * sizeof(double))));
  archive.numbers(positions.data(), static_cast<std::size_t>(positions.size()));
}
template <class Archive>
void visit(Archive& archive, VectorX& numbers) {
  numbers.resize(static_cast<Eigen::Index>(archive.count(static_cast<std::size_t>(numbers.size()), sizeof(double))));
  archive.numbers(numbers.data(), static_cast<std::size_t>(numbers.size()));
}

template <class Archive, class... Things>
void visit_each(Archive& archive, Things&... things) {
  (visit(archive, things), ...);
}

template <class Archive, class Item, std::size_t size>
void visit(Archive& archive, std::array<Item, size>& items) {
  for (Item& item : items) visit(archive, item);
}
template <class Archive, class First, class Second>
void visit(Archive& archive, std::pair<First, Second>& pair) {
  visit_each(archive, pair.first, pair.second);
}
template <class Archive, class Item>
void visit(Archive& archive, std::vector<Item>& items) {
  items.resize(archive.count(items.size(), 1));  // an item takes at least a byte
  for (Item& item : items) visit(archive, item);
}
template <class Archive>
void visit(Archive& archive, std::vector<double>& numbers) {
  numbers.resize(archive.count(numbers.size(), sizeof(double)));
  archive.numbers(numbers.data(), numbers.size());
}
template <class Archive, class Item>
void visit(Archive& archive, std::optional<Item>& item) {
  int present = item.has_value();
  archive.whole(present);
  if (present && !item) item.emplace();
  if (item) visit(archive, *item);
}
template <class Archive, class Item>
void visit(Archive& archive, std::map<std::string, Item>& items) {
  std::vector<std::pair<std::string, Item>> list(items.begin(), items.end());
  visit(archive, list);
  items = {list.begin(), list.end()};
}

template <class Archive, class Thing>
requires requires(Thing& thing) { members(thing); }
void visit(Archive& archive, Thing& thing) {
  std::apply([&](auto&... own) { visit_each(archive, own...); }, members(thing));
}

inline auto members(ContactHistory& entry) {
  return std::tie(entry.sample, entry.target, entry.count, entry.molecules, entry.weights, entry.offset,
                  entry.multiplier);
}
inline auto members(HistoryBlock& block) { return std::tie(block.name, block.values); }
inline auto members(State& state) {
  return std::tie(state.time, state.positions, state.velocities, state.accelerations, state.contact_history,
                  state.history);
}

/// Throws InputError where no body of this size can have this state, or where its history is not what
/// `history` declares: nothing at all is a beginning. `what` is how messages name it: "the saved state".
void check_state(const State& state, int molecules, const std::vector<HistoryBlock>& history, const std::string& what);

}  // namespace elastin
