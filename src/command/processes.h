#pragma once
#include <string>
#include <vector>

namespace elastin::command {

/// The command line of one of several processes that mpiexec has started. It adds the engine petsc where the line names
/// none, and a share of the processor cores. Only process 0 prints, and only it writes files other than its pieces of
/// states. Throws InputError for what several processes cannot do together.
std::vector<std::string> shared_arguments(std::vector<std::string> arguments, int rank, int count);

}  // namespace elastin::command
