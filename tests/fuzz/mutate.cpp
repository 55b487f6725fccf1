#include "fuzz/mutate.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <utility>

namespace fuzz {
namespace {

constexpr std::size_t kMostBytes = 1 << 20;

const std::array kNumbers{"0",           "-1",         "1",
                          "2",           "3",          "7",
                          "1e308",       "-1e308",     "1e-308",
                          "5e-324",      "nan",        "-nan",
                          "inf",         "-inf",       ".nan",
                          ".inf",        "1e9",        "1e18",
                          "999999999",   "2147483647", "2147483648",
                          "-2147483648", "65536",      "0x7f",
                          "1e",          "0.5",        "1e-9",
                          "4294967296",  "1e400",      "- 1",
                          "1e5 mm",      "1 kPa",      "9223372036854775807",
                          "1.5",         "100000",     "18446744073709551615",
                          "-0",          "+1",         "1_000",
                          "1e30 m",      "100 %",      "0 s"};
const std::array kYaml{"&a ",
                       "*a",
                       "<<: *a\n",
                       "{",
                       "}",
                       "[",
                       "]",
                       ": ",
                       "- ",
                       "? ",
                       "| ",
                       "> ",
                       "~",
                       "null",
                       "!!binary ",
                       "!override ",
                       "---\n",
                       "...\n",
                       "%YAML 9\n",
                       "#",
                       "\t",
                       "'",
                       "\"",
                       ",",
                       "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
                       "{a: {a: {a: {a: {a: ",
                       "&b [*a, *a, *a, *a, *a, *a]",
                       "\xEF\xBB\xBF",
                       "\xff\xfe",
                       "\\x",
                       "\r",
                       "\n",
                       " ",
                       "true",
                       "x",
                       "all"};
constexpr std::array<std::uint64_t, 12> kWords{
    0, 1, 0xff, 0x7f, 0x80, 0x7fff, 0xffff, 0x7fffffff, 0x80000000, 0xffffffff, 0x7fffffffffffffff, 0xffffffffffffffff};

bool numeric(char c) { return std::isdigit(static_cast<unsigned char>(c)); }
bool wordy(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_' || c == '$'; }
bool in_number(char c) { return numeric(c) || c == '.'; }

/// The run of such letters that begins at or after `at`, going on from the front: [begin, end).
template <class Is>
std::pair<std::size_t, std::size_t> run_from(const std::string& text, std::size_t at, const Is& is) {
  const auto find = [&](std::size_t from) {
    return static_cast<std::size_t>(std::find_if(text.begin() + static_cast<std::ptrdiff_t>(from), text.end(), is) -
                                    text.begin());
  };
  std::size_t begin = find(at);
  if (begin == text.size()) begin = find(0);
  std::size_t end = begin;
  while (end < text.size() && is(text[end])) ++end;
  return {begin, end};
}

/// Where the line that holds `at` begins, and where the next one does.
std::pair<std::size_t, std::size_t> line_at(const std::string& text, std::size_t at) {
  const std::size_t before = at == 0 ? std::string::npos : text.rfind('\n', at - 1), end = text.find('\n', at);
  return {before == std::string::npos ? 0 : before + 1, end == std::string::npos ? text.size() : end + 1};
}

std::string word_of(const std::string& text, std::size_t at) {
  const auto [begin, end] = run_from(text, at, wordy);
  return text.substr(begin, end - begin);
}

}  // namespace

std::string Mutator::mutate(std::string text, const std::string& other) {
  const std::size_t changes = std::size_t{1} << pick(4);
  for (std::size_t i = 0; i < changes; ++i) change(text, other);
  if (text.size() > kMostBytes) text.resize(kMostBytes);
  return text;
}

void Mutator::change(std::string& text, const std::string& other) {
  if (text.empty()) text = other;
  switch (pick(12)) {
    case 0:
      return change_bytes(text);
    case 1:
      return change_yaml(text);
    case 2:
      return change_binary(text);
    case 3:
    case 4:
      return change_word(text, other);
    case 5:
    case 6:
    case 7:
      return change_lines(text, other);
    default:
      return change_number(text);
  }
}

void Mutator::change_bytes(std::string& text) {
  const std::size_t at = pick(text.size() + 1), length = std::min(text.size() - at, std::size_t{1} << pick(8));
  switch (pick(4)) {
    case 0:
      text.erase(at, length);
      break;
    case 1:
      text.insert(at, text.substr(at, length));
      break;
    case 2:
      text.insert(at, 1 + pick(4), static_cast<char>(pick(256)));
      break;
    default:
      if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << pick(8)));
  }
  if (pick(40) == 0) text.resize(pick(text.size() + 1));
}

void Mutator::change_number(std::string& text) {
  auto [begin, end] = run_from(text, pick(text.size()), numeric);
  if (begin == end) return;
  while (end < text.size() && in_number(text[end])) ++end;
  const std::string digits = text.substr(begin, end - begin);
  const std::string now = pick(4) > 0 ? std::string(one_of(kNumbers)) : pick(2) ? digits + "0" : "-" + digits;
  text.replace(begin, end - begin, now);
}

/// Puts a word of this file or of the other in another's place.
void Mutator::change_word(std::string& text, const std::string& other) {
  const auto [begin, end] = run_from(text, pick(text.size()), wordy);
  if (begin == end) return;
  const std::string& source = pick(2) ? other : text;
  text.replace(begin, end - begin, word_of(source, pick(source.size())));
}

void Mutator::change_lines(std::string& text, const std::string& other) {
  const auto [begin, end] = line_at(text, pick(text.size()));
  const auto [from, to] = line_at(text, pick(text.size()));
  const std::string line = text.substr(begin, end - begin), again = text.substr(from, to - from);
  const auto [first, last] = line_at(other, pick(other.size()));
  switch (pick(6)) {
    case 0:
      text.erase(begin, end - begin);
      break;
    case 1:
      text.insert(from, line);
      break;
    case 2:
      text.replace(begin, end - begin, again);
      break;
    case 3:
      text.insert(begin, other.substr(first, last - first));
      break;
    case 4:  // the head of this file, the tail of the other
      text = text.substr(0, begin) + other.substr(first);
      break;
    default:
      pick(2) && !line.empty() && line[0] == ' ' ? text.erase(begin, 1) : text.insert(begin, 1 + pick(3), ' ');
  }
}

void Mutator::change_yaml(std::string& text) {
  const std::size_t times = pick(16) == 0 ? std::size_t{1} << pick(12) : 1;
  std::string marks;
  const std::string mark = one_of(kYaml);
  for (std::size_t i = 0; i < times; ++i) marks += mark;
  text.insert(pick(text.size() + 1), marks);
}

/// An integer of 1 to 8 bytes, in either order.
void Mutator::change_binary(std::string& text) {
  const std::size_t bytes = std::size_t{1} << pick(4), at = pick(text.size());
  if (at + bytes > text.size()) return;
  char raw[8];
  const std::uint64_t word = one_of(kWords) + (pick(4) == 0 ? pick(64) : 0);
  std::memcpy(raw, &word, sizeof raw);
  if (pick(2)) std::reverse(raw, raw + bytes);
  std::copy(raw, raw + bytes, text.begin() + static_cast<std::ptrdiff_t>(at));
}

}  // namespace fuzz
