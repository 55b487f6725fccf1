#include "command/row.h"

#include <unistd.h>

#include <csignal>
#include <string_view>

namespace elastin::command {
namespace {

volatile std::sig_atomic_t noted = 0;

void note_interrupt(int) {
  constexpr std::string_view message = "\n  stopping after this run or step; Ctrl-C again stops at once\n";
  if (write(STDERR_FILENO, message.data(), message.size()) < 0) noted = 1;  // no terminal is left
  noted = 1;
  std::signal(SIGINT, SIG_DFL);
}

}  // namespace

void stop_on_interrupt() { std::signal(SIGINT, note_interrupt); }
bool interrupted() { return noted != 0; }

}  // namespace elastin::command
