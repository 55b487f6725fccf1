#pragma once
#include <algorithm>
#include <numeric>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// Molecules that are joined pair by pair into pieces; at first each is one of its own.
class Pieces {
 public:
  explicit Pieces(int molecules) : parent_(molecules), count_(molecules) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  void join(int a, int b) {
    const int first = root(a), second = root(b);
    if (first == second) return;
    parent_[std::max(first, second)] = std::min(first, second);
    --count_;
  }
  int count() const { return count_; }
  /// Of each molecule, pieces numbered by their first one.
  std::vector<int> numbers() const {
    std::vector<int> numbers(parent_.size());
    int next = 0;
    for (std::size_t molecule = 0; molecule < parent_.size(); ++molecule) {
      const int before = parent_[molecule];
      numbers[molecule] = before == static_cast<int>(molecule) ? next++ : numbers[before];
    }
    return numbers;
  }

 private:
  int root(int molecule) {
    while (parent_[molecule] != molecule) molecule = parent_[molecule] = parent_[parent_[molecule]];
    return molecule;
  }
  std::vector<int> parent_;  // never after the molecule
  int count_;
};

/// By proper connections, rigid parts and ties.
Pieces pieces_of(const Body& body);

}  // namespace elastin
