#pragma once
#include <fmt/format.h>

#include <iterator>
#include <string>

namespace elastin::lab {

/// Writes a VTU file's arrays as text.
class VtuArrays {
 public:
  explicit VtuArrays(std::string& out) : out_(out) {}
  template <class Value>
  void add(const char* name, const char* type, int components, int count, Value&& value) {
    fmt::format_to(std::back_inserter(out_),
                   "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n", type, name,
                   components);
    for (int i = 0; i < count; ++i) {
      for (int component = 0; component < components; ++component)
        fmt::format_to(std::back_inserter(out_), "{} ", value(i, component));
      out_ += '\n';
    }
    out_ += "</DataArray>\n";
  }

 private:
  std::string& out_;
};

inline std::string vtu_head(int points, int cells) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
      points, cells);
}

inline constexpr const char* kVtuEnd = "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";

}  // namespace elastin::lab
