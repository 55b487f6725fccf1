// Feeds Elastin's readers with broken files: each must be read, or refused with an InputError, in 10 s and 2 GB.
//   elastin_fuzz [--seconds S] [--files N] [--seed N] [--kind scene|mesh|table|restart|override|journal] [--keep DIR]
//   elastin_fuzz --file FILE …     reads these alone, by their endings
// S counts processor time, so that a pause costs nothing; what comes first ends it. Finds stay in DIR with what was
// said; exit code 1 if there are any. Files that go new ways are changed further; -fsanitize-coverage=trace-pc tells
// more of them apart.
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <typeinfo>
#include <vector>

#include "elastin/core/base/error.h"
#include "elastin/core/parallel/threads.h"
#include "fuzz/coverage.h"
#include "fuzz/kinds.h"
#include "fuzz/mutate.h"

#if defined(__SANITIZE_ADDRESS__)
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "detect_leaks=0:quarantine_size_mb=16:max_allocation_size_mb=2048:hard_rss_limit_mb=3000:"
         "detect_stack_use_after_return=0";
}
#endif

namespace {

namespace fs = std::filesystem;

constexpr int kMostSeconds = 10;
constexpr long kMostKilobytes = 2 * 1024 * 1024;
constexpr int kSlow = 70, kLarge = 71;
/// Files that one process reads before a fresh one goes on.
constexpr long kBatch = 20000;

struct Options {
  double seconds = 60;
  long most_files = std::numeric_limits<long>::max();
  std::uint64_t seed = 1;
  std::string kind, keep;
  std::vector<std::string> files;
};

/// Counted by all processes.
struct Counts {
  long files = 0, read = 0, refused = 0, finds = 0, whole = 0;
};

double processor_seconds(int who) {
  rusage used{};
  getrusage(who, &used);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

void set_clock(int seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = seconds;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

[[noreturn]] void too_slow(int) { _exit(kSlow); }

void write(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

std::string bytes_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// What the reader said of a file: "" = it was read. A fault begins with "FIND: ".
std::string reading(const fuzz::Kind& kind, const std::string& path) {
  try {
    kind.read(path);
    return "";
  } catch (const elastin::InputError& error) {
    const std::string said = error.what(), name = fs::path(path).filename().string();
    if (said.empty() || (kind.names_file && said.find(name) == std::string::npos))
      return "FIND: a message that does not name the file: " + said;
    return said;
  } catch (const std::exception& error) {
    return std::string("FIND: ") + typeid(error).name() + ": " + error.what();
  }
}

class Fuzzer {
 public:
  Fuzzer(const Options& options, const fs::path& folder, Counts& counts)
      : options_(options), folder_(folder), counts_(counts), files_(folder / "files" / "here") {
    fs::create_directories(files_);
    fs::create_directories(folder_ / "ways");
    kinds_ = fuzz::all_kinds(ELASTIN_SOURCE_DIR, files_.string());
    if (!options.kind.empty()) std::erase_if(kinds_, [&](const auto& kind) { return kind.name != options.kind; });
    for (auto& kind : kinds_)  // what an earlier process found worth keeping
      for (std::size_t number = 0;; ++number) {
        const auto found = way_path(kind, number);
        if (!fs::exists(found)) break;
        kind.seeds.push_back({found.stem().extension().string(), bytes_of(found)});
      }
  }
  bool any() const { return !kinds_.empty(); }

  /// One process's share. Does not come back.
  [[noreturn]] void run(double seconds, std::uint64_t seed) {
    std::signal(SIGPROF, too_slow);
    fuzz::Mutator random(seed);
    const double until = processor_seconds(RUSAGE_SELF) + seconds;
    const auto goes_on = [&] { return counts_.files < options_.most_files && processor_seconds(RUSAGE_SELF) < until; };
    long number = 0;  // whole files first: they show the ways that are known
    for (fuzz::Kind& kind : kinds_)
      for (std::size_t s = 0; s < kind.seeds.size() && goes_on(); ++s)
        if (number++ == counts_.whole) {
          ++counts_.whole;
          read(kind, kind.seeds[s].ending, kind.seeds[s].bytes, false);
        }
    counts_.whole = std::numeric_limits<long>::max();
    for (long i = 0; i < kBatch && goes_on(); ++i) {
      fuzz::Kind& kind = kinds_[random.pick(kinds_.size())];
      const auto& seeds = kind.seeds;
      // Every second file is one of the newest.
      const std::size_t newest = std::min<std::size_t>(seeds.size(), 64);
      const fuzz::Seed& seed_file =
          seeds[random.pick(2) ? random.pick(seeds.size()) : seeds.size() - 1 - random.pick(newest)];
      const std::string ending = seed_file.ending;
      read(kind, ending, random.mutate(seed_file.bytes, seeds[random.pick(seeds.size())].bytes), true);
    }
    _exit(0);
  }

  void keep_find(const std::string& what) {
    const fs::path current = bytes_of(folder_ / "current");
    const fs::path to = folder_ / ("find-" + std::to_string(options_.seed) + "-" + std::to_string(counts_.finds++) +
                                   current.extension().string());
    std::error_code ignored;
    fs::copy_file(current, to, fs::copy_options::overwrite_existing, ignored);
    write(to.string() + ".txt", what);
    std::cout << to.string() << ": " << what.substr(0, 300) << std::endl;
  }

 private:
  fs::path way_path(const fuzz::Kind& kind, std::size_t number, const std::string& ending = "") const {
    if (!ending.empty()) return folder_ / "ways" / (kind.name + "-" + std::to_string(number) + ending + ".way");
    const std::string name = kind.name + "-" + std::to_string(number) + ".";
    for (const char* known :
         {"yaml", "msh", "vtk", "vtu", "bdf", "unv", "inp", "obj", "ply", "stl", "csv", "restart", "txt", "jsonl"})
      if (const fs::path path = folder_ / "ways" / (name + known + ".way"); fs::exists(path)) return path;
    return folder_ / "ways" / "none";
  }

  void read(fuzz::Kind& kind, const std::string& ending, const std::string& bytes, bool fresh) {
    const fs::path path = files_ / ("current" + ending);
    write(path, bytes);
    if (ending != ending_) write(folder_ / "current", path.string());
    ending_ = ending;
    fuzz::begin_coverage();
    set_clock(kMostSeconds);
    const std::string said = reading(kind, path.string());
    set_clock(0);
    ++counts_.files, ++(said.empty() ? counts_.read : counts_.refused);
    if (said.starts_with("FIND: ") && told_.insert(said.substr(0, 60)).second) keep_find(said);
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    if (used.ru_maxrss > kMostKilobytes) _exit(kLarge);
    if (fuzz::new_coverage(said) && fresh) {
      std::size_t number = ways_[kind.name];
      while (fs::exists(way_path(kind, number))) ++number;
      write(way_path(kind, number, ending), bytes);
      ways_[kind.name] = number + 1;
      kind.seeds.push_back({ending, bytes});
    }
  }

  const Options& options_;
  fs::path folder_;
  Counts& counts_;
  fs::path files_;
  std::vector<fuzz::Kind> kinds_;
  std::set<std::string> told_;
  std::map<std::string, std::size_t> ways_;
  std::string ending_;
};

/// Why a process ended that should not have; "" of one that is done.
std::string ending_of(int status) {
  if (WIFEXITED(status)) {
    const int code = WEXITSTATUS(status);
    if (code == 0) return "";
    if (code == kSlow) return "more than " + std::to_string(kMostSeconds) + " s";
    if (code == kLarge) return "more than 2 GB";
    return "exit code " + std::to_string(code);
  }
  return std::string("signal ") + strsignal(WTERMSIG(status));
}

/// Starts a process for each batch until the time is used up; goes on after one that broke.
void supervise(const Options& options, const fs::path& folder, Counts& counts) {
  Fuzzer fuzzer(options, folder, counts);
  if (!fuzzer.any()) throw elastin::InputError("no kind '" + options.kind + "'");
  const fs::path log = folder / "log";
  for (std::uint64_t batch = 0;; ++batch) {
    const double left = options.seconds - processor_seconds(RUSAGE_CHILDREN);
    if (left <= 0 || counts.files >= options.most_files) return;
    const pid_t child = fork();
    if (child == 0) {
      if (!std::freopen(log.c_str(), "w", stderr)) _exit(1);
      Fuzzer(options, folder, counts).run(left, options.seed * 1000003 + batch);
    }
    int status = 0;
    if (waitpid(child, &status, 0) != child) throw std::runtime_error("a process was lost");
    if (const std::string why = ending_of(status); !why.empty())
      fuzzer.keep_find(why + "\n" + bytes_of(log).substr(0, 8000));
  }
}

int read_alone(const std::vector<std::string>& files, const fs::path& folder) {
  const auto kinds = fuzz::all_kinds(ELASTIN_SOURCE_DIR, folder.string());
  bool good = true;
  std::signal(SIGPROF, too_slow);
  for (const std::string& file : files) {
    const std::string ending = fs::path(file).extension().string();
    for (const auto& kind : kinds)
      if (std::any_of(kind.seeds.begin(), kind.seeds.end(), [&](const auto& seed) { return seed.ending == ending; })) {
        const fs::path copy = folder / fs::path(file).filename();
        fs::copy_file(file, copy, fs::copy_options::overwrite_existing);
        set_clock(kMostSeconds);
        const std::string said = reading(kind, copy.string());
        set_clock(0);
        std::cout << file << ": " << (said.empty() ? "read" : said) << std::endl;
        good &= !said.starts_with("FIND: ");
      }
  }
  return good ? 0 : 1;
}

Options options_of(int count, char** words) {
  Options options;
  for (int i = 1; i + 1 < count; i += 2) {
    const std::string name = words[i], value = words[i + 1];
    if (name == "--seconds")
      options.seconds = std::stod(value);
    else if (name == "--seed")
      options.seed = std::stoull(value);
    else if (name == "--files")
      options.most_files = std::stol(value);
    else if (name == "--kind")
      options.kind = value;
    else if (name == "--keep")
      options.keep = value;
    else if (name == "--file") {
      options.files.assign(words + i + 1, words + count);
      return options;
    } else
      throw elastin::InputError("unknown option " + name);
  }
  return options;
}

}  // namespace

int main(int count, char** words) try {
  const Options options = options_of(count, words);
  elastin::set_threads(1);
  std::string made = (fs::temp_directory_path() / "elastin-fuzz-XXXXXX").string();
  if (options.keep.empty() && !mkdtemp(made.data())) throw std::runtime_error("cannot make " + made);
  const fs::path folder = fs::absolute(options.keep.empty() ? made : options.keep);
  fs::create_directories(folder / "files" / "alone");
  if (!options.files.empty()) return read_alone(options.files, folder / "files" / "alone");

  void* memory = mmap(nullptr, sizeof(Counts), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  Counts& counts = *new (memory) Counts;
  fuzz::share_coverage();
  supervise(options, folder, counts);
  std::cout << counts.files << " files: " << counts.read << " read, " << counts.refused << " refused, " << counts.finds
            << " finds; " << fuzz::coverage() << " ways" << std::endl;
  if (options.keep.empty() && counts.finds == 0) fs::remove_all(folder);
  return counts.finds > 0 ? 1 : 0;
} catch (const std::exception& error) {
  std::cerr << "elastin_fuzz: " << error.what() << std::endl;
  return 2;
}
