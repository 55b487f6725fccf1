#pragma once
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>

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

/// How a process ended.
struct Ended {
  bool well = false;       ///< by itself, with status 0
  bool stopped = false;    ///< by us, because `stop` gave true
  bool timed_out = false;  ///< by us, because it took too long
  double seconds = 0;      ///< that it took
  std::string text;        ///< "status 3", "signal: Segmentation fault"
};

double seconds_since(std::chrono::steady_clock::time_point start);

/// Runs a script of sh, whose $0 is the folder and whose $1 is `argument`. The script and all that it has started are
/// ended where `stop` gives true, and after this many seconds. Throws InputError where no process can be started.
Ended run_process(const JobFolder& folder, const std::string& script, const std::string& argument,
                  const std::function<bool()>& stop, double seconds);

/// The last line of a file that names an error, or the last of all.
std::string complaint(const std::string& path);

}  // namespace elastin::lab
