#include "core/base/count.h"

#include <limits>
#include <string>

#include "elastin/core/base/error.h"

namespace elastin {

int numbered(std::int64_t count, const char* what) {
  constexpr int most = std::numeric_limits<int>::max();
  if (count > most)
    throw InputError(std::to_string(count) + " " + what + " are more than " + std::to_string(most) +
                     ", the most that a body can have");
  return static_cast<int>(count);
}

}  // namespace elastin
