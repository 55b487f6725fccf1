#include "elastin/core/base/stop.h"

#include <utility>

namespace elastin {
namespace {
thread_local const StopScope* innermost = nullptr;
}  // namespace

StopScope::StopScope(std::function<bool()> stop) : stop_(std::move(stop)), outer_(std::exchange(innermost, this)) {}

StopScope::~StopScope() { innermost = outer_; }

bool stop_requested() { return innermost && innermost->stop_(); }

}  // namespace elastin
