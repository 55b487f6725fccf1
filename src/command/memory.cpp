#include "command/memory.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace elastin::command {

void keep_memory() {
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE)),
             bytes = page * (static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) / 2);
  void* const room = std::malloc(bytes);  // addresses alone: nothing is touched
  if (!room) return;                      // the system lends no more than is there: the usual way
  const std::size_t beyond = reinterpret_cast<std::uintptr_t>(room) % page;
  madvise(static_cast<char*>(room) + (page - beyond), bytes - page, MADV_HUGEPAGE);
  std::free(room);
#endif
}

}  // namespace elastin::command
