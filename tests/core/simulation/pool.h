#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "elastin/core/parallel/threads.h"

namespace elastin::testing {

/// A host's task system: threads that take one task after the other. For one caller at a time.
class Pool final : public TaskRunner {
 public:
  explicit Pool(int threads) : width_(threads) {
    for (int i = 0; i < threads; ++i) workers_.emplace_back([this] { work(); });
  }
  ~Pool() override {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& worker : workers_) worker.join();
  }
  int width() const noexcept override { return width_; }
  void run(int count, Task task, void* context) noexcept override {
    std::unique_lock lock(mutex_);
    task_ = task, context_ = context, next_ = 0, count_ = left_ = count;
    wake_.notify_all();
    done_.wait(lock, [this] { return left_ == 0; });
    ++loops;
  }
  int loops = 0;

 private:
  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return stop_ || next_ < count_; });
      if (stop_) return;
      const int number = next_++;
      lock.unlock();
      task_(context_, number);
      lock.lock();
      if (--left_ == 0) done_.notify_one();
    }
  }

  int width_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  bool stop_ = false;
  Task task_ = nullptr;
  void* context_ = nullptr;
  int next_ = 0, count_ = 0, left_ = 0;
  std::vector<std::thread> workers_;
};

}  // namespace elastin::testing
