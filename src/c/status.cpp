#include <cstdio>

#include "c/handles.h"
#include "elastin/core/parallel/threads.h"
#include "elastin/openmp/openmp.h"

namespace {

constexpr std::size_t kLongest = 4096;
/// In place, so that a message costs no memory.
thread_local char last_message[kLongest] = "";

}  // namespace

namespace elastin::c {

elastin_status failed(elastin_status status, const char* message) noexcept {
  std::snprintf(last_message, kLongest, "%s", message);
  return status;
}

}  // namespace elastin::c

extern "C" {

int elastin_abi(void) { return ELASTIN_ABI; }

const char* elastin_version(void) { return ELASTIN_VERSION; }

const char* elastin_message(void) { return last_message; }

elastin_status elastin_set_threads(int threads) {
  return elastin::c::guarded([&]() -> elastin_status {
    const bool several = elastin::openmp::use_openmp();
    elastin::set_threads(threads);
    return several || threads == 1
               ? ELASTIN_OK
               : elastin::c::failed(ELASTIN_MISSING, "this library was built without OpenMP: one thread");
  });
}
}
