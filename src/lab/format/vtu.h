#pragma once
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "elastin/contact/obstacle.h"
#include "lab/run/run.h"

namespace elastin::lab {

/// Writes a VTU file's arrays packed by zlib, in base64: a tenth of their text, and still XML. Numbers are packed block
/// by block as they are made, so that no array stands in memory but packed; with a stream to write to, that goes
/// there before the next one is made.                                           [VTK File Formats, XML formats,
/// "binary"]
class VtuArrays {
 public:
  explicit VtuArrays(std::string& out, std::ostream* stream = nullptr) : out_(out), stream_(stream) {}
  /// `type`: Float64, Int64, Int32 or UInt8; value(i, component) of `count` points or cells, i as large as the count.
  template <class Count, class Value>
  void add(const char* name, std::string_view type, int components, Count count, Value&& value) {
    const auto fill = [&](auto&& push) {
      for (Count i = 0; i < count; ++i)
        for (int component = 0; component < components; ++component) push(value(i, component));
    };
    if (type == "Float64")
      add_pushed<double>(name, type, components, fill);
    else if (type == "Int64")
      add_pushed<std::int64_t>(name, type, components, fill);
    else if (type == "Int32")
      add_pushed<std::int32_t>(name, type, components, fill);
    else
      add_pushed<std::uint8_t>(name, type, components, fill);
  }
  /// Numbers that fill(push) gives one after the other, each by push(number).
  template <class Number, class Fill>
  void add_pushed(const char* name, std::string_view type, int components, Fill&& fill) {
    Packed packed;
    std::vector<Number> block;
    const auto end_block = [&] {
      pack({reinterpret_cast<const char*>(block.data()), block.size() * sizeof(Number)}, packed);
      block.clear();
    };
    fill([&](auto number) {
      block.push_back(static_cast<Number>(number));
      if (block.size() * sizeof(Number) == kBlock) end_block();
    });
    if (!block.empty()) end_block();
    write(name, type, components, packed);
  }
  /// What stands in the head of a file whose pieces are other files, of the arrays since the last call.
  std::string declared() { return std::exchange(declared_, {}); }
  /// Hands over to the stream, where there is one, what stands in the text. Throws std::system_error where it is full.
  void flush();

 private:
  static constexpr std::size_t kBlock = std::size_t{1} << 20;  ///< bytes before packing
  struct Packed {
    std::string bytes;
    std::vector<std::uint64_t> sizes;  ///< of each block, packed
    std::uint64_t last = 0;            ///< bytes of the last block before packing
  };
  static void pack(std::string_view bytes, Packed& packed);
  void write(const char* name, std::string_view type, int components, const Packed& packed);
  std::string& out_;
  std::string declared_;
  std::ostream* stream_;
};

inline std::string vtu_head(int points, int cells) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
      points, cells);
}

/// Arrays of points, and data of points and of cells: what each of several files has that are pieces of one.
struct VtuDeclared {
  std::string points, point_data, cell_data;
};

/// The file that names the pieces.
inline std::string pvtu_text(const VtuDeclared& declared, const std::vector<std::string>& pieces) {
  std::string out =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<PUnstructuredGrid GhostLevel=\"0\">\n";
  out += "<PPoints>\n" + declared.points + "</PPoints>\n<PPointData Vectors=\"displacement\">\n" + declared.point_data +
         "</PPointData>\n<PCellData Scalars=\"strain\">\n" + declared.cell_data + "</PCellData>\n";
  for (const std::string& piece : pieces) out += "<Piece Source=\"" + piece + "\"/>\n";
  return out + "</PUnstructuredGrid>\n</VTKFile>\n";
}

inline constexpr const char* kVtuEnd = "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";

/// RFC 4648, with padding.
std::string base64(const void* bytes, std::size_t count);

/// The text as gzip (RFC 1952), in base64: what a page carries and its browser unpacks.
std::string packed(std::string_view text);

/// A VTU file of a body's surface in one state: triangles; contact pressure [Pa] and force [N] where there is contact,
/// displacement [m], the largest strain of a connection at each molecule, and the number of its piece.
std::string surface_vtu_text(const Body& body, const Cells<3>& triangles, const Snapshot& shot);

/// A VTU file of obstacles as triangles, each with its number; planes as wide as the box from `low` to `high` [m] needs
/// for.
std::string obstacles_vtu_text(const std::vector<contact::Obstacle>& obstacles, const std::vector<contact::Pose>& poses,
                               const Vector3& low, const Vector3& high);

/// What draws an obstacle by lines, pairs of points [m] in its own frame: its sharp edges, or of a round one where its
/// middle planes meet it; of a plane a square 2 `wide` across.
std::vector<std::array<Vector3, 2>> outline_of(const contact::ObstacleShape& shape, double wide);

/// The place on a plane that is nearest to the middle of a body, so that the square that is drawn lies under it; of any
/// other obstacle its own pose.
contact::Pose drawn_pose(const contact::Obstacle& obstacle, contact::Pose pose, const Vector3& middle);

}  // namespace elastin::lab
