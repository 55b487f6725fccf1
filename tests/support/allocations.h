#pragma once

namespace elastin::testing {

/// How often this program has allocated memory so far, on all threads; always 0 where they cannot be counted
/// (sanitizers, other C libraries than glibc).
long allocations();

}  // namespace elastin::testing
