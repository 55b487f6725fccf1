#pragma once

namespace elastin::command {

/// From now on the first interrupt (SIGINT) ends a run after its step, in time or of the load, and a comparison or a
/// search after its run, with all files complete. The second one ends the program.
void stop_on_interrupt();
/// Whether there was one.
bool interrupted();

}  // namespace elastin::command
