#include "lab/report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "lab/report/plot.h"
#include "lab/report/screen.h"

namespace elastin::lab {
namespace {

/// What a narrow screen does without, the first to go first.
constexpr const char* kSpared[] = {"iterations", "build",      "median",  "least", "solver", "with build",
                                   "unsuited",   "mechanisms", "threads", "on",    "source", "neighbours inside",
                                   "difference", "molecules",  "expected"};
/// Text is not made narrower than this, so that it can still be read.
constexpr std::size_t kNarrowest = 12;

bool is_right(const std::vector<std::vector<TableCell>>& rows, std::size_t column) {
  return std::any_of(rows.begin(), rows.end(),
                     [&](const auto& row) { return column < row.size() && row[column].right; });
}

/// The columns of a table that a screen has room for, and how wide each is.
struct Layout {
  std::vector<std::size_t> columns, width;
  std::size_t total() const {
    std::size_t sum = 0;
    for (const std::size_t column : columns) sum += width[column] + 2;
    return sum - std::min<std::size_t>(2, sum);
  }
};

std::size_t longest_word(const std::string& text) {
  std::size_t longest = 0;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find(' ', from), text.size());
    longest = std::max(longest, shown_width(text.substr(from, end - from)));
    from = end + 1;
  }
  return longest;
}

/// Makes the widest column of text narrower, by what is too much but not below its least; false where none is wider.
bool narrow(Layout& layout, const std::vector<char>& right, std::size_t room, const std::vector<std::size_t>& least) {
  std::size_t widest = layout.width.size();
  for (const std::size_t column : layout.columns)
    if (!right[column] && layout.width[column] > least[column] &&
        (widest == layout.width.size() || layout.width[column] > layout.width[widest]))
      widest = column;
  if (widest == layout.width.size()) return false;
  std::size_t& width = layout.width[widest];
  width = std::max(least[widest], width - std::min(width, layout.total() - room));
  return true;
}

/// `room` = 0: as wide as the text. Otherwise heads are folded, then text; columns that can be spared go.
Layout layout_of(const std::vector<std::string>& head, const std::vector<std::vector<TableCell>>& rows,
                 std::size_t room) {
  Layout layout;
  std::vector<std::size_t> of_rows(head.size()), words(head.size(), kNarrowest), readable_words;
  std::vector<char> right;
  for (std::size_t column = 0; column < head.size(); ++column) {
    for (const auto& row : rows)
      if (column < row.size()) {
        of_rows[column] = std::max(of_rows[column], shown_width(row[column].text));
        words[column] = std::max(words[column], longest_word(row[column].text));
      }
    layout.columns.push_back(column);
    layout.width.push_back(std::max(of_rows[column], shown_width(head[column])));
    right.push_back(is_right(rows, column));
  }
  if (room == 0 || layout.total() <= room) return layout;
  for (std::size_t column = 0; column < head.size(); ++column)
    layout.width[column] = std::max(of_rows[column], longest_word(head[column]));
  for (const std::size_t word : words) readable_words.push_back(std::max(word, 2 * kNarrowest));
  while (layout.total() > room && narrow(layout, right, room, readable_words)) {
  }
  for (const char* spared : kSpared)
    if (layout.total() > room)
      std::erase_if(layout.columns, [&](std::size_t column) { return column > 0 && head[column] == spared; });
  while (layout.total() > room && narrow(layout, right, room, words)) {
  }
  const std::vector<std::size_t> least(head.size(), kNarrowest);  // then words are broken
  while (layout.total() > room && narrow(layout, right, room, least)) {
  }
  while (layout.total() > room && layout.columns.size() > 1) layout.columns.pop_back();
  return layout;
}

/// The first, and those in which something stands.
std::vector<std::size_t> filled_columns(std::size_t count, const std::vector<std::vector<TableCell>>& rows) {
  std::vector<std::size_t> columns;
  for (std::size_t column = 0; column < count; ++column)
    if (column == 0 || std::any_of(rows.begin(), rows.end(),
                                   [&](const auto& row) { return column < row.size() && !row[column].text.empty(); }))
      columns.push_back(column);
  return columns;
}

const char* name_of(Tone tone) {
  constexpr const char* names[] = {"plain", "good", "poor", "bad", "faint", "bold"};
  return names[static_cast<int>(tone)];
}

}  // namespace

std::string painted(const std::string& text, Tone tone, bool colours) {
  if (!colours || tone == Tone::plain) return text;
  const char* code = tone == Tone::good   ? "32"
                     : tone == Tone::poor ? "33"
                     : tone == Tone::bad  ? "31"
                     : tone == Tone::bold ? "1"
                                          : "2";
  return fmt::format("\033[{}m{}\033[0m", code, text);
}

void Table::keep_rows_with(const std::string& word) {
  const auto same = [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); };
  const auto has = [&](const TableCell& cell) {
    return std::search(cell.text.begin(), cell.text.end(), word.begin(), word.end(), same) != cell.text.end();
  };
  for (std::size_t row = rows_.size(); row-- > 0;) {
    if (std::any_of(rows_[row].begin(), rows_[row].end(), has)) continue;
    rows_.erase(rows_.begin() + static_cast<std::ptrdiff_t>(row));
    traits_.erase(traits_.begin() + static_cast<std::ptrdiff_t>(row));
  }
}

std::string Table::text(bool colours, const std::string& indent) const {
  const Layout layout = layout_of(head_, rows_, screen_width() > indent.size() ? screen_width() - indent.size() : 0);
  std::string out;
  const auto add_row = [&](const std::vector<TableCell>& row) {
    std::vector<std::vector<std::string>> cells;  // of each column shown its lines
    std::size_t lines = 1;
    for (const std::size_t column : layout.columns) {
      cells.push_back(column < row.size() ? folded(row[column].text, layout.width[column])
                                          : std::vector<std::string>{""});
      lines = std::max(lines, cells.back().size());
    }
    for (std::size_t line = 0; line < lines; ++line) {
      std::string text = indent;
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const std::size_t column = layout.columns[i];
        const std::string word = line < cells[i].size() ? cells[i][line] : "";
        const bool last = i + 1 == cells.size(), right = column < row.size() && row[column].right;
        const std::string gap(layout.width[column] - shown_width(word), ' ');
        const std::string shown = painted(word, word.empty() ? Tone::plain : row[column].tone, colours);
        text += (i ? "  " : "") + (right ? gap + shown : shown + (last ? "" : gap));
      }
      out += text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
    }
  };
  std::vector<TableCell> head;
  for (std::size_t column = 0; column < head_.size(); ++column)
    head.push_back({head_[column], Tone::bold, is_right(rows_, column)});
  add_row(head);
  for (const auto& row : rows_) add_row(row);
  return out;
}

std::string Table::html(const std::function<std::string(const std::string&)>& colour) const {
  const auto right = [&](std::size_t column) {
    return std::any_of(rows_.begin(), rows_.end(),
                       [&](const auto& row) { return column < row.size() && row[column].right; });
  };
  const auto spared = [&](std::size_t column) {  // where there is no room, as on a narrow screen
    return std::find(std::begin(kSpared), std::end(kSpared), head_[column]) != std::end(kSpared) ? " spare" : "";
  };
  std::string out = "<div class=\"scroll\" tabindex=\"0\"><table><thead><tr>";
  const std::vector<std::size_t> columns = filled_columns(head_.size(), rows_);
  for (const std::size_t column : columns)
    out +=
        fmt::format("<th scope=\"col\" class=\"{}{}\"><button type=\"button\">{}</button></th>",
                    right(column) ? "n" : "", spared(column), head_[column].empty() ? "notes" : escaped(head_[column]));
  out += "</tr></thead><tbody>\n";
  for (std::size_t number = 0; number < rows_.size(); ++number) {
    const auto& row = rows_[number];
    const RowTraits& traits = traits_[number];
    const std::string series = !traits.series.empty() || row.empty() ? traits.series : row.front().text;
    out += fmt::format("<tr data-series=\"{}\"", escaped(series));
    out += traits.outcome.empty() ? ">" : fmt::format(" data-outcome=\"{}\">", escaped(traits.outcome));
    for (const std::size_t column : columns) {
      if (column >= row.size()) break;
      const auto& [text, tone, flush_right, value] = row[column];
      const std::string mark =
          column == 0 && colour ? fmt::format("<i class=\"dot\" style=\"background:{}\"></i>", colour(series)) : "";
      out += fmt::format("<{} class=\"{}{}{}\"{}>{}{}</{}>", column ? "td" : "th scope=\"row\"", name_of(tone),
                         flush_right ? " n" : "", spared(column),
                         flush_right && std::isfinite(value) ? fmt::format(" data-v=\"{}\"", value) : "", mark,
                         escaped(text), column ? "td" : "th");
    }
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

namespace {

std::string with_prefix(double value, const std::string& unit, int digits) {
  if (!std::isfinite(value)) return "";
  if (unit.empty()) return fmt::format("{:.4f}", std::abs(value) < 5e-5 ? 0. : value);
  const bool area = unit == "m^2", time = unit == "s";
  // Prefixes fit units that stand alone: not kg/m^3. Nobody writes ks, and a prefix of m^2 counts twice.
  if (unit != "m" && unit != "Pa" && unit != "N" && unit != "J" && unit != "N/m" && unit != "N m" && !area &&
      !(time && std::abs(value) < 1))
    return fmt::format("{:.{}g} {}", value, digits, unit);
  if (area && std::abs(value) < 0.1 && value != 0)
    return std::abs(value) < 1e-8 ? fmt::format("{:.{}g} µm^2", 1e12 * value, digits)
                                  : fmt::format("{:.{}g} mm^2", 1e6 * value, digits);
  if (area) return fmt::format("{:.{}g} {}", value, digits, unit);
  if (std::abs(value) >= 1e15) return fmt::format("{:.{}g} {}", value, digits, unit);
  static constexpr std::pair<double, const char*> prefixes[]{{1e9, "G"},  {1e6, "M"},  {1e3, "k"}, {1, ""},
                                                             {1e-3, "m"}, {1e-6, "µ"}, {1e-9, "n"}};
  for (const auto& [factor, prefix] : prefixes)
    if (std::abs(value) >= factor * (1 - 0.5 * std::pow(10., -digits))) {
      const double scaled = value / factor;
      const double rounded = std::abs(scaled) * (1 + 0.5 * std::pow(10., -digits));
      const int whole = rounded >= 100 ? 3 : rounded >= 10 ? 2 : 1;
      return fmt::format("{:.{}f} {}{}", scaled, std::max(0, digits - whole), prefix, unit);
    }
  return fmt::format("{:.{}g} {}", value, digits, unit);
}

}  // namespace

std::string readable(double value, const Dimension& dimension, int digits) {
  return with_prefix(value, si_unit(dimension), digits);
}

std::string readable(double value, const MeasureInfo& measure, int digits) {
  return with_prefix(value, measure.unit_text(), digits);
}

std::string percent(double ratio) {
  if (!std::isfinite(ratio)) return "";
  const double size = std::abs(100 * ratio);
  if (size < 5e-5) return "0.0000 %";
  if (size >= 1e6) return fmt::format("{:+.1e} %", 100 * ratio);
  return fmt::format("{:+.{}f} %", 100 * ratio, size < 0.01 ? 4 : size < 1 ? 3 : size < 100 ? 2 : 0);
}

std::string readable_seconds(double seconds) {
  if (!std::isfinite(seconds)) return "";
  if (seconds < 1e-3) return fmt::format("{:.0f} µs", 1e6 * seconds);
  if (seconds < 1) return fmt::format("{:.1f} ms", 1e3 * seconds);
  return fmt::format("{:.2f} s", seconds);
}

}  // namespace elastin::lab
