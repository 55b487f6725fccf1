#include "base/parallel.h"

#ifdef _OPENMP
#include <omp.h>
#endif

namespace elastin {
namespace {

std::atomic<int> chosen_threads = 0;

/// What the calling thread's innermost ThreadScope says.
thread_local TaskRunner* own_runner = nullptr;
thread_local int own_threads = 0;

int part_start(int count, int parts, int part) {
  return static_cast<int>(static_cast<long long>(count) * part / parts);
}

struct Loop {
  int count, parts;
  void* context;
  void (*range)(void*, int, int);

  void run(int part) const { range(context, part_start(count, parts, part), part_start(count, parts, part + 1)); }
};

}  // namespace

void set_threads(int threads) { chosen_threads.store(std::max(0, threads), std::memory_order_relaxed); }

int threads() {
  if (own_runner) return std::max(1, own_runner->width());
#ifdef _OPENMP
  if (own_threads > 0) return own_threads;
  const int chosen = chosen_threads.load(std::memory_order_relaxed);
  return chosen > 0 ? chosen : omp_get_num_procs();
#else
  return 1;
#endif
}

ThreadScope::ThreadScope(TaskRunner* runner, int threads) noexcept
    : runner_before_(own_runner), threads_before_(own_threads) {
  if (!runner && threads <= 0) return;
  own_runner = runner;
  own_threads = threads;
}

ThreadScope::~ThreadScope() {
  own_runner = runner_before_;
  own_threads = threads_before_;
}

namespace detail {

void run_ranges(int count, void* context, void (*range)(void*, int, int)) {
  const Loop loop{count, threads(), context, range};
  if (own_runner) {
    const auto task = [](void* one, int part) { static_cast<const Loop*>(one)->run(part); };
    return own_runner->run(loop.parts, task, const_cast<Loop*>(&loop));
  }
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(loop.parts)
  for (int part = 0; part < loop.parts; ++part) loop.run(part);
#else
  range(context, 0, count);
#endif
}

}  // namespace detail
}  // namespace elastin
