#pragma once
#include <string>
#include <string_view>

namespace elastin {

/// A word of a command line as a shell reads it: in quotes where it has blanks or other signs that mean something
/// there.
inline std::string shell_word(std::string_view word) {
  constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./,:=+@%";
  bool is_plain = !word.empty();
  std::string quoted = "'";
  for (const char sign : word) {
    is_plain &= plain.find(sign) != plain.npos || static_cast<unsigned char>(sign) >= 0x80;  // letters of UTF-8
    quoted += sign == '\'' ? std::string("'\\''") : std::string(1, sign);
  }
  return is_plain ? std::string(word) : quoted + "'";
}

}  // namespace elastin
