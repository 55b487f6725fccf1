#pragma once
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace elastin {

/// Where a piece of input stands. Line and column count from 1; 0 = not known.
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;
  /// "file:line:column", without the parts that are not known.
  std::string text() const;
};

/// Wrong use or wrong input. The message names the key, what was given, what is allowed and the nearest name;
/// with a source location it starts with file:line:column. The command ends with exit code 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message) {}
  InputError(const SourceLocation& location, const std::string& message)
      : std::runtime_error(location.text() + ": " + message), has_location_(true) {}
  /// Whether the message already starts with a source location, so that no second one is put in front.
  bool has_location() const { return has_location_; }

 private:
  bool has_location_ = false;
};

/// The candidate that is nearest to `word` by edit distance (swaps of neighbours count one), or "" if none is near
/// (more than a third of the letters, at least two, would change).
std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates);

/// "; did you mean 'x'? (allowed: x, y)", or "; allowed: x, y" if none is near: the tail of every "unknown name"
/// message.
std::string suggestion(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace elastin
