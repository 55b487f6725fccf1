#include "lab/report/progress.h"

#include <fmt/format.h>

#include <cstdio>

namespace elastin::lab {

using namespace std::chrono_literals;

Progress::Progress(bool shown) : shown_(shown) {
  if (shown_) thread_ = std::thread([this] { watch(); });
}

Progress::~Progress() {
  if (!shown_) return;
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Progress::set(const std::string& doing) {
  const std::lock_guard lock(mutex_);
  if (doing_.empty()) start_ = std::chrono::steady_clock::now();
  doing_ = doing;
}

void Progress::pause() {
  const std::lock_guard lock(mutex_);
  doing_.clear();
  if (drawn_) fmt::print(stderr, "\r\033[K");
  drawn_ = false;
}

void Progress::watch() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    wake_.wait_for(lock, 200ms);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    if (stop_ || doing_.empty() || seconds < 1) continue;
    fmt::print(stderr, "\r\033[K  {:.0f} s  {}", seconds, doing_);
    std::fflush(stderr);
    drawn_ = true;
  }
}

}  // namespace elastin::lab
