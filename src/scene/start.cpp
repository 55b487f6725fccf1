#include <Eigen/Geometry>

#include "elastin/model/shapes.h"
#include "scene/parts.h"

namespace elastin {
namespace {

const std::vector<std::pair<std::string, int>> kAxes{{"x", 0}, {"y", 1}, {"z", 2}};

/// One axis, or several.
std::vector<int> read_axes(const Reader& reader) {
  if (reader.is_text()) return {reader.choice<int>(kAxes)};
  std::vector<int> axes;
  for (const Reader& item : reader.items()) axes.push_back(item.choice<int>(kAxes));
  return axes;
}

/// moved: {molecules: [13], by: [0, 0, 20 mm]}
void move(Reader reader, const Matrix3& rotation, Positions& places) {
  const Vector3 way = rotation * reader.at("by").vector(dimension::length);
  for (const Reader& item : reader.at("molecules").items())
    places.col(item.whole(0, static_cast<int>(places.cols()) - 1)) += way;
  reader.finish();
}

/// random: {seed: 1}
Positions read_random(Reader reader, const Body& body) {
  const int seed = reader.at("seed").whole(0);
  reader.finish();
  return random_places(body, static_cast<std::uint64_t>(seed));
}

}  // namespace

Positions read_start(Reader reader, const Body& body, const Matrix3& rotation) {
  const auto random = reader.find("random"), flattened = reader.find("flattened"), mirrored = reader.find("mirrored"),
             rotated = reader.find("rotated"), moved = reader.find("moved");
  reader.finish();
  if (random.has_value() + flattened.has_value() + mirrored.has_value() + rotated.has_value() + moved.has_value() != 1)
    reader.fail("give one of random, flattened, mirrored, rotated, moved");
  Positions places = body.rest;
  if (moved) move(*moved, rotation, places);
  if (random) places = read_random(*random, body);
  if (!flattened && !mirrored && !rotated) return places;
  const Vector3 middle = places.rowwise().mean();
  Matrix3 map = rotated ? read_rotation(*rotated) : Matrix3(Matrix3::Identity());
  if (flattened)
    for (const int axis : read_axes(*flattened)) map(axis, axis) = 0;
  if (mirrored) {
    const int axis = mirrored->choice<int>(kAxes);
    map(axis, axis) = -1;
  }
  places.colwise() -= middle;
  places = (rotation * map * rotation.transpose() * places).eval();
  places.colwise() += middle;
  return places;
}

}  // namespace elastin
