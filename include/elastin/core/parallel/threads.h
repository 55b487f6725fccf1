#pragma once

namespace elastin {

/// A task system that runs loops over large bodies: the host's, or OpenMP's (see openmp.h). Results are bitwise
/// identical with any, and with none.
class TaskRunner {
 public:
  virtual ~TaskRunner() = default;
  /// Into how many tasks a loop is split, ≥ 1.
  virtual int width() const noexcept = 0;
  /// Calls task(context, 0) … task(context, count − 1), each once, on any threads, and comes back when all have ended.
  /// Called by one thread at a time for each simulation; must not throw.
  using Task = void (*)(void* context, int number);
  virtual void run(int count, Task task, void* context) noexcept = 0;
};

/// The runner of all loops that stand in no ThreadScope; it must outlive them. Null, as in the beginning: each loop
/// runs on the thread that begins it.
void set_runner(TaskRunner* runner);
/// The runner of a loop begun by the calling thread, or null.
TaskRunner* runner();

constexpr int kMostThreads = 4096;
/// Into how many tasks that runner parts a loop, 0 to kMostThreads; 0 = its width. Throws InputError out of that range.
void set_threads(int threads);
/// What a loop begun by the calling thread would use, its ThreadScope's where one lives; 1 without a runner.
int threads();

/// While it lives, loops that the calling thread begins run on `runner` or, where that is null, on `threads` of
/// the common runner's; both null: as before. Other threads are not touched. Scopes may stand in each other, on one
/// thread.
class ThreadScope {
 public:
  explicit ThreadScope(TaskRunner* runner, int threads = 0) noexcept;
  ~ThreadScope();
  ThreadScope(const ThreadScope&) = delete;
  ThreadScope& operator=(const ThreadScope&) = delete;

 private:
  TaskRunner* runner_before_;
  int threads_before_;
};

}  // namespace elastin
