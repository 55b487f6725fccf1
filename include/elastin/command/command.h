#pragma once
#include "elastin/core/simulation/catalog.h"

namespace elastin::command {

/// All commands of the program `elastin`, with the strategies of this catalog: a program that adds its own laws to
/// built_in_catalog() compares them with the others by the same scenes, tables and pages. Takes main's arguments and
/// prints to standard output and error, under the name that the program was called by. From the first `run`, `compare`
/// or `identify` on, the first interrupt (SIGINT) ends a run with its files complete.
/// Gives the exit code: 0 all expectations hold, 1 an expectation or a run failed, 2 wrong use or input. Throws
/// nothing.
int run_command(int argc, const char* const* argv, const Catalog& catalog);

}  // namespace elastin::command
