#pragma once
#include <atomic>

/// The newest value that one thread has for another one. Neither ever waits, and nothing is copied here.
template <class Value>
class Latest {
 public:
  explicit Latest(const Value& first) : slots_{first, first, first} {}

  /// The writer's own slot, to be filled in; publish hands it over.
  Value& next() { return slots_[writing_]; }
  void publish() { writing_ = middle_.exchange(writing_ | kNew) & ~kNew; }

  /// The reader's: what was published last. Stays as it is until newest is called again.
  const Value& newest() {
    if (middle_.load() & kNew) reading_ = middle_.exchange(reading_) & ~kNew;
    return slots_[reading_];
  }

 private:
  static constexpr int kNew = 4;
  Value slots_[3];
  int writing_ = 0, reading_ = 1;
  std::atomic<int> middle_ = 2;
};
