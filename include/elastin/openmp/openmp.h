#pragma once

namespace elastin::openmp {

/// Loops over large bodies run on OpenMP's threads from now on, unless the program has set a runner of its own
/// (set_runner). Of the library elastin::openmp: elastin::core alone knows no OpenMP. Gives false, and changes nothing,
/// where that was built without it.
bool use_openmp();

/// For the first line of a main() whose threads are OpenMP's: threads that wait shall soon sleep. One that spins keeps
/// a busy machine from running the one it waits for, and a pass over the body then takes 20 times as long. OpenMP reads
/// its setting once, before main, so the program restarts itself. Does nothing where the environment already says
/// it.
void let_threads_sleep(char** argv);

}  // namespace elastin::openmp
