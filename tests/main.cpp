#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include "elastin/febio/febio.h"
#include "elastin/openmp/openmp.h"

int main(int argc, char** argv) {
  elastin::openmp::let_threads_sleep(argv);
  elastin::openmp::use_openmp();
  elastin::febio::add_scene_format();
  return Catch::Session().run(argc, argv);
}
