#include "lab/report/screen.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>

#include "lab/report/table.h"

namespace elastin::lab {
namespace {

std::atomic<std::size_t> width_of_screen{0};

bool begins_letter(char c) { return (c & 0xC0) != 0x80; }

/// Bytes of the first `columns` letters.
std::size_t bytes_of(const std::string& text, std::size_t columns) {
  std::size_t at = 0, letters = 0;
  while (at < text.size() && (letters += begins_letter(text[at])) <= columns) ++at;
  return at;
}

}  // namespace

void say(const std::string& text) { std::fputs(text.c_str(), stderr); }

void set_screen_width(std::size_t columns) { width_of_screen = columns; }
std::size_t screen_width() { return width_of_screen; }

std::size_t terminal_width(int stream) {
  winsize size{};
  return isatty(stream) && ioctl(stream, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

std::size_t shown_width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins_letter));
}

std::vector<std::string> folded(const std::string& text, std::size_t width) {
  std::vector<std::string> lines;
  std::string rest = text;
  while (shown_width(rest) > width) {
    const std::size_t most = bytes_of(rest, width);
    std::size_t end = rest.find_last_of(' ', most);  // the blank itself may stand behind the last column
    if (end == std::string::npos || end == 0) end = most;
    lines.push_back(rest.substr(0, end));
    rest.erase(0, std::min(rest.find_first_not_of(' ', end), rest.size()));
  }
  lines.push_back(rest);
  return lines;
}

using namespace std::chrono_literals;

namespace {

double seconds_of(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

double time_left(const RunCount& count, double elapsed) {
  if (count.timed == 0 || count.done >= count.total) return std::nan("");
  const auto timed = static_cast<double>(count.timed), open = static_cast<double>(count.total - count.done);
  const double mean = count.seconds / timed;
  return std::max(mean * open - elapsed, mean * (open - 1));
}

std::string progress_text(const RunCount& count, double elapsed, const std::string& doing) {
  std::string text = fmt::format("  {:.0f} s  ", elapsed);
  if (count.total > 1) {
    text += fmt::format("run {} of {}", count.done + 1, count.total);
    const double left = time_left(count, elapsed);
    const bool overdue = count.timed > 0 && elapsed * static_cast<double>(count.timed) > count.seconds;
    if (left > 0) text += (overdue ? ", at least " : ", about ") + readable_seconds(left) + " left";
    text += ": ";
  }
  return text + doing;
}

Progress::Progress(Show show, std::chrono::milliseconds every) : show_(show), every_(every) {
  if (show_ != Show::nothing) thread_ = std::thread([this] { watch(); });
}

Progress::~Progress() {
  if (show_ == Show::nothing) return;
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Progress::set(const std::string& doing) {
  const std::lock_guard lock(mutex_);
  if (doing_.empty()) start_ = Clock::now();
  doing_ = doing;
}

void Progress::set_count(const RunCount& count) {
  const std::lock_guard lock(mutex_);
  count_ = count;
}

void Progress::pause() {
  const std::lock_guard lock(mutex_);
  doing_.clear();
  wipe();
}

void Progress::note(const std::string& line) {
  const std::lock_guard lock(mutex_);
  if (show_ == Show::nothing || Clock::now() - begin_ < (show_ == Show::line ? std::chrono::milliseconds(1s) : every_))
    return;
  wipe();
  say(line + "\n");
  told_ = Clock::now();
}

void Progress::wipe() {
  if (drawn_) say("\r\033[K");
  drawn_ = false;
}

void Progress::watch() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    wake_.wait_for(lock, show_ == Show::line ? 200ms : std::min<std::chrono::milliseconds>(200ms, every_));
    const auto now = Clock::now();
    if (stop_ || doing_.empty()) continue;
    const std::string text = progress_text(count_, seconds_of(now - start_), doing_);
    if (show_ == Show::line && now - start_ >= 1s) {
      say("\r\033[K" + text);
      std::fflush(stderr);
      drawn_ = true;
    } else if (show_ == Show::lines && now - told_ >= every_) {
      say(text + "\n");
      told_ = now;
    }
  }
}

}  // namespace elastin::lab
