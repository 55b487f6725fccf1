#include "elastin/core/base/text.h"

#include <charconv>
#include <cstdio>

namespace elastin {

std::string number(double value, int digits) {
  char text[40];
#ifdef __cpp_lib_to_chars
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits).ptr};
#else  // of libc++ before version 20; browsers have no locale that writes decimal commas
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
#endif
}

std::string counted(std::ptrdiff_t count, const std::string& singular, const std::string& plural) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural.empty() ? singular + "s" : plural);
}

std::string listed(const std::vector<std::string>& items, const std::string& before_last) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i)
    text += (i == 0 ? "" : i + 1 < items.size() ? ", " : " " + before_last + " ") + items[i];
  return text;
}

}  // namespace elastin
