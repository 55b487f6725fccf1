#include "lab/format/vtu.h"

#include <zlib.h>

#include <stdexcept>

namespace elastin::lab {

std::string base64(const void* bytes, std::size_t count) {
  constexpr const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* from = static_cast<const unsigned char*>(bytes);
  std::string out;
  out.reserve((count + 2) / 3 * 4);
  for (std::size_t i = 0; i < count; i += 3) {
    const unsigned second = i + 1 < count ? from[i + 1] : 0, third = i + 2 < count ? from[i + 2] : 0;
    const unsigned three = (unsigned{from[i]} << 16) | (second << 8) | third;
    out += letters[three >> 18];
    out += letters[three >> 12 & 63];
    out += i + 1 < count ? letters[three >> 6 & 63] : '=';
    out += i + 2 < count ? letters[three & 63] : '=';
  }
  return out;
}

std::string packed(std::string_view text) {
  constexpr int window = 15, gzip = 16, memory = 8;  // zlib.h: deflateInit2
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, window + gzip, memory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib cannot pack what a page shows");
  std::string out(deflateBound(&stream, static_cast<uLong>(text.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);  // the output has room for all
  const std::size_t size = stream.total_out;
  deflateEnd(&stream);
  return base64(out.data(), size);
}

}  // namespace elastin::lab
