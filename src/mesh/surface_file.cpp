#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "mesh/mesh_formats.h"

namespace elastin::mesh::format {
namespace {

/// Corners and faces as a file has them: a corner once for each face, normal or colour that it has.
struct Polygons {
  std::vector<Vector3> corners;
  std::vector<std::vector<int>> faces;

  /// Corners at the same position become one point of the mesh.
  void hand_over(MeshBuilder& mesh) const {
    if (faces.empty())  // for the refusal, which counts them
      for (const Vector3& corner : corners) mesh.add_point(corner);
    std::vector<char> used(corners.size(), 0);
    for (const std::vector<int>& face : faces)
      for (const int corner : face) used[corner] = 1;
    const double within = reach_of_place(corners, used);
    std::vector<int> point(corners.size(), -1);
    for (std::vector<int> face : faces) {
      for (int& corner : face) {
        if (point[corner] < 0) point[corner] = mesh.point_at(corners[corner], within);
        corner = point[corner];
      }
      mesh.add_polygon(face);
    }
  }
};

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view blanks = " \t\r\v\f";
  for (std::size_t from = line.find_first_not_of(blanks); from < line.size();) {
    const std::size_t to = std::min(line.find_first_of(blanks, from), line.size());
    words.push_back(line.substr(from, to - from));
    from = line.find_first_not_of(blanks, to);
  }
  return words;
}

/// Steps over blanks and over lines that begin with #.
bool more_than_comments(Cursor& in) {
  while (in.more() && in.data()[in.at()] == '#') in.line();
  return in.more();
}

Vector3 read_position(Cursor& in, NumberType type = float64) {
  Vector3 position;
  for (double& coordinate : position) coordinate = in.real("a coordinate", type);
  return position;
}

void read_binary_stl(Cursor in, MeshBuilder& mesh) {
  constexpr NumberType float32{NumberType::real, 4};
  constexpr std::size_t header = 80, size = 50;
  in = in.part(header, in.data().size());
  in.begin_binary(std::endian::little);
  const auto count = static_cast<std::size_t>(in.integer("the number of triangles", {NumberType::unsigned_integer, 4}));
  if (count > in.left() / size)
    in.fail(header, "expected " + std::to_string(count) + " triangles of 50 bytes, but what is left has room for " +
                        std::to_string(in.left() / size));
  Polygons all;
  for (std::size_t triangle = 0; triangle < count; ++triangle) {
    in.skip_numbers(3, float32);  // its normal
    for (int corner = 0; corner < 3; ++corner) all.corners.push_back(read_position(in, float32));
    in.skip_numbers(1, {NumberType::unsigned_integer, 2});
    const auto last = static_cast<int>(all.corners.size());
    all.faces.push_back({last - 3, last - 2, last - 1});
  }
  if (in.left() >= size && in.left() % size == 0)
    in.fail(header, "expected the number of triangles, but there are " + std::to_string(in.left() / size) +
                        " more than " + std::to_string(count));
  all.hand_over(mesh);
}

}  // namespace

void read_stl(Cursor in, MeshBuilder& mesh) {
  const std::string_view data = in.data();
  std::uint32_t count = 0;
  if (data.size() >= 84) std::memcpy(&count, data.data() + 80, 4);
  // Bytes may follow the last triangle; of a text, these four letters would be a number of triangles that do not fit.
  const bool fits = data.size() >= 84 && data.size() - 84 >= 50 * static_cast<std::size_t>(count);
  const bool is_binary = fits || data.substr(0, 84).find('\0') != std::string_view::npos;
  if (is_binary || upper_case(trimmed(data.substr(0, 80)).substr(0, 5)) != "SOLID") {
    if (data.size() < 84) in.fail(0, "expected solid, or 80 bytes and the number of triangles");
    return read_binary_stl(in, mesh);
  }
  Polygons all;
  std::vector<int> face;
  while (in.more()) {
    const std::string word = upper_case(in.word("facet"));
    if (word == "VERTEX") {
      face.push_back(static_cast<int>(all.corners.size()));
      all.corners.push_back(read_position(in));
    } else if (word == "SOLID" || word == "ENDSOLID") {
      in.line();  // a name
    } else if (word == "ENDLOOP") {
      all.faces.push_back(std::move(face));
      face.clear();
    }
  }
  if (!face.empty()) in.fail(in.at(), "expected endloop, but the data ends here");
  all.hand_over(mesh);
}

void read_obj(Cursor in, MeshBuilder& mesh) {
  Polygons all;
  const auto fail = [&](std::string_view word, const std::string& message) {
    in.fail(static_cast<std::size_t>(word.data() - in.data().data()), message);
  };
  std::string_view beyond;  // the first corner that is used before it stands in the file
  while (in.left() > 0) {
    std::vector<std::string_view> words = words_of(in.line());
    while (!words.empty() && words.back().ends_with('\\') && in.left() > 0) {
      words.back().remove_suffix(1);
      if (words.back().empty()) words.pop_back();
      const auto more = words_of(in.line());
      words.insert(words.end(), more.begin(), more.end());
    }
    if (words.empty()) continue;
    if (words[0] == "v") {
      if (words.size() < 4) fail(words[0], "expected v and three coordinates");
      Vector3 position;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto value = fortran_real(words[k + 1]);
        if (!value) fail(words[k + 1], "expected a coordinate, a finite number; found " + quoted(words[k + 1]));
        position[static_cast<Eigen::Index>(k)] = *value;
      }
      all.corners.push_back(position);
    } else if (words[0] == "l" || words[0] == "p") {
      mesh.leave_out(words[0] == "l" ? "line" : "point");
    } else if (words[0] == "f") {
      std::vector<int>& face = all.faces.emplace_back();
      for (std::size_t k = 1; k < words.size() && words[k][0] != '#'; ++k) {
        const auto number = whole_number(words[k].substr(0, words[k].find('/')));  // without texture and normal
        const auto before = static_cast<long long>(all.corners.size());
        if (!number || *number == 0 || *number < -before || *number > std::numeric_limits<int>::max())
          fail(words[k], "expected a corner of a face, 1 or more, or -1 to -" + std::to_string(before) + "; found " +
                             quoted(words[k]));
        if (*number > before && beyond.empty()) beyond = words[k];
        face.push_back(static_cast<int>(*number > 0 ? *number - 1 : before + *number));
      }
    }
  }
  for (const std::vector<int>& face : all.faces)
    for (const int corner : face)
      if (corner >= static_cast<int>(all.corners.size()))
        fail(beyond, "a face uses corner " + std::to_string(corner + 1) + ", but there are " +
                         std::to_string(all.corners.size()));
  all.hand_over(mesh);
}

/// The Object File Format of Geomview; what stands behind coordinates and corners in a line are normals and colours.
void read_off(Cursor in, MeshBuilder& mesh) {
  more_than_comments(in);
  const std::string_view kind = in.word("OFF");
  const std::string_view rest = kind.ends_with("OFF") ? kind.substr(0, kind.size() - 3) : "?";
  if (rest != "" && rest != "C" && rest != "N" && rest != "CN" && rest != "ST" && rest != "STCN")
    in.fail(in.at() - kind.size(), "expected OFF, COFF or NOFF, found " + quoted(kind));
  if (Cursor ahead = in; trimmed(ahead.line()) == "BINARY") in.fail(in.at(), "OFF BINARY is not read; save it as text");
  more_than_comments(in);
  const std::size_t points = in.count("the number of points"), faces = in.count("the number of faces");
  in.line();  // the number of sides
  Polygons all;
  for (std::size_t point = 0; point < points && more_than_comments(in); ++point) {
    all.corners.push_back(read_position(in));
    in.line();
  }
  for (std::size_t face = 0; face < faces; ++face) {
    more_than_comments(in);
    std::vector<int>& corners = all.faces.emplace_back();
    for (std::size_t left = in.count("the number of a face's corners"); left > 0; --left) {
      const std::size_t at = in.next_at();
      const long long corner = in.integer("a corner of a face");
      if (corner < 0 || corner >= static_cast<long long>(all.corners.size()))
        in.fail(at, "face " + std::to_string(face) + " uses point " + std::to_string(corner) + ", but there are " +
                        std::to_string(all.corners.size()) + ", counted from 0");
      corners.push_back(static_cast<int>(corner));
    }
    in.line();
  }
  if (more_than_comments(in)) in.expect_end("faces");
  all.hand_over(mesh);
}

}  // namespace elastin::mesh::format
