#include "elastin/base/threads.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <thread>
#include <vector>

#include "base/parallel.h"

using namespace elastin;

namespace {

/// Does the tasks one after the other, the last one first.
struct Backwards final : TaskRunner {
  int width() const noexcept override { return 3; }
  void run(int count, Task task, void* context) noexcept override {
    ++runs;
    for (int number = count - 1; number >= 0; --number) task(context, number);
  }
  int runs = 0;
};

double sum_of_roots(int count) {
  return ordered_sum(count, [](int i) { return std::sqrt(i); });
}

}  // namespace

TEST_CASE("a scope's runner runs the loops that its own thread begins, and those alone") {
  constexpr int count = 3 * kParallelThreshold;
  const int before = threads();
  const double alone = sum_of_roots(count);
  Backwards runner, other;
  std::vector<int> seen(count, 0);
  {
    const ThreadScope scope(&runner);
    CHECK(threads() == 3);
    parallel_for(count, [&](int i) { ++seen[static_cast<std::size_t>(i)]; });
    CHECK(sum_of_roots(count) == alone);
    CHECK(runner.runs == 2);
    parallel_for(kParallelThreshold - 1, [](int) {});  // not worth it
    CHECK(runner.runs == 2);
    {
      const ThreadScope inner(&other);
      sum_of_roots(count);
      const ThreadScope none(nullptr);  // as before
      sum_of_roots(count);
    }
    CHECK(other.runs == 2);
    std::thread([&] { CHECK(threads() == before); }).join();
    CHECK(threads() == 3);
  }
  CHECK(runner.runs == 2);
  CHECK(threads() == before);
  CHECK(seen == std::vector<int>(count, 1));
}

TEST_CASE("an ordered sum has the same bits in any number of parts, whatever its length") {
  for (const int count : {kSumBlock + 1, kParallelThreshold, 3000 * kSumBlock + 7}) {
    double blocks = 0;  // as it is defined
    for (int first = 0; first < count; first += kSumBlock) {
      double sum = 0;
      for (int i = first; i < std::min(count, first + kSumBlock); ++i) sum += std::sqrt(i);
      blocks += sum;
    }
    CHECK(sum_of_roots(count) == blocks);
    Backwards runner;
    const ThreadScope scope(&runner);
    CHECK(sum_of_roots(count) == blocks);
  }
}
