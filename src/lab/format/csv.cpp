#include "lab/format/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "elastin/core/base/error.h"

namespace elastin::lab {
namespace {

/// Fields of all lines. A quote inside quotes is written twice.
std::vector<std::vector<std::string>> fields_of(const std::string& text) {
  std::vector<std::vector<std::string>> lines{{""}};
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    std::string& field = lines.back().back();
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"')
      field += text[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      lines.back().emplace_back();
    else if (c == '\n' && !quoted)
      lines.push_back({""});
    else if (c != '\r' || quoted)
      field += c;
  }
  return lines;
}

/// Without the mark of UTF-8 that some programs put first.
std::string without_mark(std::string text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

}  // namespace

std::size_t Csv::column(const std::string& name) const {
  const auto found = std::find(head.begin(), head.end(), name);
  if (found == head.end())
    throw InputError(SourceLocation{path, head_line}, "no column '" + name + "'" + suggestion(name, head));
  return static_cast<std::size_t>(found - head.begin());
}

bool Csv::has(const std::string& name) const { return std::find(head.begin(), head.end(), name) != head.end(); }

double Csv::number(std::size_t row, std::size_t column) const {
  const std::string& text = rows[row][column];
  if (text.empty()) return std::nan("");
  double value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size())
    throw InputError(SourceLocation{path, line(row)}, head[column] + ": '" + text + "' is no number");
  return value;
}

Csv load_csv(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::error_code ignored;
  if (!stream || std::filesystem::is_directory(path, ignored)) throw InputError(SourceLocation{path}, "cannot be read");
  Csv csv{path, {}, fields_of(without_mark({std::istreambuf_iterator<char>(stream), {}}))};
  while (csv.rows.size() > 1 && csv.rows.front().front().starts_with('#')) {
    csv.rows.erase(csv.rows.begin());
    ++csv.head_line;
  }
  csv.head = csv.rows.front();
  if (csv.head == std::vector<std::string>{""})
    throw InputError(SourceLocation{path, csv.head_line}, "no head: names of the columns");
  if (csv.head.size() == 1 && csv.head[0].find_first_of(";\t") != std::string::npos)
    throw InputError(
        SourceLocation{path, csv.head_line},
        "the columns are separated by semicolons or tabs; separate them by commas, with points in the numbers");
  csv.rows.erase(csv.rows.begin());
  while (!csv.rows.empty() && csv.rows.back() == std::vector<std::string>{""}) csv.rows.pop_back();
  for (std::size_t row = 0; row < csv.rows.size(); ++row)
    if (csv.rows[row].size() != csv.head.size())
      throw InputError(
          SourceLocation{path, csv.line(row)},
          std::to_string(csv.rows[row].size()) + " fields; the head has " + std::to_string(csv.head.size()));
  return csv;
}

}  // namespace elastin::lab
