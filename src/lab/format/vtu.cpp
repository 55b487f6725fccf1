#include "lab/format/vtu.h"

#include <zlib.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <system_error>

#include "core/shapes/surfaces.h"
#include "hull/convex_hull.h"

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

std::string base64(const void* bytes, std::size_t count) {
  std::string out;
  out.reserve((count + 2) / 3 * 4);
  append_base64({static_cast<const char*>(bytes), count}, out);
  return out;
}

std::string packed(std::string_view text) {
  constexpr int window = 15, gzip = 16, memory = 8;  // zlib.h: deflateInit2
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, window + gzip, memory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib cannot pack what a page shows");
  std::string out(deflateBound(&stream, static_cast<uLong>(text.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);  // the output has room for all
  const std::size_t size = stream.total_out;
  deflateEnd(&stream);
  return base64(out.data(), size);
}

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

namespace {

/// How finely round obstacles are drawn.
constexpr int kDivisions = 6, kSides = 48;

struct Triangulation {
  Positions points;
  Cells<3> triangles;
};

Triangulation triangulated(const contact::shape::Plane&, double wide) {
  Triangulation square{Positions(3, 4), {{0, 1, 2}, {0, 2, 3}}};
  square.points << -wide, wide, wide, -wide, -wide, -wide, wide, wide, 0, 0, 0, 0;
  return square;
}

Triangulation triangulated(const contact::shape::Box& box, double) {
  Triangulation cuboid{Positions(3, 8), {}};
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis)
      cuboid.points(axis, corner) = (corner >> axis & 1 ? 0.5 : -0.5) * box.size[axis];
  for (const auto& [a, b, c, d] :
       Cells<4>{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    cuboid.triangles.push_back({a, b, c});
    cuboid.triangles.push_back({a, c, d});
  }
  return cuboid;
}

Triangulation triangulated(const contact::shape::Sphere& ball, double) {
  const Body round = sphere(ball.radius, SphereMesh::icosahedron, kDivisions);
  return {round.rest, round.triangles};
}

Triangulation triangulated(const contact::shape::Capsule& capsule, double) {
  Triangulation round = triangulated(contact::shape::Sphere{capsule.radius}, 0);
  for (Eigen::Index i = 0; i < round.points.cols(); ++i)
    round.points(2, i) += (round.points(2, i) > 0 ? 0.5 : -0.5) * capsule.length;
  return round;
}

Triangulation triangulated(const contact::shape::Cylinder& cylinder, double) {
  Triangulation round{Positions(3, 2 * kSides + 2), {}};
  const int low = 2 * kSides, high = low + 1;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    const Vector3 side(cylinder.radius * std::cos(angle), cylinder.radius * std::sin(angle), cylinder.length / 2);
    round.points.col(2 * i) = Vector3(side.x(), side.y(), -side.z());
    round.points.col(2 * i + 1) = side;
    const int a = 2 * i, b = 2 * ((i + 1) % kSides);
    for (const auto& t : Cells<3>{{a, b, b + 1}, {a, b + 1, a + 1}, {low, b, a}, {high, a + 1, b + 1}})
      round.triangles.push_back(t);
  }
  round.points.col(low) = Vector3(0, 0, -cylinder.length / 2);
  round.points.col(high) = Vector3(0, 0, cylinder.length / 2);
  return round;
}

Triangulation triangulated(const contact::shape::Convex& convex, double) {
  Triangulation hull{convex.points, {}};
  const std::vector<double> coordinates(convex.points.data(), convex.points.data() + convex.points.size());
  hull::visit_hull(3, coordinates, true, [&](const hull::HullFacet& facet) {
    std::array<int, 3> corners{facet.corners[0], facet.corners[1], facet.corners[2]};
    if (area_vector(convex.points, corners).dot(Vector3(facet.normal[0], facet.normal[1], facet.normal[2])) < 0)
      std::swap(corners[1], corners[2]);
    hull.triangles.push_back(corners);
  });
  return hull;
}

Triangulation triangulated(const contact::shape::Mesh& mesh, double) { return {mesh.points, mesh.triangles}; }

void add_cells(VtuArrays& arrays, std::string& out, const Cells<3>& triangles) {
  const int count = static_cast<int>(triangles.size());
  out += "<Cells>\n";
  arrays.add("connectivity", "Int32", 3, count, [&](int t, int k) { return triangles[t][k]; });
  arrays.add("offsets", "Int32", 1, count, [](int t, int) { return 3 * t + 3; });
  arrays.add("types", "UInt8", 1, count, [](int, int) { return 5; });
  out += "</Cells>\n";
}

VectorX largest_strains(const Body& body, const Positions& positions) {
  VectorX largest = VectorX::Zero(body.size());
  for (int c = 0; c < body.connections.proper(); ++c) {
    const auto& [a, b] = body.connections.ends[c];
    const double rest = body.connections.rest_length[c];
    const double strain = rest > 0 ? (positions.col(b) - positions.col(a)).norm() / rest - 1 : 0;
    for (const int end : {a, b}) largest[end] = std::max(largest[end], strain);
  }
  return largest;
}

}  // namespace

std::string surface_vtu_text(const Body& body, const Cells<3>& triangles, const Snapshot& shot) {
  // Molecules inside are left out: the surface's own are numbered again.
  std::vector<int> number(static_cast<std::size_t>(body.size()), -1), molecules;
  Cells<3> renumbered = triangles;
  for (auto& triangle : renumbered)
    for (int& corner : triangle) {
      int& known = number[corner];
      if (known < 0) {
        known = static_cast<int>(molecules.size());
        molecules.push_back(corner);
      }
      corner = known;
    }
  const int n = static_cast<int>(molecules.size());
  const VectorX strain = largest_strains(body, shot.positions);
  const auto of = [&](const Positions& values) { return [&](int i, int k) { return values(k, molecules[i]); }; };
  std::string out = vtu_head(n, static_cast<int>(triangles.size())) + "<Points>\n";
  VtuArrays arrays(out);
  arrays.add("positions", "Float64", 3, n, of(shot.positions));
  out += "</Points>\n<PointData Scalars=\"largest_strain\">\n";
  if (shot.contact_pressure.size()) {
    arrays.add("contact_pressure", "Float64", 1, n, [&](int i, int) { return shot.contact_pressure[molecules[i]]; });
    arrays.add("contact_force", "Float64", 3, n, of(shot.contact_forces));
  }
  arrays.add("displacement", "Float64", 3, n,
             [&](int i, int k) { return shot.positions(k, molecules[i]) - body.rest(k, molecules[i]); });
  arrays.add("largest_strain", "Float64", 1, n, [&](int i, int) { return strain[molecules[i]]; });
  const std::vector<int> piece = inspect(body).piece_of;
  arrays.add("piece", "Int32", 1, n, [&](int i, int) { return piece[molecules[i]]; });
  out += "</PointData>\n";
  add_cells(arrays, out, renumbered);
  return out + kVtuEnd;
}

contact::Pose drawn_pose(const contact::Obstacle& obstacle, contact::Pose pose, const Vector3& middle) {
  if (!std::holds_alternative<contact::shape::Plane>(obstacle.shape)) return pose;
  const Vector3 normal = pose.turn.col(2);
  pose.position = middle - normal.dot(middle - pose.position) * normal;
  return pose;
}

std::vector<std::array<Vector3, 2>> outline_of(const contact::ObstacleShape& shape, double wide) {
  const Triangulation form = std::visit([&](const auto& own) { return triangulated(own, wide); }, shape);
  const auto corner = [&](int point) -> Vector3 { return form.points.col(point); };
  std::map<std::pair<int, int>, std::vector<Vector3>> normals;  // of the triangles at an edge
  for (const auto& triangle : form.triangles)
    for (int k = 0; k < 3; ++k)
      normals[std::minmax(triangle[k], triangle[(k + 1) % 3])].push_back(
          area_vector(form.points, triangle).normalized());
  std::vector<std::array<Vector3, 2>> lines;
  constexpr double smooth = 0.9;  // cosine of 26 degrees
  for (const auto& [edge, sides] : normals)
    if (sides.size() != 2 || sides[0].dot(sides[1]) < smooth)
      lines.push_back({corner(edge.first), corner(edge.second)});
  const bool round = lines.empty() || std::holds_alternative<contact::shape::Cylinder>(shape);
  if (!round) return lines;
  const Vector3 middle = (form.points.rowwise().minCoeff() + form.points.rowwise().maxCoeff()) / 2;
  for (int axis = 0; axis < 3; ++axis)
    for (const auto& triangle : form.triangles) {
      std::vector<Vector3> met;
      for (int k = 0; k < 3; ++k) {
        const Vector3 a = corner(triangle[k]), b = corner(triangle[(k + 1) % 3]);
        const double before = a[axis] - middle[axis], after = b[axis] - middle[axis];
        if ((before < 0) != (after < 0)) met.push_back(a + before / (before - after) * (b - a));
      }
      if (met.size() == 2) lines.push_back({met[0], met[1]});
    }
  return lines;
}

std::string obstacles_vtu_text(const std::vector<contact::Obstacle>& obstacles, const std::vector<contact::Pose>& poses,
                               const Vector3& low, const Vector3& high) {
  std::vector<Vector3> points;
  Cells<3> triangles;
  std::vector<int> numbers;
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const double wide = (high - low).norm();
    const Triangulation own =
        std::visit([&](const auto& form) { return triangulated(form, wide); }, obstacles[i].shape);
    const contact::Pose pose = drawn_pose(obstacles[i], poses[i], (low + high) / 2);
    const int first = static_cast<int>(points.size());
    for (Eigen::Index k = 0; k < own.points.cols(); ++k) points.push_back(pose.to_world(own.points.col(k)));
    for (const auto& [a, b, c] : own.triangles) triangles.push_back({first + a, first + b, first + c});
    numbers.insert(numbers.end(), own.triangles.size(), static_cast<int>(i));
  }
  const int n = static_cast<int>(points.size()), count = static_cast<int>(triangles.size());
  std::string out = vtu_head(n, count) + "<Points>\n";
  VtuArrays arrays(out);
  arrays.add("positions", "Float64", 3, n, [&](int i, int k) { return points[i][k]; });
  out += "</Points>\n<CellData Scalars=\"obstacle\">\n";
  arrays.add("obstacle", "Int32", 1, count, [&](int t, int) { return numbers[t]; });
  out += "</CellData>\n";
  add_cells(arrays, out, triangles);
  return out + kVtuEnd;
}

}  // namespace elastin::lab
