#pragma once
#include <cstddef>

#include "elastin/core/base/types.h"

namespace elastin {

/// Asks for large pages for memory that nothing has been written to: the system then clears 2 MB at a page fault where
/// it otherwise takes 512 of them, which is a sixth of the time of a solve that allocates all it needs. Does nothing
/// where there are no such pages.
void prefer_large_pages(void* memory, std::size_t bytes) noexcept;

/// Of vectors that are written next.
void resize(Positions& vectors, int count);

/// numbers = 0, `count` of them, written first by the threads that use them.
void set_zero(VectorX& numbers, int count);

}  // namespace elastin
