#include <petscsys.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>

#include "elastin/petsc/petsc.h"
#include "petsc/handles.h"
#include "petsc/processes.h"

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

/// Longer messages go in pieces: MPI counts with 32 bits.
constexpr std::size_t kPiece = std::size_t{1} << 30;

class MpiProcesses final : public Processes {
 public:
  MpiProcesses() {
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank_);
    MPI_Comm_size(PETSC_COMM_WORLD, &count_);
  }
  int rank() const override { return rank_; }
  int count() const override { return count_; }

  std::vector<double> gather(std::span<const double> own) const override {
    const int size = static_cast<int>(own.size());
    std::vector<int> sizes(count_), starts(sizes.size(), 0);
    MPI_Allgather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, PETSC_COMM_WORLD);
    std::partial_sum(sizes.begin(), sizes.end() - 1, starts.begin() + 1);
    std::vector<double> all(starts.back() + sizes.back());
    MPI_Allgatherv(own.data(), size, MPI_DOUBLE, all.data(), sizes.data(), starts.data(), MPI_DOUBLE, PETSC_COMM_WORLD);
    return all;
  }

  void largest(std::span<double> own) const override {
    MPI_Allreduce(MPI_IN_PLACE, own.data(), static_cast<int>(own.size()), MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  }

  void send(int to, const std::vector<char>& bytes) const override {
    const auto size = static_cast<std::uint64_t>(bytes.size());
    MPI_Send(&size, 1, MPI_UINT64_T, to, 0, PETSC_COMM_WORLD);
    for (std::size_t at = 0; at < bytes.size(); at += kPiece)
      MPI_Send(bytes.data() + at, static_cast<int>(std::min(kPiece, bytes.size() - at)), MPI_CHAR, to, 0,
               PETSC_COMM_WORLD);
  }

  std::vector<char> receive(int from) const override {
    std::uint64_t size = 0;
    MPI_Recv(&size, 1, MPI_UINT64_T, from, 0, PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
    std::vector<char> bytes(size);
    for (std::size_t at = 0; at < bytes.size(); at += kPiece)
      MPI_Recv(bytes.data() + at, static_cast<int>(std::min(kPiece, bytes.size() - at)), MPI_CHAR, from, 0,
               PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
    return bytes;
  }

 private:
  int rank_ = 0, count_ = 1;
};

}  // namespace

std::shared_ptr<const Processes> make_processes() { return std::make_shared<MpiProcesses>(); }

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
