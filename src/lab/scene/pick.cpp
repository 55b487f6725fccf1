#include "lab/scene/pick.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "elastin/core/model/parts.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// Which molecules are still picked; each place takes away those that do not lie there.
class Picked {
 public:
  Picked(const Body& body, const Matrix3& rotation)
      : places_(rotation.transpose() * body.rest), in_(static_cast<std::size_t>(body.size()), true) {}

  /// Positions before the scene was turned.
  Vector3 place(int molecule) const { return places_.col(molecule); }
  const Positions& places() const { return places_; }
  double size() const { return (places_.rowwise().maxCoeff() - places_.rowwise().minCoeff()).norm(); }

  void keep(const std::function<bool(int molecule)>& there) {
    for (std::size_t molecule = 0; molecule < in_.size(); ++molecule)
      in_[molecule] = in_[molecule] && there(static_cast<int>(molecule));
  }
  std::vector<int> molecules() const {
    std::vector<int> list;
    for (std::size_t molecule = 0; molecule < in_.size(); ++molecule)
      if (in_[molecule]) list.push_back(static_cast<int>(molecule));
    return list;
  }

 private:
  Positions places_;
  std::vector<bool> in_;
};

void keep_in_box(Reader box, Picked& picked) {
  const Reader to = box.at("to");
  const Vector3 low = box.at("from").vector(dimension::length), high = to.vector(dimension::length);
  box.finish();
  if (!((high - low).array() >= 0).all()) to.fail("must not lie below `from` in any direction");
  const double slack = 1e-9 * picked.size();
  picked.keep([&](int molecule) {
    const Vector3 place = picked.place(molecule);
    return ((place - low).array() >= -slack).all() && ((high - place).array() >= -slack).all();
  });
}

void keep_in_plane(Reader plane, Picked& picked) {
  const Vector3 normal = read_direction(plane.at("normal")), point = plane.at("point").vector(dimension::length);
  const auto within = plane.find("within");
  const double reach = within ? within->quantity(dimension::length, kPositive) : 1e-6 * picked.size();
  plane.finish();
  picked.keep([&](int molecule) { return std::abs(normal.dot(picked.place(molecule) - point)) <= reach; });
}

void keep_in_sphere(Reader sphere, Picked& picked) {
  const Vector3 centre = sphere.at("centre").vector(dimension::length);
  const double radius = sphere.at("radius").quantity(dimension::length, kPositive) + 1e-9 * picked.size();
  sphere.finish();
  picked.keep([&](int molecule) { return (picked.place(molecule) - centre).norm() <= radius; });
}

void keep_part(const Reader& name, const Body& body, Picked& picked) {
  if (body.parts.empty()) name.fail("is one of several `bodies`; the scene has one");
  const Part& part = name.located([&]() -> const Part& { return find_part(body, name.text()); });
  const std::vector<int> own = molecules_of(part);
  picked.keep([&](int molecule) { return std::binary_search(own.begin(), own.end(), molecule); });
}

/// The furthest of what is picked so far: of a body that was named, its own.
void keep_side(const Reader& side, Picked& picked) {
  const Vector3 direction = read_direction(side);
  const VectorX height = picked.places().transpose() * direction;
  double end = -std::numeric_limits<double>::infinity();
  for (const int molecule : picked.molecules()) end = std::max(end, height[molecule]);
  end -= 1e-6 * picked.size();
  picked.keep([&](int molecule) { return height[molecule] >= end; });
}

}  // namespace

std::vector<int> rim_of(const Body& body) {
  std::map<std::pair<int, int>, int> sides;
  for (const auto& [a, b, c] : body.triangles)
    for (const auto& [first, second] : {std::pair{a, b}, {b, c}, {c, a}}) ++sides[std::minmax(first, second)];
  std::vector<int> rim;
  for (const auto& [side, triangles] : sides)
    if (triangles == 1) rim.insert(rim.end(), {side.first, side.second});
  std::sort(rim.begin(), rim.end());
  rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
  return rim;
}

std::vector<int> read_molecules(const Reader& reader, const Body& body, const Matrix3& rotation) {
  if (!reader.is_map()) {
    std::vector<int> molecules;
    for (const Reader& item : reader.items()) molecules.push_back(item.molecule(body.size()));
    return molecules;
  }
  Reader map = reader;
  map.set_section("pick");
  Picked picked(body, rotation);
  const auto box = map.find("box"), plane = map.find("plane"), sphere = map.find("sphere"), side = map.find("side"),
             nearest = map.find("nearest"), rim = map.find("rim"), set = map.find("set"), part = map.find("body");
  map.finish();
  if (!box && !plane && !sphere && !side && !nearest && !rim && !set && !part)
    map.fail("names no place: give box, plane, sphere, side, nearest, rim, set or body");
  if (part) keep_part(*part, body, picked);
  if (side) keep_side(*side, picked);
  if (box) keep_in_box(*box, picked);
  if (plane) keep_in_plane(*plane, picked);
  if (sphere) keep_in_sphere(*sphere, picked);
  if (rim && rim->choice<bool>({{"true", true}, {"false", false}})) {
    if (body.triangles.empty() || !body.tetrahedra.empty()) rim->fail("is of bodies of triangles; this one is a solid");
    const std::vector<int> edge = rim_of(body);
    picked.keep([&](int molecule) { return std::binary_search(edge.begin(), edge.end(), molecule); });
  }
  if (set) {
    const std::vector<int> members = set->mesh_set();
    picked.keep([&](int molecule) { return std::binary_search(members.begin(), members.end(), molecule); });
  }
  std::vector<int> molecules = picked.molecules();
  if (nearest && !molecules.empty()) {
    const Vector3 point = nearest->vector(dimension::length);
    const auto distance = [&](int molecule) { return (picked.place(molecule) - point).norm(); };
    molecules = {
        *std::min_element(molecules.begin(), molecules.end(), [&](int a, int b) { return distance(a) < distance(b); })};
  }
  if (!molecules.empty()) return molecules;
  const Vector3 low = picked.places().rowwise().minCoeff(), high = picked.places().rowwise().maxCoeff();
  map.fail(
      fmt::format("no molecule lies there; the body reaches from [{:.6g}, {:.6g}, {:.6g}] mm to [{:.6g}, {:.6g}, "
                  "{:.6g}] mm",
                  1e3 * low.x(), 1e3 * low.y(), 1e3 * low.z(), 1e3 * high.x(), 1e3 * high.y(), 1e3 * high.z()));
}

std::vector<KeySection> pick_keys() {
  return {
      {"pick",
       "Picked molecules",
       "Where molecules are named there is a list of their numbers, from 0, or a map of these places. Of several, a "
       "molecule must lie in all; `nearest` then picks one of those. Positions are those before `rotate`:",
       {{"box.from", "vector", "m", "", "needed", "lowest corner"},
        {"box.to", "vector", "m", "", "needed", "highest corner"},
        {"plane.point", "vector", "m", "", "needed", "a point of the plane"},
        {"plane.normal", "direction", "", "", "needed", "its normal"},
        {"plane.within", "quantity", "m", "> 0", "1e-6 of the body", "distance from it that counts"},
        {"sphere.centre", "vector", "m", "", "needed", "middle of the sphere"},
        {"sphere.radius", "quantity", "m", "> 0", "needed", "its radius"},
        {"side", "direction", "", "", "none", "the molecules furthest along this direction, of `body` if one is named"},
        {"rim", "`true`, `false`", "", "", "`false`", "the free edge of a body of triangles"},
        {"set", "text", "", "", "none",
         "a set of the mesh file: a physical group of Gmsh, `*NSET` or `*ELSET` of Abaqus; of several bodies the sets "
         "of "
         "this name in all their files"},
        {"body", "a body's name", "", "", "all", "the molecules of this one of several `bodies`"},
        {"nearest", "vector", "m", "", "none", "the molecule nearest to this point"}}}};
}

}  // namespace elastin::lab
