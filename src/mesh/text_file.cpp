#include "mesh/text_file.h"

#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <climits>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>

#include "elastin/core/base/error.h"

namespace elastin::mesh::format {
namespace {

bool blank(char letter) { return letter == ' ' || (letter >= '\t' && letter <= '\r'); }

/// A number written as the whole of `word`; false where it is not, or does not fit.
template <class T>
bool parse(std::string_view word, T& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace

std::string load_bytes(const std::string& path) {
  struct stat status = {};
  if (stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode))
    throw InputError(SourceLocation{path, 0, 0}, "is no regular file; a pipe or a device may have no end");
  const auto close = [](std::FILE* stream) { std::fclose(stream); };
  const std::unique_ptr<std::FILE, decltype(close)> stream(std::fopen(path.c_str(), "rb"), close);
  std::string bytes;
  char buffer[1 << 16];
  std::size_t got = 0;
  while (stream && (got = std::fread(buffer, 1, sizeof buffer, stream.get())) > 0) bytes.append(buffer, got);
  if (!stream || std::ferror(stream.get())) {
    const std::string reason = std::strerror(errno);
    throw InputError(SourceLocation{path, 0, 0}, (stream ? "cannot read: " : "cannot open: ") + reason);
  }
  return bytes;
}

File load_file(const std::string& path) {
  File file{path, load_bytes(path)};
  if (file.bytes.starts_with("\xEF\xBB\xBF")) file.bytes.erase(0, 3);
  return file;
}

std::string_view trimmed(std::string_view text) {
  const auto is_blank = [](char letter) { return std::isspace(static_cast<unsigned char>(letter)) != 0; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string upper_case(std::string_view text) {
  std::string result(text);
  for (char& letter : result) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  return result;
}

std::vector<std::string_view> comma_fields(std::string_view line) {
  std::vector<std::string_view> all;
  for (std::size_t from = 0; from <= line.size();) {
    std::size_t to = from;
    for (bool within = false; to < line.size() && (within || line[to] != ','); ++to) within ^= line[to] == '"';
    all.push_back(trimmed(line.substr(from, to - from)));
    from = to + 1;
  }
  return all;
}

std::optional<double> fortran_real(std::string_view text) {
  std::string digits = upper_case(text);
  std::replace(digits.begin(), digits.end(), 'D', 'E');
  const std::size_t sign = digits.find_first_of("+-", 1);
  if (sign != std::string::npos && digits[sign - 1] != 'E') digits.insert(sign, "E");
  double value = 0;
  return parse(digits, value) && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<long long> whole_number(std::string_view text) {
  long long value = 0;
  return parse(text, value) ? std::optional(value) : std::nullopt;
}

std::string quoted(std::string_view text) {
  std::string shown(text.substr(0, 40));
  for (char& letter : shown)
    if (letter < ' ' || letter > '~') letter = '?';
  return "'" + shown + (text.size() > 40 ? "…'" : "'");
}

Cursor Cursor::part(std::size_t begin, std::size_t end) const {
  Cursor cursor(*file_);
  cursor.data_ = cursor.data_.substr(0, end);
  cursor.at_ = begin;
  return cursor;
}

Cursor Cursor::unwrapped(std::string_view data, std::size_t stands_at, std::endian order) const {
  Cursor cursor(*file_);
  cursor.data_ = data;
  cursor.stands_at_ = stands_at;
  cursor.begin_binary(order);
  return cursor;
}

void Cursor::begin_binary(std::endian order) {
  binary_ = true;
  binary_from_ = std::min(binary_from_, at_);
  order_ = order;
}

bool Cursor::more() {
  while (at_ < data_.size() && blank(data_[at_])) ++at_;
  return at_ < data_.size();
}

std::size_t Cursor::next_at() {
  if (!binary()) more();
  return at_;
}

std::string_view Cursor::word(const char* expected) {
  if (!more()) fail(at_, std::string("expected ") + expected + ", but the data ends here");
  const std::size_t begin = at_;
  while (at_ < data_.size() && !blank(data_[at_])) ++at_;
  return data_.substr(begin, at_ - begin);
}

void Cursor::expect(std::string_view wanted) {
  const std::string text(wanted);
  const std::string_view found = word(text.c_str());
  if (found != wanted) fail(at_ - found.size(), "expected " + text + ", found " + quoted(found));
}

void Cursor::expect_end(const char* what) {
  const bool ended = binary() ? left() == 0 : !more();
  if (!ended) fail(at_, std::string("expected no more ") + what + " here");
}

std::string_view Cursor::line() {
  const std::size_t begin = at_;
  const std::size_t end = std::min(data_.find('\n', begin), data_.size());
  at_ = std::min(end + 1, data_.size());
  const std::string_view text = data_.substr(begin, end - begin);
  return text.ends_with('\r') ? text.substr(0, text.size() - 1) : text;
}

void Cursor::end_line() {
  const std::size_t begin = at_;
  const std::string_view rest = line();
  if (!std::all_of(rest.begin(), rest.end(), blank)) fail(begin, "expected the end of the line, found " + quoted(rest));
}

void Cursor::skip_past(std::string_view mark) {
  const std::size_t found = data_.find(mark, at_);
  if (found == none) fail(at_, "expected " + std::string(mark) + " further on, but the data ends without it");
  at_ = found + mark.size();
}

void Cursor::skip_numbers(std::size_t count, NumberType type) {
  require_numbers(count, "numbers", type);
  if (binary())
    at_ += count * static_cast<std::size_t>(type.bytes);
  else
    for (std::size_t number = 0; number < count; ++number) word("a number");
}

void Cursor::require_numbers(std::size_t count, const char* what, NumberType type) const {
  const std::size_t capacity = binary() ? left() / static_cast<std::size_t>(type.bytes) : (left() + 1) / 2;
  if (count > capacity)
    fail(at_, "expected " + std::to_string(count) + " " + what + ", but what is left has room for " +
                  std::to_string(capacity) + " at most");
}

template <class T>
T Cursor::raw(const char* what) {
  if (left() < sizeof(T))
    fail(at_, std::string("expected ") + what + " (" + std::to_string(sizeof(T)) + " bytes), but the data ends here");
  char bytes[sizeof(T)];
  std::memcpy(bytes, data_.data() + at_, sizeof(T));
  if (order_ != std::endian::native) std::reverse(bytes, bytes + sizeof(T));
  at_ += sizeof(T);
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

long long Cursor::integer_word(const char* what) {
  const std::string_view found = word(what);
  long long value = 0;
  if (!parse(found, value))
    fail(at_ - found.size(), std::string("expected ") + what + ", an integer; found " + quoted(found));
  return value;
}

long long Cursor::integer(const char* what, NumberType type) {
  if (!binary()) return integer_word(what);
  const bool has_sign = type.kind == NumberType::signed_integer;
  switch (type.bytes) {
    case 1:
      return has_sign ? raw<std::int8_t>(what) : raw<std::uint8_t>(what);
    case 2:
      return has_sign ? raw<std::int16_t>(what) : raw<std::uint16_t>(what);
    case 4:
      return has_sign ? static_cast<long long>(raw<std::int32_t>(what)) : raw<std::uint32_t>(what);
    default:
      return static_cast<long long>(raw<std::int64_t>(what));
  }
}

double Cursor::real_word(const char* what) {
  const std::string_view found = word(what);
  double value = 0;
  if (!parse(found, value) || !std::isfinite(value))
    fail(at_ - found.size(), std::string("expected ") + what + ", a finite number; found " + quoted(found));
  return value;
}

double Cursor::real(const char* what, NumberType type) {
  if (!binary()) return real_word(what);
  const std::size_t begin = at_;
  const double value = type.bytes == 4 ? static_cast<double>(raw<float>(what)) : raw<double>(what);
  if (!std::isfinite(value)) fail(begin, std::string("expected ") + what + ", a finite number; found nan or infinity");
  return value;
}

std::size_t Cursor::count(const char* what, NumberType type) {
  const std::size_t begin = next_at();
  const long long value = integer(what, type);
  const std::size_t most = std::min<std::size_t>(left(), INT_MAX);
  if (value < 0 || static_cast<unsigned long long>(value) > most)
    fail(begin, std::string("expected ") + what + ", at most " + std::to_string(most) + " with " +
                    std::to_string(left()) + " bytes left; found " + std::to_string(value));
  return static_cast<std::size_t>(value);
}

Integers Cursor::integers(std::size_t count, const char* what, NumberType type) {
  require_numbers(count, (std::string("numbers, each ") + what).c_str(), type);
  Integers read{*this, type, std::vector<long long>(count)};
  for (long long& value : read.values) value = integer(what, type);
  return read;
}

void Cursor::fail(std::size_t at, const std::string& message) const {
  const std::size_t stands = stands_at_ == none ? std::min(at, file_->bytes.size()) : stands_at_;
  if (stands_at_ == none && at >= binary_from_)
    throw InputError(SourceLocation{file_->path, 0, 0}, "byte " + std::to_string(stands) + ": " + message);
  const auto begin = file_->bytes.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(stands);
  const auto lines = std::count(begin, end, '\n');
  const auto column = std::find(std::make_reverse_iterator(end), file_->bytes.rend(), '\n').base();
  throw InputError(SourceLocation{file_->path, static_cast<int>(lines) + 1, static_cast<int>(end - column) + 1},
                   message);
}

Cursor Sources::include(std::string_view name) {
  const std::string& own = cursors_.front().path();
  std::string path = own.substr(0, own.find_last_of('/') + 1) + std::string(name);
  std::replace(path.begin(), path.end(), '\\', '/');
  if (files_.size() > 100) fail(name, "this file is the hundredth one that is included: do they include each other?");
  try {
    files_.push_back(load_file(path));
  } catch (const InputError& error) {
    fail(name, error.what());
  }
  return cursors_.emplace_back(files_.back());
}

const Cursor& Sources::of(std::string_view text) const {
  const auto holds = [&](const Cursor& source) {
    return source.data().data() <= text.data() && text.data() <= source.data().data() + source.data().size();
  };
  const auto found = std::find_if(cursors_.begin(), cursors_.end(), holds);
  return found == cursors_.end() ? cursors_.front() : *found;
}

void Sources::fail(std::string_view text, const std::string& message) const {
  const Cursor& source = of(text);
  source.fail(static_cast<std::size_t>(text.data() - source.data().data()), message);
}

void Integers::fail(std::size_t number, const std::string& message) const {
  Cursor cursor = before;
  if (cursor.binary()) before.fail(before.at() + number * static_cast<std::size_t>(type.bytes), message);
  cursor.more();
  for (std::size_t skipped = 0; skipped < number && cursor.more(); ++skipped) cursor.word("a number");
  cursor.more();
  cursor.fail(cursor.at(), message);
}

}  // namespace elastin::mesh::format
