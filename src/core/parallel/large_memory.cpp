#include "core/parallel/large_memory.h"

#include "core/parallel/parallel.h"
#ifdef __linux__
#include <sys/mman.h>

#include <cstdint>
#endif

namespace elastin {

void prefer_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) noexcept {
#ifdef MADV_HUGEPAGE
  constexpr std::uintptr_t page = 1 << 21;
  const auto begin = reinterpret_cast<std::uintptr_t>(memory), first = (begin + page - 1) / page * page,
             end = (begin + bytes) / page * page;
  // Only what lies within: no page is larger than what is used of it.
  if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
#endif
}

void resize(Positions& vectors, int count) {
  if (vectors.cols() == count) return;
  vectors.resize(3, count);
  prefer_large_pages(vectors.data(), sizeof(double) * static_cast<std::size_t>(vectors.size()));
}

void set_zero(VectorX& numbers, int count) {
  if (numbers.size() != count) {
    numbers.resize(count);
    prefer_large_pages(numbers.data(), sizeof(double) * static_cast<std::size_t>(count));
  }
  parallel_ranges(count, [&](int begin, int end) { numbers.segment(begin, end - begin).setZero(); });
}

}  // namespace elastin
