#pragma once
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>

#include "support/temporary_folder.h"

namespace elastin {

/// Runs a shell line in the folder, where $elastin is the command; returns its exit code. What it prints goes to the
/// files out and err.
inline int shell(const TemporaryFolder& folder, const std::string& line) {
  const std::string whole =
      "cd '" + folder.path("") + "' && elastin='" ELASTIN_COMMAND "' bash -c '" + line + "' > out 2> err";
  const int status = std::system(whole.c_str());
  REQUIRE(WIFEXITED(status));
  return WEXITSTATUS(status);
}

}  // namespace elastin
