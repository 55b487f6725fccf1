#include "lab/export/process.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <optional>
#include <thread>

#include "elastin/core/base/error.h"

namespace elastin::lab {

JobFolder::JobFolder(const std::string& program) {
  std::string pattern = (std::filesystem::temp_directory_path() / ("elastin-" + program + "-XXXXXX")).string();
  if (!mkdtemp(pattern.data())) throw InputError(program + ": cannot make a folder " + pattern + " for its files");
  path_ = pattern;
}

JobFolder::~JobFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Ended run_process(const JobFolder& folder, const std::string& script, const std::string& argument,
                  const std::function<bool()>& stop, double seconds) {
  const std::string path = folder.path();
  const char* const words[] = {"sh", "-c", script.c_str(), path.c_str(), argument.c_str(), nullptr};
  posix_spawnattr_t group;
  posix_spawnattr_init(&group);
  posix_spawnattr_setflags(&group, POSIX_SPAWN_SETPGROUP);  // so that it is ended with all that it has started
  posix_spawnattr_setpgroup(&group, 0);
  pid_t process = 0;
  const int failed = posix_spawn(&process, "/bin/sh", nullptr, &group, const_cast<char* const*>(words), environ);
  posix_spawnattr_destroy(&group);
  if (failed) throw InputError("no process could be started: " + std::string(std::strerror(failed)));
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  constexpr std::chrono::seconds kGrace(2);  // after SIGTERM
  Ended result;
  std::optional<Clock::time_point> told;
  int status = 0;
  while (waitpid(process, &status, WNOHANG) != process) {
    if (!told) {
      result.stopped = stop && stop();
      result.timed_out = !result.stopped && seconds_since(start) > seconds;
    }
    if (!told && (result.stopped || result.timed_out)) {
      kill(-process, SIGTERM);
      told = Clock::now();
    }
    if (told && Clock::now() - *told > kGrace) kill(-process, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  kill(-process, SIGKILL);  // what it has left behind
  result.seconds = seconds_since(start);
  result.well = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  result.text = WIFSIGNALED(status) ? std::string("signal: ") + strsignal(WTERMSIG(status))
                                    : "status " + std::to_string(WEXITSTATUS(status));
  return result;
}

std::string complaint(const std::string& path) {
  std::ifstream file(path);
  std::string last, error;
  for (std::string line; std::getline(file, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    last = line.substr(line.find_first_not_of(" \t\r"), 300);
    if (last.find("ERROR") != std::string::npos || last.find("Error") != std::string::npos) error = last;
  }
  return error.empty() ? last : error;
}

}  // namespace elastin::lab
