#include "core/parallel/parallel.h"

#include "elastin/core/base/error.h"

namespace elastin {
namespace {

std::atomic<TaskRunner*> common_runner = nullptr;
std::atomic<int> chosen_threads = 0;

/// What the calling thread's innermost ThreadScope says.
thread_local TaskRunner* own_runner = nullptr;
thread_local int own_threads = 0;

int range_start(int count, int ranges, int number) {
  return static_cast<int>(static_cast<long long>(count) * number / ranges);
}

struct Loop {
  int count, ranges;
  void* context;
  void (*range)(void*, int, int);

  void run(int number) const {
    range(context, range_start(count, ranges, number), range_start(count, ranges, number + 1));
  }
};

}  // namespace

void set_runner(TaskRunner* runner) { common_runner.store(runner, std::memory_order_release); }

TaskRunner* runner() { return own_runner ? own_runner : common_runner.load(std::memory_order_acquire); }

void set_threads(int threads) {
  if (threads < 0 || threads > kMostThreads)
    throw InputError("threads is " + std::to_string(threads) + "; it must be at least 0 and at most " +
                     std::to_string(kMostThreads));
  chosen_threads.store(threads, std::memory_order_relaxed);
}

int threads() {
  const TaskRunner* used = runner();
  if (!used) return 1;
  if (used != own_runner) {
    if (own_threads > 0) return own_threads;
    if (const int chosen = chosen_threads.load(std::memory_order_relaxed); chosen > 0) return chosen;
  }
  return std::max(1, used->width());
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
  TaskRunner* used = runner();
  if (!used) return range(context, 0, count);
  const Loop loop{count, threads(), context, range};
  const auto task = [](void* one, int number) { static_cast<const Loop*>(one)->run(number); };
  used->run(loop.ranges, task, const_cast<Loop*>(&loop));
}

}  // namespace detail
}  // namespace elastin
