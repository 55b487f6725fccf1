#include <zlib.h>

#include <algorithm>

#include "mesh/wrapped_data.h"

namespace elastin::mesh::format {
namespace {

/// What one base64 letter stands for; −1 = none.
int base64_value(char letter) {
  if (letter >= 'A' && letter <= 'Z') return letter - 'A';
  if (letter >= 'a' && letter <= 'z') return letter - 'a' + 26;
  if (letter >= '0' && letter <= '9') return letter - '0' + 52;
  return letter == '+' ? 62 : letter == '/' ? 63 : -1;
}

class Unwrapper {
 public:
  Unwrapper(const Cursor& in, const WrappedRange& range, const Wrapping& wrapping, std::size_t stands_at)
      : in_(in), range_(range), wrapping_(wrapping), stands_at_(stands_at) {}

  std::string plain(std::size_t bytes) const;
  std::string inflated(std::size_t bytes) const;

 private:
  std::string first(std::size_t bytes) const;
  std::string first_of_base64(std::size_t bytes) const;
  std::vector<long long> header(std::size_t numbers) const;
  void inflate_block(const std::string& packed, std::size_t begin, std::size_t packed_bytes, std::size_t bytes,
                     std::string& out) const;
  [[noreturn]] void fail(const std::string& message) const { in_.fail(stands_at_, message); }
  [[noreturn]] void fail_size(std::size_t bytes, const std::string& found) const {
    fail("expected an array of " + std::to_string(bytes) + " bytes, but its header announces " + found);
  }

  const Cursor& in_;
  const WrappedRange& range_;
  const Wrapping& wrapping_;
  std::size_t stands_at_;
};

/// The first bytes of the array, header included.
std::string Unwrapper::first(std::size_t bytes) const {
  const std::size_t length = range_.end - range_.begin;
  const std::size_t most = range_.base64 ? length / 4 * 3 : length;
  if (bytes > most)
    fail("expected " + std::to_string(bytes) + " bytes of data, but there are " + std::to_string(most) +
         " at most before the data end");
  return range_.base64 ? first_of_base64(bytes) : std::string(in_.data().substr(range_.begin, bytes));
}

/// Four letters make three bytes, less one for each '=' at their end, which may come between header and data too.
std::string Unwrapper::first_of_base64(std::size_t bytes) const {
  std::string out;
  out.reserve(bytes + 2);
  unsigned group = 0;
  int letters = 0, padding = 0;
  for (std::size_t at = range_.begin; at < range_.end && out.size() < bytes; ++at) {
    const char letter = in_.data()[at];
    if (letter == ' ' || (letter >= '\t' && letter <= '\r')) continue;
    const int value = base64_value(letter);
    if (letter != '=' && (value < 0 || padding > 0))
      in_.fail(at, "expected base64 data, found " + quoted(in_.data().substr(at, 1)));
    padding += letter == '=';
    group = group << 6 | static_cast<unsigned>(std::max(value, 0));
    if (++letters < 4) continue;
    if (padding > 2) in_.fail(at, "expected base64 data, found " + std::to_string(padding) + " times '='");
    for (int byte = 0; byte < 3 - padding; ++byte) out.push_back(static_cast<char>(group >> (16 - 8 * byte) & 255));
    group = 0;
    letters = padding = 0;
  }
  if (out.size() < bytes)
    fail("expected " + std::to_string(bytes) + " bytes of base64 data, found " + std::to_string(out.size()));
  out.resize(bytes);
  return out;
}

std::vector<long long> Unwrapper::header(std::size_t numbers) const {
  const std::string bytes = first(numbers * wrapping_.header.bytes);
  Cursor in = in_.unwrapped(bytes, stands_at_, wrapping_.order);
  std::vector<long long> values = in.integers(numbers, "a size in the array's header", wrapping_.header).values;
  const auto wrong = std::find_if(values.begin(), values.end(), [](long long value) { return value < 0; });
  if (wrong != values.end()) fail("the array's header announces more than 2⁶³ bytes");
  return values;
}

std::string Unwrapper::plain(std::size_t bytes) const {
  const auto found = static_cast<std::size_t>(header(1)[0]);
  if (found != bytes) fail_size(bytes, std::to_string(found));
  const auto header_bytes = static_cast<std::size_t>(wrapping_.header.bytes);
  return first(header_bytes + bytes).substr(header_bytes);
}

std::string Unwrapper::inflated(std::size_t bytes) const {
  const std::vector<long long> sizes = header(3);
  const auto blocks = static_cast<std::size_t>(sizes[0]), block_bytes = static_cast<std::size_t>(sizes[1]),
             last_bytes = sizes[2] ? static_cast<std::size_t>(sizes[2]) : block_bytes;
  if (blocks == 0) {
    if (bytes > 0) fail_size(bytes, "none");
    return {};
  }
  const bool too_many = blocks > 1 && block_bytes > bytes / (blocks - 1);
  if (too_many || (blocks - 1) * block_bytes + last_bytes != bytes)
    fail_size(bytes, std::to_string(blocks) + " blocks of " + std::to_string(block_bytes) + ", the last of " +
                         std::to_string(last_bytes));
  const auto header_bytes = static_cast<std::size_t>(wrapping_.header.bytes);
  const std::size_t all_data = range_.end - range_.begin;
  if (blocks > all_data / header_bytes) fail("the array's header announces more blocks than there are data");

  const std::vector<long long> all_sizes = header(3 + blocks);
  std::size_t begin = header_bytes * (3 + blocks), end = begin;
  for (std::size_t block = 0; block < blocks; ++block) {
    const auto packed_bytes = static_cast<std::size_t>(all_sizes[3 + block]);
    if (packed_bytes > all_data) fail("the array's header announces a block longer than the data");
    end += packed_bytes;
  }
  const std::string packed = first(end);
  std::string out;
  for (std::size_t block = 0; block < blocks; ++block) {
    const auto packed_bytes = static_cast<std::size_t>(all_sizes[3 + block]);
    inflate_block(packed, begin, packed_bytes, block + 1 < blocks ? block_bytes : last_bytes, out);
    begin += packed_bytes;
  }
  return out;
}

void Unwrapper::inflate_block(const std::string& packed, std::size_t begin, std::size_t packed_bytes, std::size_t bytes,
                              std::string& out) const {
  constexpr std::size_t greatest_ratio = 1032;  // of deflate, [zlib Technical Details]
  if (bytes / greatest_ratio > packed_bytes)
    fail("a block of " + std::to_string(packed_bytes) + " bytes can't inflate to " + std::to_string(bytes));
  const std::size_t done = out.size();
  out.resize(done + bytes);
  uLongf got = static_cast<uLongf>(bytes);
  const int code = uncompress(reinterpret_cast<Bytef*>(out.data() + done), &got,
                              reinterpret_cast<const Bytef*>(packed.data() + begin), static_cast<uLong>(packed_bytes));
  if (code != Z_OK || got != bytes)
    fail("a block of zlib data does not inflate to " + std::to_string(bytes) +
         " bytes: " + (code == Z_OK ? "it holds " + std::to_string(got) : std::string(zError(code))));
}

}  // namespace

std::string unwrap(const Cursor& in, const WrappedRange& range, const Wrapping& wrapping, std::size_t bytes,
                   std::size_t stands_at) {
  const Unwrapper unwrapper(in, range, wrapping, stands_at);
  return wrapping.zlib ? unwrapper.inflated(bytes) : unwrapper.plain(bytes);
}

}  // namespace elastin::mesh::format
