#include "core/base/archive.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "elastin/core/base/error.h"

namespace elastin {

std::uint64_t checksum(const void* data, std::size_t size, std::uint64_t start) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; ++i) start = (start ^ bytes[i]) * 1099511628211u;
  return start;
}

void ByteWriter::raw(const void* data, std::size_t size) {
  const char* from = static_cast<const char*>(data);
  bytes_.insert(bytes_.end(), from, from + size);
}

std::size_t ByteWriter::count(std::size_t present, std::size_t) {
  const std::uint64_t wide = present;
  raw(&wide, sizeof wide);
  return present;
}

void ByteWriter::word(std::string& value) { raw(value.data(), count(value.size(), 1)); }

void ByteReader::raw(void* data, std::size_t size) {
  if (size > left_) throw InputError(what_ + " is cut off");
  if (size > 0) std::memcpy(data, at_, size);
  at_ += size;
  left_ -= size;
}

std::size_t ByteReader::count(std::size_t, std::size_t bytes_each) {
  std::uint64_t given = 0;
  raw(&given, sizeof given);
  if (given > left_ / bytes_each) throw InputError(what_ + " is cut off");
  return given;
}

void ByteReader::word(std::string& value) {
  value.resize(count(0, 1));
  raw(value.data(), value.size());
}

void TextWriter::numbers(double* values, std::size_t count) {
  char text[40];  // "-0x1.8p+1", whatever the locale
  for (std::size_t i = 0; i < count; ++i) {
#ifdef __cpp_lib_to_chars
    const bool minus = std::signbit(values[i]), finite = std::isfinite(values[i]);
    text_ += std::string(minus ? "-" : "") + (finite ? "0x" : "");
    text_.append(text, std::to_chars(text, text + sizeof text, std::abs(values[i]), std::chars_format::hex).ptr) += ' ';
#else  // as in text.cpp
    std::snprintf(text, sizeof text, "%a ", values[i]);
    text_ += text;
#endif
  }
}

std::size_t TextWriter::count(std::size_t present, std::size_t) {
  text_ += "\n" + std::to_string(present) + " ";
  return present;
}

void TextReader::word(std::string& value) {
  word_size_ = 0;
  if (!(stream_ >> value)) fail(what_ + " is cut off");
  word_size_ = value.size();
}

void TextReader::fail(const std::string& message) {
  if (from_.file.empty()) throw InputError(message);
  stream_.clear();
  const std::string text = stream_.str();
  const auto read = static_cast<std::size_t>(stream_.tellg());
  SourceLocation at = from_;
  for (const char c : text.substr(0, read - word_size_)) {
    ++at.column;
    if (c == '\n') ++at.line, at.column = 1;
  }
  throw InputError(at, message);
}

void TextReader::numbers(double* values, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    word(text);
#ifdef __cpp_lib_to_chars
    const bool minus = text.front() == '-', hex = text.find("0x") == (minus ? 1 : 0);
    const char *begin = text.data() + (minus ? 1 : 0) + (hex ? 2 : 0), *end = text.data() + text.size();
    const auto format = hex ? std::chars_format::hex : std::chars_format::general;
    const auto [read, problem] = std::from_chars(begin, end, values[i], format);
    if (minus) values[i] = -values[i];
    const bool whole = problem == std::errc() && read == end;
#else
    char* end = nullptr;
    values[i] = std::strtod(text.c_str(), &end);
    const bool whole = end == text.c_str() + text.size();
#endif
    if (!whole) fail(what_ + " is damaged: '" + text + "' is no number");
  }
}

void TextReader::whole(int& value) {
  std::string text;
  word(text);
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size())
    fail(what_ + " is damaged: '" + text + "' is no whole number");
}

std::size_t TextReader::count(std::size_t, std::size_t) {
  int given = 0;
  whole(given);
  const auto left = stream_.rdbuf()->in_avail();
  if (given < 0 || given > left) fail(what_ + " is damaged: " + std::to_string(given) + " things");
  return static_cast<std::size_t>(given);
}

}  // namespace elastin
