#include "support/allocations.h"

#include <atomic>
#include <cstddef>

namespace {
std::atomic<long> count{0};
}

namespace elastin::testing {
long allocations() { return count; }
}  // namespace elastin::testing

// Eigen and operator new both ask malloc.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" void* __libc_malloc(std::size_t) noexcept;  // NOLINT: glibc's own
extern "C" void* malloc(std::size_t size) noexcept {
  ++count;
  return __libc_malloc(size);
}
#endif
