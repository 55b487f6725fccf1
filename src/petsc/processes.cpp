#include <petscsys.h>

#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>

#include "elastin/petsc/petsc.h"
#include "petsc/handles.h"

namespace elastin::petsc {
namespace {

/// So long a process that has failed waits for others to fail alike.
constexpr double kPatience = 5;  // [s]

/// For the end alone: its messages meet no others.
MPI_Comm farewell = MPI_COMM_NULL;

int number_in(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text && *text ? std::atoi(text) : otherwise;
}

/// Whether all processes arrive here in time.
bool all_arrive(double seconds) {
  MPI_Request request;
  MPI_Ibarrier(farewell, &request);
  int arrived = 0;
  const double last = MPI_Wtime() + seconds;
  while (!arrived && MPI_Wtime() < last) {
    MPI_Test(&request, &arrived, MPI_STATUS_IGNORE);
    if (!arrived) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return arrived != 0;
}

}  // namespace

void check(PetscErrorCode code) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw std::runtime_error("PETSc: " + std::string(text ? text : "unknown error"));
}

Launch launch() {
  return {number_in("OMPI_COMM_WORLD_RANK", number_in("PMI_RANK", 0)),
          number_in("OMPI_COMM_WORLD_SIZE", number_in("PMI_SIZE", 1))};
}

void start() {
  PetscBool running = PETSC_FALSE;
  check(PetscInitialized(&running));
  if (running) return;
  check(PetscOptionsSetValue(nullptr, "-no_signal_handler", "true"));  // signals are the program's own
  check(PetscInitializeNoArguments());
  check(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));  // errors are exceptions, which say it once
  MPI_Comm_dup(MPI_COMM_WORLD, &farewell);
}

int end(int code, void (*last_words)()) {
  if (farewell == MPI_COMM_NULL) return code;
  const bool together = all_arrive(code == 0 ? 1e9 : kPatience);
  if (!together) {
    if (last_words) last_words();
    MPI_Abort(MPI_COMM_WORLD, code);
  }
  MPI_Comm_free(&farewell);
  PetscFinalize();
  return code;
}

}  // namespace elastin::petsc
