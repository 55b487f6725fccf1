#pragma once
#include <functional>
#include <memory>
#include <string>

#include "command/options.h"
#include "elastin/core/simulation/catalog.h"

namespace elastin::command {

/// How the program was called.
struct Call {
  const Catalog& catalog;
  std::string line;  ///< as it was typed, for pages
};

/// Does what a command is for, with the options that were read; gives the exit code. Throws InputError.
using Action = std::function<int(const Call& call)>;

/// One command of the program.
struct CommandRow {
  const char *name, *summary;
  const char* examples;                 ///< lines without the program's name
  Action (*declare)(Options& options);  ///< names what the command takes
};

/// A command of one class: `add_to(options)` names its options, which are its members; `run(call)` does the work.
template <class Command>
Action declare(Options& options) {
  const auto command = std::make_shared<Command>();
  command->add_to(options);
  return [command](const Call& call) { return command->run(call); };
}

extern const CommandRow kRun, kCompare, kMerge, kVerify, kCheck, kIdentify, kList, kPlot, kLab, kExport, kNew;

}  // namespace elastin::command
