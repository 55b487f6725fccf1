#pragma once
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace elastin::lab {

/// A folder that nobody else can read or foresee, and that goes with its owner.
class JobFolder {
 public:
  /// `program`, a word, becomes part of its name. Throws InputError.
  explicit JobFolder(const std::string& program);
  ~JobFolder();
  JobFolder(const JobFolder&) = delete;
  JobFolder& operator=(const JobFolder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// The lines kept of a stream, whatever its length: the last one, the last that names an error, and those that begin
/// with '{', for the caller.
class KeptLines {
 public:
  using Read = std::function<void(std::string&& line)>;
  explicit KeptLines(Read read_object = {}) : read_object_(std::move(read_object)) {}
  void add(std::string_view text);
  /// Ends the last line, where no end of it came.
  void finish();
  /// The last line that names an error, or the last of all, up to 300 characters.
  const std::string& complaint() const { return error_.empty() ? last_ : error_; }

 private:
  Read read_object_;
  std::string line_, last_, error_;
};

/// How a process ended.
struct Ended {
  bool well = false;       ///< by itself, with status 0
  bool stopped = false;    ///< by us, because `stop` gave true
  bool timed_out = false;  ///< by us, because it took too long
  double seconds = 0;      ///< that it took
  std::string text;        ///< "status 3", "signal: Segmentation fault"
  std::string complaint;   ///< of its standard error, or where nothing stands there of its standard output
};

double seconds_since(std::chrono::steady_clock::time_point start);

/// Runs a script of sh, whose $0 is the folder and whose $1 is `argument`. The script and all that it has started are
/// ended where `stop` gives true, and after this many seconds. What it prints comes through pipes, and no file grows by
/// it; `read_object` gets each line of its standard output that begins with '{'. A script that prints ends where this
/// process has ended. Throws InputError where no process can be started.
Ended run_process(const JobFolder& folder, const std::string& script, const std::string& argument,
                  const std::function<bool()>& stop, double seconds, const KeptLines::Read& read_object = {});

}  // namespace elastin::lab
