#pragma once
#include <string>
#include <vector>

namespace elastin::command {

/// The command line of one of several processes that mpiexec has started: the engine petsc unless it names one, its
/// share of the processor cores, and words and files, but for its pieces of states, by process 0 alone. Throws
/// InputError for what several processes cannot do together.
std::vector<std::string> shared_arguments(std::vector<std::string> arguments, int rank, int count);

}  // namespace elastin::command
