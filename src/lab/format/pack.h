#pragma once
#include <string>
#include <string_view>

namespace elastin::lab {

/// RFC 4648, with padding.
std::string base64(const void* bytes, std::size_t count);

/// The text as gzip (RFC 1952), in base64: what a page carries and its browser unpacks.
std::string packed(std::string_view text);

}  // namespace elastin::lab
