// In a program that has OpenMP's runtime within it: its settings are made before the runtime reads them, at what the
// linker gives a constructor without a priority, so that let_threads_sleep has no program to restart.
#include <cstdlib>

namespace {

__attribute__((constructor(101))) void sleep_early() {
  if (!std::getenv("OMP_WAIT_POLICY") && !std::getenv("GOMP_SPINCOUNT")) setenv("GOMP_SPINCOUNT", "3000", 1);
}

}  // namespace
