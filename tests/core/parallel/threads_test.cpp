#include "elastin/core/parallel/threads.h"

#include <catch2/catch.hpp>
#include <vector>

#include "core/parallel/large_memory.h"
#include "core/parallel/parallel.h"
#include "elastin/openmp/openmp.h"

using namespace elastin;
using namespace elastin::openmp;

namespace {

/// A host's task system: runs what it is given at once, and counts.
struct Counting final : TaskRunner {
  int width() const noexcept override { return 3; }
  void run(int count, Task task, void* context) noexcept override {
    for (int number = count - 1; number >= 0; --number) task(context, number);
    tasks += count;
  }
  int tasks = 0;
};

double harmonic() {
  return ordered_sum(
      100000, [](int i) { return 1. / (i + 1); }, 0., 1);
}

}  // namespace

TEST_CASE("loops run on the runner that the program has set, with the bits of one thread", "[threads]") {
  TaskRunner* const openmp = runner();
  set_runner(nullptr);
  CHECK(threads() == 1);
  set_threads(4);
  CHECK(threads() == 1);  // nobody to run them
  const double alone = harmonic();
  Counting host;
  set_runner(&host);
  CHECK(threads() == 4);
  CHECK(harmonic() == alone);
  CHECK(host.tasks == 4);
  set_threads(0);
  CHECK(threads() == 3);
  std::vector<int> visits(1000);
  parallel_for(
      1000, [&](int i) { ++visits[i]; }, 1);
  CHECK(visits == std::vector<int>(1000, 1));
  CHECK(host.tasks == 7);
  if (use_openmp()) CHECK(runner() == &host);  // the program's own stays
  set_runner(openmp);
}

TEST_CASE("OpenMP runs the loops where it is asked to, with the bits of one thread", "[threads]") {
  TaskRunner* const before = runner();
  set_runner(nullptr);
  const double alone = harmonic();
  const bool there = use_openmp();
  set_threads(3);
  CHECK(threads() == (there ? 3 : 1));
  CHECK(harmonic() == alone);
  set_threads(0);
  set_runner(before);
}

TEST_CASE("large memory: all of it is zero, or as large as it is to be, whatever it was before", "[threads]") {
  const int before = threads();
  for (const int count : {1, 3}) {
    set_threads(count);
    VectorX numbers;
    Positions vectors;
    for (const int size : {7, 900001, 900001, 0, 60000}) {  // of 7 MB: in large pages, but for both ends
      set_zero(numbers, size);
      CHECK((numbers.size() == size && numbers.isZero(0)));
      numbers.setOnes();
      resize(vectors, size);
      CHECK((vectors.rows() == 3 && vectors.cols() == size));
    }
  }
  set_threads(before);
  VectorX numbers = VectorX::LinSpaced(900001, 0, 900000);
  const VectorX same = numbers;
  prefer_large_pages(numbers.data(), sizeof(double) * 900001);
  CHECK(numbers == same);
}
