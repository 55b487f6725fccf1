#pragma once
#include <unistd.h>

#include <cstdlib>

/// Threads that wait must soon sleep: one that spins keeps a busy machine from running the one it waits for, and a pass
/// over the body then takes 20 times as long. OpenMP reads its setting once, before main, so the program starts itself
/// anew.
inline void let_threads_sleep(char** argv) {
  if (std::getenv("OMP_WAIT_POLICY") || std::getenv("GOMP_SPINCOUNT")) return;
  setenv("GOMP_SPINCOUNT", "3000", 1);
  execv("/proc/self/exe", argv);  // comes back only if it cannot: then threads spin on
}
