#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {
namespace {

// The Polygon File Format. [Turk 1994]
struct Property {
  std::string name;
  NumberType type;
  std::optional<NumberType> list;  ///< of the number of things in a list; none: one number
};

struct Element {
  std::string name;
  std::size_t count = 0, at = 0;
  std::vector<Property> properties;
};

struct Header {
  bool binary = false;
  std::endian order = std::endian::native;
  std::vector<Element> elements;
};

NumberType read_type(Cursor& in) {
  static constexpr std::pair<const char*, NumberType> types[] = {{"char", {NumberType::signed_integer, 1}},
                                                                 {"int8", {NumberType::signed_integer, 1}},
                                                                 {"uchar", {NumberType::unsigned_integer, 1}},
                                                                 {"uint8", {NumberType::unsigned_integer, 1}},
                                                                 {"short", {NumberType::signed_integer, 2}},
                                                                 {"int16", {NumberType::signed_integer, 2}},
                                                                 {"ushort", {NumberType::unsigned_integer, 2}},
                                                                 {"uint16", {NumberType::unsigned_integer, 2}},
                                                                 {"int", int32},
                                                                 {"int32", int32},
                                                                 {"uint", {NumberType::unsigned_integer, 4}},
                                                                 {"uint32", {NumberType::unsigned_integer, 4}},
                                                                 {"float", {NumberType::real, 4}},
                                                                 {"float32", {NumberType::real, 4}},
                                                                 {"double", float64},
                                                                 {"float64", float64}};
  const std::string_view word = in.word("a type of number");
  for (const auto& [name, type] : types)
    if (word == name) return type;
  in.fail(in.at() - word.size(), "expected a type of number (char to double), found " + quoted(word));
}

Property read_property(Cursor& in) {
  Property property;
  Cursor after = in;
  if (after.word("a type of number, or list") == "list") {
    in = after;
    property.list = read_type(in);
    if (property.list->kind == NumberType::real) in.fail(in.at(), "expected a list counted in integers");
  }
  property.type = read_type(in);
  property.name = in.word("the name of a property");
  return property;
}

void read_ply_format(Cursor& in, Header& header) {
  in.expect("format");
  const std::string_view word = in.word("ascii, binary_little_endian or binary_big_endian");
  const bool big = word == "binary_big_endian";
  header.binary = big || word == "binary_little_endian";
  header.order = big ? std::endian::big : std::endian::little;
  if (!header.binary && word != "ascii")
    in.fail(in.at() - word.size(), "expected ascii, binary_little_endian or binary_big_endian, found " + quoted(word));
  in.expect("1.0");
}

Header read_header(Cursor& in) {
  Header header;
  in.expect("ply");
  read_ply_format(in, header);
  for (;;) {
    const std::string_view word = in.word("element, property or end_header");
    const std::size_t at = in.at() - word.size();
    if (word == "comment" || word == "obj_info") {
      in.line();
    } else if (word == "element") {
      Element element{std::string(in.word("the name of an element")), 0, at, {}};
      element.count = in.count("the number of these elements");
      header.elements.push_back(std::move(element));
    } else if (word == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(read_property(in));
    } else if (word == "end_header") {
      if (header.binary) in.end_line();
      return header;
    } else {
      in.fail(at, "expected element, property, comment or end_header, found " + quoted(word));
    }
  }
}

bool holds_integers(const NumberType& type) { return type.kind != NumberType::real; }

std::size_t read_list_size(Cursor& in, const NumberType& type) { return in.count("the length of a list", type); }

void skip(Cursor& in, const Property& property) {
  in.skip_numbers(property.list ? read_list_size(in, *property.list) : 1, property.type);
}

/// Number of the mesh's point for each vertex.
std::vector<int> read_points(Cursor& in, const Element& element, MeshBuilder& mesh) {
  for (const char* axis : {"x", "y", "z"})
    if (std::count_if(element.properties.begin(), element.properties.end(),
                      [&](const Property& property) { return !property.list && property.name == axis; }) != 1)
      in.fail(element.at, "expected a vertex with the properties x, y and z, each once");
  std::vector<Vector3> places;
  for (std::size_t vertex = 0; vertex < element.count; ++vertex) {
    Vector3 position;
    for (const Property& property : element.properties) {
      const int axis = property.name == "x" ? 0 : property.name == "y" ? 1 : property.name == "z" ? 2 : 3;
      if (property.list || axis == 3)
        skip(in, property);
      else if (in.binary() && holds_integers(property.type))
        position[axis] = static_cast<double>(in.integer("a coordinate", property.type));
      else
        position[axis] = in.real("a coordinate", property.type);
    }
    places.push_back(position);
  }
  const double within = reach_of_place(places);
  std::vector<int> points;
  for (const Vector3& place : places) points.push_back(mesh.point_at(place, within));
  return points;
}

/// A polygon; or strips, in which each corner makes a triangle with the two before it, and −1 ends a strip.
void read_face(Cursor& in, std::size_t number, const Property& corners, bool strips, const std::vector<int>& points,
               MeshBuilder& mesh) {
  const std::size_t at = in.next_at();
  const std::size_t size = read_list_size(in, *corners.list);
  if (size < 3)
    in.fail(at, "face " + std::to_string(number) + " has " + std::to_string(size) + " corners; 3 or more make one");
  std::string problem;
  std::size_t strip = 0;
  const Integers vertices = in.integers(size, "a vertex of a face", corners.type);
  std::vector<int> corner;
  for (std::size_t i = 0; i < size; ++i) {
    const long long vertex = vertices.values[i];
    if (strips && vertex == -1) {
      strip = corner.size();
      continue;
    }
    if (vertex < 0 || static_cast<std::size_t>(vertex) >= points.size())
      vertices.fail(i, "face " + std::to_string(number) + " uses vertex " + std::to_string(vertex) +
                           ", but there are " + std::to_string(points.size()));
    corner.push_back(points[vertex]);
    const std::size_t n = corner.size();
    if (!strips || n < strip + 3) continue;
    const bool turned = (n - strip) % 2 == 0;
    problem += mesh.add_triangle({corner[n - 3], corner[n - (turned ? 1 : 2)], corner[n - (turned ? 2 : 1)]});
  }
  if (!strips) problem = mesh.add_polygon(corner);
  if (!problem.empty()) in.fail(at, "face " + std::to_string(number) + problem);
}

void read_faces(Cursor& in, const Element& element, bool strips, const std::vector<int>& points, MeshBuilder& mesh) {
  const auto are_corners = [](const Property& property) {
    return property.list && holds_integers(property.type) &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
  };
  bool found = false;
  for (const Property& property : element.properties) {
    if (found && are_corners(property)) in.fail(element.at, "expected one list vertex_indices of a face");
    found |= are_corners(property);
  }
  if (!found) in.fail(element.at, "expected a face with the property list … vertex_indices");
  for (std::size_t face = 0; face < element.count; ++face)
    for (const Property& property : element.properties)
      are_corners(property) ? read_face(in, face, property, strips, points, mesh) : skip(in, property);
}

}  // namespace

void read_ply(Cursor in, MeshBuilder& mesh) {
  const Header header = read_header(in);
  if (header.binary) in.begin_binary(header.order);
  std::vector<int> points;
  for (const Element& element : header.elements) {
    if (element.name == "vertex")
      points = read_points(in, element, mesh);
    else if (element.name == "face" || element.name == "tristrips")
      read_faces(in, element, element.name == "tristrips", points, mesh);
    else
      for (std::size_t number = 0; number < element.count; ++number)
        for (const Property& property : element.properties) skip(in, property);
  }
  const std::string_view rest = in.data().substr(in.at());  // line ends behind binary data do no harm
  if (rest.find_first_not_of(std::string_view("\n\r\t \0", 5)) != std::string_view::npos) in.expect_end("numbers");
}

}  // namespace elastin::mesh::format
