#pragma once

namespace elastin {

/// Number of threads that large bodies use; 0 = as many as the machine has cores. Results have the same bits for any
/// number. Without OpenMP it is always 1.
void set_threads(int threads);
/// What a loop begun by the calling thread would use: that of its ThreadScope, where one lives.
int threads();

/// A host's task system, to run loops over large bodies instead of OpenMP. Results have the same bits with any.
class TaskRunner {
 public:
  virtual ~TaskRunner() = default;
  /// Into how many tasks a loop is parted, ≥ 1.
  virtual int width() const noexcept = 0;
  /// Calls task(context, 0) … task(context, count − 1), each once, on any threads, and comes back when all have ended.
  /// Called by one thread at a time for each simulation; must not throw.
  using Task = void (*)(void* context, int number);
  virtual void run(int count, Task task, void* context) noexcept = 0;
};

/// While it lives, loops that the calling thread begins run on `runner` or, where that is null, on `threads` of
/// OpenMP's; both null: as before. Other threads are not touched. Scopes may stand in each other, on one thread.
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
