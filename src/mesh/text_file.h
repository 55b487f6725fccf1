#pragma once
#include <bit>
#include <cstddef>
#include <list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace elastin::mesh::format {

/// How one number stands in binary data. In text every number is a word, whatever its type.
struct NumberType {
  enum Kind { signed_integer, unsigned_integer, real } kind = signed_integer;
  int bytes = 4;
};
inline constexpr NumberType int32{NumberType::signed_integer, 4};
inline constexpr NumberType uint64{NumberType::unsigned_integer, 8};
inline constexpr NumberType float64{NumberType::real, 8};

/// A file in memory.
struct File {
  std::string path;
  std::string bytes;
};

/// Reads a whole file. Throws InputError "path: cannot open: reason".
std::string load_bytes(const std::string& path);

/// The same of a file that begins as text, without the byte order mark of UTF-8 that some programs put first.
File load_file(const std::string& path);

struct Integers;

/// A place in a file that moves forward over words and numbers; whatever is not as expected ends in an InputError with
/// file:line:column, or with the byte offset (counted from 0) once the data is binary. Reads no byte outside its range.
class Cursor {
 public:
  explicit Cursor(const File& file) : file_(&file), data_(file.bytes) {}

  /// The text between two offsets of the file, as a cursor of its own.
  Cursor part(std::size_t begin, std::size_t end) const;
  /// Binary data that was unwrapped from the file: failures are reported at the file's offset `stands_at`. `data` must
  /// outlive it.
  Cursor unwrapped(std::string_view data, std::size_t stands_at, std::endian order) const;

  /// From here on numbers are read as binary data, words still as text; and positions are reported as byte offsets for
  /// good, for lines mean nothing from here on.
  void begin_binary(std::endian order);
  void begin_text() { binary_ = false; }
  bool binary() const { return binary_; }

  std::size_t at() const { return at_; }
  std::size_t left() const { return data_.size() - at_; }
  std::string_view data() const { return data_; }
  const std::string& path() const { return file_->path; }
  /// Steps over blanks and line ends; whether anything is left then.
  bool more();
  /// Where the next number stands.
  std::size_t next_at();

  std::string_view word(const char* expected);
  void expect(std::string_view word);
  /// The rest of this line; steps over its end.
  std::string_view line();
  /// Steps over the end of this line, which must hold no more words: binary data follows.
  void end_line();
  /// Fails where more data follow, of which `what` is the name.
  void expect_end(const char* what);
  /// Steps over the next `mark`.
  void skip_past(std::string_view mark);
  void skip_numbers(std::size_t count, NumberType type);

  long long integer(const char* what, NumberType type = int32);
  /// A finite number.
  double real(const char* what, NumberType type = float64);
  /// The number of things to come: from 0 to 2³¹−1, and not more than what is left has bytes.
  std::size_t count(const char* what, NumberType type = int32);
  Integers integers(std::size_t count, const char* what, NumberType type);
  /// Fails where `count` numbers can't fit into what is left, before anybody allocates for them.
  void require_numbers(std::size_t count, const char* what, NumberType type) const;

  [[noreturn]] void fail(std::size_t at, const std::string& message) const;

 private:
  static constexpr std::size_t none = std::string_view::npos;
  template <class T>
  T raw(const char* what);
  double real_word(const char* what);
  long long integer_word(const char* what);

  const File* file_;
  std::string_view data_;
  std::size_t at_ = 0;
  bool binary_ = false;
  std::size_t binary_from_ = none;
  std::size_t stands_at_ = none;
  std::endian order_ = std::endian::native;
};

/// Integers of one section, and the cursor before the first, so that a wrong one can be found again.
struct Integers {
  Cursor before;
  NumberType type;
  std::vector<long long> values;
  std::size_t size() const { return values.size(); }
  [[noreturn]] void fail(std::size_t number, const std::string& message) const;
};

/// A file and those that it includes, so that a failure is reported in the one where its text stands.
class Sources {
 public:
  explicit Sources(const Cursor& first) : cursors_{first} {}
  /// Loads the file of this name next to the first one; `name` is the text that names it.
  Cursor include(std::string_view name);
  const Cursor& of(std::string_view text) const;
  [[noreturn]] void fail(std::string_view text, const std::string& message) const;

 private:
  std::list<File> files_;
  std::list<Cursor> cursors_;  ///< at the beginnings of the files
};

/// Without the blanks at both ends.
std::string_view trimmed(std::string_view text);

/// ASCII letters in capitals.
std::string upper_case(std::string_view text);

/// The fields between commas that stand in no double quotes, without blanks around them.
std::vector<std::string_view> comma_fields(std::string_view line);

/// A finite number as Fortran writes it: "1.5", "+1.5E-3", "1.5D-3", "1.5-3". None where the text is something else.
std::optional<double> fortran_real(std::string_view text);

/// An integer, "+3" and "-3" too. None where the text is something else, or too large.
std::optional<long long> whole_number(std::string_view text);

/// What stands in the file, fit for a message: in quotes, cut to 40 letters, unprintable bytes as '?'.
std::string quoted(std::string_view text);

}  // namespace elastin::mesh::format
