// The command: elastin run|compare|verify|check|list|plot.

#include "elastin/base/openmp.h"
#include "elastin/report/command.h"

int main(int argc, char** argv) {
  elastin::let_threads_sleep(argv);
  return elastin::run_command(argc, argv, elastin::built_in_catalog());
}
