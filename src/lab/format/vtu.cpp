#include "lab/format/vtu.h"

#include <zlib.h>

#include <bit>
#include <cerrno>
#include <stdexcept>
#include <system_error>

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

}  // namespace

/// More effort than the least makes coordinates a hundredth smaller and takes two to ten times as long.
void VtuArrays::pack(std::string_view bytes, Packed& packed) {
  const std::size_t before = packed.bytes.size();
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  packed.bytes.resize(before + size);
  const int problem =
      compress2(reinterpret_cast<Bytef*>(packed.bytes.data() + before), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()), Z_BEST_SPEED);
  if (problem != Z_OK) throw std::runtime_error("zlib cannot pack an array of a VTU file");
  packed.bytes.resize(before + size);
  packed.sizes.push_back(size);
  packed.last = bytes.size();
}

void VtuArrays::flush() {
  if (!stream_) return;
  if (!stream_->write(out_.data(), static_cast<std::streamsize>(out_.size())))
    throw std::system_error(errno, std::generic_category());
  out_.clear();
}

/// [blocks][bytes of one before packing][bytes of the last, 0 = full][packed bytes of each], then the blocks. An empty
/// array has none.
void VtuArrays::write(const char* name, std::string_view type, int components, const Packed& packed) {
  const std::size_t blocks = packed.sizes.size();
  std::vector<std::uint64_t> head{blocks, blocks > 1 ? kBlock : packed.last,
                                  blocks > 1 && packed.last < kBlock ? packed.last : 0};
  head.insert(head.end(), packed.sizes.begin(), packed.sizes.end());
  declared_ += fmt::format("<PDataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"/>\n", type, name, components);
  out_ += fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">\n", type, name,
                      components);
  append_base64({reinterpret_cast<const char*>(head.data()), sizeof(std::uint64_t) * head.size()}, out_);
  constexpr std::size_t piece = 3 * kBlock;  // threes of bytes are four letters
  for (std::size_t at = 0; at < packed.bytes.size(); at += piece) {
    append_base64(std::string_view(packed.bytes).substr(at, piece), out_);
    flush();
  }
  out_ += "\n</DataArray>\n";
}

}  // namespace elastin::lab
