#pragma once
#include <numeric>
#include <utility>
#include <vector>

namespace elastin {

/// Numbers 0 … count − 1 in sets that are joined; each set is named by its least number.          [Tarjan 1975]
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : above_(count), count_(static_cast<int>(count)) {
    std::iota(above_.begin(), above_.end(), 0);
  }
  int set_of(int number) {
    while (above_[number] != number) number = above_[number] = above_[above_[number]];
    return number;
  }
  void join(int a, int b) {
    a = set_of(a), b = set_of(b);
    if (a == b) return;
    if (a > b) std::swap(a, b);
    above_[b] = a;
    --count_;
  }
  int count() const { return count_; }
  /// The set of each number, where sets are numbered by their first one.
  std::vector<int> numbers() const {
    std::vector<int> numbers(above_.size());
    int next = 0;
    for (std::size_t number = 0; number < above_.size(); ++number)
      numbers[number] = above_[number] == static_cast<int>(number) ? next++ : numbers[above_[number]];
    return numbers;
  }

 private:
  std::vector<int> above_;  // never after the number
  int count_;
};

}  // namespace elastin
