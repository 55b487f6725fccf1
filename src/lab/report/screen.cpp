#include "lab/report/screen.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>

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

}  // namespace elastin::lab
