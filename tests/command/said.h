#pragma once
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>

#include "support/temporary_folder.h"

struct Said {
  int code;
  std::string out, err;
};

/// Runs the command in an empty folder of its own; arguments as a shell reads them.
inline Said say(const std::string& arguments) {
  const TemporaryFolder folder;
  const std::string line = "cd '" + folder.path("") + "' && NO_COLOR= '" ELASTIN_COMMAND "' " + arguments + " > '" +
                           folder.path("out") + "' 2> '" + folder.path("err") + "' < /dev/null";
  const int status = std::system(line.c_str());
  REQUIRE(WIFEXITED(status));
  return {WEXITSTATUS(status), text_of_file(folder.path("out")), text_of_file(folder.path("err"))};
}
