#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include "elastin/openmp/openmp.h"

int main(int argc, char** argv) {
  elastin::openmp::use_openmp();
  return Catch::Session().run(argc, argv);
}
