#pragma once
#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace elastin::lab {

/// Writes a VTU file's arrays packed by zlib, in base64: a tenth of their text, and still XML.
///                                                                       [VTK File Formats, XML formats, "binary"]
class VtuArrays {
 public:
  explicit VtuArrays(std::string& out) : out_(out) {}
  /// `type`: Float64, Int64, Int32 or UInt8; value(i, component) of `count` points or cells, i as large as the count.
  template <class Count, class Value>
  void add(const char* name, std::string_view type, int components, Count count, Value&& value) {
    if (type == "Float64")
      add_as<double>(name, type, components, count, value);
    else if (type == "Int64")
      add_as<std::int64_t>(name, type, components, count, value);
    else if (type == "Int32")
      add_as<std::int32_t>(name, type, components, count, value);
    else
      add_as<std::uint8_t>(name, type, components, count, value);
  }

 private:
  template <class Number, class Count, class Value>
  void add_as(const char* name, std::string_view type, int components, Count count, Value&& value) {
    std::vector<Number> numbers;
    numbers.reserve(static_cast<std::size_t>(count) * static_cast<std::size_t>(components));
    for (Count i = 0; i < count; ++i)
      for (int component = 0; component < components; ++component)
        numbers.push_back(static_cast<Number>(value(i, component)));
    add_bytes(name, type, components, {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)});
  }
  void add_bytes(const char* name, std::string_view type, int components, std::string_view bytes);
  std::string& out_;
};

inline std::string vtu_head(int points, int cells) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
      points, cells);
}

inline constexpr const char* kVtuEnd = "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";

}  // namespace elastin::lab
