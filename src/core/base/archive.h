#pragma once
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "elastin/core/base/error.h"

/// Writers and readers of what a program keeps. A visitor shows an archive each value once, for both directions:
/// numbers, whole numbers, words and counts. `what` is how messages name the thing: "the saved state".
namespace elastin {

/// [FNV-1a] of bytes; `start` goes on with those before.
std::uint64_t checksum(const void* data, std::size_t size, std::uint64_t start = 14695981039346656037u);

/// Appends what it is shown, as this machine has it in memory.
class ByteWriter {
 public:
  static constexpr bool reads = false;
  void numbers(double* values, std::size_t count) { raw(values, count * sizeof(double)); }
  void whole(int& value) { raw(&value, sizeof value); }
  void word(std::string& value);
  /// The count of the items that follow, each with at least this many bytes.
  std::size_t count(std::size_t present, std::size_t bytes_each);
  std::vector<char> take() { return std::move(bytes_); }

 private:
  void raw(const void* data, std::size_t size);
  std::vector<char> bytes_;
};

/// Fills what it is shown. Throws InputError where the bytes do not suffice, before anybody allocates for them.
class ByteReader {
 public:
  static constexpr bool reads = true;
  ByteReader(const char* bytes, std::size_t size, std::string what) : at_(bytes), left_(size), what_(std::move(what)) {}
  void numbers(double* values, std::size_t count) { raw(values, count * sizeof(double)); }
  void whole(int& value) { raw(&value, sizeof value); }
  void word(std::string& value);
  std::size_t count(std::size_t present, std::size_t bytes_each);
  std::size_t left() const { return left_; }

 private:
  void raw(void* data, std::size_t size);
  const char* at_;
  std::size_t left_;
  std::string what_;
};

/// As words, every number with all its bits.
class TextWriter {
 public:
  static constexpr bool reads = false;
  void numbers(double* values, std::size_t count);
  void whole(int& value) { text_ += std::to_string(value) + " "; }
  void word(std::string& value) { text_ += value + " "; }
  std::size_t count(std::size_t present, std::size_t bytes_each);
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

class TextReader {
 public:
  static constexpr bool reads = true;
  /// @param from where the text begins in its file, so that errors say where they are; no file: they do not.
  TextReader(const std::string& text, std::string what, SourceLocation from = {})
      : stream_(text), what_(std::move(what)), from_(std::move(from)) {}
  void numbers(double* values, std::size_t count);
  void whole(int& value);
  void word(std::string& value);
  /// No more than what is left has letters.
  std::size_t count(std::size_t present, std::size_t bytes_each);
  /// Throws InputError at the word read last.
  [[noreturn]] void fail(const std::string& message);

 private:
  std::istringstream stream_;
  std::string what_;
  SourceLocation from_;
  std::size_t word_size_ = 0;  ///< of the word read last
};

}  // namespace elastin
