#include "config/scene_text.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

namespace elastin::config {
namespace {

/// A bracket or quote with its position, from 0.
struct Mark {
  char sign;
  std::size_t line, column;
};

/// One line of a scene, as far as YAML sees it.
struct Line {
  std::string text;        ///< without the comment and the blanks at its end
  std::size_t indent = 0;  ///< blanks before the first word
  bool block = false;      ///< begins outside brackets, quotes and folded texts, and is not empty
};

/// The lines of a text, and its brackets and quotes that do not pair.
struct Outline {
  std::vector<Line> lines;
  std::vector<Mark> open;       ///< brackets that are not closed
  std::optional<Mark> quote;    ///< one that is not closed
  std::optional<Mark> surplus;  ///< a bracket that closes nothing, or another kind
  std::optional<Mark> behind;   ///< text that follows a closing bracket or quote on its line; the sign is that one
};

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  return first == std::string_view::npos ? ""
                                         : std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char letter : text)
    if (letter == '\n')
      lines.emplace_back();
    else if (letter != '\r')
      lines.back() += letter;
  return lines;
}

/// Reads brackets, quotes, comments and folded texts of a scene line by line.
class Scanner {
 public:
  explicit Scanner(const std::string& text) {
    for (const std::string& line : lines_of(text)) scan(line);
    if (quote_) outline_.quote = quote_;
    outline_.open = open_;
  }
  const Outline& outline() const { return outline_; }

 private:
  void scan(const std::string& line) {
    const std::size_t number = outline_.lines.size(), first = line.find_first_not_of(' ');
    Line seen{line, first == std::string::npos ? line.size() : first, false};
    if (folded_ && (first == std::string::npos || first > *folded_)) {
      outline_.lines.push_back(std::move(seen));
      return;
    }
    folded_.reset();
    seen.block = !quote_ && open_.empty();
    std::size_t end = line.size();
    bool begins = true;  // a quote or a bracket here begins a value
    std::optional<char> closed;
    for (std::size_t at = 0; at < line.size(); ++at) {
      const char letter = line[at];
      if (quote_) {
        const bool doubled = letter == '\'' && letter == quote_->sign && at + 1 < line.size() && line[at + 1] == '\'';
        if (doubled || (letter == '\\' && quote_->sign == '"'))
          ++at;
        else if (letter == quote_->sign)
          closed = letter, quote_.reset(), begins = false;
        continue;
      }
      const bool blank = letter == ' ' || letter == '\t';
      if (letter == '#' && (at == 0 || line[at - 1] == ' ' || line[at - 1] == '\t')) {
        end = at;
        break;
      }
      if (blank) continue;
      const bool flow = !open_.empty();
      if (closed && letter != ':' && !(flow && (letter == ',' || letter == ']' || letter == '}')) && !outline_.behind)
        outline_.behind = Mark{*closed, number, at};
      closed.reset();
      if ((letter == '"' || letter == '\'') && begins) {
        quote_ = Mark{letter, number, at};
      } else if ((letter == '[' || letter == '{') && (begins || flow)) {
        open_.push_back({letter, number, at});
        begins = true;
        continue;
      } else if ((letter == ']' || letter == '}') && flow) {
        const bool pairs = open_.back().sign == (letter == ']' ? '[' : '{');
        if (!pairs && !outline_.surplus) outline_.surplus = Mark{letter, number, at};
        if (!pairs) continue;
        open_.pop_back();
        closed = letter;
      } else if ((letter == ']' || letter == '}') && !flow && at > 0 && (line[at - 1] == ']' || line[at - 1] == '}') &&
                 !outline_.surplus) {
        outline_.surplus = Mark{letter, number, at};
      }
      const bool spaced = at + 1 == line.size() || line[at + 1] == ' ' || line[at + 1] == '\t';
      const bool item = letter == '-' && line.find_first_not_of(" -") >= at + 1;
      begins = (flow && letter == ',') || ((letter == ':' || item) && spaced);
    }
    seen.text = line.substr(0, end);
    seen.text.erase(seen.text.find_last_not_of(" \t") + 1);
    if (seen.text.empty()) seen.block = false;
    const std::size_t sign = seen.text.find_last_of("|>");
    if (seen.block && !quote_ && open_.empty() && sign != std::string::npos && sign > 0 && seen.text[sign - 1] == ' ' &&
        seen.text.find_first_not_of("+-123456789", sign + 1) == std::string::npos)
      folded_ = seen.indent;
    outline_.lines.push_back(std::move(seen));
  }

  Outline outline_;
  std::vector<Mark> open_;
  std::optional<Mark> quote_;
  std::optional<std::size_t> folded_;  ///< indentation of the key whose text goes on below
};

/// Bytes of the UTF-8 letter that begins here; 0 where none does. [Unicode 15, table 3-7, without its finer ranges]
std::size_t letter_bytes(const std::string& text, std::size_t at) {
  const auto byte = static_cast<unsigned char>(text[at]);
  const std::size_t bytes = byte < 0x80                   ? 1
                            : byte >= 0xC2 && byte < 0xE0 ? 2
                            : byte >= 0xE0 && byte < 0xF0 ? 3
                            : byte >= 0xF0 && byte < 0xF5 ? 4
                                                          : 0;
  for (std::size_t i = 1; i < bytes; ++i)
    if (at + i >= text.size() || (static_cast<unsigned char>(text[at + i]) & 0xC0) != 0x80) return 0;
  return bytes;
}

/// The same line with each byte above 127 that is no UTF-8 as the letter that it is in Latin-1.
std::string from_latin_1(const std::string& line) {
  std::string utf8;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t bytes = letter_bytes(line, at);
    if (bytes > 0) {
      utf8 += line.substr(at, bytes);
      at += bytes;
      continue;
    }
    const auto byte = static_cast<unsigned char>(line[at++]);
    utf8 += static_cast<char>(0xC0 | (byte >> 6));
    utf8 += static_cast<char>(0x80 | (byte & 0x3F));
  }
  return utf8;
}

/// "key: value" or "- key: value": where the value begins; nothing where the line has no key.
std::optional<std::size_t> value_at(const std::string& line) {
  const std::size_t colon = line.find(": ");
  if (colon != std::string::npos) return line.find_first_not_of(' ', colon + 1);
  return line.ends_with(':') ? std::optional(line.size()) : std::nullopt;
}

class Explanation {
 public:
  Explanation(const std::string& path, const std::string& text) : path_(path), outline_(Scanner(text).outline()) {}

  void check_quotes() const {
    if (outline_.quote)
      throw at(*outline_.quote, std::string("the quote ") + outline_.quote->sign +
                                    " that begins here has no end; write " + trimmed(line(outline_.quote->line)) +
                                    outline_.quote->sign);
  }

  const Outline& outline() const { return outline_; }

  InputError of(const SourceLocation& refused, const std::string& reason) const {
    if (auto fault = of_brackets()) return *fault;
    const std::size_t last = std::min(static_cast<std::size_t>(std::max(1, refused.line)), outline_.lines.size()) - 1;
    if (auto fault = of_values(last)) return *fault;
    if (auto fault = of_colons(last)) return *fault;
    if (auto fault = of_indents(last)) return *fault;
    return InputError(refused, "not valid YAML: " + reason);
  }

 private:
  const std::string& line(std::size_t number) const { return outline_.lines[number].text; }
  InputError at(std::size_t number, std::size_t column, const std::string& message) const {
    return {SourceLocation{path_, static_cast<int>(number) + 1, static_cast<int>(column) + 1},
            "not valid YAML: " + message};
  }
  InputError at(const Mark& mark, const std::string& message) const { return at(mark.line, mark.column, message); }

  /// The lines before and behind this one that hold keys; `lines.size()` if there is no such line.
  std::size_t before(std::size_t number) const {
    while (number-- > 0)
      if (outline_.lines[number].block) return number;
    return outline_.lines.size();
  }
  std::size_t behind(std::size_t number) const {
    while (++number < outline_.lines.size())
      if (outline_.lines[number].block) return number;
    return outline_.lines.size();
  }

  std::optional<InputError> of_brackets() const {
    if (outline_.surplus) {
      const Mark& mark = *outline_.surplus;
      const std::string& text = line(mark.line);
      std::string mended = text;
      const char wanted = mark.sign == ']' ? '}' : ']';
      if (outline_.open.empty()) return at(mark, std::string("this ") + mark.sign + " closes nothing; leave it out");
      const Mark& open = outline_.open.back();
      mended.insert(mark.column, 1, wanted);
      return at(mark, std::string("the ") + open.sign + " in column " + std::to_string(open.column + 1) + " of line " +
                          std::to_string(open.line + 1) + " is not closed before this " + mark.sign + "; write " +
                          trimmed(mended));
    }
    if (outline_.behind) {
      const Mark& mark = *outline_.behind;
      const std::string& text = line(mark.line);
      const auto value = value_at(text);
      const std::string rest = text.substr(mark.column), key = value ? trimmed(text.substr(0, *value)) : "";
      if (mark.sign == ']' || mark.sign == '}') {
        const std::size_t open = text.rfind(mark.sign == ']' ? '[' : '{', mark.column);
        const std::string list = open == std::string::npos ? "" : text.substr(open + 1, mark.column - open);
        if (mark.sign == ']' && list.find_first_of("0123456789") != std::string::npos) {
          const std::string unit = trimmed(rest.substr(0, rest.find_first_of(",}]")));
          std::string each = list.substr(0, list.find(']'));
          for (std::size_t comma = 0; (comma = each.find(',', comma)) != std::string::npos; comma += unit.size() + 2)
            each.insert(comma, " " + unit);
          return at(mark, "each value of a list has its own unit; write [" + each + " " + unit + "]");
        }
        return at(mark, std::string("text follows behind ") + mark.sign +
                            "; a text that has brackets stands in quotes: write " + key + " \"" +
                            trimmed(value ? text.substr(*value) : text) + "\"");
      }
      std::string inside = value ? text.substr(*value) : text;
      std::erase(inside, '"');
      if (inside.size() > 1 && inside.front() == '\'' && inside.back() == '\'')
        inside = inside.substr(1, inside.size() - 2);
      return at(mark, std::string("the text ended with the quote ") + mark.sign + " before; write " + key + " \"" +
                          inside + "\"");
    }
    if (outline_.open.empty()) return std::nullopt;
    const Mark& open = outline_.open.back();
    std::string mended = line(open.line);
    for (auto mark = outline_.open.rbegin(); mark != outline_.open.rend() && mark->line == open.line; ++mark)
      mended += mark->sign == '[' ? ']' : '}';
    return at(open, std::string("this ") + open.sign + " is not closed; write " + trimmed(mended));
  }

  /// A value that YAML takes for something else: it has a colon, or begins with a sign of YAML's own.
  std::optional<InputError> of_values(std::size_t last) const {
    const Line& seen = outline_.lines[last];
    if (!seen.block) return std::nullopt;
    const auto value = value_at(seen.text);
    if (!value || *value >= seen.text.size()) return std::nullopt;
    const std::string text = seen.text.substr(*value), key = trimmed(seen.text.substr(0, *value));
    const bool quoted = text.find_first_of("\"'[{") == 0;
    if (!quoted && std::string_view("@`%&*!|>").find(text.front()) != std::string_view::npos)
      return at(last, *value,
                std::string("a text that begins with ") + text.front() + " stands in quotes; write " + key + " \"" +
                    text + "\"");
    if (!quoted && (text.find(": ") != std::string::npos || text.ends_with(':')))
      return at(last, *value, "a text that has a colon stands in quotes; write " + key + " \"" + text + "\"");
    return std::nullopt;
  }

  /// A line that is to have a key and has no colon, or no blank behind it.
  std::optional<InputError> of_colons(std::size_t last) const {
    std::size_t number = outline_.lines[last].block ? last : before(last);
    for (int back = 0; back < 2 && number < outline_.lines.size(); ++back, number = before(number)) {
      const Line& seen = outline_.lines[number];
      const std::string text = trimmed(seen.text);
      if (value_at(seen.text) || text.starts_with("- ") || text == "-") continue;
      const std::size_t equals = text.find('='), colon = text.find(':'), blank = text.find(' ');
      if (equals != std::string::npos && equals > 0)
        return at(number, seen.indent,
                  "a colon stands between a key and its value; write " + trimmed(text.substr(0, equals)) + ": " +
                      trimmed(text.substr(equals + 1)));
      if (colon != std::string::npos && colon > 0)
        return at(
            number, seen.indent + colon,
            "a blank stands behind the colon of a key; write " + text.substr(0, colon) + ": " + text.substr(colon + 1));
      if (blank == std::string::npos) return at(number, seen.indent, "a key ends with a colon; write " + text + ":");
      return at(number, seen.indent,
                "a colon stands between a key and its value; write " + text.substr(0, blank) + ": " +
                    trimmed(text.substr(blank)) + ", or put a # before a comment");
    }
    return std::nullopt;
  }

  InputError odd(std::size_t number, std::size_t indent, const std::string& otherwise = "") const {
    const Line& seen = outline_.lines[number];
    const auto blanks = [](std::size_t count) { return std::to_string(count) + (count == 1 ? " blank" : " blanks"); };
    return at(number, seen.indent,
              "keys of one map begin in one column, and this line begins with " + blanks(seen.indent) + "; write '" +
                  std::string(indent, ' ') + seen.text.substr(seen.indent) + "'" + otherwise);
  }

  /// A line that begins in another column than its neighbours.
  std::optional<InputError> of_indents(std::size_t last) const {
    const std::size_t none = outline_.lines.size();
    for (std::size_t number : {last, behind(last)}) {
      if (number >= none || !outline_.lines[number].block) continue;
      const std::size_t above = before(number), below = behind(number);
      if (above >= none) continue;
      const Line &seen = outline_.lines[number], &upper = outline_.lines[above];
      const auto value = value_at(upper.text);
      const bool full = value && *value < upper.text.size();
      if (seen.indent > upper.indent && full) {
        const std::size_t first = before(above);
        const bool level = first < none && outline_.lines[first].indent == seen.indent;
        const auto opened = first < none ? value_at(outline_.lines[first].text) : std::nullopt;
        if (level ||
            (opened && *opened == outline_.lines[first].text.size() && outline_.lines[first].indent == upper.indent))
          return odd(above, seen.indent,
                     ", or leave its value out if the lines below belong to it");  // it stands too far left
        if (below < none && outline_.lines[below].indent > upper.indent)
          return at(number, seen.indent,
                    "the key of line " + std::to_string(above + 1) + " has the value '" + upper.text.substr(*value) +
                        "' already, so that no keys can stand below it; leave that value out, or write '" +
                        std::string(upper.indent, ' ') + seen.text.substr(seen.indent) + "'");
        return odd(number, upper.indent);
      }
      if (seen.indent < upper.indent) {
        std::size_t outer = above;
        while (outer < none && outline_.lines[outer].indent > seen.indent) outer = before(outer);
        if (outer >= none || outline_.lines[outer].indent != seen.indent) return odd(number, upper.indent);
      }
    }
    return std::nullopt;
  }

  const std::string& path_;
  const Outline outline_;
};

}  // namespace

void check_scene_text(const std::string& path, const std::string& text) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") || text.find('\0') != std::string::npos)
    throw InputError(SourceLocation{path, 1, 1},
                     "a scene is text in UTF-8, and this file is UTF-16 or no text; save it as UTF-8");
  const std::vector<std::string> lines = lines_of(text);
  for (std::size_t number = 0; number < lines.size(); ++number) {
    const std::string& line = lines[number];
    for (std::size_t at = 0; at < line.size();) {
      const std::size_t bytes = letter_bytes(line, at);
      if (bytes == 0)
        throw InputError(
            SourceLocation{path, static_cast<int>(number) + 1, static_cast<int>(at) + 1},
            "this letter is not UTF-8; save the file as UTF-8 (it seems to be Latin-1), so that the line reads " +
                trimmed(from_latin_1(line)));
      at += bytes;
    }
  }
  const Explanation explanation(path, text);
  for (std::size_t number = 0; number < lines.size(); ++number) {
    const Line& seen = explanation.outline().lines[number];
    const std::size_t first = lines[number].find_first_not_of(" \t");
    const std::size_t tab = lines[number].find('\t');
    if (!seen.block || first == std::string::npos || tab >= first) continue;
    const auto tabs = static_cast<std::size_t>(
        std::count(lines[number].begin(), lines[number].begin() + static_cast<std::ptrdiff_t>(first), '\t'));
    std::size_t indent = 2 * tabs + first - tabs;
    if (number > 0 && explanation.outline().lines[number - 1].block) {  // as its neighbour above, if that is near
      const Line& above = explanation.outline().lines[number - 1];
      if (!above.text.ends_with(':')) indent = above.indent;
    }
    throw InputError(SourceLocation{path, static_cast<int>(number) + 1, static_cast<int>(tab) + 1},
                     "not valid YAML: a tab indents this line, and only blanks may; write '" +
                         std::string(indent, ' ') + trimmed(lines[number]) + "'");
  }
  explanation.check_quotes();
}

InputError explain_yaml(const std::string& path, const std::string& text, const SourceLocation& refused,
                        const std::string& reason) {
  return Explanation(path, text).of(refused, reason);
}

}  // namespace elastin::config
