#pragma once
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace elastin::lab {

/// Writes a text to standard error. One that is closed or full is no reason to end: nothing is thrown.
void say(const std::string& text);

/// Columns of the terminal that tables are printed on; 0, as at the start, = as wide as they are. Of the whole program,
/// as the number of threads is.
void set_screen_width(std::size_t columns);
std::size_t screen_width();

/// Columns of the terminal behind a stream; 0 = it is no terminal, or its width is unknown.
std::size_t terminal_width(int stream);

/// Columns that a terminal uses for a UTF-8 text without wide characters.
std::size_t shown_width(const std::string& text);

/// The text in lines of at most `width` ≥ 1 columns, broken at blanks where it has them.
std::vector<std::string> folded(const std::string& text, std::size_t width);

/// How far a comparison is.
struct RunCount {
  std::size_t total = 0, done = 0;  ///< runs
  std::size_t timed = 0;            ///< of the finished ones, those that were run here
  double seconds = 0;               ///< that these took
};

/// Time that is left [s], from the mean of the runs so far. It never rises: while one takes longer than that, it stays
/// at what the others will take, and is said to be the least. NaN before the first is finished. `elapsed` [s]: of the
/// run under way.
double time_left(const RunCount& count, double elapsed);

/// "  12 s  run 3 of 18, about 40.00 s left: cube, lattice"
std::string progress_text(const RunCount& count, double elapsed, const std::string& doing);

/// Says on standard error what is going on: on a terminal in one line, from the second second on, which is wiped when
/// work pauses; elsewhere in a line every few seconds.
class Progress {
 public:
  enum class Show { nothing, line, lines };
  /// `lines` come that often [ms].
  explicit Progress(Show show, std::chrono::milliseconds every = std::chrono::seconds(5));
  ~Progress();
  void set(const std::string& doing);
  void set_count(const RunCount& count);
  /// Wipes the line, so that something else can be printed; the clock starts again with the next set().
  void pause();
  /// A line that stays: a run is finished. Only where the whole work takes long enough to report it.
  void note(const std::string& line);

 private:
  using Clock = std::chrono::steady_clock;
  void watch();
  void wipe();
  const Show show_;
  const std::chrono::milliseconds every_;
  bool stop_ = false, drawn_ = false;
  std::string doing_;
  RunCount count_;
  Clock::time_point start_, told_ = Clock::now();
  const Clock::time_point begin_ = Clock::now();
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace elastin::lab
