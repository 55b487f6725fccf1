#include "lab/format/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace elastin::lab {
namespace {

struct Field {
  std::string text;
  Csv::Place place;
};

/// Fields of all lines. A quote inside quotes is written twice.
std::vector<std::vector<Field>> fields_of(const std::string& text) {
  std::vector<std::vector<Field>> lines{{Field{}}};
  bool quoted = false;
  Csv::Place next{1, 2};  // of the letter behind this one
  for (std::size_t i = 0; i < text.size(); ++i, ++next.column) {
    const char c = text[i];
    std::string& field = lines.back().back().text;
    if (c == '\n') next = {next.line + 1, 1};
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      field += text[++i];
      ++next.column;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      lines.back().push_back(Field{"", next});
    } else if (c == '\n' && !quoted) {
      lines.push_back({Field{"", next}});
    } else if (c != '\r' || quoted) {
      field += c;
    }
  }
  return lines;
}

bool is_empty(const std::vector<Field>& fields) { return fields.size() == 1 && fields.front().text.empty(); }

void split(const std::vector<Field>& fields, std::vector<std::string>& texts, std::vector<Csv::Place>& places) {
  for (const Field& field : fields) {
    texts.push_back(field.text);
    places.push_back(field.place);
  }
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
    throw InputError(location(head_places.front()), "no column '" + name + "'" + suggestion(name, head));
  return static_cast<std::size_t>(found - head.begin());
}

bool Csv::has(const std::string& name) const { return std::find(head.begin(), head.end(), name) != head.end(); }

const std::string& Csv::text(std::size_t row, std::size_t column) const {
  static const std::string nothing;
  return column < rows[row].size() ? rows[row][column] : nothing;
}

double Csv::number(std::size_t row, std::size_t column) const {
  const std::string& given = text(row, column);
  if (given.empty()) return std::nan("");
  double value = 0;
  const auto [end, problem] = std::from_chars(given.data(), given.data() + given.size(), value);
  if (problem != std::errc() || end != given.data() + given.size())
    throw InputError(location(places[row][column]), head[column] + ": '" + given + "' is no number");
  return value;
}

Csv load_csv(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::error_code ignored;
  if (!stream || std::filesystem::is_directory(path, ignored)) throw InputError(SourceLocation{path}, "cannot be read");
  std::vector<std::vector<Field>> lines = fields_of(without_mark({std::istreambuf_iterator<char>(stream), {}}));
  std::size_t first = 0;
  while (first + 1 < lines.size() && lines[first].front().text.starts_with('#')) ++first;
  Csv csv;
  csv.path = path;
  split(lines[first], csv.head, csv.head_places);
  const SourceLocation at_head = csv.location(csv.head_places.front());
  if (is_empty(lines[first])) throw InputError(at_head, "no head: names of the columns");
  if (csv.head.size() == 1 && csv.head[0].find_first_of(";\t") != std::string::npos)
    throw InputError(
        at_head,
        "the columns are separated by semicolons or tabs; separate them by commas, with points in the numbers");
  while (lines.size() > first + 1 && is_empty(lines.back())) lines.pop_back();
  for (std::size_t line = first + 1; line < lines.size(); ++line) {
    split(lines[line], csv.rows.emplace_back(), csv.places.emplace_back());
    const std::size_t fields = csv.rows.back().size();
    if (fields != csv.head.size())
      throw InputError(csv.location(csv.places.back()[std::min(fields, csv.head.size()) - 1]),
                       std::to_string(fields) + " fields; the head has " + std::to_string(csv.head.size()));
  }
  return csv;
}

}  // namespace elastin::lab
