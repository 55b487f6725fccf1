#include "lab/format/vtu.h"

#include <zlib.h>

#include <array>
#include <bit>
#include <stdexcept>

namespace elastin::lab {
namespace {

static_assert(std::endian::native == std::endian::little, "the head of a VTU file says that its bytes are");

/// Appends RFC 4648, with padding.
void append_base64(std::string_view bytes, std::string& out) {
  constexpr const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto byte = [&](std::size_t at) {
    return at < bytes.size() ? unsigned{static_cast<unsigned char>(bytes[at])} : 0u;
  };
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const unsigned three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    out += letters[three >> 18];
    out += letters[three >> 12 & 63];
    out += i + 1 < bytes.size() ? letters[three >> 6 & 63] : '=';
    out += i + 2 < bytes.size() ? letters[three & 63] : '=';
  }
}

std::string deflated(std::string_view bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string packed(size, '\0');
  const int problem = compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                               reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()));
  if (problem != Z_OK) throw std::runtime_error("zlib cannot pack an array of a VTU file");
  packed.resize(size);
  return packed;
}

}  // namespace

/// The array is one block: [blocks 1][bytes of it][bytes of the last, 0 = full][packed bytes], then the block. An
/// empty array has none.
void VtuArrays::add_bytes(const char* name, std::string_view type, int components, std::string_view bytes) {
  const std::string packed = bytes.empty() ? "" : deflated(bytes);
  const std::array<std::uint64_t, 4> head{bytes.empty() ? 0u : 1u, bytes.size(), 0, packed.size()};
  out_ += fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">\n", type, name,
                      components);
  append_base64({reinterpret_cast<const char*>(head.data()), sizeof(std::uint64_t) * (bytes.empty() ? 3 : 4)}, out_);
  append_base64(packed, out_);
  out_ += "\n</DataArray>\n";
}

}  // namespace elastin::lab
