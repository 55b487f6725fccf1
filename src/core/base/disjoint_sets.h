#pragma once
#include <numeric>
#include <utility>
#include <vector>

namespace elastin {

/// Numbers 0 … count − 1 in sets that are joined; each set is named by its least number.          [Tarjan 1975]
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : above_(count) { std::iota(above_.begin(), above_.end(), 0); }
  int set_of(int number) {
    while (above_[number] != number) number = above_[number] = above_[above_[number]];
    return number;
  }
  void join(int a, int b) {
    a = set_of(a), b = set_of(b);
    if (a > b) std::swap(a, b);
    above_[b] = a;
  }

 private:
  std::vector<int> above_;
};

}  // namespace elastin
