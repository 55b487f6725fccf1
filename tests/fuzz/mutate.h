#pragma once
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace fuzz {

/// Makes a broken file out of whole ones: bytes, lines, words, numbers, indentation, YAML's own marks, parts of another
/// file. The same seed makes the same files.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}
  /// One to eight changes; `other` is a file to take pieces from. At most 1 MB comes out.
  std::string mutate(std::string text, const std::string& other);
  /// From 0 to count − 1.
  std::size_t pick(std::size_t count) { return count == 0 ? 0 : random_() % count; }

 private:
  void change(std::string& text, const std::string& other);
  void change_bytes(std::string& text);
  void change_number(std::string& text);
  void change_word(std::string& text, const std::string& other);
  void change_lines(std::string& text, const std::string& other);
  void change_yaml(std::string& text);
  void change_binary(std::string& text);
  template <class List>
  const auto& one_of(const List& list) {
    return list[pick(std::size(list))];
  }

  std::mt19937_64 random_;
};

}  // namespace fuzz
