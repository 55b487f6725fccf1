#pragma once

namespace elastin {

/// Number of threads that large bodies use; 0 = as many as the machine has cores. Results have the same bits for any
/// number. Without OpenMP it is always 1.
void set_threads(int threads);
int threads();

}  // namespace elastin
