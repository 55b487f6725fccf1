#include "lab/experiment/pick.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/geometry/rim.h"
#include "core/model/faces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/model/share.h"

namespace elastin::lab {
namespace {

/// Which molecules are still picked; each place takes away those that do not lie there.
class Picked {
 public:
  Picked(const Body& body, const Matrix3& rotation)
      : body_(body),
        rotation_(rotation),
        places_(rotation.transpose() * body.rest),
        in_(static_cast<std::size_t>(body.size()), true) {
    for (int k = 0; k < 3; ++k) {
      low_[k] = least_over(body, places_.row(k).minCoeff());
      high_[k] = largest_over(body, places_.row(k).maxCoeff());
    }
  }

  /// Positions before the scene was turned.
  Vector3 place(int molecule) const { return places_.col(molecule); }
  const Positions& places() const { return places_; }
  const Body& body() const { return body_; }
  /// A direction of the scene as the body has it now.
  Vector3 turned(const Vector3& direction) const { return rotation_ * direction; }
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
  Matrix3 rotation_;
  Positions places_;
  std::vector<bool> in_;
  Vector3 low_, high_;
};

struct PickedPlane {
  Vector3 point = Vector3::Zero(), normal = Vector3::UnitZ();
  std::optional<double> within;
};

struct PickedSphere {
  Vector3 centre = Vector3::Zero();
  double radius = 0;
};

/// Places; those that are given must all hold.
struct PickSetup {
  std::optional<BoxCorners> box;
  std::optional<PickedPlane> plane;
  std::optional<PickedSphere> sphere;
  std::optional<Vector3> side, nearest;
  bool rim = false;
  std::optional<Reader> rim_place;
  std::optional<std::vector<int>> set, body;  ///< molecules, ascending
};

Keys<PickSetup> keys_of_places() {
  using S = PickSetup;
  return {
      key::map("box", &S::box, {low_corner_key(), high_corner_key()}),
      key::map(
          "plane", &S::plane,
          {key::vector("point", &PickedPlane::point, dimension::length, "a point of the plane").needed(),
           key::direction("normal", &PickedPlane::normal, "its normal").needed(),
           key::quantity("within", &PickedPlane::within, dimension::length, "distance from it that counts", kPositive)
               .otherwise("1e-6 of the body")}),
      key::map("sphere", &S::sphere,
               {key::vector("centre", &PickedSphere::centre, dimension::length, "middle of the sphere").needed(),
                key::quantity("radius", &PickedSphere::radius, dimension::length, "its radius", kPositive).needed()}),
      key::direction("side", &S::side,
                     "the molecules furthest along this direction, of `body` if one is named; of a solid that does not "
                     "end in a plane its whole end"),
      key::vector("nearest", &S::nearest, dimension::length, "the molecule nearest to this point"),
      key::flag("rim", &S::rim, "the free edge of a body of triangles").place(&S::rim_place),
      Key<S>(
          {"set", "text, or list of texts", "", "", "none",
           "a set of the mesh file, by its name or, where the file has none, its number: a physical group of Gmsh, "
           "`*NSET` or `*ELSET` of Abaqus, a group of I-DEAS, a property of Nastran; of several bodies the sets of "
           "this name in all their files; of a list what lies in all of its sets: `[skin, fat]` is where these meet"},
          [](const Reader& value, S& setup, const Frame&) {
            const std::vector<Reader> sets = value.is_list() ? value.items() : std::vector{value};
            if (sets.empty()) value.fail("names no set");
            setup.set = sets[0].mesh_set();
            for (const Reader& set : sets)
              std::erase_if(*setup.set, [&members = set.mesh_set()](int molecule) {
                return !std::binary_search(members.begin(), members.end(), molecule);
              });
          }),
      Key<S>({"body", "a body's name", "", "", "all", "the molecules of this one of several `bodies`"},
             [](const Reader& value, S& setup, const Frame& frame) {
               if (frame.body->parts.empty()) value.fail("is one of several `bodies`; the scene has one");
               setup.body = value.located([&] { return molecules_of(find_part(*frame.body, value.text())); });
             })};
}

void keep_where(const PickSetup& setup, Picked& picked) {
  const Body& body = picked.body();
  const double slack = 1e-9 * picked.size();
  const auto keep_members = [&](const std::optional<std::vector<int>>& members) {
    if (!members) return;
    picked.keep([&](int molecule) { return std::binary_search(members->begin(), members->end(), molecule); });
  };
  keep_members(setup.body);
  const bool whole_solid = setup.side && !setup.body && any_over(body, !body.tetrahedra.empty());
  Face whole_end;
  if (whole_solid) whole_end = end_face(body, picked.turned(*setup.side), 0);
  if (!whole_end.tilted.isZero(0)) {  // rough, tilted or rounded
    keep_members(whole_end.molecules);
  } else if (setup.side) {  // the furthest of what is picked so far: of a body that is named, its own
    const VectorX height = picked.places().transpose() * *setup.side;
    double end = -std::numeric_limits<double>::infinity();
    for (const int molecule : picked.molecules()) end = std::max(end, height[molecule]);
    end = largest_over(body, end) - 1e-6 * picked.size();
    picked.keep([&](int molecule) { return height[molecule] >= end; });
  }
  if (const auto& box = setup.box)
    picked.keep([&](int molecule) {
      const Vector3 place = picked.place(molecule);
      return ((place - box->from).array() >= -slack).all() && ((box->to - place).array() >= -slack).all();
    });
  if (const auto& plane = setup.plane)
    picked.keep([&, within = plane->within.value_or(1e-6 * picked.size())](int molecule) {
      return std::abs(plane->normal.dot(picked.place(molecule) - plane->point)) <= within;
    });
  if (const auto& sphere = setup.sphere)
    picked.keep(
        [&](int molecule) { return (picked.place(molecule) - sphere->centre).norm() <= sphere->radius + slack; });
  if (setup.rim) {
    if (!any_over(body, !body.triangles.empty()) || any_over(body, !body.tetrahedra.empty()))
      setup.rim_place->fail("is of bodies of triangles; this one is a solid");
    std::vector<char> edge(static_cast<std::size_t>(body.size()), 0);
    for (const int molecule : rim_of(body.triangles)) edge[molecule] = 1;
    mark_ghosts_as_owners(body, edge);
    picked.keep([&](int molecule) { return edge[molecule] != 0; });
  }
  keep_members(setup.set);
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

Key<BoxCorners> low_corner_key() {
  return key::vector("from", &BoxCorners::from, dimension::length, "lowest corner of the box").needed();
}

Key<BoxCorners> high_corner_key() {
  return key::vector("to", &BoxCorners::to, dimension::length, "highest corner of the box")
      .needed()
      .then([](const Reader& value, const BoxCorners& box) {
        if (!((box.to - box.from).array() >= 0).all()) value.fail("must not lie below `from` in any direction");
      });
}

std::vector<int> read_molecules(const Reader& reader, const Body& body, const Matrix3& rotation) {
  if (!reader.is_map()) {
    std::vector<int> molecules;
    const std::vector<Reader> items = reader.items();
    if (items.empty()) reader.fail("names no molecule; write their numbers, or a map of where they lie");
    for (const Reader& item : items) {
      const int number = item.molecule(static_cast<int>(molecules_of_whole(body)));
      if (const int molecule = molecule_of_whole(body, number); molecule >= 0) molecules.push_back(molecule);
    }
    return molecules;
  }
  Reader map = reader;
  map.set_section("pick");
  const Keys<PickSetup> keys = keys_of_places();
  const PickSetup setup = keys.read(map, {Matrix3::Identity(), &body});
  if (reader.keys().empty()) map.fail("names no place: give " + listed(keys.names(), "or"));
  Picked picked(body, rotation);
  keep_where(setup, picked);
  std::vector<int> molecules = picked.molecules();
  const bool any = any_over(body, !molecules.empty());
  if (setup.nearest && any) molecules = nearest_of(picked, molecules, *setup.nearest);
  if (any) return molecules;
  const Vector3 &low = picked.low(), &high = picked.high();
  map.fail(
      fmt::format("no molecule lies there; the body reaches from [{:.6g}, {:.6g}, {:.6g}] mm to [{:.6g}, {:.6g}, "
                  "{:.6g}] mm",
                  1e3 * low.x(), 1e3 * low.y(), 1e3 * low.z(), 1e3 * high.x(), 1e3 * high.y(), 1e3 * high.z()));
}

std::vector<KeySection> pick_keys() {
  return {
      {"pick", "Picked molecules",
       "Where molecules are named there is a list of their numbers, from 0, or a map of these places. Of several, a "
       "molecule must lie in all; `nearest` then picks one of those. Positions are those before `rotate`:",
       keys_of_places().rows()}};
}

}  // namespace elastin::lab
