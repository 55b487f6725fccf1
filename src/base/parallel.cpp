#include "base/parallel.h"

#ifdef _OPENMP
#include <omp.h>
#endif

namespace elastin {
namespace {
int chosen_threads = 0;
}

void set_threads(int threads) { chosen_threads = std::max(0, threads); }

int threads() {
#ifdef _OPENMP
  return chosen_threads > 0 ? chosen_threads : omp_get_num_procs();
#else
  return 1;
#endif
}

namespace detail {

void run_ranges(int count, void* context, void (*range)(void*, int, int)) {
#ifdef _OPENMP
  const int parts = threads();
#pragma omp parallel for schedule(static) num_threads(parts)
  for (int part = 0; part < parts; ++part)
    range(context, static_cast<int>(static_cast<long long>(count) * part / parts),
          static_cast<int>(static_cast<long long>(count) * (part + 1) / parts));
#else
  range(context, 0, count);
#endif
}

}  // namespace detail
}  // namespace elastin
