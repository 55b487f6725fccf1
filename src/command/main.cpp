// The command: elastin run|compare|verify|check|list|plot.

#include "elastin/command/command.h"
#include "elastin/openmp/openmp.h"

int main(int argc, char** argv) {
  elastin::openmp::let_threads_sleep(argv);
  return elastin::command::run_command(argc, argv, elastin::built_in_catalog());
}
