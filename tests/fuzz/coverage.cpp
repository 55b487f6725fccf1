#include "fuzz/coverage.h"

#include <sys/mman.h>

#include <array>
#include <cctype>
#include <cstdint>
#include <functional>

namespace fuzz {
namespace {

constexpr std::size_t kSize = 1 << 16;
struct Known {
  std::array<unsigned char, kSize> ways;
  std::size_t count;
};

std::array<unsigned char, kSize> now;
std::uintptr_t before = 0;
Known* known = nullptr;  ///< shared with the processes that this one starts

}  // namespace

void share_coverage() {
  void* memory = mmap(nullptr, sizeof(Known), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  known = static_cast<Known*>(memory);
}

void begin_coverage() { now.fill(0), before = 0; }

bool new_coverage(const std::string& message) {
  std::string shape;
  bool quoted = false;
  for (const char c : message) {
    if (c == '\'') quoted = !quoted;
    if (!quoted && !std::isdigit(static_cast<unsigned char>(c))) shape += c;
  }
  now[std::hash<std::string>{}(shape) % kSize] = 1;
  const std::size_t before_this = known->count;
  for (std::size_t i = 0; i < kSize; ++i)
    if (now[i] && !known->ways[i]) known->ways[i] = 1, ++known->count;
  return known->count > before_this;
}

std::size_t coverage() { return known->count; }

}  // namespace fuzz

/// Called by what was compiled to be followed, at each of its blocks.
extern "C" void __sanitizer_cov_trace_pc();
extern "C" __attribute__((no_sanitize_coverage, no_sanitize("address", "undefined"))) void __sanitizer_cov_trace_pc() {
  const auto at = reinterpret_cast<std::uintptr_t>(__builtin_return_address(0));
  const std::uintptr_t way = (at ^ (at >> 16) ^ (fuzz::before << 1)) % fuzz::kSize;
  fuzz::before = at;
  fuzz::now.data()[way] = 1;
}
