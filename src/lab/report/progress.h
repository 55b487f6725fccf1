#pragma once
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace elastin::lab {

/// One line on standard error that says what is going on, from the second second on; it is wiped when work pauses.
class Progress {
 public:
  /// `shown` = false: no line, no thread.
  explicit Progress(bool shown);
  ~Progress();
  void set(const std::string& doing);
  /// Wipes the line, so that something else can be printed; the clock starts again with the next set().
  void pause();

 private:
  void watch();
  bool shown_, stop_ = false, drawn_ = false;
  std::string doing_;
  std::chrono::steady_clock::time_point start_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace elastin::lab
