#pragma once
#include <fmt/format.h>

#include <iterator>
#include <string>
#include <utility>

#include "elastin/core/base/error.h"
#include "lab/export/problem.h"

namespace elastin::lab {

/// A text that grows, and the refusal of what its program does not support.
class Deck {
 protected:
  Deck(const char* program, const StaticProblem& problem) : program_(program), scene_(*problem.scene) {}

  template <class... Args>
  void write(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }
  [[noreturn]] void refuse(const std::string& what) const {
    throw InputError(SourceLocation{scene_.source.path()}, std::string(program_) + ": " + what);
  }

  std::string out_;

 private:
  const char* program_;
  const Scene& scene_;
};

}  // namespace elastin::lab
