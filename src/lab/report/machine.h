#pragma once
#include <string>

namespace elastin::lab {

/// "Elastin 0.2.0, commit 1234567890ab": this program; without the commit where it was built outside its repository.
std::string program_text();

/// What figures were measured on.
struct Machine {
  std::string processor;
  int cores = 0;
  double load = 0;  ///< of all its programs, over the last minute; NaN where it is unknown
  std::string compiler, flags;
  std::string text() const;  ///< in one line
};
Machine this_machine();

}  // namespace elastin::lab
