#ifdef __linux__
#include <unistd.h>
#endif

#include <cstdlib>

#include "elastin/core/parallel/threads.h"
#include "elastin/openmp/openmp.h"

#ifdef _OPENMP
#include <omp.h>

namespace elastin::openmp {
namespace {

class OpenMP : public TaskRunner {
 public:
  int width() const noexcept override { return omp_get_num_procs(); }

  void run(int count, Task task, void* context) noexcept override {
#pragma omp parallel for schedule(static) num_threads(count)
    for (int number = 0; number < count; ++number) task(context, number);
  }
};

}  // namespace

bool use_openmp() {
  static OpenMP openmp;
  if (!runner()) set_runner(&openmp);
  return true;
}

#ifdef __linux__
void let_threads_sleep(char** argv) {
  if (std::getenv("OMP_WAIT_POLICY") || std::getenv("GOMP_SPINCOUNT")) return;
  setenv("GOMP_SPINCOUNT", "3000", 1);
  execv("/proc/self/exe", argv);  // comes back only if it cannot: then threads spin on
}
#else  // other systems cannot restart a program in its place
void let_threads_sleep(char**) {}
#endif

}  // namespace elastin::openmp

#else

namespace elastin::openmp {

bool use_openmp() { return false; }
void let_threads_sleep(char**) {}

}  // namespace elastin::openmp

#endif
