#include "lab/identify/machine_file.h"

#include <fmt/format.h>
#include <iconv.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "elastin/core/base/text.h"

namespace elastin::lab {
namespace {

struct Cell {
  std::string text;
  int column = 1;
};

/// A line that is neither blank nor a remark.
struct Line {
  int number = 1;
  std::vector<Cell> cells = {};
  int numbers = 0;  ///< cells that are numbers
  int filled = 0;   ///< cells that are not empty
};

/// The text in UTF-8; "" where it is not of this encoding.
std::string converted(const std::string& bytes, const char* encoding) {
  const iconv_t converter = iconv_open("UTF-8", encoding);
  if (converter == iconv_t(-1)) return "";
  std::string text(4 * bytes.size() + 4, '\0'), input = bytes;
  char *from = input.data(), *to = text.data();
  std::size_t left = input.size(), room = text.size();
  const bool whole = iconv(converter, &from, &left, &to, &room) != static_cast<std::size_t>(-1);
  iconv_close(converter);
  text.resize(text.size() - room);
  return whole ? text : "";
}

/// Whether the letters above 127 stand in pairs, as those of Chinese do: of Western languages they stand alone.
bool in_pairs(const std::string& bytes) {
  int alone = 0, paired = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (static_cast<unsigned char>(bytes[i]) < 0x80) continue;
    const bool pair = i + 1 < bytes.size() && static_cast<unsigned char>(bytes[i + 1]) >= 0x80;
    ++(pair ? paired : alone);
    i += pair;
  }
  return paired > alone;
}

std::string text_of(const std::string& path, std::string& encoding) {
  std::ifstream stream(path, std::ios::binary);
  std::error_code ignored;
  if (!stream || std::filesystem::is_directory(path, ignored)) throw InputError(SourceLocation{path}, "cannot be read");
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  const auto refuse = [&](const std::string& why) { throw InputError(SourceLocation{path}, why); };
  if (bytes.starts_with("PK\x03\x04") || bytes.starts_with("\xD0\xCF\x11\xE0"))
    refuse("is a spreadsheet or an archive and not text: save the sheet as CSV");
  std::ptrdiff_t odd = 0, even = 0;  // zero bytes at odd places: UTF-16, little end first
  for (std::size_t i = 0; i < bytes.size(); ++i) (i % 2 ? odd : even) += bytes[i] == 0;
  const auto many = static_cast<std::ptrdiff_t>(bytes.size() / 5);
  std::string text;
  if (bytes.starts_with("\xFF\xFE") || (odd > many && odd > even))
    text = converted(bytes, (encoding = "UTF-16LE").c_str());
  else if (bytes.starts_with("\xFE\xFF") || even > many)
    text = converted(bytes, (encoding = "UTF-16BE").c_str());
  else if (odd + even > 0)
    refuse("is no text: save the data as CSV");
  else if (text = converted(bytes, "UTF-8"); text.empty() && in_pairs(bytes))
    text = converted(bytes, (encoding = "GB18030").c_str());
  if (text.empty() && !bytes.empty()) text = converted(bytes, (encoding = "WINDOWS-1252").c_str());
  if (text.empty() && !bytes.empty()) refuse("is no text in UTF-8, UTF-16, Latin-1 or GB 18030: save the data as CSV");
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

std::string trimmed(std::string text) {
  for (const char* blank : {"\u00a0", "\u202f", "\u2009"})
    for (std::size_t at = 0; (at = text.find(blank, at)) != std::string::npos;)
      text.replace(at, std::char_traits<char>::length(blank), " ");
  const auto is_blank = [](unsigned char c) { return std::isspace(c); };
  text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), is_blank));
  text.erase(std::find_if_not(text.rbegin(), text.rend(), is_blank).base(), text.end());
  return text;
}

std::vector<Cell> cells_of(const std::string& line, char separator) {
  std::vector<Cell> cells;
  std::size_t at = 0;
  do {
    std::size_t begin = line.find_first_not_of(separator == '\t' ? " " : " \t", at), end;
    if (separator == ' ' && begin == std::string::npos && !cells.empty()) break;
    begin = std::min(begin, line.size());
    std::string text;
    std::size_t quote = begin < line.size() && line[begin] == '"' ? line.find('"', begin + 1) : std::string::npos;
    while (quote + 1 < line.size() && line[quote + 1] == '"' && quote != std::string::npos)
      quote = line.find('"', quote + 2);
    const std::size_t from = quote == std::string::npos ? begin : quote;
    end = separator == ' ' ? line.find_first_of(" \t", from) : line.find(separator, from);
    end = std::min(end, line.size());
    if (quote == std::string::npos) {
      text = line.substr(std::min(begin, end), end - std::min(begin, end));
    } else {
      text = line.substr(begin + 1, quote - begin - 1);
      for (std::size_t twice = 0; (twice = text.find("\"\"", twice)) != std::string::npos; ++twice)
        text.erase(twice, 1);
    }
    cells.push_back({trimmed(text), static_cast<int>(at) + 1});
    at = end + 1;
  } while (at <= line.size());
  return cells;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// A number with this mark of decimals, written with a point and without marks between thousands; none if it is not a
/// number.
std::optional<std::string> plain_number(const std::string& text, char decimal) {
  std::string plain;
  std::size_t at = 0;
  if (text.starts_with("\u2212")) plain = "-", at = 3;
  if (at == 0 && !text.empty() && (text[0] == '-' || text[0] == '+')) plain = text.substr(0, text[at++] == '-');
  const std::size_t sign = plain.size();
  char mark = 0;
  int group = 0;  // digits since the last mark between thousands
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (is_digit(c)) {
      plain += c, ++group;
      continue;
    }
    const bool thousands = c != decimal && (c == ',' || c == '.' || c == ' ' || c == '\'');
    if (!thousands || (mark != 0 && c != mark)) break;
    if (mark == 0 ? group < 1 || group > 3 || plain[sign] == '0' : group != 3) return std::nullopt;
    mark = c, group = 0;
  }
  if (mark != 0 && group != 3) return std::nullopt;
  std::size_t digits = plain.size() - sign;
  if (at < text.size() && text[at] == decimal) {
    plain += '.';
    for (++at; at < text.size() && is_digit(text[at]); ++at, ++digits) plain += text[at];
    if (plain.back() == '.' && decimal == ',') return std::nullopt;
  }
  if (digits == 0) return std::nullopt;
  if (at < text.size() && std::string_view("eEdD").find(text[at]) != std::string_view::npos) {  // D: Fortran's
    const std::string power = text.substr(at + 1);
    const std::size_t first = power.starts_with('-') || power.starts_with('+') ? 1 : 0;
    if (first == power.size() ||
        !std::all_of(power.begin() + static_cast<std::ptrdiff_t>(first), power.end(), is_digit))
      return std::nullopt;
    plain += "e" + power, at = text.size();
  }
  return at == text.size() ? std::optional(plain) : std::nullopt;
}

/// The seconds of "10:22:10.050", hours, minutes and seconds, also behind a date; none if it is no such time.
std::optional<std::string> clock_seconds(const std::string& text, char decimal) {
  const std::size_t begin = text.find_first_not_of("0123456789-./");
  const bool dated = begin != std::string::npos && begin > 0 && (text[begin] == ' ' || text[begin] == 'T');
  const std::string time = dated ? text.substr(begin + 1) : text;
  const std::size_t minute = time.find(':') + 1, second = time.find(':', minute) + 1;
  if (minute == 0 || second == 0) return std::nullopt;
  const std::string hours = time.substr(0, minute - 1), minutes = time.substr(minute, second - 1 - minute);
  const auto seconds = plain_number(time.substr(second), decimal);
  for (const std::string& whole : {hours, minutes})
    if (whole.empty() || whole.size() > 4 || !std::all_of(whole.begin(), whole.end(), is_digit)) return std::nullopt;
  if (!seconds || !is_digit(time[second])) return std::nullopt;
  const double rest = std::strtod(seconds->c_str(), nullptr);
  if (rest > 60) return std::nullopt;
  return fmt::format("{:.12g}", 3600 * std::stoi(hours) + 60 * std::stoi(minutes) + rest);
}

/// What a cell holds, a number or a time, as a plain number.
std::optional<std::string> number_in(const std::string& text, char decimal) {
  const auto plain = plain_number(text, decimal);
  return plain ? plain : clock_seconds(text, decimal);
}

bool is_number(const std::string& text) {
  return !text.empty() && (is_digit(text.back()) || text.back() == '.') &&
         (number_in(text, '.') || number_in(text, ','));
}

/// What stands where nothing was measured.
bool is_gap(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  static const std::array<std::string, 11> gaps{"", "-", "--", "---", "nan", "inf", "-inf", "na", "n/a", "#nv", "#n/a"};
  return std::find(gaps.begin(), gaps.end(), text) != gaps.end();
}

std::vector<Line> lines_in(const std::string& text, char separator) {
  std::vector<Line> lines;
  int number = 0;
  for (std::size_t at = 0; at < text.size(); ++number) {
    const std::size_t end = std::min(text.find_first_of("\r\n", at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + (text.compare(end, 2, "\r\n") == 0 ? 2 : 1);
    if (line.starts_with('#') || trimmed(line).empty()) continue;
    Line& made = lines.emplace_back(Line{number + 1, cells_of(line, separator)});
    for (const Cell& cell : made.cells) made.filled += !cell.text.empty(), made.numbers += is_number(cell.text);
  }
  return lines;
}

/// Tabs, semicolons, blanks or commas: the first that leaves two numbers in half as many lines as any other does.
std::vector<Line> separated(const std::string& text, char& separator) {
  constexpr std::array candidates{'\t', ';', ' ', ','};
  std::array<std::vector<Line>, candidates.size()> all;
  std::array<std::ptrdiff_t, candidates.size()> good{}, wide{};
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    all[i] = lines_in(text, candidates[i]);
    for (const Line& line : all[i]) good[i] += line.numbers > 1, wide[i] += line.cells.size() > 1;
  }
  auto& counts = std::any_of(good.begin(), good.end(), [](auto count) { return count > 0; }) ? good : wide;
  if (&counts == &wide) counts[2] = 0;  // words have blanks between them
  const auto most = *std::max_element(counts.begin(), counts.end());
  std::size_t chosen = candidates.size() - 1;
  for (std::size_t i = candidates.size(); i-- > 0;)
    if (most > 0 && 2 * counts[i] >= most) chosen = i;
  separator = candidates[chosen];
  return std::move(all[chosen]);
}

/// The mark of decimals that the numbers show. "1,234" may be either, and between semicolons "1.234" as well.
char decimal_mark(const std::vector<Line>& lines, char separator, const std::string& path) {
  const Line *point = nullptr, *comma = nullptr, *open = nullptr;
  const char* marks = "commas";  // that are open
  for (const Line& line : lines) {
    if (line.numbers < 2) continue;
    for (const Cell& cell : line.cells) {
      if (cell.text.find_first_of(".,") == std::string::npos || !is_number(cell.text)) continue;
      const bool with_point = number_in(cell.text, '.').has_value(), with_comma = number_in(cell.text, ',').has_value();
      if (with_point && with_comma) {
        const bool has_comma = cell.text.find(',') != std::string::npos;
        if (!open && (has_comma || separator == ';')) open = &line, marks = has_comma ? "commas" : "points";
      } else if (const Line*& first = with_point ? point : comma; !first) {
        first = &line;
      }
    }
  }
  const auto refuse = [&](const Line& line, const std::string& what) {
    throw InputError(SourceLocation{path, line.number},
                     what + ": state decimal: point, or decimal: comma, of this file");
  };
  if (point && comma)
    refuse(point->number > comma->number ? *point : *comma,
           fmt::format("numbers have decimal points in line {} and decimal commas in line {}", point->number,
                       comma->number));
  if (open && !point && !comma)
    refuse(*open, fmt::format("the {} of the numbers may stand before decimals or between thousands", marks));
  return comma ? ',' : '.';
}

std::string without_brackets(const std::string& text) {
  for (const auto& [open, close] : {std::pair{'(', ')'}, {'[', ']'}, {'<', '>'}})
    if (text.size() > 1 && text.front() == open && text.back() == close)
      return trimmed(text.substr(1, text.size() - 2));
  return text;
}

/// "0.02 N"
bool is_number_with_unit(const std::string& text) {
  const std::size_t unit = text.find_first_not_of("+-.,0123456789eE ");
  return unit != std::string::npos && is_number(trimmed(text.substr(0, unit))) && is_machine_unit(text.substr(unit));
}

/// Whether at least half of the cells that are not empty are units.
bool is_units_row(const Line& line) {
  if (line.numbers > 0) return false;
  int known = 0;
  for (const Cell& cell : line.cells) {
    const std::string unit = without_brackets(cell.text);
    known += is_machine_unit(unit) || (unit == "-" && cell.text != unit);
  }
  return known > 0 && 2 * known >= line.filled;
}

/// A row, or a head, with this many fields where those behind them are empty.
void cut_to(Line& line, std::size_t width) {
  while (line.cells.size() > width && line.cells.back().text.empty()) line.cells.pop_back();
}

/// Names that blanks separate: "Time (s)" is one.
void join_brackets(Line& line) {
  for (std::size_t i = line.cells.size(); i-- > 1;)
    if (line.cells[i].text.starts_with('(') || line.cells[i].text.starts_with('[')) {
      line.cells[i - 1].text += " " + line.cells[i].text;
      line.cells.erase(line.cells.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

/// The blocks of numbers with the names above them.
class Blocks {
 public:
  Blocks(std::vector<Line> lines, MachineFile& file, const std::string& path)
      : lines_(std::move(lines)), file_(file), path_(path) {
    std::size_t free = 0;  // behind the last block
    for (std::size_t i = 0; i < lines_.size(); ++i)
      if (begins(i, free)) i = (free = add(free, i)) - 1;
    if (!file_.tables.empty()) return;
    for (const Line& line : lines_)
      for (const Cell& cell : line.cells)
        if (is_number_with_unit(cell.text))
          throw InputError(SourceLocation{path_, line.number, cell.column},
                           "'" + cell.text +
                               "' is no number: write numbers alone, and their unit in the name of the column, "
                               "'force [N]', or in a row of units below the names");
    MachineTable& table = file_.tables.emplace_back();
    table.path = path_;
    set_head(table, lines_.front(), lines_.front().cells.size());
  }

 private:
  /// Two numbers or more, and not scattered among the words of a preamble.
  bool begins(std::size_t i, std::size_t free) const {
    const Line& line = lines_[i];
    if (line.numbers < 2) return false;
    return 2 * line.numbers >= line.filled ||
           (i > free && lines_[i - 1].numbers == 0 && lines_[i - 1].cells.size() == line.cells.size());
  }

  /// @return the line behind the block
  std::size_t add(std::size_t free, std::size_t begin) {
    const std::size_t width = lines_[begin].cells.size();
    while (begin > free && lines_[begin - 1].numbers > 0 && lines_[begin - 1].cells.size() == width) --begin;
    MachineTable table;
    table.path = path_;
    std::size_t head = begin;
    if (begin > free && lines_[begin - 1].numbers == 0 && lines_[begin - 1].cells.size() > 1) head = begin - 1;
    if (head > free && head < begin && is_units_row(lines_[head]) && lines_[head - 1].numbers == 0) --head;
    table.named = head < begin;
    table.preceded = head > free;
    set_head(table, lines_[table.named ? head : begin], width);
    if (table.named && head + 2 == begin) {
      table.units_line = lines_[head + 1].number;
      for (const Cell& cell : lines_[head + 1].cells) table.units.push_back(without_brackets(cell.text));
      table.units.resize(table.head.size());
    }
    std::size_t end = begin;
    for (std::size_t next = begin; next < lines_.size(); ++next) {
      if (belongs(lines_[next], lines_[begin])) {
        for (; end < next; ++end) table.passed.push_back(lines_[end].number);
        add_row(table, lines_[end++]);
      } else if (!is_words(lines_[next], width) || (next == end && !goes_on(begin, end, width))) {
        break;
      }
    }
    file_.tables.push_back(std::move(table));
    return end;
  }

  void set_head(MachineTable& table, Line line, std::size_t width) const {
    if (file_.separator == ' ' && line.cells.size() != width) join_brackets(line);
    while (line.cells.size() > 1 && line.cells.back().text.empty()) line.cells.pop_back();
    for (std::size_t i = 0; i < line.cells.size(); ++i) {
      table.head.push_back(table.named ? line.cells[i].text : std::to_string(i + 1));
      table.head_places.push_back({line.number, line.cells[i].column});
    }
  }

  /// Rows whose numbers are missing or misspelt belong to the block; what begins with a word elsewhere does not.
  static bool belongs(const Line& line, const Line& first) {
    if (line.numbers == 0)
      return std::all_of(line.cells.begin(), line.cells.end(), [](const Cell& cell) { return is_gap(cell.text); });
    return line.cells.size() == first.cells.size() || is_number(line.cells.front().text) ||
           !is_number(first.cells.front().text);
  }

  /// Whether a line is no head: it has one text, or words and numbers in another count of fields than rows have.
  static bool is_words(const Line& line, std::size_t width) {
    return (line.numbers == 0 && line.filled <= 1) ||
           (line.numbers > 0 && line.cells.size() != width && !is_number(line.cells.front().text));
  }

  /// Whether rows behind words go on from the row before these, and do not begin again as the block began.
  bool goes_on(std::size_t begin, std::size_t end, std::size_t width) const {
    std::size_t next = end;
    while (next < lines_.size() && is_words(lines_[next], width)) ++next;
    if (next == lines_.size() || lines_[next].numbers < 2 || lines_[next].cells.size() != width) return false;
    int onward = 0;
    for (std::size_t i = 0; i < width; ++i) {
      const auto number = [&](const Line& line) {
        const auto plain = i < line.cells.size() ? number_in(line.cells[i].text, file_.decimal) : std::nullopt;
        return plain ? std::strtod(plain->c_str(), nullptr) : NAN;
      };
      const double at = number(lines_[next]), again = std::abs(at - number(lines_[begin])),
                   on = std::abs(at - number(lines_[end - 1]));
      onward += on < again, onward -= again < on;
    }
    return onward >= 0;
  }

  static void add_clock(MachineTable& table, std::size_t column) {
    if (std::find(table.clocks.begin(), table.clocks.end(), column) == table.clocks.end())
      table.clocks.push_back(column);
  }

  void add_row(MachineTable& table, Line& line) {
    cut_to(line, table.head.size());
    auto& texts = table.rows.emplace_back();
    auto& places = table.places.emplace_back();
    for (Cell& cell : line.cells) {
      const auto plain = is_number(cell.text) ? number_in(cell.text, file_.decimal) : std::nullopt;
      if (plain && cell.text.find(':') != std::string::npos)
        add_clock(table, texts.size());
      else
        file_.thousands |= plain && cell.text.find_first_of(file_.decimal == ',' ? ". '" : ", '") != std::string::npos;
      texts.push_back(plain.value_or(cell.text));
      places.push_back({line.number, cell.column});
    }
  }

  std::vector<Line> lines_;
  MachineFile& file_;
  const std::string& path_;
};

}  // namespace

std::string MachineFile::recognised(const MachineTable& used) const {
  std::vector<std::string> found;
  if (encoding != "UTF-8") found.push_back(encoding);
  if (separator != ',')
    found.push_back((separator == ';'   ? "semicolons"
                     : separator == ' ' ? "blanks"
                                        : "tabs") +
                    std::string(" between fields"));
  if (decimal == ',') found.emplace_back("decimal commas");
  if (thousands) found.emplace_back("marks between thousands");
  if (used.preceded) found.push_back(fmt::format("names of columns in line {}", used.head_places.front().line));
  if (!used.units.empty()) found.emplace_back("units in the line below the names");
  if (!used.clocks.empty()) found.emplace_back("times as hours:minutes:seconds");
  if (!used.passed.empty())
    found.push_back(fmt::format("{} of words between the rows passed over, the first in line {}",
                                counted(std::ssize(used.passed), "line"), used.passed.front()));
  if (tables.size() > 1) found.push_back(fmt::format("block {} of {}", &used - tables.data() + 1, tables.size()));
  return fmt::format("{}", fmt::join(found, ", "));
}

MachineFile load_machine_file(const std::string& path, char decimal) {
  MachineFile file;
  file.text = text_of(path, file.encoding);
  std::vector<Line> lines = separated(file.text, file.separator);
  if (lines.empty()) throw InputError(SourceLocation{path, 1}, "no head: names of the columns");
  file.decimal = decimal ? decimal : decimal_mark(lines, file.separator, path);
  const Blocks read(std::move(lines), file, path);
  return file;
}

std::optional<double> machine_unit(const std::string& unit, const Dimension& dimension) {
  if (unit.empty() || unit == "-" || unit == "1")
    return dimension == dimension::none ? std::optional(1.) : std::nullopt;
  struct Word {
    const char *name, *means;
    double factor = 1;
  };
  static constexpr std::array words{Word{"sec", "s"},
                                    Word{"secs", "s"},
                                    Word{"Sec", "s"},
                                    Word{"S", "s"},
                                    Word{"seconds", "s"},
                                    Word{"msec", "ms"},
                                    Word{"秒", "s"},
                                    Word{"KN", "kN"},
                                    Word{"Mpa", "MPa"},
                                    Word{"Kpa", "kPa"},
                                    Word{"kpa", "kPa"},
                                    Word{"strain", "m/m"},
                                    Word{"lbf", "N", 4.4482216152605},
                                    Word{"psi", "Pa", 6894.757293168},
                                    Word{"ksi", "kPa", 6894.757293168},
                                    Word{"in", "mm", 25.4},
                                    Word{"inch", "mm", 25.4},
                                    Word{"in/in", "m/m"},
                                    Word{"kgf", "N", 9.80665},
                                    Word{"kp", "N", 9.80665},
                                    Word{"gf", "mN", 9.80665},
                                    Word{"ozf", "N", 0.27801385095378},
                                    Word{"lbs", "N", 4.4482216152605},
                                    Word{"Lbf", "N", 4.4482216152605},
                                    Word{"LBF", "N", 4.4482216152605},
                                    Word{"dyn", "uN", 10},
                                    Word{"daN", "N", 10}};
  if (unit == "Mm") return std::nullopt;  // no machine moves by megametres
  std::string name = unit;
  double factor = 1;
  const std::size_t slash = std::min(unit.find('/'), unit.size());
  for (const Word& word : words)
    if (unit == word.name)
      name = word.means, factor = word.factor;
    else if (unit.substr(0, slash) == word.name)  // "kgf/cm²"
      name = word.means + unit.substr(slash), factor = word.factor;
  try {
    const Quantity one = parse_quantity("1 " + name, dimension);
    return one.has_unit ? std::optional(factor * one.value) : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

bool is_machine_unit(const std::string& unit) {
  bool found = false;
  for (const Dimension& dimension : {dimension::none, dimension::length, dimension::time, dimension::force,
                                     dimension::pressure, dimension::energy, dimension::velocity})
    found |= !unit.empty() && unit != "-" && machine_unit(unit, dimension).has_value();
  return found;
}

}  // namespace elastin::lab
