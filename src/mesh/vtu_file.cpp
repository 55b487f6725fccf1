#include <algorithm>
#include <charconv>
#include <climits>
#include <list>
#include <optional>
#include <pugixml.hpp>
#include <utility>

#include "mesh/mesh_formats.h"
#include "mesh/wrapped_data.h"

namespace elastin::mesh::format {
namespace {

class VtuReader {
 public:
  VtuReader(Cursor in, MeshBuilder& mesh) : in_(in), mesh_(mesh) {}
  void read();

 private:
  void parse_xml();
  void read_root(pugi::xml_node root);
  void read_piece(pugi::xml_node piece);
  void read_points(pugi::xml_node points, std::size_t count);
  VtkCells read_cells(pugi::xml_node cells, std::size_t count);
  void read_cell_data(pugi::xml_node data, int first_cell, std::size_t count);
  Cursor numbers(pugi::xml_node array, NumberType type, std::size_t count);
  WrappedRange inline_range(pugi::xml_node array) const;
  WrappedRange appended_range(pugi::xml_node array) const;

  pugi::xml_node child(pugi::xml_node parent, const char* name) const;
  pugi::xml_node array_named(pugi::xml_node parent, const std::string& name) const;
  NumberType number_type(pugi::xml_node array, std::optional<bool> real) const;
  std::size_t number_of(pugi::xml_node node, const char* attribute, std::size_t most) const;
  std::size_t at(pugi::xml_node node) const;
  [[noreturn]] void fail_attribute(pugi::xml_node node, const char* attribute, const std::string& allowed) const;

  Cursor in_;
  MeshBuilder& mesh_;
  pugi::xml_document document_;
  Wrapping wrapping_;
  std::size_t appended_from_ = std::string_view::npos;  // behind the '_' that starts appended data
  bool appended_base64_ = false;
  std::list<std::string> unwrapped_;  // of the present piece
};

/// Where an XML node stands in the file: at its name or its text.
std::size_t VtuReader::at(pugi::xml_node node) const {
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0));
}

void VtuReader::fail_attribute(pugi::xml_node node, const char* attribute, const std::string& allowed) const {
  const pugi::xml_attribute given = node.attribute(attribute);
  in_.fail(at(node), std::string(node.name()) + ": expected " + attribute + "=" + allowed +
                         (given ? ", found " + quoted(given.value()) : ""));
}

pugi::xml_node VtuReader::child(pugi::xml_node parent, const char* name) const {
  const pugi::xml_node found = parent.child(name);
  if (!found) in_.fail(at(parent), std::string(parent.name()) + ": expected <" + name + "> inside");
  return found;
}

pugi::xml_node VtuReader::array_named(pugi::xml_node parent, const std::string& name) const {
  const pugi::xml_node found = parent.find_child_by_attribute("DataArray", "Name", name.c_str());
  if (!found) in_.fail(at(parent), std::string(parent.name()) + ": expected <DataArray Name=\"" + name + "\"> inside");
  return found;
}

std::size_t VtuReader::number_of(pugi::xml_node node, const char* attribute, std::size_t most) const {
  const std::string_view text = node.attribute(attribute).value();
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size() || value > most)
    fail_attribute(node, attribute, "0 to " + std::to_string(most));
  return value;
}

/// @param real whether they must be real numbers, or integers; none = any
NumberType VtuReader::number_type(pugi::xml_node array, std::optional<bool> real) const {
  static constexpr std::pair<const char*, NumberType> types[] = {
      {"Int8", {NumberType::signed_integer, 1}},  {"UInt8", {NumberType::unsigned_integer, 1}},
      {"Int16", {NumberType::signed_integer, 2}}, {"UInt16", {NumberType::unsigned_integer, 2}},
      {"Int32", {NumberType::signed_integer, 4}}, {"UInt32", {NumberType::unsigned_integer, 4}},
      {"Int64", {NumberType::signed_integer, 8}}, {"UInt64", {NumberType::unsigned_integer, 8}},
      {"Float32", {NumberType::real, 4}},         {"Float64", {NumberType::real, 8}}};
  const std::string_view name = array.attribute("type").value();
  for (const auto& [known, type] : types)
    if (name == known && (type.kind == NumberType::real) == real.value_or(type.kind == NumberType::real)) return type;
  fail_attribute(array, "type", real.value_or(true) ? "Float32 or Float64" : "Int8 to Int64 or UInt8 to UInt64");
}

/// Appended data are no XML where they are raw: what is parsed ends at the start tag of AppendedData.
void VtuReader::parse_xml() {
  const std::string_view bytes = in_.data();
  std::string xml(bytes);
  const std::size_t tag = bytes.find("<AppendedData");
  const std::size_t tag_end = tag == std::string_view::npos ? tag : bytes.find('>', tag);
  if (tag_end != std::string_view::npos) {
    xml = std::string(bytes.substr(0, tag_end + 1)) + "</AppendedData></VTKFile>";
    appended_from_ = bytes.find_first_not_of(" \t\r\n", tag_end + 1);
    if (appended_from_ == std::string_view::npos || bytes[appended_from_] != '_')
      in_.fail(std::min(appended_from_, bytes.size()), "AppendedData: expected '_' before the data");
    ++appended_from_;
  }
  const pugi::xml_parse_result result =
      document_.load_buffer(xml.data(), xml.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result)
    in_.fail(static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0)),
             std::string("expected XML: ") + result.description());
}

void VtuReader::read_root(pugi::xml_node root) {
  const auto attribute = [&](const char* name, const char* usual) {
    return std::string(root.attribute(name).as_string(usual));
  };
  if (attribute("type", "") != "UnstructuredGrid") fail_attribute(root, "type", "UnstructuredGrid");
  const std::string order = attribute("byte_order", "LittleEndian");
  if (order != "LittleEndian" && order != "BigEndian") fail_attribute(root, "byte_order", "LittleEndian or BigEndian");
  wrapping_.order = order == "BigEndian" ? std::endian::big : std::endian::little;
  const std::string header = attribute("header_type", "UInt32");
  if (header != "UInt32" && header != "UInt64") fail_attribute(root, "header_type", "UInt32 or UInt64");
  wrapping_.header.bytes = header == "UInt64" ? 8 : 4;
  const std::string compressor = attribute("compressor", "");
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    fail_attribute(root, "compressor", "vtkZLibDataCompressor or none");
  wrapping_.zlib = !compressor.empty();
  if (const pugi::xml_node appended = root.child("AppendedData")) {
    const std::string encoding = appended.attribute("encoding").value();
    if (encoding != "base64" && encoding != "raw") fail_attribute(appended, "encoding", "base64 or raw");
    appended_base64_ = encoding == "base64";
  }
}

/// From the first letter of the text inside to the next tag; VTK puts <InformationKey> next to the text.
WrappedRange VtuReader::inline_range(pugi::xml_node array) const {
  const pugi::xml_node text = array.find_child([](pugi::xml_node node) { return node.type() == pugi::node_pcdata; });
  if (!text) return {at(array), at(array), true};
  return {at(text), std::min(in_.data().find('<', at(text)), in_.data().size()), true};
}

WrappedRange VtuReader::appended_range(pugi::xml_node array) const {
  if (appended_from_ == std::string_view::npos)
    in_.fail(at(array), "format=\"appended\", but there is no AppendedData");
  const std::size_t most = in_.data().size() - appended_from_;
  const std::size_t begin = appended_from_ + number_of(array, "offset", most);
  const std::size_t end =
      appended_base64_ ? std::min(in_.data().find('<', begin), in_.data().size()) : in_.data().size();
  return {begin, end, appended_base64_};
}

/// A cursor before the array's numbers, of which there are `count` (if binary; of text the reader finds out).
Cursor VtuReader::numbers(pugi::xml_node array, NumberType type, std::size_t count) {
  const std::string format = array.attribute("format").as_string("ascii");
  if (format != "ascii" && format != "binary" && format != "appended")
    fail_attribute(array, "format", "ascii, binary or appended");
  const WrappedRange range = format == "appended" ? appended_range(array) : inline_range(array);
  if (format == "ascii") return in_.part(range.begin, range.end);
  unwrapped_.push_back(unwrap(in_, range, wrapping_, count * type.bytes, at(array)));
  return in_.unwrapped(unwrapped_.back(), at(array), wrapping_.order);
}

void VtuReader::read_points(pugi::xml_node points, std::size_t count) {
  const pugi::xml_node array = child(points, "DataArray");
  if (array.attribute("NumberOfComponents").as_int(3) != 3) fail_attribute(array, "NumberOfComponents", "3");
  const NumberType type = number_type(array, true);
  Cursor in = numbers(array, type, 3 * count);
  in.require_numbers(3 * count, "coordinates", type);
  for (std::size_t point = 0; point < count; ++point) {
    Vector3 position;
    for (double& coordinate : position) coordinate = in.real("a coordinate", type);
    mesh_.add_point(position);
  }
  in.expect_end("coordinates");
}

VtkCells VtuReader::read_cells(pugi::xml_node cells, std::size_t count) {
  const auto integers = [&](const char* name, std::size_t size, const char* what) {
    const pugi::xml_node array = array_named(cells, name);
    const NumberType type = number_type(array, false);
    Cursor in = numbers(array, type, size);
    Integers read = in.integers(size, what, type);
    in.expect_end(name);
    return read;
  };
  const Integers offsets = integers("offsets", count, "an offset");
  const long long corners = count > 0 ? offsets.values[count - 1] : 0;
  if (corners < 0 || corners > INT_MAX)
    offsets.fail(count - 1,
                 "expected an offset from 0 to " + std::to_string(INT_MAX) + ", found " + std::to_string(corners));
  const auto size = static_cast<std::size_t>(corners);
  VtkCells read{integers("connectivity", size, "a point of a cell"), {}, {}, integers("types", count, "a cell's type")};
  for (std::size_t cell = 0; cell < count; ++cell) add_range(offsets, cell, size, read.first, read.count);
  return read;
}

void VtuReader::read_piece(pugi::xml_node piece) {
  unwrapped_.clear();
  const int first_point = mesh_.point_count();
  const std::size_t points = number_of(piece, "NumberOfPoints", INT_MAX - first_point);
  const std::size_t cells = number_of(piece, "NumberOfCells", INT_MAX);
  if (points == 0 && cells == 0) return;
  read_points(child(piece, "Points"), points);
  const int first_cell = mesh_.cell_count();
  if (cells > 0) add_vtk_cells(read_cells(child(piece, "Cells"), cells), first_point, mesh_);
  if (mesh_.wanted_data()) read_cell_data(piece.child("CellData"), first_cell, cells);
}

void VtuReader::read_cell_data(pugi::xml_node data, int first_cell, std::size_t count) {
  for (const pugi::xml_node array : data.children("DataArray")) {
    if (!mesh_.is_wanted(array.attribute("Name").value())) continue;
    const int components = array.attribute("NumberOfComponents").as_int(1);
    if (components < 1 || components > 9) fail_attribute(array, "NumberOfComponents", "1 to 9");
    const NumberType type = number_type(array, std::nullopt);
    const std::size_t size = components * count;
    Cursor in = numbers(array, type, size);
    read_data(in, type, components, first_cell, count, mesh_);
    in.expect_end("values of cells");
  }
}

void VtuReader::read() {
  parse_xml();
  const pugi::xml_node root = document_.child("VTKFile");
  if (!root) in_.fail(0, "expected <VTKFile type=\"UnstructuredGrid\" …>");
  read_root(root);
  const pugi::xml_node grid = child(root, "UnstructuredGrid");
  child(grid, "Piece");
  for (const pugi::xml_node piece : grid.children("Piece")) read_piece(piece);
}

}  // namespace

void read_vtu(Cursor in, MeshBuilder& mesh) { VtuReader(in, mesh).read(); }

}  // namespace elastin::mesh::format
