#include "lab/report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lab/report/plot.h"

namespace elastin::lab {
namespace {

/// Columns that a terminal uses for a UTF-8 text without wide characters.
std::size_t shown_width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
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

std::string Table::text(bool colours, const std::string& indent) const {
  std::vector<std::size_t> width;
  for (const std::string& word : head_) width.push_back(shown_width(word));
  for (const auto& row : rows_)
    for (std::size_t column = 0; column < row.size(); ++column)
      width[column] = std::max(width[column], shown_width(row[column].text));
  std::string out;
  const auto add_row = [&](const std::vector<TableCell>& row) {
    std::string line = indent;
    for (std::size_t column = 0; column < row.size(); ++column) {
      const std::string gap(width[column] - shown_width(row[column].text), ' ');
      const std::string text = painted(row[column].text, row[column].tone, colours);
      line += (column ? "  " : "") + (row[column].right ? gap + text : text + (column + 1 < row.size() ? gap : ""));
    }
    out += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  };
  std::vector<TableCell> head;
  for (std::size_t column = 0; column < head_.size(); ++column) {
    const bool right = std::any_of(rows_.begin(), rows_.end(),
                                   [&](const auto& row) { return column < row.size() && row[column].right; });
    head.push_back({head_[column], Tone::bold, right});
  }
  add_row(head);
  for (const auto& row : rows_) add_row(row);
  return out;
}

std::string Table::html(const std::function<std::string(const std::string&)>& colour) const {
  const auto right = [&](std::size_t column) {
    return std::any_of(rows_.begin(), rows_.end(),
                       [&](const auto& row) { return column < row.size() && row[column].right; });
  };
  std::string out = "<div class=\"scroll\"><table><thead><tr>";
  for (std::size_t column = 0; column < head_.size(); ++column)
    out += fmt::format("<th scope=\"col\"{}><button type=\"button\">{}</button></th>",
                       right(column) ? " class=\"n\"" : "", head_[column].empty() ? "notes" : escaped(head_[column]));
  out += "</tr></thead><tbody>\n";
  for (const auto& row : rows_) {
    out += "<tr>";
    for (std::size_t column = 0; column < row.size(); ++column) {
      const auto& [text, tone, number, value] = row[column];
      const std::string mark =
          column == 0 && colour ? fmt::format("<i class=\"dot\" style=\"background:{}\"></i>", colour(text)) : "";
      out += fmt::format("<{} class=\"{}{}\"{}>{}{}</{}>", column ? "td" : "th scope=\"row\"", name_of(tone),
                         number ? " n" : "", number && std::isfinite(value) ? fmt::format(" data-v=\"{}\"", value) : "",
                         mark, escaped(text), column ? "td" : "th");
    }
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

namespace {

std::string with_prefix(double value, const std::string& unit, int digits) {
  if (!std::isfinite(value)) return "";
  if (unit.empty()) return fmt::format("{:.4f}", std::abs(value) < 5e-5 ? 0. : value);
  // Prefixes fit units that stand alone: not m^2 or kg/m^3.
  if (unit != "m" && unit != "Pa" && unit != "N" && unit != "J" && unit != "N/m" && unit != "N m")
    return fmt::format("{:.{}g} {}", value, digits, unit);
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

std::string counted(int count, const std::string& singular, const std::string& plural) {
  return fmt::format("{} {}", count, count == 1 ? singular : plural.empty() ? singular + "s" : plural);
}

std::string readable_seconds(double seconds) {
  if (!std::isfinite(seconds)) return "";
  if (seconds < 1e-3) return fmt::format("{:.0f} µs", 1e6 * seconds);
  if (seconds < 1) return fmt::format("{:.1f} ms", 1e3 * seconds);
  return fmt::format("{:.2f} s", seconds);
}

}  // namespace elastin::lab
