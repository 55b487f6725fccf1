#pragma once
#include <zlib.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <pugixml.hpp>
#include <string>
#include <vector>

namespace elastin {

/// Bytes of base64 as RFC 4648 has it; text may hold several padded pieces, one after the other.
inline std::string bytes_of_base64(const std::string& text) {
  static const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned group = 0;
  int count = 0, padding = 0;
  for (const char c : text) {
    const std::size_t value = letters.find(c);
    if (c != '=' && value == std::string::npos) continue;
    padding += c == '=';
    group = group << 6 | (c == '=' ? 0u : static_cast<unsigned>(value));
    if (++count < 4) continue;
    for (int k = 0; k < 3 - padding; ++k) bytes += static_cast<char>(group >> (16 - 8 * k) & 255);
    group = 0;
    count = padding = 0;
  }
  CHECK(count == 0);
  return bytes;
}

/// The numbers of one packed array of a VTU file, read by the format's description alone.
inline std::vector<double> numbers_of(const pugi::xml_node& array) {
  const std::string bytes = bytes_of_base64(array.text().get());
  REQUIRE(bytes.size() >= 24);
  std::uint64_t head[3];  // blocks, bytes of each, bytes of the last or 0 where it is full
  std::memcpy(head, bytes.data(), sizeof head);
  REQUIRE(bytes.size() >= sizeof head + 8 * head[0]);
  std::vector<std::uint64_t> packed(head[0]);
  if (head[0]) std::memcpy(packed.data(), bytes.data() + sizeof head, 8 * packed.size());
  std::size_t from = sizeof head + 8 * packed.size();
  std::string data;
  for (std::size_t block = 0; block < packed.size(); ++block) {
    const std::size_t expected = block + 1 == packed.size() && head[2] ? head[2] : head[1], before = data.size();
    REQUIRE(bytes.size() >= from + packed[block]);
    data.resize(before + expected);
    uLongf size = expected;
    REQUIRE(uncompress(reinterpret_cast<Bytef*>(data.data() + before), &size,
                       reinterpret_cast<const Bytef*>(bytes.data() + from), packed[block]) == Z_OK);
    REQUIRE(size == expected);
    from += packed[block];
  }
  REQUIRE(bytes.size() == from);
  const std::string type = array.attribute("type").value();
  const auto read = [&]<class Number>(Number) {
    std::vector<double> values;
    for (std::size_t at = 0; at < data.size(); at += sizeof(Number)) {
      Number value;
      std::memcpy(&value, data.data() + at, sizeof value);
      values.push_back(static_cast<double>(value));
    }
    return values;
  };
  if (type == "Float64") return read(double());
  if (type == "Int64") return read(std::int64_t());
  if (type == "Int32") return read(std::int32_t());
  REQUIRE(type == "UInt8");
  return read(std::uint8_t());
}

/// Whether every number of every array of a VTU file is finite.
inline bool finite_arrays(const std::string& vtu) {
  pugi::xml_document document;
  REQUIRE(document.load_string(vtu.c_str()));
  for (const auto& array : document.select_nodes("//DataArray"))
    for (const double value : numbers_of(array.node()))
      if (!std::isfinite(value)) return false;
  return true;
}

}  // namespace elastin
