#include "lab/scene/pick.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "elastin/core/model/parts.h"
#include "elastin/core/model/share.h"
#include "lab/scene/parts.h"

namespace elastin::lab {
namespace {

/// Which molecules are still picked; each place takes away those that do not lie there.
class Picked {
 public:
  Picked(const Body& body, const Matrix3& rotation)
      : body_(body), places_(rotation.transpose() * body.rest), in_(static_cast<std::size_t>(body.size()), true) {
    for (int k = 0; k < 3; ++k) {
      low_[k] = least_over(body, places_.row(k).minCoeff());
      high_[k] = largest_over(body, places_.row(k).maxCoeff());
    }
  }

  /// Positions before the scene was turned.
  Vector3 place(int molecule) const { return places_.col(molecule); }
  const Positions& places() const { return places_; }
  const Body& body() const { return body_; }
  /// Corners of the outline of the whole body.
  const Vector3& low() const { return low_; }
  const Vector3& high() const { return high_; }
  double size() const { return (high_ - low_).norm(); }

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
  const Body& body_;
  Positions places_;
  std::vector<bool> in_;
  Vector3 low_, high_;
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
  const Vector3 normal = plane.at("normal").direction(), point = plane.at("point").vector(dimension::length);
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
  const Vector3 direction = side.direction();
  const VectorX height = picked.places().transpose() * direction;
  double end = -std::numeric_limits<double>::infinity();
  for (const int molecule : picked.molecules()) end = std::max(end, height[molecule]);
  end = largest_over(picked.body(), end) - 1e-6 * picked.size();
  picked.keep([&](int molecule) { return height[molecule] >= end; });
}

/// Of equally near ones the first of the whole; none where another process has it.
std::vector<int> nearest_of(const Picked& picked, const std::vector<int>& molecules, const Vector3& point) {
  const Body& body = picked.body();
  double least = std::numeric_limits<double>::infinity(), first = least;
  for (const int molecule : molecules) least = std::min(least, (picked.place(molecule) - point).norm());
  least = least_over(body, least);
  for (const int molecule : molecules)
    if ((picked.place(molecule) - point).norm() == least)
      first = std::min(first, static_cast<double>(number_in_whole(body, molecule)));
  const int molecule = molecule_of_whole(body, static_cast<std::int64_t>(least_over(body, first)));
  return molecule < 0 ? std::vector<int>{} : std::vector{molecule};
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
    for (const Reader& item : reader.items()) {
      const int number = item.molecule(static_cast<int>(molecules_of_whole(body)));
      if (const int molecule = molecule_of_whole(body, number); molecule >= 0) molecules.push_back(molecule);
    }
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
    if (!any_over(body, !body.triangles.empty()) || any_over(body, !body.tetrahedra.empty()))
      rim->fail("is of bodies of triangles; this one is a solid");
    std::vector<char> edge(static_cast<std::size_t>(body.size()), 0);
    for (const int molecule : rim_of(body)) edge[molecule] = 1;
    mark_ghosts_as_owners(body, edge);
    picked.keep([&](int molecule) { return edge[molecule] != 0; });
  }
  if (set) {
    const std::vector<int> members = set->mesh_set();
    picked.keep([&](int molecule) { return std::binary_search(members.begin(), members.end(), molecule); });
  }
  std::vector<int> molecules = picked.molecules();
  const bool any = any_over(body, !molecules.empty());
  if (nearest && any) molecules = nearest_of(picked, molecules, nearest->vector(dimension::length));
  if (any) return molecules;
  const Vector3 &low = picked.low(), &high = picked.high();
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
