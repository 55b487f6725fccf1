#pragma once
#include <utility>

namespace elastin {

/// A flag that has a value as long as this object lives.
class Within {
 public:
  explicit Within(bool& flag, bool value = true) : flag_(flag), before_(std::exchange(flag, value)) {}
  ~Within() { flag_ = before_; }
  Within(const Within&) = delete;
  Within& operator=(const Within&) = delete;

 private:
  bool& flag_;
  bool before_;
};

}  // namespace elastin
