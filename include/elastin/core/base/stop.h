#pragma once
#include <functional>

namespace elastin {

/// Ends long work of the calling thread while it lives: solves, fits of spring constants and conjugate gradients ask
/// it, in addition to StaticOptions::stop. True ends them as `interrupted`, or with an InputError where they have no
/// outcome.
class StopScope {
 public:
  explicit StopScope(std::function<bool()> stop);
  ~StopScope();
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

 private:
  friend bool stop_requested();
  std::function<bool()> stop_;
  const StopScope* outer_;
};

/// Whether the innermost scope of the calling thread says so; false without one.
bool stop_requested();

}  // namespace elastin
