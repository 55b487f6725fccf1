#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <type_traits>

#include "elastin/core/parallel/threads.h"

namespace elastin {

/// Below this many items a loop stays on one thread: waking the others costs more than they give.
inline constexpr int kParallelThreshold = 50000;
/// The same of passes over molecules, of which each costs as much as some ten connections.
inline constexpr int kMoleculeThreshold = kParallelThreshold / 10;

/// Items in one block of an ordered sum. Fixed, so that the order of additions never depends on the thread count.
inline constexpr int kSumBlock = 1024;

namespace detail {
/// Runs range(begin, end) over disjoint ranges that cover 0 … count−1.
void run_ranges(int count, void* context, void (*range)(void*, int, int));
}  // namespace detail

/// Calls work(i) once for each i in 0 … count−1; each i must write only what it owns. Below `threshold` items one
/// thread does it all.
template <class Work>
void parallel_for(int count, Work&& work, int threshold = kParallelThreshold) {
  if (count < std::max(threshold, 2) || threads() == 1) {  // one alone has nobody to share with
    for (int i = 0; i < count; ++i) work(i);
    return;
  }
  detail::run_ranges(count, &work, [](void* context, int begin, int end) {
    auto& call = *static_cast<std::remove_reference_t<Work>*>(context);
    for (int i = begin; i < end; ++i) call(i);
  });
}

/// Σ term(begin, end) over the blocks of kSumBlock items (the last one may be smaller) of 0 … count−1 in a fixed order:
/// bitwise identical on any number of threads, and no allocation. Value is a number, or a small vector where several
/// sums share a pass.
template <class Value = double, class Term>
Value ordered_sum_of_blocks(int count, Term&& term, Value zero = Value(0), int threshold = kParallelThreshold) {
  const int blocks = (count + kSumBlock - 1) / kSumBlock;
  const auto block_sum = [&](int block) -> Value {
    const int begin = block * kSumBlock;
    return term(begin, std::min(count, begin + kSumBlock));
  };
  if (blocks == 1) return block_sum(0);
  Value total = zero;
  if (count < std::max(threshold, 2) || threads() == 1) {  // one alone has nobody to share with
    for (int block = 0; block < blocks; ++block) total += block_sum(block);
    return total;
  }
  constexpr int most = std::max(16, static_cast<int>(16384 / sizeof(Value)));  // on the stack: no allocation
  std::array<Value, most> sums;
  for (int first = 0; first < blocks; first += most) {
    const int some = std::min(most, blocks - first);
    auto work = [&](int block) { sums[block] = block_sum(first + block); };
    detail::run_ranges(some, &work, [](void* context, int begin, int end) {
      for (int block = begin; block < end; ++block) (*static_cast<decltype(work)*>(context))(block);
    });
    for (int block = 0; block < some; ++block) total += sums[block];
  }
  return total;
}

/// Σ term(i) over 0 … count−1, likewise.
template <class Value = double, class Term>
Value ordered_sum(int count, Term&& term, Value zero = Value(0), int threshold = kParallelThreshold) {
  return ordered_sum_of_blocks<Value>(
      count,
      [&](int begin, int end) {
        Value sum = zero;
        for (int i = begin; i < end; ++i) sum += term(i);
        return sum;
      },
      zero, threshold);
}

/// Calls range(begin, end) over disjoint ranges that cover 0 … count−1.
template <class Range>
void parallel_ranges(int count, Range&& range, int threshold = kParallelThreshold) {
  if (count < threshold || threads() == 1) return range(0, count);
  detail::run_ranges(count, &range, [](void* context, int begin, int end) {
    (*static_cast<std::remove_reference_t<Range>*>(context))(begin, end);
  });
}

/// The largest of what most(begin, end) ≥ 0 finds in such ranges; 0 of none. Allocates nothing.
template <class Most>
double largest_of_ranges(int count, Most&& most, int threshold = kParallelThreshold) {
  std::atomic<double> largest{0};
  parallel_ranges(
      count,
      [&](int begin, int end) {
        const double found = most(begin, end);
        for (double known = largest; found > known && !largest.compare_exchange_weak(known, found);) {
        }
      },
      threshold);
  return largest;
}

}  // namespace elastin
