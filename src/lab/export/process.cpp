#include "lab/export/process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
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

namespace {

/// A line that begins with '{' is kept up to the first of these lengths, any other up to the second.
constexpr std::size_t kLongestObject = std::size_t{1} << 30, kLongestLine = 300;

/// A pipe out of a process; what is there is read without waiting.
class Pipe {
 public:
  Pipe() {
    if (pipe(ends_.data()) != 0) throw InputError("no pipe could be opened: " + std::string(std::strerror(errno)));
    for (const int end : ends_) fcntl(end, F_SETFD, FD_CLOEXEC);
    fcntl(ends_[0], F_SETFL, O_NONBLOCK);
  }
  ~Pipe() {
    for (const int end : ends_)
      if (end >= 0) close(end);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int reading() const { return ends_[0]; }
  int writing() const { return ends_[1]; }
  void close_writing() { close(std::exchange(ends_[1], -1)); }
  /// Reads one piece, if there is any.
  bool read_into(KeptLines& lines) {
    std::array<char, 1 << 16> text;
    const ssize_t count = ends_[0] < 0 ? 0 : read(ends_[0], text.data(), text.size());
    if (count > 0) lines.add({text.data(), static_cast<std::size_t>(count)});
    if (count == 0 && ends_[0] >= 0) close(std::exchange(ends_[0], -1));  // nobody writes to it any more
    return count > 0;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

}  // namespace

void KeptLines::add(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view piece = text.substr(0, end);
    if (line_.empty()) piece.remove_prefix(std::min(piece.find_first_not_of(" \t\r"), piece.size()));
    const char first = !line_.empty() ? line_.front() : piece.empty() ? ' ' : piece.front();
    line_.append(piece.substr(0, (first == '{' ? kLongestObject : kLongestLine) - line_.size()));
    if (end == text.size()) return;
    finish();
    text.remove_prefix(end + 1);
  }
}

void KeptLines::finish() {
  if (line_.empty()) return;
  last_ = line_.substr(0, kLongestLine);
  if (last_.find("ERROR") != std::string::npos || last_.find("Error") != std::string::npos) error_ = last_;
  if (line_.front() == '{' && read_object_) read_object_(std::move(line_));
  line_ = {};
}

Ended run_process(const JobFolder& folder, const std::string& script, const std::string& argument,
                  const std::function<bool()>& stop, double seconds, const KeptLines::Read& read_object) {
  std::array<Pipe, 2> pipes;  // of its standard output and its standard error
  std::array<KeptLines, 2> kept{KeptLines(read_object), KeptLines()};
  posix_spawn_file_actions_t outputs;
  posix_spawn_file_actions_init(&outputs);
  posix_spawn_file_actions_adddup2(&outputs, pipes[0].writing(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&outputs, pipes[1].writing(), STDERR_FILENO);
  const std::string path = folder.path();
  const char* const words[] = {"sh", "-c", script.c_str(), path.c_str(), argument.c_str(), nullptr};
  posix_spawnattr_t group;
  posix_spawnattr_init(&group);
  posix_spawnattr_setflags(&group, POSIX_SPAWN_SETPGROUP);  // so that it is ended with all that it has started
  posix_spawnattr_setpgroup(&group, 0);
  pid_t process = 0;
  const int failed = posix_spawn(&process, "/bin/sh", &outputs, &group, const_cast<char* const*>(words), environ);
  posix_spawnattr_destroy(&group);
  posix_spawn_file_actions_destroy(&outputs);
  for (Pipe& one : pipes) one.close_writing();
  if (failed) throw InputError("no process could be started: " + std::string(std::strerror(failed)));
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  constexpr std::chrono::seconds grace(2);  // after SIGTERM
  Ended result;
  std::optional<Clock::time_point> asked_to_end;
  int status = 0;
  const auto read_all = [&](Clock::time_point until) {
    for (bool more = true; more && Clock::now() < until;) {
      more = pipes[0].read_into(kept[0]);
      more |= pipes[1].read_into(kept[1]);
    }
  };
  while (waitpid(process, &status, WNOHANG) != process) {
    if (!asked_to_end) {
      result.stopped = stop && stop();
      result.timed_out = !result.stopped && seconds_since(start) > seconds;
    }
    if (!asked_to_end && (result.stopped || result.timed_out)) {
      kill(-process, SIGTERM);
      asked_to_end = Clock::now();
    }
    if (asked_to_end && Clock::now() - *asked_to_end > grace) kill(-process, SIGKILL);
    constexpr int patience = 5;  // [ms]
    std::array<pollfd, 2> ends{pollfd{pipes[0].reading(), POLLIN, 0}, pollfd{pipes[1].reading(), POLLIN, 0}};
    poll(ends.data(), ends.size(), patience);  // one that is closed, -1, is passed over
    read_all(Clock::now() + std::chrono::milliseconds(patience));
  }
  kill(-process, SIGKILL);  // what it has left behind
  result.seconds = seconds_since(start);
  read_all(Clock::now() + grace);
  for (KeptLines& lines : kept) lines.finish();
  result.complaint = kept[kept[1].complaint().empty() ? 0 : 1].complaint();
  result.well = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  result.text = WIFSIGNALED(status) ? std::string("signal: ") + strsignal(WTERMSIG(status))
                                    : "status " + std::to_string(WEXITSTATUS(status));
  return result;
}

}  // namespace elastin::lab
