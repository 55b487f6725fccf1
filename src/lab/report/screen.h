#pragma once
#include <cstddef>
#include <string>
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

}  // namespace elastin::lab
