#pragma once
#include <bit>
#include <string>

#include "mesh/text_file.h"

namespace elastin::mesh::format {

/// How the arrays of one VTK XML file are wrapped.
struct Wrapping {
  std::endian order = std::endian::little;
  NumberType header{NumberType::unsigned_integer, 4};
  bool zlib = false;
};

/// Where the bytes of one array begin, and the last place where they may end.
struct WrappedRange {
  std::size_t begin = 0;
  std::size_t end = 0;
  bool base64 = true;
};

/// The bytes of one array that should have `bytes` of them. Fails at the file's offset `stands_at` where the array
/// holds another number of bytes, ends early, is no base64 or does not inflate. Allocates no more than zlib could have
/// packed into the range. Format: [number of bytes][data], or for zlib [blocks n][bytes of a block][bytes of the last,
/// 0 = full][n packed sizes][packed blocks]; base64 pads the header for itself or not.  [VTK File Formats, XML formats]
std::string unwrap(const Cursor& in, const WrappedRange& range, const Wrapping& wrapping, std::size_t bytes,
                   std::size_t stands_at);

}  // namespace elastin::mesh::format
