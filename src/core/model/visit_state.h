#pragma once
#include <string>

#include "elastin/core/model/state.h"

/// The one description of what a state is made of, for restart files and saved states; see base/archive.
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
void visit(Archive& archive, Vector3& vector) {
  archive.numbers(vector.data(), 3);
}
template <class Archive>
void visit(Archive& archive, Matrix3& matrix) {
  archive.numbers(matrix.data(), 9);
}

template <class Archive>
void visit(Archive& archive, Positions& positions) {
  const auto columns = static_cast<std::size_t>(positions.cols());
  positions.resize(3, static_cast<Eigen::Index>(archive.count(columns, 3 * sizeof(double))));
  archive.numbers(positions.data(), static_cast<std::size_t>(positions.size()));
}

template <class Archive, class Item>
void visit_all(Archive& archive, std::vector<Item>& items) {
  items.resize(archive.count(items.size(), 1));  // an item takes more than a byte
  for (Item& item : items) visit(archive, item);
}

template <class Archive>
void visit(Archive& archive, ContactHistory& entry) {
  for (int* value : {&entry.sample, &entry.target, &entry.count}) archive.whole(*value);
  for (int& molecule : entry.molecules) archive.whole(molecule);
  archive.numbers(entry.weights.data(), entry.weights.size());
  visit(archive, entry.offset);
  visit(archive, entry.multiplier);
}

template <class Archive>
void visit(Archive& archive, HistoryBlock& block) {
  archive.word(block.name);
  block.values.resize(archive.count(block.values.size(), sizeof(double)));
  archive.numbers(block.values.data(), block.values.size());
}

template <class Archive>
void visit(Archive& archive, State& state) {
  visit(archive, state.time);
  for (Positions* field : {&state.positions, &state.velocities, &state.accelerations}) visit(archive, *field);
  visit_all(archive, state.contact_history);
  visit_all(archive, state.history);
}

/// Throws InputError where no body of this size can have this state, or where its history is not what
/// `history` declares: nothing at all is a beginning. `what` is how messages name it: "the saved state".
void check_state(const State& state, int molecules, const std::vector<HistoryBlock>& history, const std::string& what);

}  // namespace elastin
